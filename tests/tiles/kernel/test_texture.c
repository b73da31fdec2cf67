// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "passes/gl/context_backend.h"
#include "tests/support/texture.h"
#include "weft.h"

static const struct {
    enum weft_tile_format format;
    int bits;
    GLenum nearest, linear;
} formats[] = {
    {WEFT_TILE_UNORM, 4, GL_R8, GL_R16},
    {WEFT_TILE_UNORM, 7, GL_R8, GL_R16},
    {WEFT_TILE_UNORM, 8, GL_R8, GL_R8},
    {WEFT_TILE_UNORM, 9, GL_R16, GL_R16},
    {WEFT_TILE_UNORM, 15, GL_R16, GL_R16},
    {WEFT_TILE_UNORM, 16, GL_R16, GL_R16},
    {WEFT_TILE_SNORM, 8, GL_R8_SNORM, GL_R8_SNORM},
    {WEFT_TILE_SNORM, 16, GL_R16_SNORM, GL_R16_SNORM},
    {WEFT_TILE_HALF, 0, GL_R16F, GL_R16F},
    {WEFT_TILE_FLOAT, 0, GL_R32F, GL_R32F},
};

static void assert_read_back(const GladGLContext *gl, const weft_kernel_tiles *set,
                             const struct weft_tile_texture *texture, const void *expected)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const size_t bytes = info->tile_values * info->value_bytes;
    void *values = malloc(bytes);
    assert_non_null(values);
    assert_int_equal(weft_tile_texture_read(NULL, gl, set, texture, values), WEFT_OK);
    assert_memory_equal(values, expected, bytes);
    free(values);
}

static void check_tiles(const GladGLContext *gl, const weft_kernel_tiles *set,
                        enum weft_error_lookup lookup, GLenum internal)
{
    const int count = weft_kernel_tiles_get_info(set)->tile_count;
    for (int t = 0; t < count; t += 3) {
        struct weft_tile_texture texture;
        assert_int_equal(weft_tile_texture_create(NULL, gl, set, t, lookup, 0, &texture), WEFT_OK);
        assert_int_equal(texture.internal_format, internal);
        assert_read_back(gl, set, &texture, weft_kernel_tiles_get(set, t)->data);
        weft_tile_texture_destroy(gl, &texture);
    }
}

static void read_back_equals_the_cpus_values(void **state)
{
    (void)state;
    const char *const names[] = {"catmull-rom", "bspline2", "lanczos:3", "d-bspline"};
    for (int c = 0; c < 2 && contexts[c]; c++) {
        assert_int_equal(weft_context_enter(contexts[c]), WEFT_OK);
        for (size_t i = 0; i < WEFT_COUNT(formats) * WEFT_COUNT(names) * 3; i++) {
            const size_t f = i % WEFT_COUNT(formats), n = i / WEFT_COUNT(formats) / 3;
            const int dims = 1 + (int)(i / WEFT_COUNT(formats) % 3);
            weft_kernel_tiles *set = NULL;
            assert_int_equal(
                weft_kernel_tiles_create(
                    weft_kernel_tiles_params(.kernel = kernel_named(names[n]), .dims = dims,
                                             .samples = dims == 3 ? 7 : 33,
                                             .format = formats[f].format, .bits = formats[f].bits,
                                             .scaling = WEFT_TILE_SCALE_EACH),
                    &set),
                WEFT_OK);
            check_tiles(&contexts[c]->gl, set, WEFT_ERROR_NEAREST, formats[f].nearest);
            if (n == 0)
                check_tiles(&contexts[c]->gl, set, WEFT_ERROR_LINEAR, formats[f].linear);
            weft_kernel_tiles_destroy(&set);
        }
        weft_context_leave(contexts[c]);
    }
}

static void sampling_is_as_asked(void **state)
{
    (void)state;
    const GladGLContext *gl = &contexts[0]->gl;
    assert_int_equal(weft_context_enter(contexts[0]), WEFT_OK);
    for (int dims = 1; dims <= 3; dims++) {
        weft_kernel_tiles *set = NULL;
        assert_int_equal(
            weft_kernel_tiles_create(weft_kernel_tiles_params(.kernel = kernel_named("bspline"),
                                                              .dims = dims, .samples = 4),
                                     &set),
            WEFT_OK);
        for (int l = WEFT_ERROR_NEAREST; l <= WEFT_ERROR_LINEAR; l++) {
            struct weft_tile_texture texture;
            assert_int_equal(
                weft_tile_texture_create(NULL, gl, set, 0, (enum weft_error_lookup)l, 0, &texture),
                WEFT_OK);
            GLint filter, wrap;
            gl->BindTexture(texture.target, texture.texture);
            gl->GetTexParameteriv(texture.target, GL_TEXTURE_MAG_FILTER, &filter);
            gl->GetTexParameteriv(texture.target, GL_TEXTURE_WRAP_S, &wrap);
            assert_int_equal(filter, l == WEFT_ERROR_LINEAR ? GL_LINEAR : GL_NEAREST);
            assert_int_equal(wrap, GL_CLAMP_TO_EDGE);
            // 255 of R8 is 1.0, and one of the set is 255.
            assert_true(texture.factor == 1.0);
            weft_tile_texture_destroy(gl, &texture);
        }
        weft_kernel_tiles_destroy(&set);
    }
    weft_context_leave(contexts[0]);
}

static void limits_are_named(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    struct weft_log log = {keep_message, &message};
    struct weft_tile_texture texture;
    weft_kernel_tiles *set = NULL;
    const GladGLContext *gl = &contexts[0]->gl;
    assert_int_equal(weft_context_enter(contexts[0]), WEFT_OK);
    assert_int_equal(
        weft_kernel_tiles_create(
            weft_kernel_tiles_params(.kernel = kernel_named("bspline"), .samples = 100), &set),
        WEFT_OK);
    // The texels and a staging copy.
    assert_int_equal(
        weft_tile_texture_create(&log, gl, set, 0, WEFT_ERROR_NEAREST, 19999, &texture),
        WEFT_ERR_LIMIT);
    assert_non_null(strstr(message.text, "20000 bytes"));
    assert_non_null(strstr(message.text, "19999"));
    assert_int_equal(texture.texture, 0);
    assert_int_equal(
        weft_tile_texture_create(&log, gl, set, 0, WEFT_ERROR_NEAREST, 20000, &texture), WEFT_OK);
    weft_tile_texture_destroy(gl, &texture);
    assert_int_equal(weft_tile_texture_create(&log, gl, set, 99, WEFT_ERROR_NEAREST, 0, &texture),
                     WEFT_ERR_ARGUMENT);
    weft_kernel_tiles_destroy(&set);
    weft_context_leave(contexts[0]);
}

static GLint no_width;

static void refuse_proxy(GLenum target, GLint level, GLenum name, GLint *out)
{
    (void)target;
    (void)level;
    (void)name;
    *out = no_width;
}

// A GL that takes no such texture, by its proxy: no set that fits in memory here is too large for
// it.
static void a_refusing_proxy_is_believed(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    struct weft_log log = {keep_message, &message};
    struct weft_tile_texture texture;
    weft_kernel_tiles *set = NULL;
    GladGLContext gl = contexts[0]->gl;
    gl.GetTexLevelParameteriv = refuse_proxy;
    assert_int_equal(weft_context_enter(contexts[0]), WEFT_OK);
    assert_int_equal(
        weft_kernel_tiles_create(weft_kernel_tiles_params(.kernel = kernel_named("bspline"),
                                                          .dims = 3, .samples = 8, .bits = 16),
                                 &set),
        WEFT_OK);
    assert_int_equal(weft_tile_texture_create(&log, &gl, set, 0, WEFT_ERROR_NEAREST, 0, &texture),
                     WEFT_ERR_LIMIT);
    assert_non_null(strstr(message.text, "8^3 texels R16 (1024 bytes)"));
    assert_int_equal(texture.texture, 0);
    weft_kernel_tiles_destroy(&set);
    weft_context_leave(contexts[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(read_back_equals_the_cpus_values),
        cmocka_unit_test(sampling_is_as_asked),
        cmocka_unit_test(limits_are_named),
        cmocka_unit_test(a_refusing_proxy_is_believed),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
