// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/job.h - what checking and running separable filters share (not installed).
#ifndef WEFT_PASSES_SEPARABLE_JOB_H
#define WEFT_PASSES_SEPARABLE_JOB_H

#include "filter/check.h"
#include "passes/separable/separable.h"

// The request with its defaults filled in. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_UNSUPPORTED.
enum weft_result weft_separable_check(const struct weft_separable_params *params,
                                      struct weft_separable_params *out);

// Samples in reach of the pixels along an axis, inclusive.
struct weft_separable_reach {
    int first, last;
};

// What is done so that pixels are right where sums in single precision alone would not be.
struct weft_separable_care {
    bool skips_zeros; // a sample is not finite: taps whose weight is 0 are left out
    // Samples are divided by 2^this and pixels multiplied, so that no sum overflows on the way.
    int scale_bits;
    double margin;     // by which rounding alone may bring a pixel past the range of floats
    int32_t *whole[2]; // of every column and row: the sample it is, with a weight of 1; -1: none
};

// The request must be checked. Returns WEFT_ERR_MEMORY.
enum weft_result weft_separable_care_create(const struct weft_separable_params *params,
                                            const struct weft_separable_reach reach[2],
                                            struct weft_separable_care *out);
void weft_separable_care_destroy(struct weft_separable_care *care); // {0} is fine
// Scales a rectangle of pixels back, and makes those samples, bit by bit, that are samples.
void weft_separable_care_finish(const struct weft_separable_care *care,
                                const struct weft_separable_params *params, const int from[2],
                                const int size[2]);

static inline bool weft_separable_go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

#endif
