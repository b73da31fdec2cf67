// SPDX-License-Identifier: BSD-3-Clause
// Unsigned integers that are moved, not filtered.
#include <stdlib.h>

#include "passes/resample/resample_impl.h"

bool weft_resample_moves(const struct weft_kernel *kernel)
{
    return kernel->info && kernel->width == 1 && kernel->unit_sum && !kernel->radial &&
           !kernel->prefiltered && kernel->info->derivation == 0;
}

// Fills the window and the stride in.
static bool is_readable(struct weft_resample_integers *source)
{
    if (source->width < 1 || source->height < 1 || !source->plane ||
        weft_rectangle_within(NULL, &source->window, source->width, source->height,
                              &source->window) != WEFT_OK)
        return false;
    source->stride = source->stride ? source->stride : source->window.width;
    return source->stride >= source->window.width;
}

// Where a row of the window begins.
static const uint32_t *row_of(const struct weft_resample_integers *source, int64_t y)
{
    return source->plane + (y - source->window.y) * source->stride;
}

void weft_resample_integer_range(const struct weft_resample_integers *source, uint32_t range[2])
{
    struct weft_resample_integers own = *source;
    const bool readable = is_readable(&own);
    range[0] = readable ? UINT32_MAX : 0;
    range[1] = 0;
    for (int64_t y = 0; readable && y < own.window.height; y++) {
        const uint32_t *row = row_of(&own, own.window.y + y);
        for (int64_t x = 0; x < own.window.width; x++) {
            range[0] = row[x] < range[0] ? row[x] : range[0];
            range[1] = row[x] > range[1] ? row[x] : range[1];
        }
    }
}

enum weft_result weft_resample_check_move(const weft_resample_plan *plan,
                                          struct weft_resample_integers *source,
                                          const struct weft_rectangle *part, const uint32_t *pixels,
                                          int64_t *stride, struct weft_rectangle *out)
{
    const struct weft_resample_info *info = &plan->info;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(plan->log, is_readable(source) && pixels);
    if (source->width != info->size[0] || source->height != info->size[1]) {
        weft_error(plan->log, "moving %d x %d integers by a plan for %d x %d samples",
                   source->width, source->height, info->size[0], info->size[1]);
        goto fail;
    }
    if (!info->moves) {
        weft_error(
            plan->log,
            "%s%s is no plan to move integers by: one without passes, of a kernel that takes "
            "one sample, is",
            info->kernel.info->name, info->passes ? " by passes" : "");
        goto fail;
    }
    res = weft_rectangle_within(plan->log, part ? part : &(struct weft_rectangle){0}, info->width,
                                info->height, out);
    if (res == WEFT_OK)
        res = weft_resample_check_reach(plan->log, plan, out, &source->window);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    *stride = *stride ? *stride : out->width;
    weft_require(plan->log, *stride >= out->width);
    res = WEFT_OK;
fail:
    return res;
}

// The columns or rows that the kernel takes; NULL: out of memory.
static int *find_samples(const weft_resample_plan *plan, int axis, int first, int count)
{
    const double *at = plan->at[axis] + first;
    int *out = malloc((size_t)count * sizeof *out);
    double fraction;
    for (int i = 0; out && i < count; i++)
        out[i] = (int)weft_boundary_index(
            plan->info.boundary, weft_kernel_first_tap(&plan->info.kernel, at[i], &fraction),
            plan->info.size[axis]);
    return out;
}

enum weft_result weft_resample_move(const weft_resample_plan *plan,
                                    const struct weft_resample_integers *source,
                                    const struct weft_rectangle *part, uint32_t *pixels,
                                    int64_t stride)
{
    struct weft_resample_integers from = *source;
    struct weft_rectangle p;
    enum weft_result res = weft_resample_check_move(plan, &from, part, pixels, &stride, &p);
    if (res != WEFT_OK)
        return res;
    int *columns = find_samples(plan, 0, p.x, p.width),
        *rows = find_samples(plan, 1, p.y, p.height);
    if (!columns || !rows) {
        weft_error(plan->log, "out of memory for the positions of %d x %d pixels", p.width,
                   p.height);
        res = WEFT_ERR_MEMORY;
    }
    for (int64_t y = 0; res == WEFT_OK && y < p.height; y++) {
        const uint32_t *row = row_of(&from, rows[y]);
        for (int64_t x = 0; x < p.width; x++)
            pixels[y * stride + x] = row[columns[x] - from.window.x];
    }
    free(columns);
    free(rows);
    return res;
}
