// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/build.h - what makes and changes scenes, and what that is made with.
#ifndef WEFT_TOOLS_SCENE_BUILD_H
#define WEFT_TOOLS_SCENE_BUILD_H

#include "tools/common/random.h"
#include "tools/scene/scene.h"
#include "tools/scene/vector.h"

// Copies a name, cut and cleaned.
void scene_set_name(char out[SCENE_NAME], const char *name);

// ---- building -----------------------------------------------------------------------------------

// A scene that grows. When memory runs out it stops growing, and scene_build_end says so.
struct scene_build {
    struct scene *scene; // borrowed
    size_t vertex_room, index_room;
    int object_room, material_room;
    bool full;
};

// Returns the material's place in the list.
int scene_build_material(struct scene_build *build, const struct scene_material *material);
// Begins an object; triangles belong to it from now on.
void scene_build_object(struct scene_build *build, const char *name, int material);
// A polygon of `count` (3 to 16) corners, convex and flat, counterclockwise from its front. Its uv
// are those that are given, (x, y) each, or of NULL 0; colour may be NULL for white.
void scene_build_polygon(struct scene_build *build, int count, const double corner[][3],
                         const double uv[][2], const float colour[3]);
// Six faces of a box from low to high, fronts outside; uv of each from 0 to 1.
void scene_build_box(struct scene_build *build, const double low[3], const double high[3]);
// A ball of `rings` times 2 `rings` quads, smooth, about a middle.
void scene_build_ball(struct scene_build *build, const double middle[3], double radius, int rings);
// Adds a lamp, and its surface where it is seen.
void scene_build_lamp(struct scene_build *build, const struct scene_light *light);
// Gives the object that was begun last a path of so many keys. NULL where memory ran out.
struct scene_key *scene_build_path(struct scene_build *build, int count);
// Finds the box. On failure the scene is cleared. Returns WEFT_ERR_MEMORY after a line.
enum weft_result scene_build_end(struct scene_build *build, const struct weft_log *log);

// ---- what there is ------------------------------------------------------------------------------

extern const struct scene_info scene_cube, scene_cornell, scene_furnace, scene_polygons,
    scene_plane, scene_moving, scene_penumbra;

// The scene of a mesh file: scene_make's part.
enum weft_result scene_load(const struct scene_params *params, struct scene *out);

#endif
