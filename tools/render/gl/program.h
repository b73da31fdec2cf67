// SPDX-License-Identifier: BSD-3-Clause
// tools/render/gl/program.h - programs of the shaders in tools/render; inside of it. The
// context is current.
#ifndef WEFT_TOOLS_RENDER_GL_PROGRAM_H
#define WEFT_TOOLS_RENDER_GL_PROGRAM_H

#include "tools/render/gl/gl.h"

extern const char tools_shader_scene_depth[];
extern const char tools_shader_scene_depth_vertex[];
extern const char tools_shader_scene_line[];
extern const char tools_shader_scene_surface[];
extern const char tools_shader_scene_vertex[];

// The first string of shaders that need no other.
#define SCENE_VERSION "#version 330 core\n"

// Compiles a shader of a stage of GL from strings, the first of which has its version. Returns 0
// after GL's message.
GLuint scene_shader_compile(const GladGLContext *gl, const struct weft_log *log, GLenum stage,
                            const char *const *text, int count);

// Links a program of two shaders, which stay as they are. Returns 0 after GL's message.
GLuint scene_program_link(const GladGLContext *gl, const struct weft_log *log, GLuint vertex,
                          GLuint fragment);

#endif
