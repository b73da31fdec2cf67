// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/range.h - the worst-case range simulator (Hadwiger, Hauser and Moeller, WSCG 2003,
// section 4): accumulates the tiles' actual values, pass by pass, at every sample position.
// It knows nothing of how a list of passes was found, so that it can catch the planner.
//
// On unorm targets it follows the integers that the passes compute (passes/plan/pass.h), roundings
// and all, so that a valid list clamps nothing when it is run. Values are told in units of full
// range; T, e and n are those of passes/plan/pass.h. How sharp the ranges are:
//   constants, unorm8   exact: all 256 levels are followed one by one
//   constants, unorm16  bounds: the line between black and white, and what roundings may be off it
//   any input           exact for whole parts, as n rises with every sample: each pass at its own
//                       least and most
//   half, float         exact sums, nothing rounded
// Where some sum is out of all proportion (a hundred times the range), constants are bounded as
// those of unorm16 are.
//
// Floors make bounds of values that are not followed. A high part loses up to (2^e - 1) / 2^e codes
// in every pass that has a product there; a low part gains what n may leave, up to 2^e - 1 codes.
// Once high and low parts of the same sums are combined (2^e times one and once the other, or in
// proportion), nothing was lost.
//
// A pass changes its target by its products and its bias, with `subtract` or without: that turns n
// only. q is what the tile's memory holds, at mirrored positions where the tile is mirrored; the
// sign of negative parts and of negated tiles is the group's.
#ifndef WEFT_PASSES_PLAN_RANGE_H
#define WEFT_PASSES_PLAN_RANGE_H

#include "pass.h"

WEFT_BEGIN_DECLS

// The inputs for which ranges are followed. Default: constants.
enum weft_worst_case {
    WEFT_WORST_CONSTANT, // one code everywhere, every one there is (the paper's: 1.0)
    WEFT_WORST_ANY,      // every input sample anywhere in [0, 1], independently in every pass
};
// NULL-ended, in the order of the enum: "constant", "any".
WEFT_API extern const char *const weft_worst_case_names[];

// The values that a pass's target has after it, over all sample positions and inputs. What is
// outside [0, 1] clamps, but later passes are followed as if it had not. Half and float targets
// never leave their range.
struct weft_range {
    double minimum, maximum;
    int minimum_at[3], maximum_at[3]; // sample positions, the first of several
};

// What a simulation found. A pass leaves its range where its target does, where a fragment that is
// blended (the codes that a whole or high part adds or takes away) is outside [0, 1], or where a
// sum inside may saturate at
// +-range, as the bias may come first or last.
struct weft_range_report {
    bool valid;      // no pass leaves its range
    int pass;        // the first one that does, from 0, where the list is not valid
    int position[3]; // a sample position where that pass goes furthest
    double value;    // what it comes to there: the target's, the fragment's or the sum's magnitude
    double overflow; // largest excursion of any pass, >= 0
};

// Follows a list of passes. ranges gets pass_count entries, or is NULL; progress may be NULL. A
// value is outside when it is by more than 1e-9. On failure ranges and report stay as they were.
// Pure and thread-safe. Returns WEFT_ERR_ARGUMENT (a tile, slot or numerator that makes no sense,
// or a slot that is read but holds nothing, with the pass in the log), WEFT_ERR_MEMORY or
// WEFT_ERR_CANCELLED.
WEFT_API enum weft_result
weft_range_simulate(const struct weft_log *log, const struct weft_pass_list *passes,
                    enum weft_worst_case worst_case, const struct weft_progress *progress,
                    struct weft_range *ranges, struct weft_range_report *report);

WEFT_END_DECLS
#endif
