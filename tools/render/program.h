// SPDX-License-Identifier: BSD-3-Clause
// tools/render/program.h - programs of the shaders in tools/render; inside of tools/render.
#ifndef WEFT_TOOLS_RENDER_PROGRAM_H
#define WEFT_TOOLS_RENDER_PROGRAM_H

#include "tools/render/gl.h"

extern const char tools_shader_scene_depth[];
extern const char tools_shader_scene_depth_vertex[];
extern const char tools_shader_scene_surface[];
extern const char tools_shader_scene_vertex[];

// Links a program of "#version 330 core", `defines` and the sources; the context is current.
// Returns WEFT_ERR_GL after GL's message.
enum weft_result scene_program_link(const GladGLContext *gl, const struct weft_log *log,
                                    const char *defines, const char *vertex, const char *fragment,
                                    GLuint *out);

#endif
