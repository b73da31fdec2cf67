// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/kernel_curve.h - the curve of a kernel as its user sees it: what a single sample of
// 1 becomes. For kernels with a prefilter that is the cardinal spline, not the h that weighs
// coefficients.
#ifndef WEFT_TOOLS_DRAW_KERNEL_CURVE_H
#define WEFT_TOOLS_DRAW_KERNEL_CURVE_H

#include "weft.h"

struct kernel_curve {
    struct weft_kernel kernel, slope; // slope: the derived kernel, of prefiltered ones
    bool has_slope;
    double end; // half-width shown: to where it is 0, or of cardinal splines below 10^-3
    struct weft_prefilter prefilter;
    int overlap;
};

void kernel_curve_init(const struct weft_kernel *kernel, struct kernel_curve *out);
double kernel_curve_value(const struct kernel_curve *curve, double x);
double kernel_curve_slope(const struct kernel_curve *curve, double x); // NAN where there is none

#endif
