// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/gl.h - what GL holds of a compiled plan (not installed).
#ifndef WEFT_PASSES_MULTIPASS_GL_H
#define WEFT_PASSES_MULTIPASS_GL_H

#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/multipass/job.h"

struct weft_multipass_gl {
    weft_context *context;
    bool fetches_targets; // GL_EXT_shader_framebuffer_fetch: no copy of what is read
    GLuint *programs;     // of the list's passes; held
    struct weft_gl_buffer tiles, log_table;
    // Of the runs: kept, and grown where one needs larger ones.
    struct weft_gl_buffer source, entries;
    int target_count; // the slots' and, if any pass needs it, one more to write beside them
    struct weft_gl_target *targets;
};

// Hands the tiles to GL, whose values are freed then, and finds the programs. Sets compiled->gl,
// which on failure may hold a part. Errors as of weft_multipass_compile.
enum weft_result weft_multipass_gl_create(weft_context *context, struct weft_multipass *compiled);
void weft_multipass_gl_destroy(struct weft_multipass *compiled); // where there is none, too

// Fills a buffer with values, laid out as shaders read them.
enum weft_result weft_multipass_gl_load(const struct weft_log *log, const GladGLContext *gl,
                                        const struct weft_job_values *values,
                                        struct weft_gl_buffer *buffer);

// Groups that a pass's shader has: GLSL has no empty arrays.
static inline int weft_multipass_shader_groups(const struct weft_pass *pass)
{
    return pass->group_count > 0 ? pass->group_count : 1;
}
// Whether the components of a group that have a tile share one factor, which goes to *out. With
// logarithms those without need their zero, elsewhere their weights are 0.
bool weft_multipass_common_factor(const struct weft_multipass *compiled,
                                  const struct weft_pass *pass, const struct weft_tap_group *group,
                                  int *out);
bool weft_multipass_has_one_factor(const struct weft_multipass *compiled,
                                   const struct weft_pass *pass);

#endif
