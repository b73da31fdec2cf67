// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/kernel_weights.h - a kernel's polynomial tiles as passes/gl/kernel_weights.glsl reads
// them (not installed): a uniform where there is one segment, else a texture buffer.
// Functions take the table of a context that is current in the calling thread.
#ifndef WEFT_PASSES_GL_KERNEL_WEIGHTS_H
#define WEFT_PASSES_GL_KERNEL_WEIGHTS_H

#include "passes/gl/gl.h"
#include "tiles/kernel/polynomial_tiles.h"

// Makes the buffer of what is {0}, or fills one that was made for other tiles; where a uniform does
// it stays what it is. weft_gl_buffer_destroy ends it. Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_gl_kernel_create(const struct weft_log *log, const GladGLContext *gl,
                                       const struct weft_polynomial_tiles *tiles,
                                       struct weft_gl_buffer *out);

// Hands the tiles to the program in use, as its uniform `name`, through texture unit `unit` where
// they have a buffer.
void weft_gl_kernel_bind(const GladGLContext *gl, GLuint program, GLuint unit, const char *name,
                         const struct weft_polynomial_tiles *tiles,
                         const struct weft_gl_buffer *buffer);

#endif
