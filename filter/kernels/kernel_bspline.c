// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/kernel_records.h"

#include <math.h>
#include <stddef.h>

enum { MAX_DEGREE = 7 };

// The centred cardinal B-spline of a degree, zero outside its support, by the recursion of de Boor
// and Cox: every term is positive, so nothing cancels (truncated powers lose all digits at the
// ends).
static double value(int degree, double x)
{
    const double radius = 0.5 * (degree + 1);
    if (!(x >= -radius && x < radius))
        return 0.0;
    // Mirrored where that changes nothing but the rounding. Just below the right end the sum rounds
    // up to it.
    const double position = (degree > 0 ? -fabs(x) : x) + radius;
    const double knot = fmin(floor(position), degree), u = position - knot;
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

// The n-th derivative is the n-th central difference of the B-spline n degrees lower.
static double bspline(const struct weft_kernel *kernel, double x, int n)
{
    static const double binomials[4][4] = {{1}, {1, -1}, {1, -2, 1}, {1, -3, 3, -1}};
    const int degree = kernel->info->degree + kernel->info->derivation - n;
    double sum = 0.0;
    for (int j = 0; j <= n; j++)
        sum += binomials[n][j] * value(degree, x + (0.5 * n - j));
    return sum;
}

WEFT_KERNEL_NTH(bspline, 0)
WEFT_KERNEL_NTH(bspline, 1)
WEFT_KERNEL_NTH(bspline, 2)
WEFT_KERNEL_NTH(bspline, 3)

const struct weft_kernel_info weft_kernel_nearest[1] = {
    WEFT_KERNEL_RECORD("nearest", bspline, 0, -1,
                       (.description = "the nearest sample", .citation = "box of unit width",
                        .order = 1, .order_prefiltered = 1, .interpolating = true, .unit_sum = true,
                        .moves = true, .radius = 0.5)),
};

const struct weft_kernel_info weft_kernel_area[1] = {
    WEFT_KERNEL_RECORD("area", bspline, 0, -1,
                       (.description = "the nearest sample; the mean of what a larger pixel covers",
                        .citation = "box of unit width", .order = 1, .order_prefiltered = 1,
                        .interpolating = true, .unit_sum = true, .radius = 0.5)),
};

#define TENT .citation = "tent of half-width 1", .radius = 1.0
const struct weft_kernel_info weft_kernel_linear[2] = {
    WEFT_KERNEL_RECORD("linear", bspline, 1, 0,
                       (.description = "linear interpolation", .order = 2, .order_prefiltered = 2,
                        .interpolating = true, .unit_sum = true),
                       TENT),
    WEFT_KERNEL_D(weft_kernel_linear, "linear", bspline, 1, 0, 1, TENT),
};

#define UNSER(n)                                                                                   \
    .citation = "Schoenberg 1946; Unser, IEEE Signal Processing Magazine 1999",                    \
    .radius = 0.5 * (n + 1)

#define OWN(about, n)                                                                              \
    (.description = about, .order = n > 0 ? 2 : 1, .order_prefiltered = n + 1,                     \
     .interpolating = n < 2, .unit_sum = true)

#define BSPLINE(self, text, about, n, order_dd)                                                    \
    {                                                                                              \
        WEFT_KERNEL_RECORD(text, bspline, n, n - 1, OWN(about, n), UNSER(n)),                      \
            WEFT_KERNEL_D(self, text, bspline, n, n - 1, 2, UNSER(n)),                             \
            WEFT_KERNEL_DD(self, text, bspline, n > 2 ? bspline_3 : NULL, n, n - 1, order_dd,      \
                           UNSER(n)),                                                              \
    }

const struct weft_kernel_info weft_kernel_bspline[3] =
    BSPLINE(weft_kernel_bspline, "bspline", "cubic B-spline, smooths unless prefiltered", 3, 2);

const struct weft_kernel_info weft_kernel_bspline0[1] = {
    WEFT_KERNEL_RECORD("bspline0", bspline, 0, -1, OWN("B-spline of degree 0", 0), UNSER(0)),
};
const struct weft_kernel_info weft_kernel_bspline1[2] = {
    WEFT_KERNEL_RECORD("bspline1", bspline, 1, 0, OWN("B-spline of degree 1", 1), UNSER(1)),
    WEFT_KERNEL_D(weft_kernel_bspline1, "bspline1", bspline, 1, 0, 1, UNSER(1)),
};
const struct weft_kernel_info weft_kernel_bspline2[3] =
    BSPLINE(weft_kernel_bspline2, "bspline2", "B-spline of degree 2", 2, 1);
const struct weft_kernel_info weft_kernel_bspline3[3] =
    BSPLINE(weft_kernel_bspline3, "bspline3", "B-spline of degree 3", 3, 2);
const struct weft_kernel_info weft_kernel_bspline4[3] =
    BSPLINE(weft_kernel_bspline4, "bspline4", "B-spline of degree 4", 4, 2);
const struct weft_kernel_info weft_kernel_bspline5[3] =
    BSPLINE(weft_kernel_bspline5, "bspline5", "B-spline of degree 5", 5, 2);
const struct weft_kernel_info weft_kernel_bspline6[3] =
    BSPLINE(weft_kernel_bspline6, "bspline6", "B-spline of degree 6", 6, 2);
const struct weft_kernel_info weft_kernel_bspline7[3] =
    BSPLINE(weft_kernel_bspline7, "bspline7", "B-spline of degree 7", 7, 2);
