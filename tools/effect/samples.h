// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/samples.h - the frames of one scene of a plan: sets of each dimension, joined.
#ifndef WEFT_TOOLS_EFFECT_SAMPLES_H
#define WEFT_TOOLS_EFFECT_SAMPLES_H

#include "tools/effect/plan.h"

// Dimensions, in order; those of lamps are one each.
enum effect_dimension {
    EFFECT_BY_PIXEL,
    EFFECT_BY_LENS,
    EFFECT_BY_TIME,
    EFFECT_BY_LIGHTS,
    EFFECT_BY_LAMP,
    EFFECT_DIMENSION_COUNT = EFFECT_BY_LAMP + SCENE_MAX_LIGHTS
};

// How frames go through a set of their number.
enum effect_order {
    EFFECT_ORDER_KEPT,     // one after another
    EFFECT_ORDER_SPREAD,   // such that the first n lie evenly over all, for any n: by ranks of the
                           // radical inverse to base 2
    EFFECT_ORDER_PERMUTED, // at random: another permutation for each seed and dimension
};
void effect_order_make(enum effect_order order, uint64_t seed, enum effect_dimension dimension,
                       int count, int *out);

// Returns how wide the pixel's filter is, in pixels: what its samples fill.
double effect_filter_width(const struct effect_params *params);

// Writes the frames of scene `scene`, whose weights add up to 1, and counts none of them. The
// lights that stand in them are those of the scene, or one of `lights` each, which is NULL without
// radiosity. Sets are told in *plan where `tell` says so, `extends` always. Returns what
// effect_plan_make does.
struct effect_sampling {
    const struct effect_params *params; // focus and aperture are known
    int scene;
    int count;
    const struct scene_point_light *lights;
    bool tell;
};
enum weft_result effect_sample(const struct effect_sampling *sampling, struct effect_frame *frames,
                               struct effect_plan *plan);

#endif
