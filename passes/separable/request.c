// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/kernels/kernel_nd.h"
#include "passes/separable/job.h"

// ---- the request --------------------------------------------------------------------------------

static bool in_range(int size)
{
    return size >= 1 && size <= WEFT_SEPARABLE_MAX_SIZE;
}

static enum weft_result check_positions(const struct weft_log *log, char axis, const double *at,
                                        int count)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(at[i])) {
            weft_error(log, "separable filtering: position %g of pixel %d along %c", at[i], i,
                       axis);
            return WEFT_ERR_ARGUMENT;
        }
    }
    return WEFT_OK;
}

static enum weft_result check_sizes(const struct weft_separable_params *p)
{
    if (!in_range(p->size[0]) || !in_range(p->size[1]) || !in_range(p->width) ||
        !in_range(p->height)) {
        weft_error(
            p->log,
            "separable filtering of %d x %d samples to %d x %d pixels: sides must be 1 to %d",
            p->size[0], p->size[1], p->width, p->height, WEFT_SEPARABLE_MAX_SIZE);
        return WEFT_ERR_ARGUMENT;
    }
    if (p->stride < p->width) {
        weft_error(p->log,
                   "separable filtering: a stride of %lld floats is less than the %d pixels",
                   (long long)p->stride, p->width);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result weft_separable_check(const struct weft_separable_params *params,
                                      struct weft_separable_params *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_log *log = params->log;
    *out = *params;
    weft_require(log, params->samples && params->x && params->y && params->pixels);
    if (!out->kernel.info)
        weft_kernel_parse(log, "catmull-rom", &out->kernel);
    out->stride = out->stride ? out->stride : out->width;
    out->memory_bytes = out->memory_bytes ? out->memory_bytes : UINT64_C(1) << 30;
    res = weft_kernel_check(log, &out->kernel);
    if (res != WEFT_OK)
        goto fail;
    res = WEFT_ERR_ARGUMENT;
    if (weft_kernel_is_radial(&out->kernel, 2)) {
        weft_error(log, "separable filtering: kernel %s is radial, not separable",
                   out->kernel.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    res = check_sizes(out);
    if (res == WEFT_OK)
        res = check_positions(log, 'x', out->x, out->width);
    if (res == WEFT_OK)
        res = check_positions(log, 'y', out->y, out->height);
fail:
    return res;
}
