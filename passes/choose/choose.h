// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/choose.h - the cheapest method of a slice that meets an error budget.
// The budget is for what weft adds to the kernel: representation (E2), arithmetic (E3) and the
// source's codes, all by proven bounds. E1, the kernel's own error, is told beside. Costs are
// predicted by a model of the machine (passes/choose/cost.h).
#ifndef WEFT_PASSES_CHOOSE_CHOOSE_H
#define WEFT_PASSES_CHOOSE_CHOOSE_H

#include "candidate.h"
#include "cost.h"

WEFT_BEGIN_DECLS

struct weft_choose_params {
    // kernel, geometry, space, memory, savings to do without, clamp_to_samples, progress, log;
    // layout: only fused methods of this one, unless AUTO
    struct weft_slice_params slice;
    double max_error;                    // in the volume's values, >= 0
    const struct weft_profile *profile;  // only passes on this one; NULL: any method
    const struct weft_cost_model *model; // NULL: weft_cost_default
};

struct weft_choice {
    struct weft_candidate *candidates; // by predicted time, refused ones last
    size_t count;
    int chosen; // -1: none meets the budget
    int best;   // the one of the least bound among those that are not estimated; -1: none can run
    struct weft_slice_statistics statistics;
    // Of the chosen method, the one plan that was made of it: what of the budget its own bound
    // leaves is given to smooth pieces, where there are pixels enough for that to pay. NULL: none.
    weft_method_plan *plan;
    int planned; // plans that were made to choose
};

// Returns WEFT_OK with chosen = -1 where nothing meets the budget; WEFT_ERR_ARGUMENT (max_error,
// and what weft_slice_plan_create refuses), WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED, and what
// weft_volume_read returns.
WEFT_API enum weft_result weft_choose(weft_volume *volume, const struct weft_choose_params *params,
                                      struct weft_choice *out);
WEFT_API void weft_choice_clear(struct weft_choice *choice); // {0} is fine

WEFT_END_DECLS
#endif
