// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/candidate.h - what a choice considers: methods of one request, each with what it
// costs and how wrong it can be. Slices (passes/choose/choose.h) and images list them alike.
#ifndef WEFT_PASSES_CHOOSE_CANDIDATE_H
#define WEFT_PASSES_CHOOSE_CANDIDATE_H

#include "method.h"

WEFT_BEGIN_DECLS

enum weft_candidate_state {
    WEFT_CANDIDATE_CHOSEN,
    WEFT_CANDIDATE_DEARER,  // meets the budget, or might: it was predicted to take longer
    WEFT_CANDIDATE_EXCEEDS, // the bound is over the budget
    WEFT_CANDIDATE_REFUSED, // does not apply, or cannot be planned
};
// NULL-ended, in the order of the enum: "chosen", "dearer", "exceeds", "refused".
WEFT_API extern const char *const weft_candidate_state_names[];

struct weft_candidate {
    struct weft_method method;
    char name[96]; // weft_method_format
    enum weft_candidate_state state;
    // Passes that were not planned, as they need not be: seconds, bytes and bound are the least
    // that a plan could have.
    bool estimated;
    double seconds; // predicted, of a run
    uint64_t bytes; // voxels, layouts, tiles and targets while running; of images tiles alone
    double bound;   // of |result - exact|, in the units of the budget; NAN: refused
};

WEFT_END_DECLS
#endif
