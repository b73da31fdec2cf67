// SPDX-License-Identifier: BSD-3-Clause
// What a resampling is going to do.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis/analysis.h"
#include "filter/kernels/kernel_nd.h"
#include "filter/kernels/prefilter.h"
#include "filter/kernels/stretch.h"
#include "passes/resample/resample_impl.h"
#include "passes/separable/separable.h"
#include "tiles/volume/volume.h"

// ---- the request --------------------------------------------------------------------------------

static bool is_size(int size)
{
    return size >= 1 && size <= WEFT_RESAMPLE_MAX_SIZE;
}

static enum weft_result check_sizes(const struct weft_resample_params *p)
{
    if (is_size(p->size[0]) && is_size(p->size[1]) && is_size(p->width) && is_size(p->height) &&
        (int64_t)p->width * p->height <= WEFT_RESAMPLE_MAX_PIXELS &&
        (int64_t)p->size[0] * p->size[1] <= WEFT_RESAMPLE_MAX_PIXELS)
        return WEFT_OK;
    weft_error(p->log,
               "resampling %d x %d samples to %d x %d pixels: sides must be 1 to %d, and %lld in "
               "all",
               p->size[0], p->size[1], p->width, p->height, WEFT_RESAMPLE_MAX_SIZE,
               (long long)WEFT_RESAMPLE_MAX_PIXELS);
    return WEFT_ERR_ARGUMENT;
}

static bool is_same_kernel(const struct weft_kernel *a, const struct weft_kernel *b)
{
    bool same = a->info == b->info && a->normalised == b->normalised && a->radial == b->radial &&
                a->prefiltered == b->prefiltered;
    for (int i = 0; same && i < WEFT_KERNEL_PARAMS; i++)
        same = a->param[i] == b->param[i] || !a->info->params[i].name;
    return same;
}

static enum weft_result check_passes(const struct weft_log *log,
                                     const struct weft_pass_plan_info *passes,
                                     const struct weft_kernel *kernel)
{
    if (passes->dims != 2 || weft_derivative_order(&passes->derivative) != 0) {
        char along[WEFT_DERIVATIVE_TEXT];
        weft_error(log,
                   "resampling by passes in %dD with derivative %s: they must be 2D and of "
                   "the signal itself",
                   passes->dims, weft_derivative_format(&passes->derivative, along));
        return WEFT_ERR_ARGUMENT;
    }
    if (is_same_kernel(kernel, &passes->kernel))
        return WEFT_OK;
    char names[2][256];
    weft_kernel_format(kernel, names[0], sizeof names[0]);
    weft_kernel_format(&passes->kernel, names[1], sizeof names[1]);
    weft_error(log, "resampling with %s by passes of %s: they must be of the same kernel", names[0],
               names[1]);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result set_kernel(weft_resample_plan *plan,
                                   const struct weft_resample_params *params)
{
    struct weft_resample_info *info = &plan->info;
    info->kernel = params->kernel;
    if (!info->kernel.info && info->passes)
        info->kernel = info->passes->kernel;
    else if (!info->kernel.info)
        weft_kernel_parse(plan->log, "catmull-rom", &info->kernel);
    const enum weft_result res = weft_kernel_check(plan->log, &info->kernel);
    if (res != WEFT_OK)
        return res;
    if (info->passes)
        return check_passes(plan->log, info->passes, &info->kernel);
    if (!weft_kernel_is_radial(&info->kernel, 2))
        return WEFT_OK;
    weft_error(plan->log, "resampling with %s, which is radial, needs passes",
               info->kernel.info->name);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result set_maps(weft_resample_plan *plan,
                                 const struct weft_resample_params *params)
{
    struct weft_resample_info *info = &plan->info;
    const int pixels[2] = {info->width, info->height};
    for (int a = 0; a < 2; a++) {
        const struct weft_window_map *m = &params->map[a];
        info->map[a] = m->from || m->to || m->pixel || m->sample
                           ? *m
                           : weft_window_map_plain(info->size[a], pixels[a]);
        m = &info->map[a];
        if (isfinite(weft_window_map_position(m, 0, 0)) &&
            isfinite(weft_window_map_position(m, pixels[a] - 1, WEFT_PREFILTER_MAX_OVERLAP)))
            continue;
        weft_error(plan->log,
                   "resampling from %lld to %lld pixels, from pixel %lld and sample %lld on: sizes "
                   "must be at least 1, and all within %d of 0",
                   (long long)m->from, (long long)m->to, (long long)m->pixel, (long long)m->sample,
                   WEFT_WINDOW_MAX);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// What passes and prefilters cannot do.
static enum weft_result check_stretch(const weft_resample_plan *plan)
{
    const struct weft_resample_info *info = &plan->info;
    const char *const name = info->kernel.info->name;
    const bool stretched = info->stretch[0] > 1.0 || info->stretch[1] > 1.0;
    if (info->passes && info->boundary != WEFT_BOUNDARY_CLAMP) {
        weft_error(plan->log, "resampling by passes knows the boundary clamp alone, not %s",
                   weft_boundary_names[info->boundary]);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (!stretched || (!info->passes && !info->kernel.prefiltered))
        return WEFT_OK;
    if (info->passes)
        weft_error(plan->log,
                   "resampling to a smaller size stretches %s by %.4g and %.4g, which passes do "
                   "not: go without passes, or without anti-aliasing",
                   name, info->stretch[0], info->stretch[1]);
    else
        weft_error(plan->log,
                   "resampling to a smaller size stretches kernels by %.4g and %.4g, and %s, which "
                   "interpolates by a prefilter, cannot be: take one without, like mitchell or "
                   "lanczos:3, or go without anti-aliasing",
                   info->stretch[0], info->stretch[1], name);
    return WEFT_ERR_UNSUPPORTED;
}

// Pixels lie as far apart as the display windows' sizes say.
static enum weft_result set_stretch(weft_resample_plan *plan,
                                    const struct weft_resample_params *params)
{
    struct weft_resample_info *info = &plan->info;
    for (int a = 0; a < 2; a++) {
        const double distance = (double)info->map[a].from / (double)info->map[a].to;
        info->stretch[a] = params->unstretched ? 1.0 : weft_stretch_scale(&info->kernel, distance);
    }
    return check_stretch(plan);
}

static enum weft_result set_overlap(weft_resample_plan *plan)
{
    struct weft_prefilter prefilter;
    const enum weft_boundary boundary = plan->info.boundary;
    // Coefficients of a mirrored or periodic signal are mirrored or periodic themselves.
    if (!plan->info.kernel.prefiltered || boundary == WEFT_BOUNDARY_MIRROR ||
        boundary == WEFT_BOUNDARY_WRAP)
        return WEFT_OK;
    const enum weft_result res = weft_prefilter_compute(plan->log, &plan->info.kernel, &prefilter);
    if (res == WEFT_OK)
        plan->info.overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    return res;
}

static enum weft_result check_engine(const struct weft_resample_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(p->log, p->engine, WEFT_ENGINE_CPU);
    weft_require_enum(p->log, p->sums, WEFT_SUMS_DOUBLE);
    weft_require_enum(p->log, p->boundary, WEFT_BOUNDARY_BORDER);
    if (!p->passes || p->sums == WEFT_SUMS_FLOAT)
        return WEFT_OK;
    weft_error(p->log, "resampling by passes does not sum in double");
    return WEFT_ERR_UNSUPPORTED;
fail:
    return res;
}

// ---- separable ----------------------------------------------------------------------------------

static enum weft_result set_positions(weft_resample_plan *plan)
{
    const int count[2] = {plan->info.width, plan->info.height};
    for (int a = 0; a < 2; a++) {
        plan->at[a] = malloc((size_t)count[a] * sizeof *plan->at[a]);
        if (!plan->at[a]) {
            weft_error(plan->log, "out of memory for %d positions", count[a]);
            return WEFT_ERR_MEMORY;
        }
        weft_window_map_positions(&plan->info.map[a], 0, count[a], plan->info.overlap, plan->at[a]);
    }
    return WEFT_OK;
}

// "6 taps along each axis", or of stretched kernels how many along which, and by how much.
static void tell_taps(const weft_resample_plan *plan, char *text, size_t size)
{
    const struct weft_separable_info *info = weft_separable_plan_get_info(plan->separable);
    if (info->stretch[0] == 1.0 && info->stretch[1] == 1.0)
        snprintf(text, size, "%d taps along each axis", info->taps[0]);
    else
        snprintf(text, size, "stretched by %.4g and %.4g to %d taps along x and %d along y",
                 info->stretch[0], info->stretch[1], info->taps[0], info->taps[1]);
}

static void tell_separable(weft_resample_plan *plan)
{
    const struct weft_resample_info *info = &plan->info;
    char name[256], taps[128], beyond[64] = "";
    weft_kernel_format(&info->kernel, name, sizeof name);
    tell_taps(plan, taps, sizeof taps);
    if (info->boundary != WEFT_BOUNDARY_CLAMP)
        snprintf(beyond, sizeof beyond, ", beyond the samples %s",
                 weft_boundary_names[info->boundary]);
    snprintf(plan->words, sizeof plan->words,
             "separable %s: %s, one after the other, on the %s engine in %s precision%s%s; the "
             "error is at most %.3g of the largest sample in reach\n",
             name, taps, weft_name(weft_engine_names, info->engine),
             info->sums == WEFT_SUMS_DOUBLE ? "double" : "single", beyond,
             info->clamp ? ", clamped to the samples next to each pixel" : "",
             weft_separable_plan_error(plan->separable));
    plan->info.text = plan->words;
}

static enum weft_result plan_separable(weft_resample_plan *plan)
{
    struct weft_resample_info *info = &plan->info;
    enum weft_result res = set_positions(plan);
    if (res == WEFT_OK)
        res = weft_separable_plan_create(
            weft_separable_params(.kernel = info->kernel,
                                  .size = {info->size[0] + 2 * info->overlap,
                                           info->size[1] + 2 * info->overlap},
                                  .width = info->width, .height = info->height, .x = plan->at[0],
                                  .y = plan->at[1], .stretch = {info->stretch[0], info->stretch[1]},
                                  .boundary = info->boundary, .engine = info->engine,
                                  .sums = info->sums, .memory_bytes = plan->memory_bytes,
                                  .log = plan->log),
            &plan->separable);
    if (res != WEFT_OK)
        return res;
    info->bound = weft_separable_plan_bound(plan->separable, 1.0, WEFT_VOLUME_PREFILTER_ERROR);
    info->fetches = weft_separable_plan_get_info(plan->separable)->fetches_per_pixel;
    info->moves = weft_resample_moves(&info->kernel) && info->stretch[0] == 1.0 &&
                  info->stretch[1] == 1.0 && info->boundary != WEFT_BOUNDARY_BORDER;
    tell_separable(plan);
    return WEFT_OK;
}

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result plan_passes(weft_resample_plan *plan)
{
    plan->info.text = plan->info.passes->text;
    plan->info.bound = plan->info.passes->bound;
    plan->info.fetches = (double)plan->info.passes->fetches / plan->info.passes->channels;
    return weft_resample_plan_tiles(plan);
}

static enum weft_result fill(weft_resample_plan *plan, const struct weft_resample_params *params)
{
    enum weft_result res = set_kernel(plan, params);
    if (res == WEFT_OK)
        res = set_maps(plan, params);
    if (res == WEFT_OK)
        res = set_stretch(plan, params);
    if (res == WEFT_OK)
        res = set_overlap(plan);
    if (res != WEFT_OK)
        return res;
    return plan->passes ? plan_passes(plan) : plan_separable(plan);
}

enum weft_result weft_resample_plan_create(const struct weft_resample_params *params,
                                           weft_resample_plan **out)
{
    *out = NULL;
    enum weft_result res = check_sizes(params);
    if (res == WEFT_OK)
        res = check_engine(params);
    if (res != WEFT_OK)
        return res;
    weft_resample_plan *plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(params->log, "out of memory for a plan of resampling");
        return WEFT_ERR_MEMORY;
    }
    plan->passes = params->passes;
    plan->memory_bytes = params->memory_bytes ? params->memory_bytes : UINT64_C(1) << 30;
    plan->log = params->log;
    plan->info = (struct weft_resample_info){
        .passes = params->passes ? weft_pass_plan_get_info(params->passes) : NULL,
        .size = {params->size[0], params->size[1]},
        .width = params->width,
        .height = params->height,
        .boundary = params->boundary,
        .clamp = params->clamp,
        .engine = params->engine,
        .sums = params->sums,
    };
    res = fill(plan, params);
    if (res == WEFT_OK)
        *out = plan;
    else
        weft_resample_plan_destroy(&plan);
    return res;
}

void weft_resample_plan_destroy(weft_resample_plan **plan)
{
    if (!plan || !*plan)
        return;
    weft_separable_plan_destroy(&(*plan)->separable);
    free((*plan)->at[0]);
    free((*plan)->at[1]);
    free(*plan);
    *plan = NULL;
}

const struct weft_resample_info *weft_resample_plan_get_info(const weft_resample_plan *plan)
{
    return &plan->info;
}
