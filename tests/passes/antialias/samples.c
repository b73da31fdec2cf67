// SPDX-License-Identifier: BSD-3-Clause
#include "tests/passes/antialias/samples.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <setjmp.h>
#include <cmocka.h>

#include "passes/antialias/drawing/run.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "tests/support/common.h"

// ---- samples ------------------------------------------------------------------------------------

// One sample of each pixel; the other programs' names are told from this one by its name.
static const char fetch_one[] = "uniform sampler2DMS samples;\n"
                                "uniform int number;\n"
                                "out vec4 value;\n"
                                "void main()\n"
                                "{\n"
                                "    value = texelFetch(samples, ivec2(gl_FragCoord.xy), number);\n"
                                "}\n";
static const char fetch_single[] = "uniform sampler2D samples;\n"
                                   "out vec4 value;\n"
                                   "void main()\n"
                                   "{\n"
                                   "    value = texelFetch(samples, ivec2(gl_FragCoord.xy), 0);\n"
                                   "}\n";

struct target {
    GLuint framebuffer, texture;
    struct weft_depth_buffer depth;
};

static GLenum kind_of(int count)
{
    return count > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
}

static void create_target(const GladGLContext *gl, const struct samples *s, int depth_bits,
                          struct target *out)
{
    assert_int_equal(weft_depth_buffer_create(&log_to_stderr, gl, s->width, s->height, s->count,
                                              depth_bits, false, &out->depth),
                     WEFT_OK);
    assert_int_equal(out->depth.samples, s->count);
    gl->GenTextures(1, &out->texture);
    gl->BindTexture(kind_of(s->count), out->texture);
    if (s->count > 1)
        gl->TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, s->count, GL_RGBA32F, s->width,
                                  s->height, GL_TRUE);
    else
        gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, s->width, s->height, 0, GL_RGBA, GL_FLOAT,
                       NULL);
    if (s->count == 1)
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->GenFramebuffers(1, &out->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, out->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, kind_of(s->count), out->texture,
                             0);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, out->depth.attachment, GL_RENDERBUFFER,
                                out->depth.renderbuffer);
    assert_int_equal(gl->CheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

static void fetch(weft_context *context, const struct samples *s, GLuint texture)
{
    const GladGLContext *gl = &context->gl;
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    float *one = malloc(4 * pixels * sizeof *one);
    struct weft_gl_target target;
    GLuint program;
    assert_non_null(one);
    assert_int_equal(weft_program_get(context, s->count > 1 ? "test fetch one" : "test fetch", "",
                                      weft_shader_full_target,
                                      s->count > 1 ? fetch_one : fetch_single, &program),
                     WEFT_OK);
    assert_int_equal(
        weft_gl_target_create(&log_to_stderr, gl, GL_RGBA32F, s->width, s->height, &target),
        WEFT_OK);
    for (int i = 0; i < s->count; i++) {
        weft_gl_target_bind(gl, &target, s->width, s->height);
        gl->UseProgram(program);
        weft_gl_bind_texture(gl, program, 0, "samples", kind_of(s->count), texture);
        gl->Uniform1i(weft_gl_location(gl, program, "number"), i);
        gl->DrawArrays(GL_TRIANGLES, 0, 3);
        const struct weft_gl_pixels to = {
            .width = s->width, .height = s->height, .type = GL_FLOAT, .data = one};
        assert_int_equal(weft_gl_target_read(&log_to_stderr, gl, &target, &to), WEFT_OK);
        for (size_t p = 0; p < pixels; p++)
            memcpy(s->value + 4 * (p * (size_t)s->count + (size_t)i), one + 4 * p, 4 * sizeof *one);
    }
    weft_gl_target_destroy(gl, &target);
    free(one);
}

void samples_read(struct triangles *triangles, int width, int height, int count, int depth_bits,
                  const double place[16], struct samples *out)
{
    weft_context *context = triangles->context;
    const GladGLContext *gl = &context->gl;
    const struct weft_pass_state state = {.colours = 1, .depth_func = GL_LESS, .depth_write = true};
    struct target target;
    *out = (struct samples){width, height, count, NULL};
    out->value = calloc((size_t)width * (size_t)height * (size_t)count, 4 * sizeof *out->value);
    assert_non_null(out->value);
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    create_target(gl, out, depth_bits, &target);
    struct weft_antialias_pass pass = {.stage = WEFT_STAGE_COLOUR,
                                       .framebuffer = target.framebuffer,
                                       .width = width,
                                       .height = height,
                                       .part = {0, 0, width, height},
                                       .head = weft_head_colour(gl, true)};
    memcpy(pass.place, place, sizeof pass.place);
    assert_int_equal(
        weft_drawing_run(&log_to_stderr, context, triangles_drawing(triangles), &pass, &state),
        WEFT_OK);
    fetch(context, out, target.texture);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->DeleteFramebuffers(1, &target.framebuffer);
    gl->DeleteTextures(1, &target.texture);
    weft_depth_buffer_destroy(gl, &target.depth);
    weft_context_leave(context);
}

void samples_free(struct samples *samples)
{
    free(samples->value);
    *samples = (struct samples){0};
}

// ---- scenes -------------------------------------------------------------------------------------

static double next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / 0x1p24;
}

void samples_scene(uint32_t seed, const int size[2], int triangles, float range,
                   struct triangle_vertex *out)
{
    uint32_t state = seed * 747796405u + 1u;
    for (int t = 0; t < triangles; t++) {
        const double x = next(&state) * size[0], y = next(&state) * size[1];
        const double wide = t % 3 == 0 ? size[0] : 8.0, thin = t % 3 == 1 ? 0.3 : wide;
        const double angle = 6.2831853 * next(&state);
        for (int i = 0; i < 3; i++) {
            struct triangle_vertex *v = &out[3 * t + i];
            const double along = (next(&state) - 0.5) * wide, across = (next(&state) - 0.5) * thin;
            const double at[2] = {x + along * cos(angle) - across * sin(angle),
                                  y + along * sin(angle) + across * cos(angle)};
            *v = (struct triangle_vertex){.position = {(float)(2.0 * at[0] / size[0] - 1.0),
                                                       (float)(2.0 * at[1] / size[1] - 1.0),
                                                       (float)(1.9 * next(&state) - 0.95), 1.0f},
                                          .colour = {range * (float)next(&state),
                                                     range * (float)next(&state),
                                                     range * (float)next(&state), 1.0f},
                                          .surface = (uint32_t)t + 1u};
            if (t % 4 == 3 && i < 2)
                memcpy(v->position, out[3 * (t - 1) + i].position, sizeof v->position);
        }
    }
}
