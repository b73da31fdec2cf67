// SPDX-License-Identifier: BSD-3-Clause
// tools/render/drawing.h - draws a scene on OpenGL 3.3: triangles with depth, Lambert surfaces,
// shadow maps.
#ifndef WEFT_TOOLS_RENDER_DRAWING_H
#define WEFT_TOOLS_RENDER_DRAWING_H

#include "tools/scene/scene.h"

// A point that light comes from in one frame: of a lamp, or a virtual light on a surface.
struct scene_point_light {
    double position[3];
    double normal[3];    // of the surface that it lies on, of length 1; all 0: it shines all around
    double intensity[3]; // radiance * area of what it stands for; of a point W / sr; of falloffs
                         // other than that of radiance the lamp's radiance, and nothing of pi:
    enum scene_falloff
        falloff; // a surface has reflectance / pi * intensity * cos cos / distance^2,
                 // reflectance * intensity * cos or reflectance * intensity
    bool shadowed;
    // Largest factor cos cos / distance^2 that counts (clamping, in 1 / length^2); 0: all of it.
    double most;
};

// What one frame shows.
struct scene_frame {
    struct weft_camera_frame camera; // picture's move, place on the lens
    double time;                     // of the scene
    struct scene_point_light light[SCENE_MAX_LIGHTS];
    int light_count;      // 0 to SCENE_MAX_LIGHTS
    bool without_ambient; // the scene's ambient light does not count
    bool clamped_share;   // shows what clamping took away of the light, and nothing else but alpha
};

struct scene_drawing_params {
    const struct scene *scene; // borrowed for the drawing's life (required)
    weft_context *context;     // likewise (required)
    int shadow_size;           // texels along a side of a face of a shadow map, 4 to what GL has
                               // (default 1,024)
    bool by_triangle; // each triangle is a surface of its own, and its outline is lines, as of the
                      // polygons of a mesh that is drawn flat (default: false)
    const struct weft_log *log; // may be NULL
};
#define SCENE_DRAWING_DEFAULTS .shadow_size = 1024,
#define scene_drawing_params(...)                                                                  \
    (&(struct scene_drawing_params){SCENE_DRAWING_DEFAULTS __VA_ARGS__})

// The scene as objects of GL. Thread-safety: one thread at a time, with its context.
typedef struct scene_drawing scene_drawing;

// Uploads the triangles. On failure *out is NULL. Returns WEFT_ERR_LIMIT (shadow_size; more
// triangles than a buffer of GL has texels), WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result scene_drawing_create(const struct scene_drawing_params *params,
                                      scene_drawing **out);
void scene_drawing_destroy(scene_drawing **drawing); // accepts &NULL

// Draws a frame into a target as weft_accumulator_add gives it, inside such a callback or
// weft_context_call: radiance RGB over the background, alpha its coverage: 1 where there is a
// surface. Of surfaces in one place the object that comes first is seen. Programs are linked when a
// frame has other kinds of lights than those before it. Returns WEFT_ERR_ARGUMENT (the camera),
// WEFT_ERR_MEMORY (GL's) or WEFT_ERR_GL.
enum weft_result scene_drawing_draw(scene_drawing *drawing, const struct scene_frame *frame,
                                    const struct weft_draw_target *target);

// ---- anti-aliasing ------------------------------------------------------------------------------

// Prepares a frame for passes of anti-aliasing: where objects are, the shadow maps, surfaces and
// lines. Inside weft_context_call. Passes move the picture beside the frame's own move, which is
// mostly 0. Returns as scene_drawing_draw does, which prepares its frame, too, but for lines.
enum weft_result scene_drawing_prepare(scene_drawing *drawing, const struct scene_frame *frame);

// Draws a pass of the frame that was prepared: a callback of struct weft_antialias_drawing, priv
// being the scene_drawing. Surfaces are numbered from 1 on over the whole scene: triangles that
// share an edge by the same two vertices, and so their normals, are one. Lines are all other edges,
// and those of which the frame shows one side's front and the other's back; points are their ends.
// Edges of the picture that are none of these, and are to be found by their surfaces: where
// triangles go through one another, and where the near plane cuts them. With by_triangle lines and
// points are the triangles again, as outlines and corners.
enum weft_result scene_drawing_pass(void *drawing, const struct weft_antialias_pass *pass);

// How shadows are found, for reports. tools/render/shadow_view.h tells the whole of it: what is lit
// is compared, without a filter, in the middle of its texel, in the plane of its triangle, so that
// edges of shadows are off by half a texel along each axis of the map at most.
struct scene_shadow_info {
    int faces;      // of maps that the last frame took, of all its lights together
    int size;       // texels along a side of a face
    double bias;    // in texels, times the slope of the triangle's plane
    uint64_t bytes; // of the maps that there is room for
};
void scene_drawing_get_shadow(const scene_drawing *drawing, struct scene_shadow_info *out);

#endif
