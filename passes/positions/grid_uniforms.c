// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/grid_uniforms.h"

#include "passes/gl/target.h"

static int low_bits(const struct weft_slice_grid *grid)
{
    return grid->fraction_bits - WEFT_GRID_WORD_FRACTION_BITS;
}

// A position or step modulo 8 voxels, as the shader's two words.
static void set_fixed(const GladGLContext *gl, GLuint program, const struct weft_slice_grid *grid,
                      const int order[3], const char *name, const char *low_name,
                      const int64_t value[3])
{
    const int bits = low_bits(grid);
    GLint word[3], low[3];
    for (int i = 0; i < 3; i++) {
        const int64_t v = value[order[i]];
        word[i] = (GLint)(uint32_t)(v >> bits);
        low[i] = (GLint)(v & ((INT64_C(1) << bits) - 1));
    }
    gl->Uniform3iv(weft_gl_location(gl, program, name), 1, word);
    gl->Uniform3iv(weft_gl_location(gl, program, low_name), 1, low);
}

void weft_slice_grid_bind(const GladGLContext *gl, GLuint program,
                          const struct weft_slice_grid *grid, const int order[3])
{
    gl->Uniform1i(weft_gl_location(gl, program, "low_bits"), low_bits(grid));
    set_fixed(gl, program, grid, order, "du", "du_low", grid->du);
    set_fixed(gl, program, grid, order, "dv", "dv_low", grid->dv);
}

void weft_slice_grid_bind_block(const GladGLContext *gl, GLuint program,
                                const struct weft_slice_grid *grid, const int order[3], int bx,
                                int by)
{
    struct weft_slice_block block;
    weft_slice_grid_block(grid, bx, by, &block);
    set_fixed(gl, program, grid, order, "origin", "origin_low", block.position);
}
