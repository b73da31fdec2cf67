// SPDX-License-Identifier: BSD-3-Clause
#include <stdio.h>
#include <stdlib.h>

#include "passes/separable/gl.h"

// On software GLs, rectangles that take more than this are up to twice as slow: fresh memory costs
// as much as filtering does, and caches hold less of it. None is made lower than LOW_ROWS for that
// while it is wide.
enum { CACHE_BYTES = 12 << 20, LOW_ROWS = 64, LANES = WEFT_SEPARABLE_LANES };

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

// ---- the cut ------------------------------------------------------------------------------------

static void measure(struct weft_separable_gl *c)
{
    const int first_axis = c->plan->info.first_axis;
    const size_t columns = (size_t)weft_separable_round_up(c->cut[0]) / LANES;
    const size_t source_columns = (size_t)weft_separable_round_up(c->most_taps[0]) / LANES;
    const size_t rows = (size_t)c->cut[1], source_rows = (size_t)c->most_taps[1];
    const size_t middle_columns = first_axis == 0 ? columns : source_columns;
    const size_t middle_rows = first_axis == 0 ? source_rows : rows;
    struct weft_separable_sizes *s = &c->sizes;
    s->source_texels = source_columns * source_rows * (first_axis == 0 ? LANES : 1);
    s->middle_texels = middle_columns * middle_rows * (first_axis == 0 ? 1 : LANES);
    s->target_width = (int)larger(columns, middle_columns);
    s->target_height = (int)larger(rows, middle_rows);
    for (int a = 0; a < 2; a++) {
        s->first_texels[a] = (size_t)weft_separable_round_up(c->cut[a]);
        s->weight_texels[a] = s->first_texels[a] * (size_t)c->groups[a];
    }
    s->staging_floats = columns * LANES * rows;
    s->bytes = 16 * (uint64_t)source_columns * source_rows +
               16 * (uint64_t)middle_columns * middle_rows +
               16 * (uint64_t)s->target_width * (uint64_t)s->target_height +
               4 * (uint64_t)s->staging_floats;
    for (int a = 0; a < 2; a++)
        s->bytes += 16 * (uint64_t)s->weight_texels[a] + 4 * (uint64_t)s->first_texels[a];
}

static bool fits(const struct weft_separable_gl *c)
{
    const struct weft_separable_sizes *s = &c->sizes;
    const struct weft_context_info *info = weft_context_get_info(c->context);
    const size_t texels = larger(larger(s->source_texels, s->middle_texels),
                                 larger(s->weight_texels[0], s->weight_texels[1]));
    return s->bytes <= c->plan->memory_bytes && (info->hardware || s->bytes <= CACHE_BYTES) &&
           (int64_t)texels <= info->max_buffer_texels && s->target_width <= info->max_target_size &&
           s->target_height <= info->max_target_size;
}

// Makes rectangles lower, and where they are low halves their longer side, until they fit. Rows are
// cut first: the columns' weights then need not be made again. Columns are cut between texels.
static enum weft_result choose_cut(struct weft_separable_gl *c)
{
    for (measure(c); !fits(c); measure(c)) {
        const bool rows = c->cut[1] > LOW_ROWS || c->cut[1] >= c->cut[0] || c->cut[0] <= LANES;
        const struct weft_context_info *info = weft_context_get_info(c->context);
        const int a = rows ? 1 : 0;
        if (c->cut[a] == 1) {
            weft_error(c->plan->log,
                       "separable filtering: %llu bytes for %d pixels with %d x %d samples in "
                       "reach, over the limit of %llu bytes, or the context's of %lld texels",
                       (unsigned long long)c->sizes.bytes, c->cut[0], c->most_taps[0],
                       c->most_taps[1], (unsigned long long)c->plan->memory_bytes,
                       (long long)info->max_buffer_texels);
            return WEFT_ERR_LIMIT;
        }
        const int half = (c->cut[a] + 1) / 2;
        c->cut[a] = rows ? half : weft_separable_round_up(half);
        c->most_taps[a] = weft_separable_most_taps(&c->plan->axis[a], c->cut[a], &c->taps[a]);
    }
    return WEFT_OK;
}

// ---- what GL holds ------------------------------------------------------------------------------

enum weft_result weft_separable_find_programs(struct weft_separable_gl *c, bool skips_zeros)
{
    GLuint *programs = c->programs[skips_zeros];
    for (int a = 0; a < 2 && !programs[a]; a++) {
        char defines[128];
        GLuint program;
        snprintf(defines, sizeof defines,
                 "#define WIDTH %d\n#define GROUPS %d\n#define ALONG_X %d\n"
                 "#define SKIPS_ZEROS %d\n",
                 c->plan->axis[a].width, c->groups[a], a == 0, skips_zeros);
        const enum weft_result res =
            weft_program_get(c->context, "separable", defines, weft_shader_full_target,
                             weft_shader_separable, &program);
        if (res != WEFT_OK)
            return res;
        weft_program_hold(c->context, program);
        programs[a] = program;
    }
    return WEFT_OK;
}

static enum weft_result create_buffers(struct weft_separable_gl *c)
{
    const struct weft_separable_sizes *s = &c->sizes;
    const struct weft_log *log = c->plan->log;
    const GladGLContext *gl = &c->context->gl;
    const int first_axis = c->plan->info.first_axis;
    const GLenum formats[2] = {GL_R32F, GL_RGBA32F}; // read along x, along y
    enum weft_result res =
        weft_gl_buffer_create(log, gl, formats[first_axis], s->source_texels, &c->source);
    if (res == WEFT_OK)
        res = weft_gl_buffer_create(log, gl, formats[!first_axis], s->middle_texels, &c->middle);
    for (int a = 0; res == WEFT_OK && a < 2; a++) {
        res = weft_gl_buffer_create(log, gl, GL_RGBA32F, s->weight_texels[a], &c->weights[a]);
        if (res == WEFT_OK)
            res = weft_gl_buffer_create(log, gl, GL_R32I, s->first_texels[a], &c->first_taps[a]);
    }
    return res;
}

static enum weft_result create(struct weft_separable_gl *c)
{
    enum weft_result res = weft_separable_find_programs(c, false);
    if (res == WEFT_OK)
        res = create_buffers(c);
    if (res == WEFT_OK)
        res = weft_gl_target_create(c->plan->log, &c->context->gl, GL_RGBA32F,
                                    c->sizes.target_width, c->sizes.target_height, &c->target);
    return res;
}

static enum weft_result prepare(struct weft_separable_gl *c)
{
    for (int a = 0; a < 2; a++) {
        const struct weft_separable_axis *axis = &c->plan->axis[a];
        const enum weft_result res = weft_separable_taps_create(c->plan->log, axis, &c->taps[a]);
        if (res != WEFT_OK)
            return res;
        c->cut[a] = axis->positions;
        c->most_taps[a] = axis->all_taps;
    }
    return choose_cut(c);
}

// ---- compiled plans -----------------------------------------------------------------------------

enum weft_result weft_separable_gl_compile(weft_context *context, const weft_separable_plan *plan,
                                           struct weft_separable_gl **out)
{
    *out = NULL;
    struct weft_separable_gl *c = calloc(1, sizeof *c);
    if (!c) {
        weft_error(plan->log, "not enough memory for a compiled plan");
        return WEFT_ERR_MEMORY;
    }
    c->plan = plan;
    c->context = context;
    for (int a = 0; a < 2; a++)
        c->groups[a] = (plan->axis[a].width + 3) / 4;
    enum weft_result res = prepare(c);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res == WEFT_OK) {
        res = create(c);
        weft_context_leave(context);
    }
    if (res == WEFT_OK)
        *out = c;
    else
        weft_separable_gl_destroy(&c);
    return res;
}

static void destroy(struct weft_separable_gl *c)
{
    const GladGLContext *gl = &c->context->gl;
    weft_gl_buffer_destroy(gl, &c->source);
    weft_gl_buffer_destroy(gl, &c->middle);
    for (int a = 0; a < 2; a++) {
        weft_gl_buffer_destroy(gl, &c->weights[a]);
        weft_gl_buffer_destroy(gl, &c->first_taps[a]);
        weft_program_release(c->context, c->programs[0][a]);
        weft_program_release(c->context, c->programs[1][a]);
    }
    weft_gl_target_destroy(gl, &c->target);
}

void weft_separable_gl_destroy(struct weft_separable_gl **compiled)
{
    struct weft_separable_gl *c = compiled ? *compiled : NULL;
    if (!c)
        return;
    if (weft_context_enter(c->context) == WEFT_OK) {
        destroy(c);
        weft_context_leave(c->context);
    }
    weft_separable_taps_destroy(&c->taps[0]);
    weft_separable_taps_destroy(&c->taps[1]);
    free(c->staging);
    free(c);
    *compiled = NULL;
}
