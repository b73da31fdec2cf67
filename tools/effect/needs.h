// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/needs.h - how many frames the effects need.
#ifndef WEFT_TOOLS_EFFECT_NEEDS_H
#define WEFT_TOOLS_EFFECT_NEEDS_H

#include "tools/effect/plan.h"

// Fills plan->need and plan->needed, whose focus and aperture are known: the largest of the scenes
// whose share of the picture, one a scene, is not 0. Where nothing is in sight one frame is
// enough. Returns WEFT_ERR_MEMORY.
enum weft_result effect_needs_find(const struct effect_params *params, const double *share,
                                   struct effect_plan *plan);

// Returns the frames that are planned unasked: what is needed, at most EFFECT_MOST_AUTO, in the
// least number that the set of samples has as many of, or else its largest; a warning where that is
// less than what is needed.
int effect_needs_fit(const struct effect_params *params, int64_t needed);

#endif
