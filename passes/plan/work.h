// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/work.h - what a run of a plan of passes does, in counts: of a plan that is made, and
// the least that one could do and be off by, before it is planned. passes/choose/cost.h weighs it.
#ifndef WEFT_PASSES_PLAN_WORK_H
#define WEFT_PASSES_PLAN_WORK_H

#include "plan.h"

WEFT_BEGIN_DECLS

// The work of one run. All of it is counted, nothing timed.
struct weft_pass_work {
    enum weft_target_format target;
    bool dot4;
    double passes;
    double fetches;    // per pixel and channel set: of source, tiles and targets, over all passes
    double tile_bytes; // of tile textures, made and uploaded once
    double exact_weights; // per pixel: of the exact sum that it is corrected by; 0 where sums are 1
};

// Returns what the passes of a plan do. Pure and thread-safe, as all below.
WEFT_API struct weft_pass_work weft_pass_work_of(const struct weft_pass_plan_info *plan);

// The least that any plan of these parameters does: a fetch of source and tile for each group of
// taps, as many groups a pass as the profile takes. Defaults as in weft_pass_plan_create; nothing
// is planned. All 0 for parameters out of their ranges.
WEFT_API struct weft_pass_work weft_pass_work_least(const struct weft_pass_plan_params *params);

// The least that any plan of these parameters is off by, for weft_bound_compute: tiles are looked
// up at the nearest of M samples along an axis, where a kernel's weights change by up to `slope`
// (the largest sum of |h'|), half of which counts; the target's codes are rounded. Of prefiltered
// kernels the spline through the samples is no flatter than the kernel's own.
WEFT_API struct weft_bound_terms weft_pass_bound_least(const struct weft_pass_plan_params *params,
                                                       double slope);

WEFT_END_DECLS
#endif
