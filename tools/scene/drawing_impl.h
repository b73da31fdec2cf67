// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/drawing_impl.h - what drawing scenes is made of; inside of tools/scene.
#ifndef WEFT_TOOLS_SCENE_DRAWING_IMPL_H
#define WEFT_TOOLS_SCENE_DRAWING_IMPL_H

#include "tools/scene/drawing.h"
#include "tools/scene/gl.h"

// ---- matrices -----------------------------------------------------------------------------------

// a * b, in columns.
void scene_multiply(const double a[16], const double b[16], double out[16]);

// The box of an object's triangles, as modelled.
struct scene_extent {
    double low[3], high[3];
};
// Whether a part of it can be within the sides of what a matrix shows, and before its eye.
bool scene_extent_seen(const struct scene_extent *extent, const double clip[16]);

// ---- programs -----------------------------------------------------------------------------------

extern const char tools_shader_scene_vertex[];
extern const char tools_shader_scene_surface[];

// Links a program of "#version 330 core", `defines` and the sources; the context is current.
// Returns WEFT_ERR_GL after GL's message.
enum weft_result scene_program_link(const GladGLContext *gl, const struct weft_log *log,
                                    const char *defines, const char *vertex, const char *fragment,
                                    GLuint *out);

#endif
