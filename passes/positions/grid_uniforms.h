// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/grid_uniforms.h - a slice's grid as passes/positions/grid_uniforms.glsl reads it
// (not installed). Functions take the table of a context that is current in the calling thread.
#ifndef WEFT_PASSES_POSITIONS_GRID_UNIFORMS_H
#define WEFT_PASSES_POSITIONS_GRID_UNIFORMS_H

#include "passes/gl/gl.h"
#include "passes/positions/grid.h"

// Hands the steps of all blocks, and the position of block (bx, by), to the program in use. order:
// which of the volume's axes are the shader's x, y and z.
void weft_slice_grid_bind(const GladGLContext *gl, GLuint program,
                          const struct weft_slice_grid *grid, const int order[3]);
void weft_slice_grid_bind_block(const GladGLContext *gl, GLuint program,
                                const struct weft_slice_grid *grid, const int order[3], int bx,
                                int by);

#endif
