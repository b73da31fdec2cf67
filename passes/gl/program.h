// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/program.h - shader programs from the embedded sources (not installed).
#ifndef WEFT_PASSES_GL_PROGRAM_H
#define WEFT_PASSES_GL_PROGRAM_H

#include "passes/gl/context_backend.h"

// One for each passes/*/<name>.glsl, made by cmake/embed.cmake.
extern const char weft_shader_acaa_background[];
extern const char weft_shader_acaa_head[];
extern const char weft_shader_blend[];
extern const char weft_shader_combine[];
extern const char weft_shader_convolve[];
extern const char weft_shader_full_target[];
extern const char weft_shader_hardware[];
extern const char weft_shader_msaa_sum[];
extern const char weft_shader_marks_limit[];
extern const char weft_shader_naive_slice[];
extern const char weft_shader_rectangles[];
extern const char weft_shader_sampler[];
extern const char weft_shader_separable[];
extern const char weft_shader_supersample_gather[];
extern const char weft_shader_supersample_mask[];
extern const char weft_shader_texture_copy[];
extern const char weft_shader_fused[];
extern const char weft_shader_tree_leaf[];
extern const char weft_shader_tree_node[];
extern const char weft_shader_warp[];

// A program from "#version 330 core", `defines` and the sources, compiled and linked at first use
// and kept by the context, which is current. It is good until the next call; who needs it longer
// holds it. Defines that begin with a #version of their own, of the fragment shader, have that one.
// `name` names it in messages, and defines and name tell
// programs apart. On failure the log gets GL's message, and at debug level the numbered source.
// Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_program_get(weft_context *context, const char *name, const char *defines,
                                  const char *vertex, const char *fragment, GLuint *out);

// Keeps a program that weft_program_get gave until it is released as often as it was held. 0 is
// nobody's.
void weft_program_hold(weft_context *context, GLuint program);
void weft_program_release(weft_context *context, GLuint program);

#endif
