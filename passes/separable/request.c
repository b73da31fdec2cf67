// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/kernels/kernel_nd.h"
#include "filter/analysis/reference.h"
#include "passes/verify/pixel_error.h"
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

// ---- errors -------------------------------------------------------------------------------------

struct verifier {
    struct weft_separable_params *params;
    double square_sum;
    uint64_t compared;
    struct weft_separable_error error;
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct weft_separable_params *p = priv;
    int64_t at[2];
    for (int a = 0; a < 2; a++)
        at[a] = index[a] < 0 ? 0 : index[a] >= p->size[a] ? p->size[a] - 1 : index[a];
    return (double)p->samples[at[1] * p->size[0] + at[0]];
}

static void check_pixel(struct verifier *v, int x, int y)
{
    struct weft_separable_error *e = &v->error;
    const struct weft_separable_params *p = v->params;
    const struct weft_reference_value reference = weft_reference_compute(
        &p->kernel, 2, (const double[2]){p->x[x], p->y[y]}, fetch, v->params);
    bool mismatch;
    const double error = weft_pixel_error(p->pixels[y * p->stride + x], reference.value, &mismatch);
    e->pixels_checked++;
    e->not_finite_mismatches += mismatch;
    if (isnan(error))
        return;
    v->square_sum += error * error;
    v->compared++;
    if (error > 0.0)
        e->relative_maximum = fmax(e->relative_maximum, error / reference.magnitude);
    if (error > e->maximum || v->compared == 1) {
        e->maximum = error;
        e->at_x = x;
        e->at_y = y;
    }
}

static uint64_t greatest_common_divisor(uint64_t a, uint64_t b)
{
    while (b) {
        const uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

// A step that comes by all pixels, and is spread over the image wherever it stops: near the golden
// section of their number, without a divisor in common with it.
static uint64_t find_step(uint64_t pixels)
{
    uint64_t step = (uint64_t)(0.61803398874989485 * (double)pixels);
    while (step > 1 && greatest_common_divisor(step, pixels) != 1)
        step--;
    return step ? step : 1;
}

static enum weft_result check_pixels(struct verifier *v, double max_seconds)
{
    enum { PIXELS_AT_ONCE = 4096 };
    const struct weft_separable_params *p = v->params;
    const uint64_t total = v->error.pixels_total, width = (uint64_t)p->width;
    // Neighbours one after another where there is time for all.
    const uint64_t step = max_seconds > 0.0 ? find_step(total) : 1;
    const double start = weft_now_seconds();
    uint64_t at = 0;
    for (uint64_t i = 0; i < total; i++) {
        if (i % PIXELS_AT_ONCE == 0) {
            if (!weft_separable_go_on(p->progress, (double)i / (double)total)) {
                weft_note(p->log, "verifying was cancelled at pixel %llu of %llu",
                          (unsigned long long)i, (unsigned long long)total);
                return WEFT_ERR_CANCELLED;
            }
            if (max_seconds > 0.0 && i > 0 && weft_now_seconds() - start > max_seconds)
                break;
        }
        check_pixel(v, (int)(at % width), (int)(at / width));
        at = (at + step) % total;
    }
    weft_separable_go_on(p->progress, 1.0);
    return WEFT_OK;
}

enum weft_result weft_separable_verify(const struct weft_separable_params *params,
                                       double max_seconds, struct weft_separable_error *out)
{
    struct weft_separable_params resolved;
    *out = (struct weft_separable_error){0};
    enum weft_result res = weft_separable_check(params, &resolved);
    if (res != WEFT_OK)
        return res;
    struct verifier v = {.params = &resolved};
    v.error.pixels_total = (uint64_t)resolved.width * (uint64_t)resolved.height;
    res = check_pixels(&v, max_seconds);
    if (res != WEFT_OK)
        return res;
    v.error.rms = v.compared ? sqrt(v.square_sum / (double)v.compared) : 0.0;
    *out = v.error;
    return WEFT_OK;
}
