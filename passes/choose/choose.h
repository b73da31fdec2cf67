// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/choose.h - the cheapest method of a slice that meets an error budget.
// The budget is for what weft adds to the kernel: representation (E2), arithmetic (E3) and the
// source's codes, all by proven bounds. E1, the kernel's own error, is told beside. Costs are
// predicted by a model of the machine (passes/choose/cost.h).
#ifndef WEFT_PASSES_CHOOSE_CHOOSE_H
#define WEFT_PASSES_CHOOSE_CHOOSE_H

#include "cost.h"

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
    double seconds; // predicted
    uint64_t bytes;
    double bound; // in the volume's values; NAN: refused
};

struct weft_choose_params {
    // kernel, geometry, space, memory, savings to do without, clamp_to_samples, progress, log;
    // layout: only fused methods of this one, unless AUTO
    struct weft_slice_params slice;
    double max_error;                               // in the volume's values, >= 0
    const struct weft_profile *profile;             // only passes on this one; NULL: any method
    const struct weft_cost_model *model;            // NULL: weft_cost_default
    const struct weft_slice_statistics *statistics; // of the voxels in reach; NULL: measured first
};

struct weft_choice {
    struct weft_candidate *candidates; // by predicted time, refused ones last
    size_t count;
    int chosen; // -1: none meets the budget
    int best;   // the one of the least bound among those that can be run; -1: none can
    struct weft_slice_statistics statistics;
    // Of the chosen method: what of the budget its own bound leaves is given to smooth pieces,
    // where there are pixels enough for that to pay.
    weft_method_plan *plan;
};

// Returns WEFT_OK with chosen = -1 where nothing meets the budget; WEFT_ERR_ARGUMENT (max_error,
// and what weft_slice_plan_create refuses), WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED, and what
// weft_volume_read returns.
WEFT_API enum weft_result weft_choose(weft_volume *volume, const struct weft_choose_params *params,
                                      struct weft_choice *out);
WEFT_API void weft_choice_clear(struct weft_choice *choice); // {0} is fine

WEFT_END_DECLS
#endif
