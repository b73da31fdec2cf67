// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/weights.h - the weights of frames as integers, and their exact sums (not
// installed).
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_WEIGHTS_H
#define WEFT_PASSES_ACCUMULATE_SUMS_WEIGHTS_H

#include "passes/accumulate/sums/wide.h"

WEFT_BEGIN_DECLS

enum {
    WEFT_WEIGHT_BITS = 64,              // a scaled weight counts units of 2^-64
    WEFT_WEIGHT_LOST_BITS = 128,        // what that loses of it, units of 2^-128
    WEFT_WEIGHT_LARGEST_LOG2 = 20,      // scaled weights are at most 2^20
    WEFT_WEIGHT_NARROW_TOTAL = 1 << 22, // sum of |integers| that narrow sums (sums.h) take
};

// One weight w, scaled.
struct weft_weight {
    weft_wide fixed; // w * 2^scale_log2 in units of 2^-64, rounded to nearest
    double scaled;   // w * 2^scale_log2
    int32_t integer; // the same, where it is an integer below WEFT_WEIGHT_NARROW_TOTAL; otherwise 0
};

// All weights so far. Starts as {0}.
struct weft_weights {
    // 0, so that parts can be joined whatever their weights, unless known weights are so small or
    // so large that units would not do: then the largest one is scaled to [1, 2).
    int32_t scale_log2;
    weft_wide total;            // of `fixed`
    struct weft_wide256 square; // sum of squares, in units of 2^-128
    int64_t integers;           // sum of |integer|; -1: not all were integers, or too much together
    weft_uwide magnitude;       // sum of |fixed|, for bounds only
    // Of w' = fixed * 2^-(64 + scale_log2), what counts in the place of w:
    double change;   // largest |w - w'| / |w|
    weft_uwide lost; // sum of |w - w'|, scaled, in units of 2^-128, each rounded up: of any order
};

// Chooses the scale for known weights, of which `largest` is the largest |w|.
void weft_weights_scale(struct weft_weights *weights, double largest);
// False: beyond 2^WEFT_WEIGHT_LARGEST_LOG2. Pure.
bool weft_weight_make(const struct weft_weights *weights, double weight, struct weft_weight *out);
// Whether products with it are whole units of narrow sums.
bool weft_weight_is_integer(const struct weft_weight *weight);
// Whether sums of the weights so far and this one may be narrow.
bool weft_weights_are_narrow(const struct weft_weights *weights, const struct weft_weight *weight);
void weft_weights_add(struct weft_weights *weights, const struct weft_weight *weight);
// Of the same scale.
void weft_weights_join(struct weft_weights *weights, const struct weft_weights *other);

// Sum of weights, and of their squares, as they were given.
double weft_weights_total(const struct weft_weights *weights);
double weft_weights_square(const struct weft_weights *weights);

WEFT_END_DECLS
#endif
