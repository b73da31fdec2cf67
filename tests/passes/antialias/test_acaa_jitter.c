// SPDX-License-Identifier: BSD-3-Clause
// Which form a context gets, and what the one without image atomics shows: the same samples but
// for those at edges, each with the colour that it has where it is.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/passes/antialias/pictures.h"
#include "passes/antialias/multisample.h"
#include "passes/gl/context_backend.h"

enum { WIDTH = 41, HEIGHT = 27, PIXELS = WIDTH * HEIGHT, TRIANGLES = 24, SAMPLES = 16 };

static const int size[2] = {WIDTH, HEIGHT};
static struct triangle_vertex vertices[3 * TRIANGLES];
static struct picture exact, jittered;

// ---- forms --------------------------------------------------------------------------------------

static enum weft_result choose(weft_context *context, enum weft_acaa_form form,
                               struct weft_acaa_report *report, struct message *message)
{
    const struct weft_log log = {keep_message, message};
    weft_acaa *acaa;
    const enum weft_result res = weft_acaa_create(
        weft_acaa_params(.width = 5, .height = 4, .form = form, .context = context, .log = &log),
        &acaa);
    if (res == WEFT_OK)
        weft_acaa_get_report(acaa, report);
    assert_int_equal(acaa != NULL, res == WEFT_OK);
    weft_acaa_destroy(&acaa);
    return res;
}

static PFNGLGETSTRINGIPROC real_strings;

static const GLubyte *GLAD_API_PTR hide_coverage(GLenum name, GLuint index)
{
    const GLubyte *text = real_strings(name, index);
    return text && strcmp((const char *)text, "GL_ARB_post_depth_coverage") == 0
               ? (const GLubyte *)"GL_hidden"
               : text;
}

// Contexts that lack one thing after another get the next form; what is asked for and not there is
// refused.
static void test_forms(void **state)
{
    struct weft_acaa_report report;
    struct message message = {.count = 0};
    weft_context *context;
    (void)state;
    if (!has_exact_forms(contexts[0]))
        return;
    assert_int_equal(choose(contexts[0], WEFT_ACAA_AUTO, &report, &message), WEFT_OK);
    const bool has_all = report.form == WEFT_ACAA_POST_DEPTH;
    assert_int_equal(weft_context_create(weft_context_params(.log = NULL), &context), WEFT_OK);
    real_strings = context->gl.GetStringi;
    context->gl.GetStringi = hide_coverage;
    assert_int_equal(choose(context, WEFT_ACAA_AUTO, &report, &message), WEFT_OK);
    assert_int_equal(report.form, WEFT_ACAA_SAMPLE_ID);
    assert_non_null(strstr(report.why, "no ARB_post_depth_coverage"));
    assert_int_equal(message.count, 0);
    assert_int_equal(choose(context, WEFT_ACAA_POST_DEPTH, &report, &message),
                     WEFT_ERR_UNSUPPORTED);
    assert_int_equal(message.count, 1);
    context->gl.GetStringi = real_strings;
    assert_int_equal(choose(context, WEFT_ACAA_AUTO, &report, &message), WEFT_OK);
    assert_int_equal(report.form == WEFT_ACAA_POST_DEPTH, has_all);
    context->gl.VERSION_4_2 = 0; // as of a context of GL 3.3
    message.count = 0;
    assert_int_equal(choose(context, WEFT_ACAA_AUTO, &report, &message), WEFT_OK);
    assert_int_equal(report.form, WEFT_ACAA_JITTER);
    assert_non_null(strstr(report.why, "GL 4.2"));
    assert_int_equal(message.count, 0);
    assert_int_equal(choose(context, WEFT_ACAA_SAMPLE_ID, &report, &message), WEFT_ERR_UNSUPPORTED);
    assert_non_null(strstr(message.text, "sample-id"));
    weft_context_destroy(&context);
}

// ---- edges --------------------------------------------------------------------------------------

static void draw_both(struct triangles *triangles, const char *fragment)
{
    triangles->fragment[WEFT_STAGE_COLOUR] = fragment;
    picture_draw(triangles,
                 weft_acaa_params(.width = WIDTH, .height = HEIGHT, .samples = SAMPLES,
                                  .background = {grey[0], grey[1], grey[2], grey[3]}),
                 &exact);
    picture_draw(triangles,
                 weft_acaa_params(.width = WIDTH, .height = HEIGHT, .samples = SAMPLES,
                                  .form = WEFT_ACAA_JITTER,
                                  .background = {grey[0], grey[1], grey[2], grey[3]}),
                 &jittered);
    picture_check_weights(&exact, PIXELS);
    picture_check_weights(&jittered, PIXELS);
    assert_int_equal(jittered.report.form, WEFT_ACAA_JITTER);
    assert_int_equal(jittered.report.callbacks, SAMPLES);
    assert_true(jittered.report.discrepancy == exact.report.discrepancy);
}

static double distance(const double p[2], const double a[2], const double b[2])
{
    const double d[2] = {b[0] - a[0], b[1] - a[1]}, l = d[0] * d[0] + d[1] * d[1];
    double t = l > 0.0 ? ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / l : 0.0;
    t = fmin(fmax(t, 0.0), 1.0);
    return hypot(p[0] - a[0] - t * d[0], p[1] - a[1] - t * d[1]);
}

// Samples of a pixel that are within 1/128 of an edge of any triangle, seen or not.
static int count_near(int x, int y, const struct weft_pattern *pattern)
{
    int near = 0;
    for (int i = 0; i < pattern->count; i++) {
        const double p[2] = {x + 0.5 + pattern->position[i][0], y + 0.5 - pattern->position[i][1]};
        bool is_near = false;
        for (int t = 0; t < TRIANGLES; t++)
            for (int k = 0; k < 3; k++) {
                const float *f = vertices[3 * t + k].position,
                            *g = vertices[3 * t + (k + 1) % 3].position;
                const double a[2] = {((double)f[0] + 1.0) / 2.0 * WIDTH,
                                     ((double)f[1] + 1.0) / 2.0 * HEIGHT};
                const double b[2] = {((double)g[0] + 1.0) / 2.0 * WIDTH,
                                     ((double)g[1] + 1.0) / 2.0 * HEIGHT};
                is_near = is_near || distance(p, a, b) < 1.0 / 128.0;
            }
        near += is_near;
    }
    return near;
}

static void make_pattern(weft_context *context, int device, struct weft_pattern *out)
{
    double position[WEFT_PATTERN_MAX][2];
    assert_int_equal(weft_msaa_positions(context, device, position), device);
    assert_int_equal(
        weft_pattern_create(weft_pattern_params(.device = (const double(*)[2])position,
                                                .device_count = device, .count = SAMPLES),
                            out),
        WEFT_OK);
}

// Flat triangles of constant depth each, none in another's plane: a pixel differs by no more than
// its samples that are near edges.
static void test_edges(void **state)
{
    int different = 0, near_pixels = 0, pixels = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        static struct weft_pattern pattern;
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        samples_scene(23, size, TRIANGLES, 1.0f, vertices);
        for (int i = 0; i < 3 * TRIANGLES; i++)
            vertices[i].position[2] = 0.9f - 0.07f * (float)(i / 3);
        triangles_create(contexts[c], vertices, 3 * TRIANGLES, &triangles);
        draw_both(&triangles, triangles_flat);
        make_pattern(contexts[c], exact.report.device_samples, &pattern);
        for (int i = 0; i < PIXELS; i++) {
            const int near = count_near(i % WIDTH, i / WIDTH, &pattern);
            for (int k = 0; k < 4; k++) {
                const double off =
                    fabs((double)exact.channel[k][i] - (double)jittered.channel[k][i]);
                assert_true(off <=
                            (double)near / SAMPLES + exact.report.bound + jittered.report.bound);
                different += k == 0 && off > exact.report.bound + jittered.report.bound;
            }
            near_pixels += near > 0;
            pixels++;
        }
        triangles_destroy(&triangles);
    }
    assert_true(pixels == 0 || (near_pixels > 0 && near_pixels < pixels));
    print_message("%d of %d pixels differ; %d have samples near edges\n", different, pixels,
                  near_pixels);
}

// A colour that is linear over the picture: its value in the middle, and there plus its slope
// times the mean of the samples' places. Vertices are snapped to 1/256 of a pixel, which moves it
// by half of that at most along each axis.
static void test_shading(void **state)
{
    static const double corner[3][2] = {{-50, -60}, {150, -30}, {-20, 150}};
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        static struct weft_pattern pattern;
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        for (int k = 0; k < 3; k++) {
            const float value = (float)((corner[k][0] + 2.0 * corner[k][1]) / 400.0);
            const float colour[4] = {value, -value, 0.0f, 1.0f};
            struct triangle_vertex all[3];
            triangle_at(size, corner, 0.5, colour, 1, all);
            vertices[k] = all[k];
        }
        triangles_create(contexts[c], vertices, 3, &triangles);
        draw_both(&triangles, triangles_smooth);
        make_pattern(contexts[c], exact.report.device_samples, &pattern);
        for (int i = 0; i < PIXELS; i++) {
            const double middle = (i % WIDTH + 0.5 + 2.0 * (i / WIDTH + 0.5)) / 400.0;
            const double shift = (pattern.mean[0] - 2.0 * pattern.mean[1]) / 400.0;
            const double snap = (1.0 + 2.0) / 400.0 / 512.0 + 1e-6;
            assert_near(exact.channel[0][i], middle, snap, "in the middle");
            assert_near(jittered.channel[0][i], middle + shift, snap, "at its samples");
            assert_near(jittered.channel[1][i], -middle - shift, snap, "at its samples");
        }
        triangles_destroy(&triangles);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forms),
        cmocka_unit_test(test_edges),
        cmocka_unit_test(test_shading),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
