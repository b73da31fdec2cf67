// SPDX-License-Identifier: BSD-3-Clause
// filter/analysis/bound.h - how far results may be off, in the values of what is filtered: one sum
// for every engine, in 1D to 3D. Pure arithmetic, thread-safe.
//
// Read are numbers c: the samples f, or a prefiltered kernel's coefficients of them as they were
// computed (filter/kernels/prefilter.h). With weights w of the kernel at a position and w', x' and
// c' those that an engine has in their place, a result less the exact one is
//     sum (w' c' - w c)  +  sum w c - exact
// in which
// - the first sum is what the engine states: `relative` times the largest |c|, or, where c is
//   mapped to [0, 1] by its range, `source`, E2, `e3` and `clamp` times that range's width; and
//   `absolute`;
// - E2 has two bounds, of which the smaller holds. `e2` is of any c in the range. Coefficients are
//   not any c: between the nearest position of a tile and the pixel's own their spline changes by
//   `e2_sampled` times the range of the samples, and the tile's codes by `e2_quantised` times that
//   of the coefficients;
// - the second sum is weft_prefilter_error's: `coefficient` times the largest |c|, `sample` times
//   the largest |f| in reach and `beyond` times the largest farther away. The spline of
//   `e2_sampled` is that of the samples in reach; those beyond are off from its range's middle by
//   at most both largest |f|, at either of two positions;
// - a result of passes is rounded to single precision once more, by 2^-24 of itself;
// - and samples that were no floats lost `sample_rounding` of the largest |f|, and
//   `absolute_rounding`.
// Weights that are off count errors of coefficients a little more: 1 + `relative` + `e2` times.
#ifndef WEFT_FILTER_ANALYSIS_BOUND_H
#define WEFT_FILTER_ANALYSIS_BOUND_H

#include "error.h"

WEFT_BEGIN_DECLS

// What an engine's plan knows of its errors, whatever the values (default: all 0). Plans export it:
// struct weft_slice_plan_info, struct weft_pass_plan_info and weft_separable_bound_terms.
struct weft_bound_terms {
    double relative; // to the largest |value read|: weights, products and sums in floating point
    // To the width of the range read, of engines that map it to [0, 1]: the codes of the source,
    // the kernel's representation (E2), arithmetic (E3), and what clamped stores can lose.
    double source, e2, e3, clamp;
    double e2_quantised, e2_sampled; // of prefiltered kernels; both 0: there is only e2
    double absolute; // in the values' unit: products that GL flushes to 0, cheaper pieces, formats
    // Results are rounded to single precision when all of this has been counted; they are at most
    // this times the largest |value read|. 0: `relative` has it.
    double rounded_gain;
    double sample_rounding;   // of samples to floats before they are read, to the largest |sample|
    double absolute_rounding; // likewise, in the values' unit
    struct weft_prefilter_error prefilter; // all 0 but for prefiltered kernels
};

// What was measured of the values (default: all 0). In the values' unit; low <= high.
struct weft_bound_values {
    double low, high;               // of the finite values read: samples, or coefficients
    double sample_low, sample_high; // of the finite samples in reach
    double beyond; // prefiltered kernels: largest |sample| farther away, weighted as `beyond` asks
    double result; // largest |result|, once it is known (0: not yet, any result counts)
};

// The bound and its parts, in the values' unit.
struct weft_bound {
    double source, e2, e3, clamp; // e3 with what is relative and absolute
    double rounding;              // of samples before, and of results
    double prefilter;             // coefficients, and what weighs them wrong
    double total;                 // of |result - exact|, for any input with these values
};

// Adds up the bound. NAN in, NAN out; values in which low > high count as they are.
WEFT_API struct weft_bound weft_bound_compute(const struct weft_bound_terms *terms,
                                              const struct weft_bound_values *values);

WEFT_END_DECLS
#endif
