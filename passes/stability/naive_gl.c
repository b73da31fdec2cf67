// SPDX-License-Identifier: BSD-3-Clause
// What one writes first, in OpenGL.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/stability/cases.h"

struct target {
    struct weft_gl_target drawn;
    GLuint source;
};

// Leaves program, target and source texture bound.
static enum weft_result set_up(const struct weft_stability_params *params, const char *name,
                               const char *defines, const char *fragment, GLenum format, int width,
                               int height, struct target *t, GLuint *program)
{
    const GladGLContext *gl = &params->context->gl;
    enum weft_result res = weft_program_get(params->context, name, defines, weft_shader_full_target,
                                            fragment, program);
    if (res != WEFT_OK)
        return res;
    res = weft_gl_target_create(params->log, gl, format, width, height, &t->drawn);
    if (res != WEFT_OK)
        return res;
    gl->UseProgram(*program);
    weft_gl_target_bind(gl, &t->drawn, width, height);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT);
    gl->GenTextures(1, &t->source);
    return weft_gl_check(params->log, gl, "setting a naive way up");
}

// As floats, unorm targets too.
static enum weft_result read_back(const struct weft_stability_params *params,
                                  const struct target *t, float *pixels)
{
    const struct weft_gl_pixels out = {
        .width = t->drawn.width, .height = t->drawn.height, .type = GL_FLOAT, .data = pixels};
    return weft_gl_target_read(params->log, &params->context->gl, &t->drawn, &out);
}

static void clear(const GladGLContext *gl, struct target *t)
{
    weft_gl_target_destroy(gl, &t->drawn);
    gl->DeleteTextures(1, &t->source);
}

// ---- slices -------------------------------------------------------------------------------------

struct mapping {
    float low, width, scale;
};

// Formed as naive code forms it.
static struct mapping map_range(const float *data, size_t count)
{
    float low = data[0], high = data[0];
    for (size_t i = 1; i < count; i++) {
        low = fminf(low, data[i]);
        high = fmaxf(high, data[i]);
    }
    return (struct mapping){low, high - low, 1.0f / (high - low)};
}

static void upload(const GladGLContext *gl, const struct weft_stability_slice *s,
                   const struct weft_naive_slice *naive, GLuint texture, const float *data)
{
    const bool linear = naive->lookup >= WEFT_NAIVE_SAMPLER;
    gl->BindTexture(GL_TEXTURE_3D, texture);
    gl->TexImage3D(GL_TEXTURE_3D, 0, (GLint)naive->source, s->size[0], s->size[1], s->size[2], 0,
                   GL_RED, GL_FLOAT, data);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, linear ? GL_LINEAR : GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, linear ? GL_LINEAR : GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAX_LEVEL, 0);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
}

static void set_vector(const GladGLContext *gl, GLuint program, const char *name,
                       const double value[3], double divisor)
{
    gl->Uniform3f(weft_gl_location(gl, program, name), (float)(value[0] / divisor),
                  (float)(value[1] / divisor), (float)(value[2] / divisor));
}

static void draw_slice(const GladGLContext *gl, const struct weft_stability_slice *s,
                       GLuint program)
{
    const struct weft_slice_geometry *g = &s->geometry;
    const double first[3] = {s->first[0], s->first[1], s->first[2]};
    gl->Uniform1i(weft_gl_location(gl, program, "source"), 0);
    set_vector(gl, program, "origin", g->origin, 1.0);
    set_vector(gl, program, "du", g->u, g->width);
    set_vector(gl, program, "dv", g->v, g->height);
    set_vector(gl, program, "first", first, 1.0);
    gl->Uniform2f(weft_gl_location(gl, program, "shown"), (float)g->width, (float)g->height);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

enum weft_result weft_naive_slice_run(const struct weft_stability_params *params,
                                      const struct weft_stability_slice *slice,
                                      const struct weft_naive_slice *naive, float *pixels)
{
    const GladGLContext *gl = &params->context->gl;
    const size_t count = (size_t)slice->size[0] * (size_t)slice->size[1] * (size_t)slice->size[2];
    const size_t pixel_count = (size_t)slice->geometry.width * (size_t)slice->geometry.height;
    struct mapping map = {0.0f, 1.0f, 1.0f};
    struct target target = {0};
    GLuint program = 0;
    char defines[64];
    float *mapped = malloc(count * sizeof *mapped);
    enum weft_result res = mapped ? weft_context_enter(params->context) : WEFT_ERR_MEMORY;
    if (res != WEFT_OK)
        goto fail;
    if (naive->mapped)
        map = map_range(slice->data, count);
    for (size_t i = 0; i < count; i++)
        mapped[i] = naive->mapped ? (slice->data[i] - map.low) * map.scale : slice->data[i];
    snprintf(defines, sizeof defines, "#define LOOKUP %d\n#define NORMALISED %d\n",
             (int)naive->lookup, naive->normalised);
    res = set_up(params, "naive slice", defines, weft_shader_naive_slice, naive->target,
                 slice->geometry.width, slice->geometry.height, &target, &program);
    if (res == WEFT_OK) {
        upload(gl, slice, naive, target.source, mapped);
        draw_slice(gl, slice, program);
        res = read_back(params, &target, pixels);
    }
    for (size_t i = 0; naive->mapped && i < pixel_count; i++)
        pixels[i] = pixels[i] * map.width + map.low;
    clear(gl, &target);
    weft_context_leave(params->context);
fail:
    free(mapped);
    return res;
}
