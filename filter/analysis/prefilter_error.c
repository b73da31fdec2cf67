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

struct weft_prefilter_error weft_prefilter_error_axes(const struct weft_kernel kernel[], int dims,
                                                      double cut)
{
    struct weft_prefilter_error error = {0.0, 0.0, 0.0, 0.0};
    double gain[3], cardinal[3], whole = 1.0;
    if (dims < 1 || dims > 3)
        return (struct weft_prefilter_error){NAN, NAN, NAN, NAN};
    for (int a = 0; a < dims; a++) {
        struct weft_prefilter prefilter;
        struct weft_kernel plain = kernel[a];
        plain.prefiltered = false;
        if (!weft_kernel_usable(&kernel[a]))
            return (struct weft_prefilter_error){NAN, NAN, NAN, NAN};
        if (!kernel[a].prefiltered || weft_prefilter_compute(NULL, &kernel[a], &prefilter))
            return error;
        gain[a] = weft_analysis_gain(&plain);
        cardinal[a] = cardinal_gain(&prefilter, &kernel[a]) + cut * gain[a];
        whole *= gain[a];
    }
    // The product of the filters cut off less that of the whole ones is a sum of `dims` products in
    // which one factor is the difference, some are cut off and some are whole: each is convolved
    // with the kernel along its own axis.
    error.gain = 1.0;
    for (int a = 0; a < dims; a++) {
        double beyond = gain[a] * cut;
        for (int b = 0; b < dims; b++)
            beyond *= b == a ? 1.0 : cardinal[b];
        error.beyond += beyond;
        error.gain *= cardinal[a];
    }
    error.coefficient = 0x1p-24 * whole;
    error.sample = error.beyond + WEFT_PREFILTER_MISSING * whole;
    return error;
}

struct weft_prefilter_error weft_prefilter_error(const struct weft_kernel *kernel, int dims,
                                                 double cut)
{
    const struct weft_kernel all[3] = {*kernel, *kernel, *kernel};
    return weft_prefilter_error_axes(all, dims, cut);
}
