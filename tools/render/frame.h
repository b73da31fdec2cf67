// SPDX-License-Identifier: BSD-3-Clause
// tools/render/frame.h - what draws one frame of a scene; inside of tools/render. The context is
// current.
#ifndef WEFT_TOOLS_RENDER_FRAME_H
#define WEFT_TOOLS_RENDER_FRAME_H

#include "tools/render/drawing.h"
#include "tools/render/gl/matrix.h"
#include "tools/render/surface.h"
#include "tools/render/triangles.h"

struct scene_drawing {
    const struct scene *scene;
    weft_context *context;
    const struct weft_log *log;
    int shadow_size;
    GladGLContext gl;
    double middle[3]; // of the scene's box
    double
        diagonal; // likewise; 1 where it is 0. Shaders' lengths are in diagonals, from the middle
    struct scene_extent *extent; // of each object, as modelled
    struct scene_hull *hull;     // of each object
    struct scene_caster *caster; // room for as many, and which object each is
    int *caster_object;
    struct scene_shadows shadows;
    double bias; // scene_shadows_get_bias
    struct scene_surfaces surfaces;
    struct scene_buffers buffers;
    // Of anti-aliasing, once a frame was prepared for it:
    bool by_triangle;
    struct scene_edges edges;
    bool *front;                   // room for the triangles of any object
    struct scene_line *silhouette; // room for all folds; object by object
    size_t *silhouette_first;      // of each object, and the end
    // The frame that was prepared:
    struct scene_frame frame;
    double camera[16];   // its projection * view
    double eye[3];       // its place
    double (*model)[16]; // where each object lies
};

// Finds where all lies in a frame, and draws its shadow maps. Returns WEFT_ERR_ARGUMENT (the
// camera), WEFT_ERR_MEMORY (GL's) or WEFT_ERR_GL.
enum weft_result scene_frame_prepare(scene_drawing *drawing, const struct scene_frame *frame);

// Makes what passes of anti-aliasing need, if there is none yet, and finds the silhouettes of the
// frame that was prepared. Returns WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result scene_frame_prepare_lines(scene_drawing *drawing);
void scene_frame_end_lines(scene_drawing *drawing); // what that made but of GL; none: nothing

// Draws a stage of the frame that was prepared with the program of a head, into what is bound.
// place: what clip coordinates are multiplied by; NULL: nothing. Returns WEFT_ERR_MEMORY (GL's) or
// WEFT_ERR_GL.
enum weft_result scene_frame_draw(scene_drawing *drawing, enum weft_antialias_stage stage,
                                  const char *head, const double place[16]);

// WEFT_ERR_GL, or WEFT_ERR_MEMORY, after a line where an error of GL is pending.
enum weft_result scene_frame_check(const scene_drawing *drawing, const char *what);

#endif
