// SPDX-License-Identifier: BSD-3-Clause
// tiles/kernel/polynomial_tiles.h - a kernel's tiles as polynomials, for full-precision passes (not
// installed). A tile holds the weight of one tap over all fractional positions t in [0, 1)
// (filter/kernels/kernel.h, weft_kernel_first_tap). Here it is cut into equal segments, each a
// polynomial through the kernel's values at its ends and between them: exact for piecewise
// polynomial kernels, as close as asked for others. Where a segment begins, weights are the
// kernel's own, rounded once.
#ifndef WEFT_TILES_KERNEL_POLYNOMIAL_TILES_H
#define WEFT_TILES_KERNEL_POLYNOMIAL_TILES_H

#include "filter/check.h"
#include "filter/kernels/kernel.h"

enum { WEFT_POLYNOMIAL_MAX_DEGREE = 7, WEFT_POLYNOMIAL_MAX_SEGMENTS = 1024 };

struct weft_polynomial_tiles {
    int width;  // tiles, one per tap
    int groups; // of four taps, the last one padded with zero weights
    int degree;
    int segments; // per tile
    // Largest |polynomial - h| found between the nodes, and largest sum of it over the taps of a
    // position.
    double error, sum_error;
    // [segment][power][4 * groups taps]; weight = sum_p c[p] u^p, u = fraction of the segment.
    float *coefficients;
    double *precise; // the same before they were rounded to floats
    bool exact;      // which changed none
    size_t coefficient_count;
};

// As many segments as an error of at most `tolerance` (> 0), or that part of the largest |weight|
// where this is above 1, needs: powers of two, or another number that has the ends of the support
// (and the knots of tables, up to 63 odd parts a unit) on borders of segments, where a kernel may
// jump or kink. Where no number is good enough, the best one is taken, and `sum_error` tells. Below
// 1e-10 what is no polynomial is cut into fewer pieces of a higher degree.
// Returns WEFT_ERR_MEMORY.
enum weft_result weft_polynomial_tiles_create(const struct weft_log *log,
                                              const struct weft_kernel *kernel, double tolerance,
                                              struct weft_polynomial_tiles *out);
// Tiles of M samples (1 to WEFT_POLYNOMIAL_MAX_SEGMENTS) instead, whatever their error: nearest
// look-up is a constant over each segment, that of its middle; linear look-up goes straight from
// the weights at one end to those at the other. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY.
enum weft_result weft_polynomial_tiles_sample(const struct weft_log *log,
                                              const struct weft_kernel *kernel, int samples,
                                              bool linear, struct weft_polynomial_tiles *out);
void weft_polynomial_tiles_destroy(struct weft_polynomial_tiles *tiles); // {0} is fine

#endif
