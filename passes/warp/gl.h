// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/gl.h - warps on OpenGL (not installed).
//
// Pixels are made in tiles. Where they lie is uploaded, formed in double as the CPU engine forms
// it, as is what of the samples a tile reaches (all of them, once, where there is room), four
// channels to a texel. Weights of kernels that are stretched are uploaded with the positions.
#ifndef WEFT_PASSES_WARP_GL_H
#define WEFT_PASSES_WARP_GL_H

#include "passes/gl/kernel_weights.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/warp/careful.h"

struct weft_warp_gl {
    const struct weft_warp_plan *plan;
    weft_context *context;
    GLuint programs[2]; // [skips zeros]; held; 0: not wanted so far
    struct weft_gl_buffer kernel, entries, weights;
    struct weft_gl_buffer source[2]; // of one channel, of more
    struct weft_gl_target target[2]; // likewise
    int threads;
    struct weft_warp_scratch *scratch; // [threads]
    float *staging;                    // pixels as they are read back
    size_t staging_floats;
};

// The program. The context is current. Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_warp_find_program(struct weft_warp_gl *compiled, bool skips_zeros);

#endif
