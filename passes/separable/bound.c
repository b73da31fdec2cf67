// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/analysis/analysis.h"
#include "passes/separable/separable.h"

static double own_gain(const struct weft_kernel *kernel)
{
    struct weft_kernel plain = *kernel;
    plain.prefiltered = false;
    return weft_analysis_gain(&plain);
}

static double bound_of_gain(double gain, double width)
{
    return gain * gain * expm1((2.0 * width + 2.0) * log1p(0x1p-24));
}

double weft_separable_error_bound(const struct weft_kernel *kernel)
{
    return bound_of_gain(own_gain(kernel), kernel->width);
}

struct weft_bound_terms weft_separable_bound_terms(const struct weft_kernel *kernel, double largest,
                                                   double cut)
{
    const double gain = own_gain(kernel), width = kernel->width;
    const double scale = gain * gain * largest >= 0x1p127 ? 4.0 * gain * gain : 1.0;
    return (struct weft_bound_terms){
        .relative = bound_of_gain(gain, width),
        .absolute = largest > 0.0 ? 0x1p-125 * (width + gain) * (1.0 + gain) * scale : 0.0,
        .prefilter = weft_prefilter_error(kernel, 2, cut),
    };
}
