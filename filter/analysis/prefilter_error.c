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

// NAN for a kernel that is none, 0 for one that is not prefiltered.
static struct weft_prefilter_error along_axis(const struct weft_kernel *kernel, double cut)
{
    struct weft_prefilter prefilter;
    struct weft_kernel plain = *kernel;
    plain.prefiltered = false;
    if (!weft_kernel_usable(kernel))
        return (struct weft_prefilter_error){NAN, NAN, NAN, NAN};
    if (!kernel->prefiltered || weft_prefilter_compute(NULL, kernel, &prefilter))
        return (struct weft_prefilter_error){0.0, 0.0, 0.0, 0.0};
    const double gain = weft_analysis_gain(&plain);
    return (struct weft_prefilter_error){
        .coefficient = 0x1p-24 * gain,
        .sample = gain * cut + WEFT_PREFILTER_MISSING * gain,
        .beyond = gain * cut,
        .gain = cardinal_gain(&prefilter, kernel) + cut * gain,
    };
}

struct weft_prefilter_error weft_prefilter_error_join(const struct weft_prefilter_error along[],
                                                      int dims)
{
    struct weft_prefilter_error error = {.gain = 1.0};
    double whole = 1.0;
    if (dims < 1 || dims > 3)
        return (struct weft_prefilter_error){NAN, NAN, NAN, NAN};
    // The product of the filters cut off less that of the whole ones is a sum of `dims` products in
    // which one factor is the difference, some are cut off and some are whole: each is convolved
    // with the kernel along its own axis.
    for (int a = 0; a < dims; a++) {
        double beyond = along[a].beyond;
        for (int b = 0; b < dims; b++)
            beyond *= b == a ? 1.0 : along[b].gain;
        error.beyond += beyond;
        error.gain *= along[a].gain;
        whole *= 0x1p24 * along[a].coefficient;
    }
    error.coefficient = 0x1p-24 * whole;
    error.sample = error.beyond + WEFT_PREFILTER_MISSING * whole;
    return error;
}

struct weft_prefilter_error weft_prefilter_error_axes(const struct weft_kernel kernel[], int dims,
                                                      double cut)
{
    struct weft_prefilter_error along[3];
    for (int a = 0; a < dims && a < 3; a++) {
        along[a] = along_axis(&kernel[a], cut);
        if (!(along[a].gain > 0.0)) // as that axis is
            return along[a];
    }
    return weft_prefilter_error_join(along, dims);
}

struct weft_prefilter_error weft_prefilter_error(const struct weft_kernel *kernel, int dims,
                                                 double cut)
{
    struct weft_prefilter_error along[3];
    along[0] = along[1] = along[2] = along_axis(kernel, cut);
    // Of what is no kernel or has no prefilter, as the axis is; of no number of axes, NAN.
    return along[0].gain > 0.0 || dims < 1 || dims > 3 ? weft_prefilter_error_join(along, dims)
                                                       : along[0];
}
