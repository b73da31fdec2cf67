// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/multipass/gl.h"

// Programs of one plan that differ in their divisor only: from more on it is a uniform, as each
// takes long to compile.
enum { MAX_DIVISORS = 3 };

// What programs of one plan have in common.
struct choice {
    weft_context *context;
    const struct weft_multipass *m;
    bool divisor_is_uniform, has_bias;
};

// ---- programs -----------------------------------------------------------------------------------

static void choose_defines(struct choice *c)
{
    int divisors[MAX_DIVISORS], count = 0;
    for (int p = 0; p < c->m->passes->pass_count; p++) {
        const struct weft_pass *pass = &c->m->passes->passes[p];
        if (pass->kind != WEFT_PASS_TAPS)
            continue;
        c->has_bias = c->has_bias || pass->bias != 0;
        int i = 0;
        while (i < count && divisors[i] != pass->divisor)
            i++;
        c->divisor_is_uniform = c->divisor_is_uniform || i == MAX_DIVISORS;
        if (i == count && count < MAX_DIVISORS)
            divisors[count++] = pass->divisor;
    }
}

bool weft_multipass_common_factor(const struct weft_multipass *m, const struct weft_pass *pass,
                                  const struct weft_tap_group *group, int *out)
{
    bool any = false;
    *out = 0;
    for (int c = 0; c < (m->passes->dot4 ? 4 : 1); c++) {
        const int factor = weft_multipass_factor(m, pass, group, c);
        if (group->tile[c] < 0 && !m->passes->log_table)
            continue;
        if (any && factor != *out)
            return false;
        any = true;
        *out = factor;
    }
    return true;
}

bool weft_multipass_has_one_factor(const struct weft_multipass *m, const struct weft_pass *pass)
{
    int factor;
    for (int g = pass->group_first; g < pass->group_first + pass->group_count; g++)
        if (!weft_multipass_common_factor(m, pass, &m->passes->groups[g], &factor))
            return false;
    return true;
}

// Blending whole passes that subtract differ from others by factors and blend equation only.
static bool shader_subtracts(const struct weft_pass *pass)
{
    return pass->subtract && (pass->reads_target || pass->part != WEFT_PASS_WHOLE);
}

static enum weft_result find_program(const struct choice *c, const struct weft_pass *pass,
                                     GLuint *out)
{
    const struct weft_multipass *m = c->m;
    const struct weft_pass_list *l = m->passes;
    const int reads = !pass->reads_target ? 0 : m->gl->fetches_targets ? 2 : 1;
    char divisor[16] = "divisor", limit[32] = "", defines[768];
    if (!c->divisor_is_uniform)
        snprintf(divisor, sizeof divisor, "%d", pass->divisor);
    if (m->limit < INT_MAX)
        snprintf(limit, sizeof limit, "#define LIMIT %d\n", m->limit);
    snprintf(defines, sizeof defines,
             "%s#define FLOATS %d\n#define ONE %d\n#define EXTRA_BITS %d\n#define DIVISOR %s\n"
             "#define GROUPS %d\n#define DOT4 %d\n#define SPLIT_DOT %d\n#define FACTORS %d\n"
             "#define CHANNELS %d\n#define DIMS %d\n#define PART %d\n#define SUBTRACT %d\n"
             "#define READS_TARGET %d\n#define EXACT %d\n#define HAS_BIAS %d\n"
             "#define LOGARITHMS %d\n#define POSITIONS %d\n#define POSITION_BITS %d\n%s",
             reads > 1 ? "#extension GL_EXT_shader_framebuffer_fetch : require\n" : "", m->floats,
             m->one, m->extra_bits, divisor, weft_multipass_shader_groups(pass), l->dot4,
             l->dot_width == 3, weft_multipass_has_one_factor(m, pass) ? 1 : 4, m->work.channels,
             l->dims, (int)pass->part, shader_subtracts(pass), reads, l->exact_inside, c->has_bias,
             l->log_table != NULL, (int)m->positions, m->position_bits, limit);
    return weft_program_get(c->context, "convolve", defines, weft_shader_full_target,
                            weft_shader_convolve, out);
}

static enum weft_result find_combining_program(const struct choice *c, const struct weft_pass *pass,
                                               GLuint *out)
{
    const struct weft_multipass *m = c->m;
    char defines[256];
    snprintf(defines, sizeof defines,
             "#define FLOATS %d\n#define INPUTS %d\n#define ONE %d\n#define EXTRA_BITS %d\n"
             "#define EXACT %d\n#define DENOMINATOR %d\n#define CHANNELS %d\n",
             m->floats, pass->input_count, m->one, m->extra_bits, m->passes->exact_inside,
             pass->denominator, m->work.channels);
    return weft_program_get(c->context, "combine", defines, weft_shader_full_target,
                            weft_shader_combine, out);
}

static int count_different(const GLuint *programs, int count)
{
    int different = 0;
    for (int i = 0; i < count; i++) {
        int twin = 0;
        while (programs[twin] != programs[i])
            twin++;
        different += twin == i;
    }
    return different;
}

static enum weft_result find_programs(weft_context *context, struct weft_multipass *m)
{
    const int count = m->passes->pass_count;
    struct choice c = {.context = context, .m = m};
    enum weft_result res = WEFT_OK;
    m->gl->programs = calloc((size_t)count + 1, sizeof *m->gl->programs);
    if (!m->gl->programs) {
        weft_error(m->log, "convolution: not enough memory for %d programs", count);
        return WEFT_ERR_MEMORY;
    }
    choose_defines(&c);
    for (int p = 0; res == WEFT_OK && p < count; p++) {
        const struct weft_pass *pass = &m->passes->passes[p];
        GLuint program;
        res = pass->kind == WEFT_PASS_COMBINE ? find_combining_program(&c, pass, &program)
                                              : find_program(&c, pass, &program);
        if (res != WEFT_OK)
            break;
        weft_program_hold(context, program);
        m->gl->programs[p] = program;
    }
    m->info.programs = count_different(m->gl->programs, count);
    return res;
}

// ---- buffers and targets ------------------------------------------------------------------------

enum weft_result weft_multipass_gl_load(const struct weft_log *log, const GladGLContext *gl,
                                        const struct weft_job_values *values,
                                        struct weft_gl_buffer *buffer)
{
    static const GLenum formats[][2] = {
        [WEFT_VALUE_UINT8] = {GL_R8UI, GL_RGBA8UI},
        [WEFT_VALUE_UINT16] = {GL_R16UI, GL_RGBA16UI},
        [WEFT_VALUE_FLOAT] = {GL_R32F, GL_RGBA32F},
    };
    return weft_gl_buffer_load(log, gl, formats[values->type][values->components == 4],
                               values->data, values->bytes, buffer);
}

static enum weft_result load_tiles(weft_context *context, struct weft_multipass *m)
{
    const GladGLContext *gl = &context->gl;
    enum weft_result res = weft_multipass_gl_load(m->log, gl, &m->tiles, &m->gl->tiles);
    if (res == WEFT_OK && m->passes->log_table)
        res = weft_gl_buffer_load(m->log, gl, GL_R32UI, m->passes->log_table,
                                  (2 * (size_t)m->one + 1) * sizeof *m->passes->log_table,
                                  &m->gl->log_table);
    free(m->tiles.data);
    m->tiles.data = NULL;
    m->tiles.room = 0;
    return res;
}

static bool has_framebuffer_fetch(const GladGLContext *gl)
{
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++) {
        const char *name = (const char *)gl->GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (name && strcmp(name, "GL_EXT_shader_framebuffer_fetch") == 0)
            return true;
    }
    return false;
}

static bool writes_beside(const struct weft_multipass *m)
{
    for (int p = 0; p < m->passes->pass_count; p++) {
        const struct weft_pass *pass = &m->passes->passes[p];
        if (pass->kind == WEFT_PASS_COMBINE || (pass->reads_target && !m->gl->fetches_targets))
            return true;
    }
    return false;
}

static enum weft_result create(weft_context *context, struct weft_multipass *m)
{
    struct weft_multipass_gl *g = m->gl;
    g->fetches_targets = !m->work.portable && has_framebuffer_fetch(&context->gl);
    g->target_count = m->passes->slot_count + writes_beside(m);
    g->targets = calloc((size_t)g->target_count, sizeof *g->targets);
    if (!g->targets) {
        weft_error(m->log, "convolution: not enough memory for %d targets", g->target_count);
        return WEFT_ERR_MEMORY;
    }
    const enum weft_result res = load_tiles(context, m);
    return res == WEFT_OK ? find_programs(context, m) : res;
}

enum weft_result weft_multipass_gl_create(weft_context *context, struct weft_multipass *m)
{
    m->gl = calloc(1, sizeof *m->gl);
    if (!m->gl) {
        weft_error(m->log, "convolution: not enough memory for a compiled plan");
        return WEFT_ERR_MEMORY;
    }
    m->gl->context = context;
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = create(context, m);
    weft_context_leave(context);
    return res;
}

static void destroy(struct weft_multipass *m)
{
    struct weft_multipass_gl *g = m->gl;
    const GladGLContext *gl = &g->context->gl;
    for (int t = 0; g->targets && t < g->target_count; t++)
        weft_gl_target_destroy(gl, &g->targets[t]);
    for (int p = 0; g->programs && p < m->passes->pass_count; p++)
        weft_program_release(g->context, g->programs[p]);
    weft_gl_buffer_destroy(gl, &g->tiles);
    weft_gl_buffer_destroy(gl, &g->log_table);
    weft_gl_buffer_destroy(gl, &g->source);
    weft_gl_buffer_destroy(gl, &g->entries);
}

void weft_multipass_gl_destroy(struct weft_multipass *m)
{
    if (!m->gl)
        return;
    if (weft_context_enter(m->gl->context) == WEFT_OK) {
        destroy(m);
        weft_context_leave(m->gl->context);
    }
    free(m->gl->targets);
    free(m->gl->programs);
    free(m->gl);
    m->gl = NULL;
}
