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

// Both axes: 2 (n + 1) factors of up to 1 + u a term.
static double sums_error(const struct weft_kernel *kernel, enum weft_sums sums, double gain)
{
    const double unit = sums == WEFT_SUMS_DOUBLE ? 0x1p-53 : 0x1p-24;
    return gain * gain * expm1((2.0 * kernel->width + 2.0) * log1p(unit));
}

double weft_separable_error_bound(const struct weft_kernel *kernel, enum weft_sums sums)
{
    const double gain = own_gain(kernel), error = sums_error(kernel, sums, gain);
    return sums == WEFT_SUMS_DOUBLE ? error + 0x1p-24 * (gain * gain + error) : error;
}

// What is below 2^-126 GL may flush to 0. On the CPU it is rounded to multiples of 2^-149, and
// where scaling makes samples or weights as small no more is lost than GL may lose; doubles lose
// nothing, and a pixel half of 2^-149.
struct weft_bound_terms weft_separable_bound_terms(const struct weft_kernel *kernel,
                                                   enum weft_sums sums, double largest, double cut)
{
    const double gain = own_gain(kernel), width = kernel->width;
    const double scale = gain * gain * largest >= 0x1p127 ? 4.0 * gain * gain : 1.0;
    return (struct weft_bound_terms){
        .relative = sums_error(kernel, sums, gain),
        .absolute = largest > 0.0 ? 0x1p-125 * (width + gain) * (1.0 + gain) * scale : 0.0,
        .rounded_gain = sums == WEFT_SUMS_DOUBLE ? gain * gain : 0.0,
        .prefilter = weft_prefilter_error(kernel, 2, cut),
    };
}
