// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/weights.h - a footprint's kernel as engines look it up, and what bounds ask of
// it: found when first wanted and kept as long as the footprint, whose plans share them, or as what
// many footprints share (not installed).
#ifndef WEFT_PASSES_POSITIONS_WEIGHTS_H
#define WEFT_PASSES_POSITIONS_WEIGHTS_H

#include "filter/analysis/error.h"
#include "filter/kernels/prefilter.h"
#include "passes/cpu/cpu.h"
#include "tiles/kernel/polynomial_tiles.h"

struct weft_footprint;

// Of one look-up.
struct weft_slice_weights {
    int samples;         // that the kernel is sampled at; 0: polynomials, as good as the sums
    bool linear;         // between samples
    enum weft_sums sums; // that they are for
    struct weft_polynomial_tiles tiles;
    // The largest sum over a position's taps of what Horner's rule in the precision of sums, and
    // sampling, make each weight off by.
    double error;
    // The largest sum over a position's taps of |slope|, of the polynomials themselves: it is known
    // of derivatives, too, whose own derivative no record has. Jumps between segments not counted.
    double slope;
};

// Of the kernel itself: weft_analysis_gain without its prefilter, weft_analysis_slope,
// weft_analysis_curvature (0 where linear interpolation has no say: of an odd number of taps, or
// of two, or weights that do not add up to one), and weft_prefilter_error in 3D and along an axis.
struct weft_slice_kernel {
    bool known;
    double gain, slope, curvature;
    struct weft_prefilter_error prefilter, along;
};

// Of one kernel, and in a list of several.
struct weft_kernel_facts {
    struct weft_kernel kernel;
    struct weft_slice_weights **weights;
    size_t weights_count;
    struct weft_slice_kernel facts;
    struct weft_kernel_facts *next;
};

// Whether two kernels are one: parameters, normalised, radial and prefiltered included.
bool weft_kernel_same(const struct weft_kernel *a, const struct weft_kernel *b);

// Finds a kernel in a list, or adds it. NULL: out of memory.
struct weft_kernel_facts *weft_kernel_facts_find(struct weft_kernel_facts **list,
                                                 const struct weft_kernel *kernel);
void weft_kernel_facts_destroy(struct weft_kernel_facts **list);

// Finds a look-up's weights, or makes them. Returns what weft_polynomial_tiles_create and
// weft_polynomial_tiles_sample return.
enum weft_result weft_kernel_facts_weights(const struct weft_log *log,
                                           struct weft_kernel_facts *facts, int samples,
                                           bool linear, enum weft_sums sums,
                                           const struct weft_slice_weights **out);
// Computes the facts, once.
const struct weft_slice_kernel *weft_kernel_facts_compute(struct weft_kernel_facts *facts);

// The same of a footprint's kernel.
enum weft_result weft_footprint_weights(const struct weft_log *log,
                                        struct weft_footprint *footprint, int samples, bool linear,
                                        enum weft_sums sums, const struct weft_slice_weights **out);
const struct weft_slice_kernel *weft_footprint_kernel(struct weft_footprint *footprint);
// Finds the facts of the footprint's kernel derived `order` times, 0 to 2, kept like its own.
// Returns WEFT_ERR_UNSUPPORTED (the kernel has no such derivative: both are in the log) or
// WEFT_ERR_MEMORY.
enum weft_result weft_footprint_derive(const struct weft_log *log, struct weft_footprint *footprint,
                                       int order, struct weft_kernel_facts **out);

#endif
