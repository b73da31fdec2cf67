// SPDX-License-Identifier: BSD-3-Clause
#include <stdio.h>
#include <stdlib.h>

#include "filter/threads.h"
#include "passes/warp/gl.h"

enum weft_result weft_warp_find_program(struct weft_warp_gl *c, bool skips_zeros)
{
    const struct weft_warp_plan *plan = c->plan;
    const struct weft_polynomial_tiles *tiles = &plan->weights->tiles;
    char defines[256];
    GLuint program;
    if (c->programs[skips_zeros])
        return WEFT_OK;
    snprintf(
        defines, sizeof defines,
        "#define WIDTH %d\n#define GROUPS %d\n#define DEGREE %d\n#define SEGMENTS %d\n"
        "#define STRETCHED %d\n#define STRIDE %d\n#define BOUNDARY %d\n#define SKIPS_ZEROS %d\n",
        tiles->width, tiles->groups, tiles->degree, tiles->segments, plan->stretches,
        plan->info.taps[0] + plan->info.taps[1], (int)plan->info.boundary, skips_zeros);
    const enum weft_result res = weft_program_get(
        c->context, "warp", defines, weft_shader_full_target, weft_shader_warp, &program);
    if (res != WEFT_OK)
        return res;
    weft_program_hold(c->context, program);
    c->programs[skips_zeros] = program;
    return WEFT_OK;
}

static enum weft_result create_scratch(struct weft_warp_gl *c)
{
    enum weft_result res = WEFT_OK;
    c->scratch = calloc((size_t)c->threads, sizeof *c->scratch);
    if (!c->scratch) {
        weft_error(c->plan->log, "out of memory for %d threads of a warp", c->threads);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; res == WEFT_OK && i < c->threads; i++)
        res = weft_warp_scratch_create(c->plan, &c->scratch[i]);
    return res;
}

enum weft_result weft_warp_gl_compile(weft_context *context, const struct weft_warp_plan *plan,
                                      struct weft_warp_gl **out)
{
    *out = NULL;
    struct weft_warp_gl *c = calloc(1, sizeof *c);
    if (!c) {
        weft_error(plan->log, "out of memory for a compiled warp");
        return WEFT_ERR_MEMORY;
    }
    c->plan = plan;
    c->context = context;
    c->threads = weft_threads_available();
    enum weft_result res = create_scratch(c);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res == WEFT_OK) {
        res = weft_warp_find_program(c, false);
        if (res == WEFT_OK)
            res = weft_gl_kernel_create(plan->log, &context->gl, &plan->weights->tiles, &c->kernel);
        weft_context_leave(context);
    }
    if (res == WEFT_OK)
        *out = c;
    else
        weft_warp_gl_destroy(&c);
    return res;
}

static void destroy(struct weft_warp_gl *c)
{
    const GladGLContext *gl = &c->context->gl;
    weft_gl_buffer_destroy(gl, &c->kernel);
    weft_gl_buffer_destroy(gl, &c->entries);
    weft_gl_buffer_destroy(gl, &c->weights);
    for (int i = 0; i < 2; i++) {
        weft_program_release(c->context, c->programs[i]);
        weft_gl_buffer_destroy(gl, &c->source[i]);
        weft_gl_target_destroy(gl, &c->target[i]);
    }
}

void weft_warp_gl_destroy(struct weft_warp_gl **compiled)
{
    struct weft_warp_gl *c = *compiled;
    if (!c)
        return;
    if (weft_context_enter(c->context) == WEFT_OK) {
        destroy(c);
        weft_context_leave(c->context);
    }
    for (int i = 0; c->scratch && i < c->threads; i++)
        weft_warp_scratch_destroy(&c->scratch[i]);
    free(c->scratch);
    free(c->staging);
    free(c);
    *compiled = NULL;
}
