// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/gl.h - filtering on OpenGL (not installed).
#ifndef WEFT_PASSES_SEPARABLE_GL_H
#define WEFT_PASSES_SEPARABLE_GL_H

#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/separable/separable_impl.h"

// ---- compiled plans -----------------------------------------------------------------------------

// Of the largest rectangle, and together.
struct weft_separable_sizes {
    size_t source_texels, middle_texels, weight_texels[2], first_texels[2];
    int target_width, target_height;
    size_t staging_floats; // rows that GL cannot write where they belong
    uint64_t bytes;
};

// What weights a buffer holds: those of positions `from` to `from` + `count`.
struct weft_separable_loaded {
    int from, count; // 0: none
    bool skips_zeros;
};

struct weft_separable_gl {
    const weft_separable_plan *plan;
    weft_context *context;
    int groups[2];    // texels of four weights, of a position along x and along y
    int cut[2];       // positions of a rectangle at most
    int most_taps[2]; // different taps of all positions of a rectangle, at most
    struct weft_separable_sizes sizes;
    struct weft_separable_taps taps[2]; // of the part that is loaded
    struct weft_separable_loaded loaded[2];
    struct weft_gl_buffer source, middle; // middle: what the first pass made
    struct weft_gl_buffer weights[2], first_taps[2];
    GLuint programs[2][2]; // [skips zeros][along x, along y]; held; 0: not wanted so far
    struct weft_gl_target target;
    float *staging;
};

// The programs that leave zeros out, or do not. The context is current. Returns WEFT_ERR_GL or
// WEFT_ERR_MEMORY.
enum weft_result weft_separable_find_programs(struct weft_separable_gl *compiled, bool skips_zeros);

// Cuts a plan into rectangles for a context, and makes what GL holds. Returns WEFT_ERR_LIMIT,
// WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_separable_gl_compile(weft_context *context, const weft_separable_plan *plan,
                                           struct weft_separable_gl **out);
void weft_separable_gl_destroy(struct weft_separable_gl **compiled); // accepts &NULL

// The request is checked. Returns WEFT_ERR_MEMORY, WEFT_ERR_GL or WEFT_ERR_CANCELLED.
enum weft_result weft_separable_gl_run(struct weft_separable_gl *compiled,
                                       const struct weft_separable_run_params *params,
                                       struct weft_separable_report *report);

#endif
