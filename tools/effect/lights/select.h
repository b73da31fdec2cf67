// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/lights/select.h - a few of many virtual lights that stand for all of them; inside of
// lights.h.
#ifndef WEFT_TOOLS_EFFECT_LIGHTS_SELECT_H
#define WEFT_TOOLS_EFFECT_LIGHTS_SELECT_H

#include "tools/render/drawing.h"

// A virtual light of a path.
struct virtual_light {
    double paths;   // how many paths there are when it appears
    int bounce;     // that it is of; of two of the same `paths`, the earlier bounce is first
    double weight;  // its part in choosing, >= 0
    uint64_t place; // where it is, as a number (select_find_places)
    struct scene_point_light light;
};

// Writes each light's place: lights that follow each other in the order of places face alike and
// lie near each other, along a Hilbert curve through the box of them all.
void select_find_places(struct virtual_light *lights, int64_t count);

// Writes `wanted` lights of many, by systematic sampling along their places: light i is the one in
// which (i + offset) / wanted of all weight is reached (offset in [0, 1)), so that each stands for
// neighbours of the same weight together. Its intensity is divided by its share of the weight:
// where the sum of all lights is a picture, so is the mean of the chosen ones. They come in the
// order of their radical inverses in base 2, so that the first n, of any n, lie evenly among all.
// Sorts the lights by places. The sum of all weights must be above 0.
void select_lights(struct virtual_light *lights, int64_t count, double offset, int64_t wanted,
                   struct scene_point_light *out);

#endif
