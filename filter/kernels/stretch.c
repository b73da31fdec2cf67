// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/stretch.h"

#include <math.h>

#include "filter/kernels/kernel_records.h"

// What any caller may rely on, but for what the record says of itself.
static bool is_usable(const struct weft_kernel *kernel, double scale)
{
    return kernel && !kernel->radial && scale >= 1.0 && scale <= WEFT_STRETCH_MAX &&
           weft_kernel_usable(kernel);
}

static int64_t width_of(const struct weft_kernel *kernel, double scale)
{
    if (scale == 1.0)
        return kernel->width;
    return (int64_t)ceil(2.0 * kernel->support * scale) + (kernel->width == 1);
}

double weft_stretch_scale(const struct weft_kernel *kernel, double distance)
{
    if (!kernel || !kernel->info || kernel->info->moves || !(distance > 1.0))
        return 1.0;
    return fmin(distance, WEFT_STRETCH_MAX);
}

int64_t weft_stretch_width(const struct weft_kernel *kernel, double scale)
{
    const bool valid = is_usable(kernel, scale) && weft_kernel_check(NULL, kernel) == WEFT_OK;
    return valid ? width_of(kernel, scale) : 0;
}

// What of each sample's unit square lies within scale / 2 of x.
static int64_t cover(double scale, double x, double *weights, int64_t width)
{
    const double from = x - 0.5 * scale, to = x + 0.5 * scale;
    const int64_t first = (int64_t)floor(from + 0.5);
    for (int64_t i = 0; i < width; i++) {
        const double middle = (double)(first + i);
        const double covered = fmin(to, middle + 0.5) - fmax(from, middle - 0.5);
        weights[i] = fmax(covered, 0.0) / scale;
    }
    return first;
}

// Divides by the sum, or by what keeps a derivative one.
static void scale_weights(const struct weft_kernel *kernel, double scale, double *weights,
                          int64_t width)
{
    double divisor = pow(scale, 1 + kernel->info->derivation);
    if (kernel->unit_sum && kernel->info->derivation == 0) {
        divisor = 0.0;
        for (int64_t i = 0; i < width; i++)
            divisor += weights[i];
    }
    for (int64_t i = 0; i < width; i++)
        weights[i] /= divisor;
}

int64_t weft_stretch_weights(const struct weft_kernel *kernel, double scale, double x,
                             double *weights)
{
    if (!is_usable(kernel, scale) || !isfinite(x))
        return 0;
    const int64_t width = width_of(kernel, scale);
    if (scale == 1.0)
        return weft_kernel_weights(kernel, x, weights);
    if (kernel->width == 1)
        return cover(scale, x, weights, width);
    // The support is [-r, r): the lowest sample is the first one past x - r scale.
    const int64_t first = (int64_t)floor(x - kernel->support * scale) + 1;
    for (int64_t i = 0; i < width; i++)
        weights[i] = weft_kernel_weight(kernel, (x - (double)(first + i)) / scale);
    scale_weights(kernel, scale, weights, width);
    return first;
}
