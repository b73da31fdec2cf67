// SPDX-License-Identifier: BSD-3-Clause
// The error of the way by coefficients.
#include <math.h>

#include "filter/analysis/analysis.h"
#include "filter/analysis/error.h"
#include "filter/kernels/kernel_records.h"

// Largest sum of |weights| of the cardinal spline, found at points a little apart.
static double cardinal_gain(const struct weft_prefilter *prefilter,
                            const struct weft_kernel *kernel)
{
    enum { POINTS = 64 };
    const int overlap = weft_prefilter_overlap(prefilter, 0x1p-32);
    const int count = kernel->width + 2 * overlap;
    double largest = 0.0;
    for (int i = 0; i <= POINTS; i++) {
        double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
        weft_prefilter_weights(prefilter, kernel, overlap, (double)i / POINTS, weights);
        for (int k = 0; k < count; k++)
            sum += fabs(weights[k]);
        largest = fmax(largest, sum);
    }
    // Between two points it can be a little more.
    return 1.02 * largest;
}

struct weft_prefilter_error weft_prefilter_error(const struct weft_kernel *kernel, int dims,
                                                 double cut)
{
    struct weft_prefilter_error error = {0.0, 0.0, 0.0, 0.0};
    struct weft_prefilter prefilter;
    if (!weft_kernel_usable(kernel) || dims < 1 || dims > 3)
        return (struct weft_prefilter_error){NAN, NAN, NAN, NAN};
    struct weft_kernel plain = *kernel;
    plain.prefiltered = false;
    if (!kernel->prefiltered || weft_prefilter_compute(NULL, kernel, &prefilter) != WEFT_OK)
        return error;
    // The product of the filters cut off less that of the whole ones is a sum of `dims` products in
    // which one factor is the difference, some are cut off and some are whole: each is convolved
    // with the kernel along its own axis.
    const double gain = weft_analysis_gain(&plain), whole = pow(gain, dims);
    const double cardinal = cardinal_gain(&prefilter, kernel) + cut * gain;
    error.coefficient = 0x1p-24 * whole;
    error.beyond = dims * gain * cut * pow(cardinal, dims - 1);
    error.sample = error.beyond + WEFT_PREFILTER_MISSING * whole;
    error.gain = pow(cardinal, dims);
    return error;
}
