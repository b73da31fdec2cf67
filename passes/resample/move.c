// SPDX-License-Identifier: BSD-3-Clause
// Unsigned integers that are moved, not filtered.
#include <stdlib.h>

#include "passes/resample/resample_impl.h"

bool weft_resample_moves(const struct weft_kernel *kernel)
{
    return kernel->info && kernel->width == 1 && kernel->unit_sum && !kernel->radial &&
           !kernel->prefiltered && kernel->info->derivation == 0;
}

static bool is_readable(const struct weft_resample_integers *source)
{
    return source->width >= 1 && source->height >= 1 && source->plane &&
           (!source->stride || source->stride >= source->width);
}

static int64_t stride_of(const struct weft_resample_integers *source)
{
    return source->stride ? source->stride : source->width;
}

void weft_resample_integer_range(const struct weft_resample_integers *source, uint32_t range[2])
{
    const bool readable = is_readable(source);
    range[0] = readable ? UINT32_MAX : 0;
    range[1] = 0;
    for (int64_t y = 0; readable && y < source->height; y++) {
        const uint32_t *row = source->plane + y * stride_of(source);
        for (int64_t x = 0; x < source->width; x++) {
            range[0] = row[x] < range[0] ? row[x] : range[0];
            range[1] = row[x] > range[1] ? row[x] : range[1];
        }
    }
}

enum weft_result weft_resample_check_move(const weft_resample_plan *plan,
                                          const struct weft_resample_integers *source,
                                          const uint32_t *pixels, int64_t stride)
{
    const struct weft_resample_info *info = &plan->info;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(plan->log, is_readable(source) && pixels);
    weft_require(plan->log, stride >= info->width);
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
    res = WEFT_OK;
fail:
    return res;
}

static int clamp(int64_t i, int size)
{
    return i < 0 ? 0 : i >= size ? size - 1 : (int)i;
}

// The columns or rows that the kernel takes; NULL: out of memory.
static int *find_samples(const weft_resample_plan *plan, int axis)
{
    const int count = axis ? plan->info.height : plan->info.width;
    int *out = malloc((size_t)count * sizeof *out);
    double fraction;
    for (int i = 0; out && i < count; i++)
        out[i] = clamp(weft_kernel_first_tap(&plan->info.kernel, plan->at[axis][i], &fraction),
                       plan->info.size[axis]);
    return out;
}

enum weft_result weft_resample_move(const weft_resample_plan *plan,
                                    const struct weft_resample_integers *source, uint32_t *pixels,
                                    int64_t stride)
{
    stride = stride ? stride : plan->info.width;
    enum weft_result res = weft_resample_check_move(plan, source, pixels, stride);
    if (res != WEFT_OK)
        return res;
    int *columns = find_samples(plan, 0), *rows = find_samples(plan, 1);
    if (!columns || !rows) {
        weft_error(plan->log, "out of memory for the positions of %d x %d pixels", plan->info.width,
                   plan->info.height);
        res = WEFT_ERR_MEMORY;
    }
    for (int64_t y = 0; res == WEFT_OK && y < plan->info.height; y++) {
        const uint32_t *from = source->plane + rows[y] * stride_of(source);
        for (int64_t x = 0; x < plan->info.width; x++)
            pixels[y * stride + x] = from[columns[x]];
    }
    free(columns);
    free(rows);
    return res;
}
