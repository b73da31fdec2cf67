// SPDX-License-Identifier: BSD-3-Clause
// Results beside the samples themselves, whatever engine made them.
#include <stdlib.h>

#include "passes/resample/resample_impl.h"

// Along both axes; integers that are moved are found in whole numbers, without rounding.
static bool find_positions(const struct weft_resample_info *info, bool moved, double *at[2])
{
    const int count[2] = {info->width, info->height};
    for (int a = 0; a < 2; a++)
        at[a] = malloc((size_t)count[a] * sizeof *at[a]);
    for (int a = 0; at[0] && at[1] && a < 2; a++) {
        weft_window_map_positions(&info->map[a], 0, count[a], 0, at[a]);
        for (int i = 0; moved && i < count[a]; i++)
            at[a][i] = (double)weft_window_map_square(&info->map[a], i);
    }
    return at[0] && at[1];
}

// The rest of a request, of which samples, pixels and their bound are there.
static enum weft_result verify(const weft_resample_plan *plan, bool moved,
                               const struct weft_verify_params *how,
                               struct weft_pixels_verify_params *params,
                               struct weft_verify_report *out)
{
    const struct weft_resample_info *info = &plan->info;
    double *at[2] = {NULL};
    enum weft_result res = WEFT_ERR_MEMORY;
    *out = (struct weft_verify_report){0};
    if (!find_positions(info, moved, at)) {
        weft_error(params->log, "out of memory for the positions of %d x %d pixels", info->width,
                   info->height);
        goto fail;
    }
    const struct weft_pixel_grid grid = {
        .width = info->width, .height = info->height, .columns = at[0], .rows = at[1]};
    params->kernel[0] = info->kernel;
    params->grid = &grid;
    params->size[0] = info->size[0];
    params->size[1] = info->size[1];
    params->boundary = info->boundary;
    params->cardinal = info->kernel.prefiltered;
    params->how = how ? *how : (struct weft_verify_params){0};
    res = weft_pixels_verify(params, out);
fail:
    free(at[0]);
    free(at[1]);
    return res;
}

enum weft_result weft_resample_verify(const weft_resample_plan *plan,
                                      const struct weft_resample_verify_params *p,
                                      struct weft_verify_report *out)
{
    int64_t stride = p->stride;
    *out = (struct weft_verify_report){0};
    struct weft_rectangle part = p->part;
    const enum weft_result res =
        weft_resample_check_request(p->log, plan, p->source, &part, p->plane, &stride);
    if (res != WEFT_OK)
        return res;
    struct weft_pixels_verify_params params = {
        .part = part,
        .window = p->source->info.window,
        .channels = p->source->info.channels,
        .stretch = {plan->info.stretch[0], plan->info.stretch[1]},
        .border = p->source->info.border,
        .clamp = plan->info.clamp,
        .bound_absolute = weft_resample_bound(plan, &p->source->info.statistics, 0.0).total,
        .log = p->log};
    for (int c = 0; c < params.channels; c++) {
        params.samples[c] =
            (struct weft_verify_plane){.values = p->source->plane[c], .stride = p->source->stride};
        params.pixels[c] = (struct weft_verify_plane){.values = p->plane[c], .stride = stride};
    }
    return verify(plan, false, &p->how, &params, out);
}

enum weft_result weft_resample_move_verify(const weft_resample_plan *plan,
                                           const struct weft_resample_integers *source,
                                           const struct weft_rectangle *part,
                                           const uint32_t *pixels, int64_t stride,
                                           const struct weft_verify_params *how,
                                           struct weft_verify_report *out)
{
    *out = (struct weft_verify_report){0};
    struct weft_resample_integers from = *source;
    struct weft_rectangle own;
    const enum weft_result res = weft_resample_check_move(plan, &from, part, pixels, &stride, &own);
    if (res != WEFT_OK)
        return res;
    struct weft_pixels_verify_params params = {
        .part = own,
        .window = from.window,
        .samples = {{from.plane, WEFT_VERIFY_UINT32, from.stride}},
        .pixels = {{pixels, WEFT_VERIFY_UINT32, stride}},
        .log = plan->log};
    return verify(plan, true, how, &params, out);
}
