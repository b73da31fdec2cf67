// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernel_records.h"

#include <math.h>
#include <stddef.h>

enum { MAX_DEGREE = 5 };

// The centred cardinal B-spline of a degree, zero outside its support, by the recursion of de Boor
// and Cox: every term is positive, so nothing cancels (truncated powers lose all digits at the
// ends).
static double bspline(int degree, double x)
{
    const double radius = 0.5 * (degree + 1);
    if (!(x >= -radius && x < radius))
        return 0.0;
    // Just below the right end the sum rounds up to it.
    const double position = x + radius, knot = fmin(floor(position), degree), u = position - knot;
    // b[i]: the piece of B_d that is i knots from its start, for d = 0..degree.
    double b[MAX_DEGREE + 1] = {1.0};
    for (int d = 1; d <= degree; d++) {
        b[d] = (1.0 - u) * b[d - 1] / d;
        for (int i = d - 1; i > 0; i--)
            b[i] = ((u + i) * b[i] + (d - i + 1 - u) * b[i - 1]) / d;
        b[0] = u * b[0] / d;
    }
    return b[(int)knot];
}

static double weight(const struct weft_kernel *kernel, double x)
{
    const int degree = kernel->info->degree;
    return bspline(degree, degree > 0 ? fabs(x) : x);
}

static double derivative(const struct weft_kernel *kernel, double x)
{
    const int degree = kernel->info->degree;
    return bspline(degree - 1, x + 0.5) - bspline(degree - 1, x - 0.5);
}

const struct weft_kernel_info weft_kernel_nearest = {
    .name = "nearest",
    .description = "the nearest sample",
    .citation = "box of unit width",
    .radius = 0.5,
    .weight = weight,
    .degree = 0,
    .continuity = -1,
    .order = 1,
    .interpolating = true,
    .unit_sum = true,
};

const struct weft_kernel_info weft_kernel_linear = {
    .name = "linear",
    .description = "linear interpolation",
    .citation = "tent of half-width 1",
    .radius = 1.0,
    .weight = weight,
    .derivative = derivative,
    .degree = 1,
    .continuity = 0,
    .order = 2,
    .interpolating = true,
    .unit_sum = true,
};

#define BSPLINE(text, n, ...)                                                                      \
    {                                                                                              \
        .name = text, .description = "B-spline of degree " #n,                                     \
        .citation = "Schoenberg 1946; Unser, IEEE Signal Processing Magazine 1999",                \
        .radius = 0.5 * (n + 1), .weight = weight, .derivative = n > 0 ? derivative : NULL,        \
        .degree = n, .continuity = n - 1, .order = n > 0 ? 2 : 1, .interpolating = n < 2,          \
        .unit_sum = true, __VA_ARGS__                                                              \
    }

const struct weft_kernel_info weft_kernel_bspline =
    BSPLINE("bspline", 3, .description = "cubic B-spline, smooths unless prefiltered");

const struct weft_kernel_info weft_kernel_bspline_degree[6] = {
    BSPLINE("bspline0", 0, ), BSPLINE("bspline1", 1, ), BSPLINE("bspline2", 2, ),
    BSPLINE("bspline3", 3, ), BSPLINE("bspline4", 4, ), BSPLINE("bspline5", 5, ),
};
