// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/kernel_curve.h"

#include <math.h>

// Of what is left out beyond the overlap, and of what is shown of a cardinal spline.
static const double left_out = 0x1p-40, shown = 1e-3;

void kernel_curve_init(const struct weft_kernel *kernel, struct kernel_curve *out)
{
    *out = (struct kernel_curve){.kernel = *kernel,
                                 .has_slope = kernel->info->derivative != NULL,
                                 .end = kernel->support + 0.5};
    if (!kernel->prefiltered || weft_prefilter_compute(NULL, kernel, &out->prefilter) != WEFT_OK)
        return;
    out->has_slope = weft_kernel_derive(NULL, kernel, &out->slope) == WEFT_OK;
    out->overlap = weft_prefilter_overlap(&out->prefilter, left_out);
    out->end += weft_prefilter_overlap(&out->prefilter, shown);
}

// The weight that sample 0 has at position x.
static double cardinal(const struct kernel_curve *curve, const struct weft_kernel *kernel, double x)
{
    double weights[WEFT_PREFILTER_MAX_WEIGHTS];
    const int64_t first =
        weft_prefilter_weights(&curve->prefilter, kernel, curve->overlap, x, weights);
    const int64_t count = kernel->width + 2 * curve->overlap;
    return first <= 0 && -first < count ? weights[-first] : 0.0;
}

double kernel_curve_value(const struct kernel_curve *curve, double x)
{
    return curve->kernel.prefiltered ? cardinal(curve, &curve->kernel, x)
                                     : weft_kernel_weight(&curve->kernel, x);
}

double kernel_curve_slope(const struct kernel_curve *curve, double x)
{
    if (!curve->has_slope)
        return (double)NAN;
    return curve->kernel.prefiltered ? cardinal(curve, &curve->slope, x)
                                     : weft_kernel_derivative(&curve->kernel, x);
}
