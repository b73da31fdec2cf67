// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/weights.h - what frames weigh in a sum: by where in a pixel's filter their samples
// lie, or when in the time that a shutter is open.
//
// Weights add up to 1 but for rounding. A lens of even glass weighs its samples alike, which
// weft_weights_even gives. Weights of several effects at once are the products of each's, divided
// by their sum: weft_weights_normalise. Everything is pure, allocates nothing, and may be called
// from any thread.
#ifndef WEFT_PASSES_JITTER_WEIGHTS_H
#define WEFT_PASSES_JITTER_WEIGHTS_H

#include "../../filter/kernels/kernel.h"

WEFT_BEGIN_DECLS

// What weights are like.
struct weft_weights_report {
    double sum;      // before it was divided by; kernels: mean of s^2 h h, per sample sum / count
    double largest;  // the largest |weight|
    double negative; // sum of the |weights| below 0, as a share of the sum of all |weights|
    // Sum of all |weights|, 1 where none is negative: what an error of one code in every frame
    // becomes at most.
    double gain;
    // 1 / sum of the squares: so many frames of even weights have as little noise.
    double effective;
    int zeros; // frames of weight 0, which need not be drawn
};

// Writes `count` weights of 1 / count. Count must be above 0: else nothing is written, and the
// report (NULL: not wanted) is all NAN with no zeros. Returns WEFT_ERR_ARGUMENT with a line in the
// log then.
WEFT_API enum weft_result weft_weights_even(const struct weft_log *log, int count, double *weights,
                                            struct weft_weights_report *report);

// Divides weights of one's own by their sum, count of them, and tells what they are like then. On
// failure they are as before, and the report (NULL: not wanted) is all NAN with no zeros. Returns
// WEFT_ERR_ARGUMENT: a count that is not above 0, weights that are not finite, or that add up to
// less than 1/1000 of their magnitudes.
WEFT_API enum weft_result weft_weights_normalise(const struct weft_log *log, int count,
                                                 double *weights,
                                                 struct weft_weights_report *report);

// Which filter a pixel has. All zero: nearest, a box of one pixel.
struct weft_weights_kernel_params {
    const double (
        *points)[2]; // offsets of the samples from the pixel's centre, in pixels (required)
    int count;       // > 0 (required)
    struct weft_kernel kernel; // h (default nearest)
    double width; // pixels that the support 2 r of h is scaled to (default 2 r: as it is)
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define WEFT_WEIGHTS_KERNEL_DEFAULTS
#define weft_weights_kernel_params(...)                                                            \
    (&(struct weft_weights_kernel_params){WEFT_WEIGHTS_KERNEL_DEFAULTS __VA_ARGS__})

// Writes each sample's weight h(-x / s) h(-y / s), s = width / (2 r), divided by the sum of all.
// Positions are to fill a square as large as the support evenly (a set of `size` = width): what
// lies outside weighs 0. The support counts as closed, so that a box weighs samples on both its
// rims alike. Kernels with negative lobes give negative weights, which sums of floats and exact
// sums take; trees do not.
// On failure weights are not written, and the report (NULL: not wanted) is all NAN with no zeros.
// Returns WEFT_ERR_ARGUMENT: no kernel, no points or one that is not finite, a count, a width that
// is not in [2^-20, 2^20], a derivative (its weights add up to 0), weights that add up to less than
// 1/1000 of their magnitudes (all samples outside, or in a negative lobe); WEFT_ERR_UNSUPPORTED:
// radial kernels, which are no product, and prefiltered ones.
WEFT_API enum weft_result weft_weights_kernel(const struct weft_weights_kernel_params *params,
                                              double *weights, struct weft_weights_report *report);

WEFT_END_DECLS
#endif
