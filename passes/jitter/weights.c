// SPDX-License-Identifier: BSD-3-Clause
#include "passes/jitter/weights.h"

#include <math.h>

#include "filter/check.h"
#include "passes/jitter/points.h"
#include "passes/jitter/weights_impl.h"

enum weft_result weft_weights_normalise(const struct weft_log *log, int count, double *weights,
                                        struct weft_weights_report *report)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_weights_report r = {.sum = 0.0};
    double squares = 0.0, negative = 0.0, magnitude = 0.0;
    if (report)
        *report = WEFT_WEIGHTS_NONE;
    weft_require(log, count > 0 && weights);
    for (int i = 0; i < count; i++) {
        r.sum += weights[i];
        magnitude += fabs(weights[i]);
    }
    if (!(r.sum > 0.0 && r.sum >= 1e-3 * magnitude && isfinite(magnitude))) {
        weft_error(log, "%d weights add up to %g, their magnitudes to %g", count, r.sum, magnitude);
        goto fail;
    }
    for (int i = 0; i < count; i++) {
        weights[i] /= r.sum;
        const double size = fabs(weights[i]);
        r.gain += size;
        negative += weights[i] < 0.0 ? size : 0.0;
        r.largest = fmax(r.largest, size);
        squares += size * size;
        r.zeros += size == 0.0;
    }
    r.negative = negative / r.gain;
    r.effective = 1.0 / squares;
    if (report)
        *report = r;
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_weights_even(const struct weft_log *log, int count, double *weights,
                                   struct weft_weights_report *report)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (report)
        *report = WEFT_WEIGHTS_NONE;
    weft_require(log, count > 0 && weights);
    for (int i = 0; i < count; i++)
        weights[i] = 1.0;
    res = weft_weights_normalise(log, count, weights, report);
fail:
    return res;
}

// ---- kernels
// --------------------------------------------------------------------------------------

static enum weft_result resolve(const struct weft_log *log, struct weft_kernel *kernel)
{
    if (!kernel->info)
        return weft_kernel_create(log, weft_kernel_find("nearest"), NULL, kernel);
    const enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    if (kernel->info->derivation > 0) {
        weft_error(log, "kernel %s is a derivative: its weights add up to 0", kernel->info->name);
        return WEFT_ERR_ARGUMENT;
    }
    if (kernel->radial || kernel->prefiltered) {
        weft_error(log, "samples are not weighed by %s kernels (%s)",
                   kernel->radial ? "radial" : "prefiltered", kernel->info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    return WEFT_OK;
}

enum weft_result weft_weights_resolve(const struct weft_log *log, double width,
                                      struct weft_kernel *kernel, double *scale)
{
    if (width != 0.0 && !(width >= 0x1p-20 && width <= 0x1p20)) {
        weft_error(log, "a filter is %g pixels wide: it must be 2^-20 to 2^20", width);
        return WEFT_ERR_ARGUMENT;
    }
    const enum weft_result res = resolve(log, kernel);
    if (res == WEFT_OK)
        *scale = width == 0.0 ? 1.0 : width / (2.0 * kernel->support);
    return res;
}

// h at a sample's place, with both ends of its support in it, as far as rounding goes.
static double weigh_axis(const struct weft_kernel *kernel, double x)
{
    const double r = kernel->support;
    const bool on_rim = fabs(x) >= r && fabs(x) <= r * (1.0 + 0x1p-50);
    return weft_kernel_weight(kernel, on_rim ? copysign(nextafter(r, 0.0), x) : x);
}

static double weigh(const struct weft_kernel *kernel, double scale, const double point[2])
{
    return weigh_axis(kernel, -point[0] / scale) * weigh_axis(kernel, -point[1] / scale);
}

enum weft_result weft_weights_kernel(const struct weft_weights_kernel_params *params,
                                     double *weights, struct weft_weights_report *report)
{
    const struct weft_log *log = params ? params->log : NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_kernel kernel;
    double scale;
    if (report)
        *report = WEFT_WEIGHTS_NONE;
    weft_require(log, params && params->points && params->count > 0 && weights);
    kernel = params->kernel;
    res = weft_weights_resolve(params->log, params->width, &kernel, &scale);
    if (res != WEFT_OK)
        goto fail;
    res = WEFT_ERR_ARGUMENT;
    if (!weft_points_check(params->log, params->points, params->count))
        goto fail;
    double sum = 0.0, magnitude = 0.0;
    for (int i = 0; i < params->count; i++) {
        const double weight = weigh(&kernel, scale, params->points[i]);
        sum += weight;
        magnitude += fabs(weight);
    }
    if (!(sum > 0.0 && sum >= 1e-3 * magnitude)) {
        weft_error(log,
                   "the weights of %d samples by kernel %s add up to %g, their magnitudes to %g",
                   params->count, kernel.info->name, sum, magnitude);
        goto fail;
    }
    for (int i = 0; i < params->count; i++)
        weights[i] = weigh(&kernel, scale, params->points[i]);
    res = weft_weights_normalise(params->log, params->count, weights, report);
fail:
    return res;
}
