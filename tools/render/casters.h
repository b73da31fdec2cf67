// SPDX-License-Identifier: BSD-3-Clause
// tools/render/casters.h - what can cast shadows; inside of tools/render.
//
// A flat part of an object that has all of the scene on one side hides nothing from lights on that
// side: a ground, the walls of a room. Without them maps can be fitted to what is left, and take
// less to draw.
#ifndef WEFT_TOOLS_RENDER_CASTERS_H
#define WEFT_TOOLS_RENDER_CASTERS_H

#include "tools/scene/scene.h"

enum { SCENE_CASTER_PLANES = 8, SCENE_CASTER_CORNERS = 1 << 26 };

// The planes that all triangles of an object lie in, where each of them has the whole scene on one
// side, at any time, but for 2^-20 of its box's diagonal.
struct scene_hull {
    int count;                            // 0: it has none of these, and may cast shadows
    double plane[SCENE_CASTER_PLANES][4]; // normal to the scene's side, of length 1; distance
};

// Finds it for each object, while SCENE_CASTER_CORNERS corners of triangles are looked at, within a
// second; later ones may cast shadows.
void scene_hulls_find(const struct scene *scene, struct scene_hull *out);

// Whether an object may cast shadows in the light of a point.
bool scene_hull_casts(const struct scene *scene, const struct scene_hull *hull,
                      const double eye[3]);

#endif
