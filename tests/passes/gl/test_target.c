// SPDX-License-Identifier: BSD-3-Clause
// Targets: what is drawn is read back at every stride, sizes grow and stay, refusals are told.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "passes/gl/context_backend.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"

enum { WIDTH = 5, HEIGHT = 3, STRIDE = 7, FILLER = -9 };

static const char fragment[] =
    "uniform samplerBuffer ramp;\n"
    "uniform sampler2D one;\n"
    "out vec4 value;\n"
    "void main() { ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    value = texelFetch(one, ivec2(0), 0).r * texelFetch(ramp, at.x + 5 * at.y).rrrr; }\n";

// Draws 0, 1, ... 14 over 16 through a buffer on unit 1 and a cleared target on unit 2.
static void draw_ramp(weft_context *context, const struct weft_gl_target *target,
                      const struct weft_gl_target *one, const struct weft_gl_buffer *ramp)
{
    const GladGLContext *gl = &context->gl;
    GLuint program;
    assert_int_equal(
        weft_program_get(context, "ramp", "", weft_shader_full_target, fragment, &program),
        WEFT_OK);
    weft_gl_target_bind(gl, one, 1, 1);
    gl->ClearColor(1.0f, 1.0f, 1.0f, 1.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT);
    gl->UseProgram(program);
    weft_gl_bind_buffer(gl, program, 1, "ramp", ramp);
    weft_gl_bind_texture(gl, program, 2, "one", GL_TEXTURE_2D, one->texture);
    weft_gl_target_bind(gl, target, WIDTH, HEIGHT);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

static void assert_floats(const GladGLContext *gl, const struct weft_gl_target *target,
                          int channels, int stride)
{
    float out[4 * STRIDE * HEIGHT];
    const int row = stride ? stride : WIDTH;
    for (int i = 0; i < 4 * STRIDE * HEIGHT; i++)
        out[i] = FILLER;
    assert_int_equal(
        weft_gl_target_read(
            NULL, gl, target,
            &(struct weft_gl_pixels){
                .width = WIDTH, .height = HEIGHT, .type = GL_FLOAT, .stride = stride, .data = out}),
        WEFT_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < row; x++)
            for (int c = 0; c < channels; c++) {
                const bool inside = x < WIDTH, tail = y == HEIGHT - 1 && !inside;
                const double expected = inside ? (x + WIDTH * y) / 16.0 : FILLER;
                if (!tail)
                    assert_true(fabs((double)out[(y * row + x) * channels + c] - expected) <=
                                (inside ? 0.5 / 255.0 + 1e-6 : 0.0));
            }
}

// Sixteenths are exact in floats, and off by half a code at most in unorm.
static void drawn_texels_are_read_back(void **state)
{
    static const struct {
        GLenum format;
        int channels, one;
        GLenum type;
    } cases[] = {
        {GL_R8, 1, 255, GL_UNSIGNED_BYTE},
        {GL_RGBA8, 4, 255, GL_UNSIGNED_BYTE},
        {GL_R16, 1, 65535, GL_UNSIGNED_SHORT},
        {GL_RGBA16, 4, 65535, GL_UNSIGNED_SHORT},
        {GL_R16F, 1, 0, GL_FLOAT},
        {GL_RGBA16F, 4, 0, GL_FLOAT},
        {GL_R32F, 1, 0, GL_FLOAT},
        {GL_RGBA32F, 4, 0, GL_FLOAT},
    };
    float values[WIDTH * HEIGHT];
    int ran = 0;
    (void)state;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        values[i] = (float)i / 16.0f;
    for (int k = 0; k < 2 * (int)(sizeof cases / sizeof *cases); k++) {
        weft_context *context = contexts[k % 2];
        struct weft_gl_target target, one;
        struct weft_gl_buffer ramp = {0};
        if (!context)
            continue;
        const GladGLContext *gl = &context->gl;
        assert_int_equal(weft_context_enter(context), WEFT_OK);
        assert_int_equal(weft_gl_buffer_load(NULL, gl, GL_R32F, values, sizeof values, &ramp),
                         WEFT_OK);
        assert_int_equal(weft_gl_target_create(NULL, gl, GL_R8, 1, 1, &one), WEFT_OK);
        assert_int_equal(
            weft_gl_target_create(NULL, gl, cases[k / 2].format, WIDTH + 2, HEIGHT, &target),
            WEFT_OK);
        draw_ramp(context, &target, &one, &ramp);
        assert_floats(gl, &target, cases[k / 2].channels, 0);
        assert_floats(gl, &target, cases[k / 2].channels, STRIDE);
        if (cases[k / 2].one) {
            uint16_t words[4 * WIDTH];
            uint8_t bytes[4 * WIDTH];
            const bool byte = cases[k / 2].one == 255;
            struct weft_gl_pixels out = {.width = WIDTH, .height = 1, .type = cases[k / 2].type};
            out.data = byte ? (void *)bytes : words;
            assert_int_equal(weft_gl_target_read(NULL, gl, &target, &out), WEFT_OK);
            for (int x = 0; x < WIDTH; x++) {
                const int at = x * cases[k / 2].channels;
                const double code = byte ? bytes[at] : words[at];
                assert_true(fabs(code - cases[k / 2].one * x / 16.0) <= 0.5 + 1e-9);
            }
        }
        weft_gl_target_destroy(gl, &one);
        weft_gl_target_destroy(gl, &target);
        weft_gl_buffer_destroy(gl, &ramp);
        weft_context_leave(context);
        ran++;
    }
    assert_int_equal(ran, (contexts[1] ? 2 : 1) * (int)(sizeof cases / sizeof *cases));
}

static void targets_and_buffers_grow_and_stay(void **state)
{
    const GladGLContext *gl = &contexts[0]->gl;
    struct weft_gl_target target = {0};
    struct weft_gl_buffer buffer = {0};
    const float values[8] = {0};
    (void)state;
    assert_int_equal(weft_context_enter(contexts[0]), WEFT_OK);
    assert_int_equal(weft_gl_target_fit(NULL, gl, GL_R32F, 8, 4, &target), WEFT_OK);
    const GLuint first = target.texture;
    assert_int_equal(weft_gl_target_fit(NULL, gl, GL_R32F, 3, 4, &target), WEFT_OK);
    assert_int_equal(target.texture, first);
    assert_int_equal(weft_gl_target_fit(NULL, gl, GL_R32F, 2, 6, &target), WEFT_OK);
    assert_int_equal(target.width, 8);
    assert_int_equal(target.height, 6);
    assert_int_equal(weft_gl_target_fit(NULL, gl, GL_R8, 2, 2, &target), WEFT_OK);
    assert_int_equal(target.width, 2);
    weft_gl_target_destroy(gl, &target);
    assert_int_equal(target.texture, 0);
    weft_gl_target_destroy(gl, &target); // {0} is fine

    assert_int_equal(weft_gl_buffer_load(NULL, gl, GL_R32F, values, 16, &buffer), WEFT_OK);
    const GLuint kept = buffer.buffer;
    assert_int_equal(weft_gl_buffer_load(NULL, gl, GL_R32F, values, 32, &buffer), WEFT_OK);
    assert_int_equal(buffer.buffer, kept);
    assert_int_equal(buffer.size_bytes, 32);
    assert_int_equal(weft_gl_buffer_load(NULL, gl, GL_R32F, values, 4, &buffer), WEFT_OK);
    assert_int_equal(buffer.size_bytes, 32);
    weft_gl_buffer_destroy(gl, &buffer);
    weft_context_leave(contexts[0]);
}

static void what_cannot_be_had_is_told(void **state)
{
    const GladGLContext *gl = &contexts[0]->gl;
    const int side = weft_context_get_info(contexts[0])->max_target_size + 1;
    struct weft_gl_target target;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    (void)state;
    assert_int_equal(weft_context_enter(contexts[0]), WEFT_OK);
    assert_int_equal(weft_gl_target_create(&log, gl, GL_R32F, side, 1, &target), WEFT_ERR_GL);
    assert_non_null(strstr(message.text, "x 1 texels r32f"));
    assert_int_equal(target.texture, 0);
    assert_int_equal(weft_gl_target_create(NULL, gl, GL_R32F, 1, 1, &target), WEFT_OK);
    weft_gl_target_destroy(gl, &target);
    weft_context_leave(contexts[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drawn_texels_are_read_back),
        cmocka_unit_test(targets_and_buffers_grow_and_stay),
        cmocka_unit_test(what_cannot_be_had_is_told),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
