// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/run.h - draws the frames of a plan and accumulates them.
#ifndef WEFT_TOOLS_EFFECT_RUN_H
#define WEFT_TOOLS_EFFECT_RUN_H

#include "tools/effect/plan.h"

// Frames of a plan, for an accumulator of 4 channels, RGBA, of the plan's size, that has the
// drawings' context. Its rows go up, as OpenGL's do: row 0 is the lowest.
struct effect_run_params {
    const struct effect_plan *plan;       // (required)
    scene_drawing *const *drawing;        // one a scene of the plan; NULL where its weight is 0
    weft_accumulator *accumulator;        // (required)
    int64_t first, count;                 // frames of the plan; count 0: all that follow
    bool clamped_share;                   // see struct scene_frame
    const struct weft_progress *progress; // may be NULL; of these frames
};
#define EFFECT_RUN_DEFAULTS
#define effect_run_params(...) (&(struct effect_run_params){EFFECT_RUN_DEFAULTS __VA_ARGS__})

// Adds frames with their weights; those of weight 0 are not drawn. To go on until a mean is good
// enough, call it for a range at a time (weft_accumulator_judge). *added (NULL: not wanted) is how
// many frames are in. Returns WEFT_ERR_CANCELLED, WEFT_ERR_ARGUMENT (frames that the plan has not)
// or what weft_accumulator_add returned.
enum weft_result effect_run(const struct effect_run_params *params, int64_t *added);

#endif
