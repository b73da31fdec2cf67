// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/candidate.h - what a choice considers: methods of one request, each with what it
// costs and how wrong it can be. Slices (passes/choose/choose.h) and images list them alike.
#ifndef WEFT_PASSES_CHOOSE_CANDIDATE_H
#define WEFT_PASSES_CHOOSE_CANDIDATE_H

#include "method.h"

WEFT_BEGIN_DECLS

// How a search judged a candidate. A search that finds nothing has no chosen one.
enum weft_candidate_state {
    WEFT_CANDIDATE_CHOSEN,  // meets the budget, and no other that does was predicted to be faster
    WEFT_CANDIDATE_DEARER,  // meets the budget, or might: it was predicted to take longer
    WEFT_CANDIDATE_EXCEEDS, // the bound is over the budget
    WEFT_CANDIDATE_REFUSED, // does not apply to the request, or planning it failed
};
// NULL-ended, in the order of the enum: "chosen", "dearer", "exceeds", "refused".
WEFT_API extern const char *const weft_candidate_state_names[];

// One method that a search looked at. Searches fill it in; it is a plain value and owns nothing.
struct weft_candidate {
    struct weft_method method;
    char name[96]; // the method in words, by weft_method_format
    enum weft_candidate_state state;
    // The search decided without planning these passes: seconds, bytes and bound are then the
    // least that any plan of them could have, not what a plan has.
    bool estimated;
    double seconds; // that a run takes, as the cost model predicts
    uint64_t bytes; // that a run needs: voxels, layouts, tiles and targets; for images tiles alone
    double bound;   // of |result - exact|, in the unit of the search's budget; NAN where refused
};

WEFT_END_DECLS
#endif
