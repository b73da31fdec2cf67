// SPDX-License-Identifier: BSD-3-Clause
// Weights at positions.
#include <math.h>

#include "filter/kernels/kernel_records.h"

// Splits x, within 2^62 of 0, into an integer and the distance past it in [0, 1): x - floor(x)
// rounds to 1 where x is a tiny negative number, and is to be no -0. Faster than floor.
static double split(double x, double *fraction)
{
    const double toward_zero = (double)(int64_t)x;
    const double base = toward_zero > x ? toward_zero - 1.0 : toward_zero;
    *fraction = x - base + 0.0;
    if (*fraction < 1.0)
        return base;
    *fraction = 0.0;
    return base + 1.0;
}

int64_t weft_kernel_first_tap(const struct weft_kernel *kernel, double x, double *fraction)
{
    const double limit = 0x1p62, below_one = 1.0 - 0x1p-53;
    if (kernel->width < 1 || kernel->width > WEFT_KERNEL_MAX_WIDTH) {
        *fraction = NAN;
        return 0;
    }
    const double within = x > limit ? limit : x < -limit ? -limit : x == x ? x : 0.0;
    double base = split(within, fraction);
    if (kernel->width % 2 == 0)
        return (int64_t)base - kernel->width / 2 + 1;
    // Not floor(x + 1/2): that sum rounds the double below 1/2 up to 1.
    if (*fraction >= 0.5) {
        base += 1.0;
        *fraction -= 0.5;
    } else {
        const double later = *fraction + 0.5;
        *fraction = later < below_one ? later : below_one;
    }
    return (int64_t)base - (kernel->width - 1) / 2;
}

double weft_kernel_offset(const struct weft_kernel *kernel)
{
    return 0.5 * kernel->width - 1.0;
}

// Radial kernels lose the flag for what they are in 2D and 3D; along one axis h is what it was.
static bool value_interpolates(const struct weft_kernel *kernel)
{
    struct weft_kernel plain = *kernel;
    if (!kernel->radial)
        return kernel->interpolating;
    plain.interpolating = kernel->info->interpolating;
    if (kernel->info->refine)
        kernel->info->refine(&plain);
    return plain.interpolating;
}

double weft_kernel_value(const struct weft_kernel *kernel, double x)
{
    if (x == rint(x) && value_interpolates(kernel))
        return x == 0.0 ? 1.0 : 0.0;
    return kernel->info->weight(kernel, x);
}

double weft_kernel_argument(double fraction, double shift)
{
    const double x = fraction + shift, knot = shift + 1.0;
    return x < knot ? x : nextafter(knot, -INFINITY);
}

static int64_t plain_weights(const struct weft_kernel *kernel, double x, double *weights)
{
    double fraction;
    const int64_t first = weft_kernel_first_tap(kernel, x, &fraction);
    const double offset = weft_kernel_offset(kernel);
    for (int j = 0; j < kernel->width; j++)
        weights[j] = weft_kernel_value(kernel, weft_kernel_argument(fraction, offset - j));
    return first;
}

static double sum(const double *values, int count)
{
    double total = 0.0;
    for (int i = 0; i < count; i++)
        total += values[i];
    return total;
}

int64_t weft_kernel_weights(const struct weft_kernel *kernel, double x, double *weights)
{
    if (!weft_kernel_usable(kernel))
        return 0;
    const int64_t first = plain_weights(kernel, x, weights);
    if (kernel->normalised) {
        const double total = sum(weights, kernel->width);
        for (int j = 0; j < kernel->width; j++)
            weights[j] /= total;
    }
    return first;
}

double weft_kernel_weight(const struct weft_kernel *kernel, double x)
{
    if (!weft_kernel_usable(kernel))
        return NAN;
    const double h = weft_kernel_value(kernel, x);
    if (!kernel->normalised || h == 0.0)
        return h;
    double weights[WEFT_KERNEL_MAX_WIDTH];
    plain_weights(kernel, x, weights);
    return h / sum(weights, kernel->width);
}

// (h / s)' = (h' - h s' / s) / s.
double weft_kernel_derivative(const struct weft_kernel *kernel, double x)
{
    if (!weft_kernel_usable(kernel) || !kernel->info->derivative)
        return NAN;
    const double slope = kernel->info->derivative(kernel, x);
    if (!kernel->normalised || !(fabs(x) <= kernel->support))
        return slope;
    double weights[WEFT_KERNEL_MAX_WIDTH], slopes[WEFT_KERNEL_MAX_WIDTH];
    const int64_t first = plain_weights(kernel, x, weights);
    for (int j = 0; j < kernel->width; j++)
        slopes[j] = kernel->info->derivative(kernel, x - (double)(first + j));
    const double total = sum(weights, kernel->width);
    return (slope - weft_kernel_value(kernel, x) * sum(slopes, kernel->width) / total) / total;
}
