// SPDX-License-Identifier: BSD-3-Clause
// Samplers: what is proven of known ones holds for them, others are refused, and what is measured
// of a context's holds at points that were not measured.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "passes/gl/program.h"
#include "passes/gl/sampler_rows.h"
#include "passes/gl/target.h"
#include "passes/gl/volume_texture.h"

enum { COUNT = WEFT_SAMPLER_POINTS * WEFT_SAMPLER_ROWS };

// ---- samplers that are known --------------------------------------------------------------------

// Cuts or rounds a fraction to `bits` and a value to multiples of `unit` (0: not); moves
// coordinates.
struct emulated {
    int bits;
    bool rounds;
    double unit, moved;
    bool falls; // the fraction does, at one place
};

static double emulate(const struct emulated *e, double low, int size, double coordinate)
{
    const double at = coordinate - 0.5 + e->moved, scale = ldexp(1.0, e->bits);
    double fixed = floor(at * scale + (e->rounds ? 0.5 : 0.0)) / scale;
    const double whole = floor(fixed), fraction = fixed - whole;
    double texel[2];
    for (int i = 0; i < 2; i++) {
        const int number = (int)fmax(0.0, fmin(whole + i, size - 1.0));
        texel[i] = number % 2 ? 1.0 : low;
    }
    double value = texel[0] + fraction * (texel[1] - texel[0]);
    if (e->falls && fraction > 0.5 && fraction < 0.51)
        value = texel[0] + 0.4 * (texel[1] - texel[0]);
    return e->unit > 0.0 ? floor(value / e->unit) * e->unit : value;
}

static bool judge(const struct emulated *e, struct weft_sampler *out, char *why, size_t why_size)
{
    enum { SIZE = 256 };
    static float contrast[COUNT], code[COUNT];
    struct weft_sampler_row rows[WEFT_SAMPLER_ROWS];
    const double low = 1.0 - 1.0 / 255.0;
    weft_sampler_rows_set(SIZE, rows);
    for (int i = 0; i < COUNT; i++) {
        const struct weft_sampler_row *row = &rows[i / WEFT_SAMPLER_POINTS];
        const double at = row->start + (double)(i % WEFT_SAMPLER_POINTS) * row->step;
        contrast[i] = (float)emulate(e, 0.0, SIZE, at);
        code[i] = (float)emulate(e, low, SIZE, at);
    }
    *out = (struct weft_sampler){0};
    return weft_sampler_rows_judge(&(struct weft_sampler_found){SIZE, contrast, code, low}, out,
                                   why, why_size);
}

// What holds is found, and at most half as much again but for what 2^13 points leave open.
static void test_known(void **state)
{
    static const struct {
        struct emulated sampler;
        double fraction, rounding;
    } cases[] = {
        {{8, true, 0.0, 0.0, false}, 0x1p-9, 0.0},
        {{8, false, 0.0, 0.0, false}, 0x1p-8, 0.0},
        {{6, true, 0.0, 0.0, false}, 0x1p-7, 0.0},
        {{12, false, 0.0, 0.0, false}, 0x1p-12, 0.0},
        {{24, true, 0.0, 0.0, false}, 0x1p-25, 0.0},
        {{8, false, 1.0 / 255, 0.0, false}, 0x1p-8, 1.0 / 255},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_sampler found;
        char why[200] = "";
        assert_true(judge(&cases[i].sampler, &found, why, sizeof why));
        assert_int_equal(found.max_size, 256);
        // Values cut off to codes are off by more where texels differ by all: counted as fraction.
        const double most = cases[i].fraction + cases[i].sampler.unit;
        if (!(found.fraction >= cases[i].fraction && found.fraction <= most + 0x1p-12))
            fail_msg("sampler %zu: fraction to %g instead of %g", i, found.fraction,
                     cases[i].fraction);
        if (!(found.rounding >= 0.99 * cases[i].rounding &&
              found.rounding <= cases[i].rounding + found.fraction / 100 + 0x1p-20))
            fail_msg("sampler %zu: values to %g instead of %g", i, found.rounding,
                     cases[i].rounding);
    }
}

static void test_refused(void **state)
{
    static const struct emulated cases[] = {
        {16, true, 0.0, 0x1p-10, false},  // centres are no texels
        {8, false, 0.0, -0x1p-20, false}, // one step before
        {16, true, 0.0, 0.0, true},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_sampler found;
        char why[200] = "";
        assert_false(judge(&cases[i], &found, why, sizeof why));
        assert_true(strlen(why) > 0);
    }
}

// ---- contexts' own ------------------------------------------------------------------------------

static const char fragment[] =
    "uniform sampler3D source;\n"
    "uniform vec3 points[64];\n"
    "out float value;\n"
    "void main() { ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    value = textureLod(source, points[at.x + 8 * at.y], 0.0).r; }\n";

enum { SIDE = 64, TEXELS = SIDE * SIDE * SIDE, POINTS = 64, TURNS = 12 };

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

// Random texels, as stored and as the numbers that they stand for.
static void fill(enum weft_source_format format, uint32_t *random, uint8_t *stored, double *value)
{
    for (int i = 0; i < TEXELS; i++) {
        const uint32_t bits = next_random(random);
        if (format == WEFT_SOURCE_FLOAT) {
            const float f = (float)bits * 0x1p-24f;
            memcpy(stored + 4 * (size_t)i, &f, 4);
            value[i] = f;
        } else if (format == WEFT_SOURCE_HALF) {
            const uint16_t half = (uint16_t)(0x3800u + (bits & 0x3ffu)); // in [1/2, 1)
            memcpy(stored + 2 * (size_t)i, &half, 2);
            value[i] = 0.5 + (bits & 0x3ffu) * 0x1p-11;
        } else if (format == WEFT_SOURCE_UNORM16) {
            const uint16_t code = (uint16_t)bits;
            memcpy(stored + 2 * (size_t)i, &code, 2);
            value[i] = code / 65535.0;
        } else {
            stored[i] = (uint8_t)bits;
            value[i] = stored[i] / 255.0;
        }
    }
}

static double trilinear(const double *value, const float at[3])
{
    double sum = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1.0;
        size_t index = 0;
        for (int a = 2; a >= 0; a--) {
            const double texel = (double)at[a] * SIDE - 0.5, whole = floor(texel);
            const int up = corner >> a & 1;
            weight *= up ? texel - whole : 1.0 - (texel - whole);
            index = index * SIDE + (size_t)whole + (size_t)up;
        }
        sum += weight * value[index];
    }
    return sum;
}

// The largest difference from exact interpolation over random points.
static double compare(weft_context *context, enum weft_source_format format, uint32_t *random,
                      const double *value, const struct weft_gl_volume *volume,
                      const struct weft_gl_target *target)
{
    const GladGLContext *gl = &context->gl;
    double largest = 0.0;
    GLuint program;
    assert_int_equal(
        weft_program_get(context, "points", "", weft_shader_full_target, fragment, &program),
        WEFT_OK);
    gl->UseProgram(program);
    weft_gl_bind_texture(gl, program, 0, "source", GL_TEXTURE_3D, volume->texture);
    for (int turn = 0; turn < TURNS; turn++) {
        float points[POINTS][3], found[POINTS];
        for (int i = 0; i < 3 * POINTS; i++)
            points[i / 3][i % 3] =
                (0.5f + (float)next_random(random) * 0x1p-24f * (SIDE - 1)) / SIDE;
        gl->Uniform3fv(weft_gl_location(gl, program, "points"), POINTS, points[0]);
        weft_gl_target_bind(gl, target, 8, 8);
        gl->DrawArrays(GL_TRIANGLES, 0, 3);
        assert_int_equal(
            weft_gl_target_read(
                NULL, gl, target,
                &(struct weft_gl_pixels){.width = 8, .height = 8, .type = GL_FLOAT, .data = found}),
            WEFT_OK);
        for (int i = 0; i < POINTS; i++)
            largest = larger(largest, fabs(found[i] - trilinear(value, points[i])));
    }
    (void)format;
    return largest;
}

static void test_measured(void **state)
{
    uint8_t *stored = malloc(4 * TEXELS);
    double *value = malloc(TEXELS * sizeof *value);
    uint32_t random = 1;
    int measured = 0;
    (void)state;
    assert_true(stored && value);
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (int f = 0; f < WEFT_SOURCE_FORMATS; f++) {
            const enum weft_source_format format = (enum weft_source_format)f;
            struct weft_sampler sampler, again;
            struct weft_gl_volume volume;
            struct weft_gl_target target;
            assert_int_equal(weft_sampler_measure(contexts[c], format, &sampler), WEFT_OK);
            assert_int_equal(weft_sampler_measure(contexts[c], format, &again), WEFT_OK);
            assert_memory_equal(&sampler, &again, sizeof again);
            assert_int_equal(weft_context_enter(contexts[c]), WEFT_OK);
            fill(format, &random, stored, value);
            const GladGLContext *gl = &contexts[c]->gl;
            assert_int_equal(
                weft_gl_volume_create(NULL, gl, format, (const int[]){SIDE, SIDE, SIDE}, &volume),
                WEFT_OK);
            assert_int_equal(weft_gl_volume_load(NULL, gl, &volume, 0, SIDE, stored), WEFT_OK);
            assert_int_equal(weft_gl_target_create(NULL, gl, GL_R32F, 8, 8, &target), WEFT_OK);
            const double off = compare(contexts[c], format, &random, value, &volume, &target);
            const double bound = 3.0 * (sampler.fraction + sampler.rounding);
            print_message("%s, %s: fraction %.3g, rounding %.3g, size %d; off by %.3g of %.3g\n",
                          weft_context_get_info(contexts[c])->platform,
                          weft_source_format_name(format), sampler.fraction, sampler.rounding,
                          sampler.max_size, off, bound);
            assert_true(sampler.fraction > 0.0 && sampler.fraction < 0.02);
            assert_true(off <= bound);
            weft_gl_target_destroy(gl, &target);
            weft_gl_volume_destroy(gl, &volume);
            weft_context_leave(contexts[c]);
            measured++;
        }
    }
    assert_true(measured >= WEFT_SOURCE_FORMATS);
    free(stored);
    free(value);
}

static void test_arguments(void **state)
{
    struct weft_sampler sampler;
    (void)state;
    assert_int_equal(weft_sampler_measure(contexts[0], (enum weft_source_format)4, &sampler),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(sampler.max_size, 0);
    assert_int_equal(weft_sampler_assume((enum weft_source_format)4).max_size, 0);
    for (int f = 0; f < WEFT_SOURCE_FORMATS; f++) {
        const struct weft_sampler s = weft_sampler_assume((enum weft_source_format)f);
        assert_true(s.fraction >= 0x1p-8 && s.rounding > 0.0 && s.max_size == 256);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_measured),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
