// SPDX-License-Identifier: BSD-3-Clause
// Multisampling: places of samples, both resolves against coverage that is known and against each
// other, errors, bytes.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/passes/antialias/triangles.h"
#include "passes/antialias/multisample.h"

enum { WIDTH = 37, HEIGHT = 23, PIXELS = WIDTH * HEIGHT };
static const int size[2] = {WIDTH, HEIGHT};

static const struct weft_msaa_params base = {
    .width = WIDTH, .height = HEIGHT, .samples = 4, .log = &log_to_stderr};

static weft_msaa *create(struct weft_msaa_params params, weft_context *context)
{
    weft_msaa *msaa;
    params.context = context;
    assert_int_equal(weft_msaa_create(&params, &msaa), WEFT_OK);
    return msaa;
}

static void draw(weft_msaa *msaa, struct triangles *t, float picture[4][PIXELS])
{
    assert_int_equal(weft_msaa_run(msaa, triangles_drawing(t)), WEFT_OK);
    for (int c = 0; c < 4; c++)
        assert_int_equal(weft_msaa_read(msaa, c, picture[c], 0), WEFT_OK);
}

// ---- places -------------------------------------------------------------------------------------

// llvmpipe has Direct3D's four; those of one are the middle; more than there are give none.
static void test_positions(void **state)
{
    double at[WEFT_PATTERN_MAX][2];
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        assert_int_equal(weft_msaa_positions(contexts[c], 1, at), 1);
        assert_true(at[0][0] == 0.0 && at[0][1] == 0.0);
        const int four = weft_msaa_positions(contexts[c], 3, at);
        assert_true(four >= 3 && four <= 4);
        for (int i = 0; i < four; i++)
            assert_true(fabs(at[i][0]) <= 0.5 && fabs(at[i][1]) <= 0.5);
        assert_int_equal(weft_msaa_positions(contexts[c], 4, at), 4);
        if (!weft_context_get_info(contexts[c])->hardware) {
            static const double standard[4][2] = {{6, 2}, {14, 6}, {2, 10}, {10, 14}};
            for (int i = 0; i < 4; i++) {
                assert_true(at[i][0] == standard[i][0] / 16.0 - 0.5);
                assert_true(at[i][1] == 0.5 - standard[i][1] / 16.0);
            }
        }
        assert_int_equal(weft_msaa_positions(contexts[c], 1000, at), 0);
        assert_int_equal(weft_msaa_positions(contexts[c], 0, at), 0);
    }
}

// ---- pictures -----------------------------------------------------------------------------------

static const float white[4] = {1.0f, 1.0f, 1.0f, 1.0f}, colour[4] = {0.8f, 0.3f, 0.1f, 1.0f};

// Everything left of a vertical edge: how many samples of the pixel at x are in it is known.
static void edge_at(double x, struct triangle_vertex out[3])
{
    const double corners[3][2] = {{x, -1000.0}, {x, 1000.0}, {-1000.0, 0.0}};
    triangle_at(size, corners, 0.5, white, 1, out);
}

// The share of the samples left of the edge, in both resolves and with 1 sample.
static void test_edge(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        for (int samples = 1; samples <= 4; samples += 3)
            for (int resolve = 0; resolve < WEFT_MSAA_RESOLVE_COUNT; resolve++) {
                struct weft_msaa_params params = base;
                params.samples = samples;
                params.resolve = (enum weft_msaa_resolve)resolve;
                params.format = WEFT_ANTIALIAS_RGBA32F;
                weft_msaa *msaa = create(params, contexts[c]);
                double at[WEFT_PATTERN_MAX][2];
                assert_int_equal(weft_msaa_positions(contexts[c], samples, at), samples);
                int shares = 0;
                for (int i = 0; i < 16; i++) {
                    const double x = 20.0 + (2 * i + 1) / 32.0;
                    struct triangle_vertex vertices[3];
                    struct triangles t;
                    float picture[4][PIXELS];
                    int in = 0;
                    edge_at(x, vertices);
                    triangles_create(contexts[c], vertices, 3, &t);
                    draw(msaa, &t, picture);
                    for (int s = 0; s < samples; s++)
                        in += 20.5 + at[s][0] < x;
                    for (int y = 0; y < HEIGHT; y++) {
                        assert_true(picture[0][y * WIDTH + 19] == 1.0f);
                        assert_true(picture[3][y * WIDTH + 20] == (float)in / (float)samples);
                        assert_true(picture[3][y * WIDTH + 21] == 0.0f);
                    }
                    shares += in > 0 && in < samples;
                    triangles_destroy(&t);
                }
                assert_true(samples == 1 ? shares == 0 : shares > 5);
                weft_msaa_destroy(&msaa);
            }
}

// Rows go up: what is drawn in the lower half of clip space is in the first rows, and `y` of
// positions runs down.
static void test_rows(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct weft_msaa_params params = base;
        double at[WEFT_PATTERN_MAX][2];
        params.format = WEFT_ANTIALIAS_RGBA32F;
        params.resolve = WEFT_MSAA_SUM;
        weft_msaa *msaa = create(params, contexts[c]);
        assert_int_equal(weft_msaa_positions(contexts[c], 4, at), 4);
        for (int i = 0; i < 4; i++) {
            const double y = 7.0 + (4 * i + 1) / 16.0;
            const double corners[3][2] = {{-1000.0, y}, {1000.0, y}, {0.0, -1000.0}};
            struct triangle_vertex vertices[3];
            struct triangles t;
            float picture[4][PIXELS];
            int in = 0;
            triangle_at(size, corners, 0.5, white, 1, vertices);
            triangles_create(contexts[c], vertices, 3, &t);
            draw(msaa, &t, picture);
            for (int s = 0; s < 4; s++)
                in += 7.5 - at[s][1] < y;
            assert_true(picture[0][6 * WIDTH] == 1.0f && picture[0][8 * WIDTH] == 0.0f);
            assert_true(picture[0][7 * WIDTH] == (float)in / 4.0f);
            triangles_destroy(&t);
        }
        weft_msaa_destroy(&msaa);
    }
}

static void random_triangles(struct triangle_vertex *vertices, int count, float brightest)
{
    srand(1);
    for (int i = 0; i < count; i++) {
        double corners[3][2];
        float c[4] = {0.0f, 0.0f, 0.0f, 1.0f};
        for (int k = 0; k < 3; k++) {
            corners[k][0] = rand() % (WIDTH * 64) / 64.0;
            corners[k][1] = rand() % (HEIGHT * 64) / 64.0;
            c[k] = brightest * (float)(rand() % 1000) / 1000.0f;
        }
        triangle_at(size, corners, rand() % 1000 / 1000.0, c, (uint32_t)i + 1, &vertices[3 * i]);
    }
}

// GL's own mean of codes is within one of the exact one; of floats within their rounding.
static void test_resolves(void **state)
{
    enum { COUNT = 60 };
    static const double tolerance[] = {1.0 / 255.0 + 1e-7, 1e-3, 1e-6};
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        for (int format = 0; format < WEFT_ANTIALIAS_FORMAT_COUNT; format++) {
            struct triangle_vertex vertices[3 * COUNT];
            struct weft_msaa_params params = base;
            struct triangles t;
            static float blit[4][PIXELS], sum[4][PIXELS];
            double largest = 0.0;
            int mixed = 0;
            params.format = (enum weft_antialias_format)format;
            params.background[0] = 0.25;
            params.background[3] = 1.0;
            random_triangles(vertices, COUNT, 1.0f);
            triangles_create(contexts[c], vertices, 3 * COUNT, &t);
            weft_msaa *msaa = create(params, contexts[c]);
            draw(msaa, &t, blit);
            weft_msaa_destroy(&msaa);
            params.resolve = WEFT_MSAA_SUM;
            msaa = create(params, contexts[c]);
            draw(msaa, &t, sum);
            weft_msaa_destroy(&msaa);
            triangles_destroy(&t);
            for (int i = 0; i < PIXELS; i++) {
                for (int k = 0; k < 4; k++)
                    largest = larger(largest, fabs((double)blit[k][i] - (double)sum[k][i]));
                assert_true(sum[3][i] == 1.0f);
                mixed += blit[0][i] != sum[0][i];
            }
            print_message(
                "%s: GL's resolve differs from the exact mean in %d of %d pixels, by %g\n",
                weft_antialias_format_names[format], mixed, PIXELS, largest);
            assert_true(largest <= tolerance[format]);
        }
}

// A picture again is the same, after one of other colours, and one of no triangles is background.
static void test_again(void **state)
{
    struct triangle_vertex vertices[6];
    struct triangles t;
    static float first[4][PIXELS], other[4][PIXELS], again[4][PIXELS];
    struct weft_msaa_params params = base;
    (void)state;
    edge_at(11.3, vertices);
    edge_at(30.7, vertices + 3);
    for (int i = 0; i < 3; i++)
        memcpy(vertices[3 + i].colour, colour, sizeof colour);
    triangles_create(contexts[0], vertices, 6, &t);
    params.background[2] = 1.0;
    weft_msaa *msaa = create(params, contexts[0]);
    t.count = 3;
    draw(msaa, &t, first);
    t.first = 3;
    draw(msaa, &t, other);
    t.first = 0;
    draw(msaa, &t, again);
    assert_memory_equal(first, again, sizeof first);
    assert_memory_not_equal(first, other, sizeof first);
    assert_true(first[2][WIDTH - 1] == 1.0f && first[3][WIDTH - 1] == 0.0f);
    assert_int_equal(t.calls[WEFT_STAGE_COLOUR], 3);
    assert_int_equal(t.calls[WEFT_STAGE_DEPTH], 0);
    // Of surfaces in the same place the first is seen.
    t.count = 6;
    edge_at(30.7, vertices);
    triangles_destroy(&t);
    triangles_create(contexts[0], vertices, 6, &t);
    draw(msaa, &t, first);
    assert_true(first[0][0] == 1.0f && first[2][0] == 1.0f);
    // Strides.
    float wide[HEIGHT * 50];
    assert_int_equal(weft_msaa_read(msaa, 2, wide, 50), WEFT_OK);
    for (int y = 0; y < HEIGHT; y++)
        assert_memory_equal(wide + 50 * y, first[2] + WIDTH * y, WIDTH * sizeof *wide);
    weft_msaa_destroy(&msaa);
    triangles_destroy(&t);
}

// HDR: sums to the range are exact, beyond it an error; so is what is no number.
static void test_range(void **state)
{
    static const float values[] = {900.0f, -900.0f, 1001.0f, INFINITY, NAN};
    static const enum weft_result results[] = {WEFT_OK, WEFT_OK, WEFT_ERR_LIMIT, WEFT_ERR_FORMAT,
                                               WEFT_ERR_FORMAT};
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_msaa_params params = base;
        struct weft_msaa_report report;
        params.format = WEFT_ANTIALIAS_RGBA32F;
        params.resolve = WEFT_MSAA_SUM;
        params.range = 1000.0;
        params.log = &log;
        weft_msaa *msaa = create(params, contexts[c]);
        weft_msaa_get_report(msaa, &report);
        assert_true(report.scale == 0x1p18);
        for (size_t i = 0; i < WEFT_COUNT(values); i++) {
            struct triangle_vertex vertices[3];
            struct triangles t;
            float out[PIXELS];
            edge_at(20.5, vertices);
            for (int k = 0; k < 3; k++)
                vertices[k].colour[1] = values[i];
            triangles_create(contexts[c], vertices, 3, &t);
            message.count = 0;
            assert_int_equal(weft_msaa_run(msaa, triangles_drawing(&t)), results[i]);
            assert_int_equal(message.count, results[i] != WEFT_OK);
            if (results[i] == WEFT_OK) {
                assert_int_equal(weft_msaa_read(msaa, 1, out, 0), WEFT_OK);
                assert_true(out[0] == values[i] && out[20] == 0.5f * values[i]);
            } else {
                assert_int_equal(weft_msaa_read(msaa, 1, out, 0), WEFT_ERR_ARGUMENT);
            }
            triangles_destroy(&t);
        }
        weft_msaa_destroy(&msaa);
    }
}

// ---- reports and errors -------------------------------------------------------------------------

// Bytes that GL has: samples, and what they are resolved into.
static void test_bytes(void **state)
{
    static const int formats[] = {4, 8, 16};
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        for (int samples = 1; samples <= 4; samples += 3)
            for (int format = 0; format < WEFT_ANTIALIAS_FORMAT_COUNT; format++)
                for (int resolve = 0; resolve < WEFT_MSAA_RESOLVE_COUNT; resolve++) {
                    struct weft_msaa_params params = base;
                    struct weft_msaa_report r;
                    params.samples = samples;
                    params.format = (enum weft_antialias_format)format;
                    params.resolve = (enum weft_msaa_resolve)resolve;
                    weft_msaa *msaa = create(params, contexts[c]);
                    const int resolved = resolve == WEFT_MSAA_SUM ? 16
                                         : samples > 1            ? formats[format]
                                                                  : 0;
                    weft_msaa_get_report(msaa, &r);
                    assert_int_equal(r.samples, samples);
                    assert_int_equal(r.formula_bytes, PIXELS * samples * (formats[format] + 4));
                    assert_int_equal(r.bytes, r.formula_bytes + (uint64_t)(PIXELS * resolved));
                    assert_near(r.discrepancy, samples == 1 ? 0.5 : 158.0 / 512.0, 1e-11, "D");
                    weft_msaa_destroy(&msaa);
                }
}

static enum weft_result no_drawing(void *priv, const struct weft_antialias_pass *pass)
{
    (void)priv;
    (void)pass;
    return WEFT_ERR_UNSUPPORTED;
}

static void test_errors(void **state)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    const int most = weft_context_get_info(contexts[0])->max_target_size;
    struct weft_msaa_params good = base;
    (void)state;
    good.log = &log;
    good.context = contexts[0];
    struct weft_msaa_params bad[10];
    for (int i = 0; i < 10; i++)
        bad[i] = good;
    bad[0].width = 0;
    bad[1].samples = -1;
    bad[2].depth_bits = 16;
    bad[3].range = -1.0;
    bad[4].background[1] = (double)NAN;
    bad[5].format = WEFT_ANTIALIAS_FORMAT_COUNT;
    bad[6].resolve = WEFT_MSAA_RESOLVE_COUNT;
    bad[7].context = NULL;
    bad[8].width = most + 1;
    bad[9].samples = 1000;
    for (int i = 0; i < 10; i++) {
        weft_msaa *msaa = (weft_msaa *)&bad;
        message.count = 0;
        assert_int_equal(weft_msaa_create(&bad[i], &msaa),
                         i < 8 ? WEFT_ERR_ARGUMENT : WEFT_ERR_LIMIT);
        assert_int_equal(message.count, 1);
        assert_null(msaa);
    }
    float out[PIXELS];
    weft_msaa *msaa = create(good, contexts[0]);
    message.count = 0;
    assert_int_equal(weft_msaa_read(msaa, 0, out, 0), WEFT_ERR_ARGUMENT);
    assert_int_equal(
        weft_msaa_run(msaa, &(struct weft_antialias_drawing){.draw = no_drawing, .priv = NULL}),
        WEFT_ERR_UNSUPPORTED);
    assert_int_equal(weft_msaa_run(msaa, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, 3);
    weft_msaa_destroy(&msaa);
    weft_msaa_destroy(&msaa);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_positions), cmocka_unit_test(test_edge),
        cmocka_unit_test(test_rows),      cmocka_unit_test(test_resolves),
        cmocka_unit_test(test_again),     cmocka_unit_test(test_range),
        cmocka_unit_test(test_bytes),     cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
