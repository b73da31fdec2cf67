// SPDX-License-Identifier: BSD-3-Clause
// tools/render/lamps.h - a scene's lamp as the point light of one frame.
#ifndef WEFT_TOOLS_RENDER_LAMPS_H
#define WEFT_TOOLS_RENDER_LAMPS_H

#include "tools/render/drawing.h"

// Returns a lamp's area: of a parallelogram |u x v|, of an ellipse of these diameters pi / 4 of it,
// of a point 0.
double scene_lamp_area(const struct scene_light *light);

// Writes the light that a place on a lamp stands for, shadowed: at (x, y) of [-1/2, 1/2]^2, or of
// the disc of diameter 1, in units of u and v from the middle. Its intensity is such that the mean
// over evenly spread places is the lamp's light: radiance * area; of a point, or with another
// falloff than SCENE_FALLOFF_RADIANCE, its radiance.
void scene_lamp_at(const struct scene_light *light, const double place[2],
                   struct scene_point_light *out);
// Sets a frame's lights: all lamps of the scene, each a point in its middle.
void scene_lamps_in_middle(const struct scene *scene, struct scene_frame *out);

#endif
