// SPDX-License-Identifier: BSD-3-Clause
// How callbacks are called: places, state before and afterwards, where inputs are taken, bytes.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/passes/antialias/triangles.h"
#include "passes/antialias/drawing/run.h"

static void test_place(void **state)
{
    static const double none[2] = {0.0, 0.0}, sample[2] = {0.375, -0.125};
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double place[16];
    (void)state;
    weft_drawing_place(333, 17, 0, none, place);
    assert_memory_equal(place, identity, sizeof place);
    // A point of the picture, in pixels from its lower left corner, lands in the larger target's
    // pixels a rim further on, less the sample's x, plus its y (which runs downwards).
    weft_drawing_place(333, 17, 3, sample, place);
    for (int i = 0; i < 20; i++) {
        const double x = 17.3 * i, y = 0.9 * i;
        const double clip[2] = {2.0 * x / 333.0 - 1.0, 2.0 * y / 17.0 - 1.0};
        assert_near(((place[0] * clip[0] + place[12]) + 1.0) * 0.5 * 339.0, x + 3.0 - 0.375, 1e-12,
                    "x");
        assert_near(((place[5] * clip[1] + place[13]) + 1.0) * 0.5 * 23.0, y + 3.0 - 0.125, 1e-12,
                    "y");
    }
}

// A framebuffer of one pixel size with a colour of 4 floats and depths.
struct target {
    GLuint framebuffer, colour;
    struct weft_depth_buffer depth;
};

enum { WIDTH = 33, HEIGHT = 17 };

static void create_target(const GladGLContext *gl, int samples, struct target *out)
{
    assert_int_equal(
        weft_depth_buffer_create(&log_to_stderr, gl, WIDTH, HEIGHT, samples, 24, true, &out->depth),
        WEFT_OK);
    gl->GenRenderbuffers(1, &out->colour);
    gl->BindRenderbuffer(GL_RENDERBUFFER, out->colour);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, GL_RGBA32F,
                                       WIDTH, HEIGHT);
    gl->GenFramebuffers(1, &out->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, out->framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, out->colour);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, out->depth.attachment, GL_RENDERBUFFER,
                                out->depth.renderbuffer);
    assert_int_equal(gl->CheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->ClearStencil(0);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
}

static void destroy_target(const GladGLContext *gl, struct target *target)
{
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->DeleteFramebuffers(1, &target->framebuffer);
    gl->DeleteRenderbuffers(1, &target->colour);
    weft_depth_buffer_destroy(gl, &target->depth);
}

static struct weft_antialias_pass pass_of(const struct target *target,
                                          enum weft_antialias_stage stage, const char *head)
{
    static const double none[2] = {0.0, 0.0};
    struct weft_antialias_pass pass = {.stage = stage,
                                       .framebuffer = target->framebuffer,
                                       .width = WIDTH,
                                       .height = HEIGHT,
                                       .part = {0, 0, WIDTH, HEIGHT},
                                       .head = head};
    weft_drawing_place(WIDTH, HEIGHT, 0, none, pass.place);
    return pass;
}

static const int size[2] = {WIDTH, HEIGHT};
static const double corners[3][2] = {{1.3, 0.7}, {31.1, 4.2}, {9.8, 16.4}};
static const float red[4] = {1.0f, 0.25f, 0.125f, 1.0f};

static void make_mess(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    (void)pass;
    gl->Enable(GL_BLEND);
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonOffset(3.0f, 4.0f);
    gl->StencilFunc(GL_NEVER, 3, 5);
    gl->StencilOp(GL_INVERT, GL_INVERT, GL_INVERT);
    gl->Enable(GL_STENCIL_TEST);
    gl->DepthMask(GL_FALSE);
    gl->LineWidth(1.0f);
    gl->PointSize(7.0f);
    gl->SampleMaski(0, 1);
    gl->Enable(GL_SAMPLE_MASK);
    gl->DrawBuffer(GL_NONE);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

static void check_state(const GladGLContext *gl, GLuint framebuffer)
{
    GLint value = -1;
    GLfloat real = -1.0f;
    assert_false(gl->IsEnabled(GL_BLEND));
    assert_false(gl->IsEnabled(GL_POLYGON_OFFSET_FILL));
    assert_false(gl->IsEnabled(GL_STENCIL_TEST));
    assert_false(gl->IsEnabled(GL_DEPTH_TEST));
    assert_false(gl->IsEnabled(GL_SAMPLE_MASK));
    gl->GetIntegerv(GL_STENCIL_FUNC, &value);
    assert_int_equal(value, GL_ALWAYS);
    gl->GetIntegerv(GL_STENCIL_FAIL, &value);
    assert_int_equal(value, GL_KEEP);
    gl->GetIntegerv(GL_DEPTH_WRITEMASK, &value);
    assert_int_equal(value, GL_TRUE);
    gl->GetFloatv(GL_POINT_SIZE, &real);
    assert_true(real == 1.0f);
    gl->GetIntegeri_v(GL_SAMPLE_MASK_VALUE, 0, &value);
    assert_int_equal((GLuint)value, ~0u);
    gl->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &value);
    assert_int_equal(value, framebuffer);
    gl->GetIntegerv(GL_DRAW_BUFFER, &value);
    assert_int_equal(value, GL_COLOR_ATTACHMENT0);
}

// What a callback leaves is put right; its result and its errors come back.
static void test_state(void **state)
{
    struct triangle_vertex vertices[3];
    (void)state;
    triangle_at(size, corners, 0.5, red, 1, vertices);
    for (int c = 0; c < 2 && contexts[c]; c++) {
        const GladGLContext *gl = &contexts[c]->gl;
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct triangles triangles;
        struct target target;
        triangles_create(contexts[c], vertices, 3, &triangles);
        assert_int_equal(weft_context_enter(contexts[c]), WEFT_OK);
        create_target(gl, 4, &target);
        const struct weft_antialias_pass pass =
            pass_of(&target, WEFT_STAGE_COLOUR, weft_head_colour(gl, true));
        const struct weft_pass_state needs = {
            .colours = 1, .depth_func = GL_LESS, .depth_write = true};
        triangles.after = make_mess;
        assert_int_equal(
            weft_drawing_run(&log, contexts[c], triangles_drawing(&triangles), &pass, &needs),
            WEFT_OK);
        check_state(gl, target.framebuffer);
        assert_int_equal(message.count, 0);
        triangles.result = WEFT_ERR_OPEN;
        assert_int_equal(
            weft_drawing_run(&log, contexts[c], triangles_drawing(&triangles), &pass, &needs),
            WEFT_ERR_OPEN);
        assert_non_null(strstr(message.text, "stage colour"));
        check_state(gl, target.framebuffer);
        destroy_target(gl, &target);
        weft_context_leave(contexts[c]);
        triangles_destroy(&triangles);
    }
}

static void read_pixels(const GladGLContext *gl, const struct target *target, float *out)
{
    GLuint framebuffer, texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, WIDTH, HEIGHT, 0, GL_RGBA, GL_FLOAT, NULL);
    gl->GenFramebuffers(1, &framebuffer);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, target->framebuffer);
    gl->BlitFramebuffer(0, 0, WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->ReadPixels(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_FLOAT, out);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->DeleteFramebuffers(1, &framebuffer);
    gl->DeleteTextures(1, &texture);
}

static void draw_smooth(weft_context *context, struct triangles *triangles, int samples,
                        const char *head, float *out)
{
    const struct weft_pass_state needs = {.colours = 1, .depth_func = GL_LESS, .depth_write = true};
    struct target target;
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    create_target(&context->gl, samples, &target);
    const struct weft_antialias_pass pass = pass_of(&target, WEFT_STAGE_COLOUR, head);
    assert_int_equal(
        weft_drawing_run(&log_to_stderr, context, triangles_drawing(triangles), &pass, &needs),
        WEFT_OK);
    read_pixels(&context->gl, &target, out);
    destroy_target(&context->gl, &target);
    weft_context_leave(context);
}

// With one sample, and with four where all of a pixel's are covered, inputs that are asked for in
// the pixel's middle have the bits of those that are not; shaded by samples, too.
static void test_middle(void **state)
{
    static const char by_samples[] = "in vec4 smooth_colour;\n"
                                     "flat in uint surface;\n"
                                     "void main()\n"
                                     "{\n"
                                     "    vec4 c = WEFT_AT(smooth_colour);\n"
                                     "    if (gl_SampleID < 32)\n"
                                     "        weft_write(c, surface);\n"
                                     "}\n";
    static float plain[4 * WIDTH * HEIGHT], middle[4 * WIDTH * HEIGHT], each[4 * WIDTH * HEIGHT];
    struct triangle_vertex vertices[3];
    int compared = 0;
    (void)state;
    triangle_at(size, (const double[3][2]){{-40, -40}, {90, -20}, {-10, 99}}, 0.5, red, 1,
                vertices);
    for (int i = 0; i < 3; i++) {
        vertices[i].colour[i] = 0.3f + 0.2f * (float)i;
        for (int k = 0; k < 4; k++) // perspective
            vertices[i].position[k] *= 1.0f + 0.7f * (float)i;
    }
    for (int c = 0; c < 2 && contexts[c]; c++) {
        const GladGLContext *gl = &contexts[c]->gl;
        struct triangles triangles;
        if (!gl->VERSION_4_0)
            continue;
        triangles_create(contexts[c], vertices, 3, &triangles);
        triangles.fragment[WEFT_STAGE_COLOUR] = triangles_smooth;
        for (int samples = 1; samples <= 4; samples += 3) {
            draw_smooth(contexts[c], &triangles, samples, weft_head_colour(gl, false), plain);
            draw_smooth(contexts[c], &triangles, samples, weft_head_colour(gl, true), middle);
            triangles.fragment[WEFT_STAGE_COLOUR] = by_samples;
            draw_smooth(contexts[c], &triangles, samples, weft_head_colour(gl, true), each);
            triangles.fragment[WEFT_STAGE_COLOUR] = triangles_smooth;
            assert_memory_equal(plain, middle, sizeof plain);
            assert_memory_equal(middle, each, sizeof each);
            compared++;
        }
        assert_true(middle[0] != middle[4 * WIDTH * HEIGHT - 4]);
        triangles_destroy(&triangles);
    }
    print_message("%d pictures shaded in the pixel's middle compared\n", compared);
}

static void test_bytes(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        const GladGLContext *gl = &contexts[c]->gl;
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_depth_buffer depth;
        assert_int_equal(weft_context_enter(contexts[c]), WEFT_OK);
        for (int samples = 1; samples <= 4; samples += 3) {
            const uint64_t count = (uint64_t)WIDTH * HEIGHT * (uint64_t)samples;
            assert_int_equal(
                weft_depth_buffer_create(&log, gl, WIDTH, HEIGHT, samples, 24, true, &depth),
                WEFT_OK);
            assert_int_equal(depth.samples, samples);
            assert_int_equal(depth.bytes, 4 * count);
            weft_depth_buffer_destroy(gl, &depth);
            assert_int_equal(
                weft_depth_buffer_create(&log, gl, WIDTH, HEIGHT, samples, 32, false, &depth),
                WEFT_OK);
            assert_int_equal(depth.bytes, 4 * count);
            weft_depth_buffer_destroy(gl, &depth);
            assert_int_equal(
                weft_depth_buffer_create(&log, gl, WIDTH, HEIGHT, samples, 32, true, &depth),
                WEFT_OK);
            assert_int_equal(depth.bytes, 8 * count);
            weft_depth_buffer_destroy(gl, &depth);
        }
        assert_int_equal(message.count, 0);
        assert_int_equal(weft_depth_buffer_create(&log, gl, WIDTH, HEIGHT, 4096, 24, true, &depth),
                         WEFT_ERR_LIMIT);
        assert_non_null(strstr(message.text, "4096"));
        assert_int_equal(depth.renderbuffer, 0);
        weft_context_leave(contexts[c]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_place),
        cmocka_unit_test(test_state),
        cmocka_unit_test(test_middle),
        cmocka_unit_test(test_bytes),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
