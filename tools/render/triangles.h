// SPDX-License-Identifier: BSD-3-Clause
// tools/render/triangles.h - a scene's triangles on OpenGL, uploaded once; inside of tools/render.
// The context is current.
#ifndef WEFT_TOOLS_RENDER_TRIANGLES_H
#define WEFT_TOOLS_RENDER_TRIANGLES_H

#include "tools/render/edges.h"
#include "tools/render/gl/gl.h"
#include "tools/render/gl/matrix.h"
#include "tools/scene/scene.h"

// All zero: none.
struct scene_buffers {
    GLuint vertex_array; // attributes 0 to 3: position, normal, uv, colour; and the indices
    GLuint vertices, indices;
    // A texel of 4 floats a triangle: its normal of length 1, as modelled, and how far neighbours
    // of a smooth surface tilt against it, as a tangent: that of twice the largest angle to the
    // normal of a corner, up to 1; 0 of flat ones.
    GLuint planes, plane_texture;
    // Of anti-aliasing: a texel a triangle, the number of its surface; attribute 0 alone, with
    // indices of lines: first all that are always drawn, then room for all folds.
    GLuint surfaces, surface_texture;
    GLuint line_array, lines;
};

// On failure what was made is for scene_buffers_end to end. most: texels of a buffer. Returns
// WEFT_ERR_LIMIT after a line, WEFT_ERR_MEMORY. Errors are GL's.
enum weft_result scene_buffers_make(const GladGLContext *gl, const struct weft_log *log,
                                    const struct scene *scene, int64_t most,
                                    struct scene_buffers *out);
// Adds what anti-aliasing needs. surface: a number for each triangle; edges: NULL: no lines. Errors
// are GL's.
void scene_buffers_add_edges(const GladGLContext *gl, const struct scene *scene,
                             const uint32_t *surface, const struct scene_edges *edges,
                             struct scene_buffers *out);
void scene_buffers_end(const GladGLContext *gl, struct scene_buffers *buffers);

// The box of an object's triangles. No triangles: from INFINITY to -INFINITY.
void scene_extent_find(const struct scene *scene, const struct scene_object *object,
                       struct scene_extent *out);

#endif
