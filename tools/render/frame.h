// SPDX-License-Identifier: BSD-3-Clause
// tools/render/frame.h - what draws one frame of a scene; inside of tools/render. The context is
// current.
#ifndef WEFT_TOOLS_RENDER_FRAME_H
#define WEFT_TOOLS_RENDER_FRAME_H

#include "tools/render/drawing.h"
#include "tools/render/gl/matrix.h"
#include "tools/render/surface.h"
#include "tools/render/triangles.h"

// What of a frame can reach a part of the picture; of all stages but lines and points, and of
// these. All zero: none was asked for yet.
struct scene_parts {
    struct weft_rectangle of, lines_of; // pixels of the picture, rows upwards
    bool boxed, listed, lines_boxed, lines_listed;
    float (*box)[4];           // of each triangle, in pixels: lowest x and y, highest x and y
    uint32_t *index, *surface; // of those that are listed; surfaces, and planes, of all behind them
    float (*plane)[4];         // likewise
    size_t *first;             // triangle of each object in the list, and the end
    float (*line_box)[4];      // of each line, then of each of the silhouettes
    struct scene_line *line;   // those that are listed
    size_t *line_first;        // of each object, and the end
    GLuint buffer[4];          // planes, surfaces, indices, lines
    GLuint texture[2];         // of the first two
};

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
    bool *front; // room for the triangles of any object
    struct scene_parts parts;
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

// Draws a pass of the frame that was prepared into what is bound, with the program of its head; of
// a part of the picture what can reach it. Returns WEFT_ERR_MEMORY (GL's) or WEFT_ERR_GL.
enum weft_result scene_frame_draw(scene_drawing *drawing, const struct weft_antialias_pass *pass);

// ---- parts.c ------------------------------------------------------------------------------------

// Lists what can reach a pass's part, of the frame that was prepared, and binds the indices of it
// to the vertex array of the stage, which is bound. NULL: all is to be drawn.
const struct scene_parts *scene_parts_list(scene_drawing *drawing,
                                           const struct weft_antialias_pass *pass);
void scene_parts_forget(scene_drawing *drawing); // another frame is prepared
void scene_parts_end(scene_drawing *drawing);

// WEFT_ERR_GL, or WEFT_ERR_MEMORY, after a line where an error of GL is pending.
enum weft_result scene_frame_check(const scene_drawing *drawing, const char *what);

#endif
