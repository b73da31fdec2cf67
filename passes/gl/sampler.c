// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/sampler.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "passes/gl/program.h"
#include "passes/gl/sampler_rows.h"
#include "passes/gl/target.h"
#include "passes/gl/volume_texture.h"

enum { MIN_SIZE = 64, OTHER_SIZE = 2 };

// 1 and the next lower number of a format, as texels and as what they stand for. Floats are taken
// 2^-20 apart, so that what is blended shows.
static const struct codes {
    uint32_t one, low, bytes;
    double value;
} codes[WEFT_SOURCE_FORMATS] = {
    [WEFT_SOURCE_FLOAT] = {0x3f800000u, 0x3f7ffff0u, 4, 1.0 - 0x1p-20},
    [WEFT_SOURCE_HALF] = {0x3c00u, 0x3bffu, 2, 1.0 - 0x1p-11},
    [WEFT_SOURCE_UNORM16] = {65535u, 65534u, 2, 65534.0 / 65535.0},
    [WEFT_SOURCE_UNORM8] = {255u, 254u, 1, 254.0 / 255.0},
};

struct weft_sampler weft_sampler_assume(enum weft_source_format format)
{
    if ((size_t)format >= WEFT_SOURCE_FORMATS)
        return (struct weft_sampler){0};
    return (struct weft_sampler){
        .fraction = 0x1p-8 + 0x1p-12, // what measuring leaves open included
        .rounding = format == WEFT_SOURCE_UNORM8 ? 1.0 / 255.0 : 0x1p-16,
        .max_size = 256,
    };
}

struct measurement {
    weft_context *context;
    const GladGLContext *gl;
    enum weft_source_format format;
    int size;
    GLuint program;
    struct weft_gl_target target;
    uint8_t *texels;        // of a texture
    float *contrast, *code; // found
};

// Texels that take turns along an axis between `even` and 1.
static void fill_texels(const struct measurement *m, int axis, uint32_t even)
{
    const struct codes *c = &codes[m->format];
    const int across = OTHER_SIZE * OTHER_SIZE;
    for (int i = 0; i < across * m->size; i++) {
        // x is the fastest: along z texels of one plane are the same.
        const int along = axis == 0   ? i % m->size
                          : axis == 1 ? i / OTHER_SIZE % m->size
                                      : i / across;
        const uint32_t texel = along % 2 ? c->one : even;
        for (uint32_t b = 0; b < c->bytes; b++) // little-endian, as GL takes it here
            m->texels[(size_t)i * c->bytes + b] = (uint8_t)(texel >> 8 * b);
    }
}

static void draw(const struct measurement *m, int axis, const struct weft_gl_volume *volume)
{
    struct weft_sampler_row rows[WEFT_SAMPLER_ROWS];
    float along[3] = {0}, across[3] = {0.5f, 0.5f, 0.5f};
    const GladGLContext *gl = m->gl;
    weft_sampler_rows_set(m->size, rows);
    along[axis] = 1.0f / (float)m->size;
    across[axis] = 0.0f;
    gl->UseProgram(m->program);
    weft_gl_bind_texture(gl, m->program, 0, "source", GL_TEXTURE_3D, volume->texture);
    gl->Uniform2fv(weft_gl_location(gl, m->program, "rows"), WEFT_SAMPLER_ROWS, &rows[0].start);
    gl->Uniform3fv(weft_gl_location(gl, m->program, "along"), 1, along);
    gl->Uniform3fv(weft_gl_location(gl, m->program, "across"), 1, across);
    weft_gl_target_bind(gl, &m->target, WEFT_SAMPLER_POINTS, WEFT_SAMPLER_ROWS);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

static enum weft_result measure_texels(const struct measurement *m, int axis, uint32_t even,
                                       float *found)
{
    const struct weft_log *log = m->context->log;
    int size[3] = {OTHER_SIZE, OTHER_SIZE, OTHER_SIZE};
    struct weft_gl_volume volume;
    size[axis] = m->size;
    fill_texels(m, axis, even);
    enum weft_result res = weft_gl_volume_create(log, m->gl, m->format, size, &volume);
    if (res == WEFT_OK)
        res = weft_gl_volume_load(log, m->gl, &volume, 0, size[2], m->texels);
    if (res == WEFT_OK) {
        const struct weft_gl_pixels out = {.width = WEFT_SAMPLER_POINTS,
                                           .height = WEFT_SAMPLER_ROWS,
                                           .type = GL_FLOAT,
                                           .data = found};
        draw(m, axis, &volume);
        res = weft_gl_target_read(log, m->gl, &m->target, &out);
    }
    weft_gl_volume_destroy(m->gl, &volume);
    return res;
}

static enum weft_result measure_axes(const struct measurement *m, struct weft_sampler *out)
{
    const struct codes *c = &codes[m->format];
    const struct weft_sampler_found found = {m->size, m->contrast, m->code, c->value};
    char why[200];
    for (int axis = 0; axis < 3; axis++) {
        enum weft_result res = measure_texels(m, axis, 0, m->contrast);
        if (res == WEFT_OK)
            res = measure_texels(m, axis, c->low, m->code);
        if (res != WEFT_OK)
            return res;
        if (!weft_sampler_rows_judge(&found, out, why, sizeof why)) {
            weft_debug(m->context->log, "textures of format %s are not filtered linearly: %s",
                       weft_source_format_name(m->format), why);
            return WEFT_ERR_UNSUPPORTED;
        }
    }
    return WEFT_OK;
}

static enum weft_result measure(struct measurement *m, struct weft_sampler *out)
{
    const struct weft_log *log = m->context->log;
    const size_t count = (size_t)WEFT_SAMPLER_POINTS * WEFT_SAMPLER_ROWS;
    char defines[32];
    GLint most = 0;
    m->gl->GetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
    for (m->size = MIN_SIZE; 2 * m->size <= most && m->size < WEFT_SAMPLER_MAX_SIZE;)
        m->size *= 2;
    m->texels = malloc((size_t)m->size * OTHER_SIZE * OTHER_SIZE * 4);
    m->contrast = malloc(2 * count * sizeof *m->contrast);
    if (!m->texels || !m->contrast) {
        weft_error(log, "not enough memory to measure a sampler");
        return WEFT_ERR_MEMORY;
    }
    m->code = m->contrast + count;
    snprintf(defines, sizeof defines, "#define ROWS %d\n", WEFT_SAMPLER_ROWS);
    enum weft_result res = weft_program_get(m->context, "sampler", defines, weft_shader_full_target,
                                            weft_shader_sampler, &m->program);
    if (res == WEFT_OK)
        res = weft_gl_target_create(log, m->gl, GL_R32F, WEFT_SAMPLER_POINTS, WEFT_SAMPLER_ROWS,
                                    &m->target);
    if (res == WEFT_OK)
        res = measure_axes(m, out);
    weft_gl_target_destroy(m->gl, &m->target);
    return res;
}

enum weft_result weft_sampler_measure(weft_context *context, enum weft_source_format format,
                                      struct weft_sampler *out)
{
    *out = (struct weft_sampler){0};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(context->log, format, WEFT_SOURCE_UNORM8);
    if (context->samplers[format].max_size) {
        *out = context->samplers[format];
        return WEFT_OK;
    }
    struct measurement m = {.context = context, .gl = &context->gl, .format = format};
    res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = measure(&m, out);
    free(m.texels);
    free(m.contrast);
    weft_context_leave(context);
    if (res == WEFT_OK)
        context->samplers[format] = *out;
    else
        *out = (struct weft_sampler){0};
    if (res == WEFT_OK)
        weft_debug(context->log, "sampler of format %s: fractions to %.3g, values to %.3g",
                   weft_source_format_name(format), out->fraction, out->rounding);
fail:
    return res;
}
