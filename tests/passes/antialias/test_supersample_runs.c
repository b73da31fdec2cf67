// SPDX-License-Identifier: BSD-3-Clause
// Supersampling: methods of adding up, filters of other widths, reports, and what ends a picture
// before it is done.
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
#include "passes/antialias/supersample.h"

enum { WIDTH = 21, HEIGHT = 17, PIXELS = WIDTH * HEIGHT };
static const int size[2] = {WIDTH, HEIGHT};
static struct message message;
static const struct weft_log kept = {keep_message, &message};

// A bright triangle over a darker one, over the background. Corners are multiples of 1/256, which
// GL snaps to: rounding of matrices moves no edge.
static void make_scene(weft_context *context, struct triangles *out)
{
    static const double corner[2][3][2] = {
        {{2.265625, 1.703125}, {19.140625, 3.390625}, {9.328125, 15.796875}},
        {{-4.015625, 5.046875}, {24.984375, 8.078125}, {3.109375, 14.015625}}};
    static const float colour[2][4] = {{0.9f, 0.7f, 0.2f, 1.0f}, {0.3f, 0.1f, 0.6f, 1.0f}};
    struct triangle_vertex vertices[6];
    for (int i = 0; i < 2; i++)
        triangle_at(size, corner[i], 0.25 + 0.5 * i, colour[i], (uint32_t)i + 1, &vertices[3 * i]);
    triangles_create(context, vertices, 6, out);
}

static struct weft_supersample_params usual(weft_context *context)
{
    return (struct weft_supersample_params){
        .width = WIDTH, .height = HEIGHT, .count = 4, .context = context, .log = &kept};
}

static weft_supersample *create(const struct weft_supersample_params *params)
{
    weft_supersample *s;
    assert_int_equal(weft_supersample_create(params, &s), WEFT_OK);
    return s;
}

static struct weft_marks mark_middle(void)
{
    struct weft_marks marks = {.width = WIDTH, .height = HEIGHT, .marked = calloc(PIXELS, 1)};
    assert_non_null(marks.marked);
    for (int i = 5 * WIDTH; i < 9 * WIDTH; i++)
        marks.count += marks.marked[i] = 1;
    return marks;
}

static void draw(const struct weft_supersample_params *params, struct triangles *t,
                 const struct weft_marks *marks, float picture[PIXELS],
                 struct weft_supersample_report *report)
{
    weft_supersample *s = create(params);
    memset(picture, 0, PIXELS * sizeof *picture);
    assert_int_equal(weft_supersample_run(s, triangles_drawing(t), marks, NULL), WEFT_OK);
    assert_int_equal(weft_supersample_read(s, 0, picture, 0), WEFT_OK);
    weft_supersample_get_report(s, report);
    weft_supersample_destroy(&s);
}

// ---- methods and filters ------------------------------------------------------------------------

// Every method's picture is within its bound of the exact one's, and marked pixels have the bytes
// of all pixels.
static void test_methods(void **state)
{
    int cases = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct triangles t;
        struct weft_marks marks = mark_middle();
        make_scene(contexts[c], &t);
        for (int method = 0; method < WEFT_ACCUMULATE_METHOD_COUNT; method++) {
            static float exact[PIXELS], full[PIXELS], part[PIXELS];
            struct weft_supersample_params params = usual(contexts[c]);
            struct weft_supersample_report of_exact, report;
            params.method = WEFT_ACCUMULATE_EXACT;
            draw(&params, &t, NULL, exact, &of_exact);
            params.method = (enum weft_accumulate_method)method;
            draw(&params, &t, NULL, full, &report);
            assert_true(report.method != WEFT_ACCUMULATE_AUTO &&
                        (method == WEFT_ACCUMULATE_AUTO || report.method == params.method));
            assert_true(report.bound > 0.0 && report.bound < 0.05 && report.filter_bound == 0.0);
            draw(&params, &t, &marks, part, &report);
            for (int i = 0; i < PIXELS; i++) {
                assert_near(full[i], exact[i], of_exact.bound + report.bound, "a method's pixel");
                assert_true(memcmp(&part[i], marks.marked[i] ? &full[i] : &(float){0.0f}, 4) == 0);
            }
            cases++;
        }
        weft_marks_clear(&marks);
        triangles_destroy(&t);
    }
    assert_true(cases == WEFT_ACCUMULATE_METHOD_COUNT || cases == 2 * WEFT_ACCUMULATE_METHOD_COUNT);
}

// Samples that a filter gives nothing are not drawn: of half a pixel's width, 4 of 4 x 4 are left.
// A wide box has windows of other sizes for samples on either side.
static void test_widths(void **state)
{
    static float picture[PIXELS], middle[PIXELS];
    struct weft_supersample_params params = usual(contexts[0]);
    struct weft_supersample_report report;
    struct triangles t;
    (void)state;
    make_scene(contexts[0], &t);
    params.count = 16;
    params.filter_width = 0.5;
    draw(&params, &t, NULL, picture, &report);
    assert_true(report.samples == 16 && report.passes == 4 && report.radius == 0);
    assert_int_equal(t.calls[WEFT_STAGE_COLOUR], 4);
    static const double positions[4][2] = {
        {-0.125, -0.125}, {0.125, -0.125}, {-0.125, 0.125}, {0.125, 0.125}};
    params.position = positions;
    params.count = 4;
    params.filter_width = 0.0;
    draw(&params, &t, NULL, middle, &report);
    assert_memory_equal(picture, middle, sizeof picture);

    // A box of three pixels is the mean of nine boxes of one; a pixel at the rim has the background
    // beside it.
    params.position = NULL;
    params.count = 4;
    params.background[0] = 0.25;
    params.background[3] = 1.0;
    draw(&params, &t, NULL, middle, &report);
    params.filter_width = 3.0;
    draw(&params, &t, NULL, picture, &report);
    assert_int_equal(report.radius, 1);
    const double bound = 2.0 * (report.bound + report.filter_bound);
    int compared = 0;
    for (int y = 1; y < HEIGHT - 1; y++)
        for (int x = 1; x < WIDTH - 1; x++, compared++) {
            double sum = 0.0;
            for (int i = 0; i < 9; i++)
                sum += (double)middle[(y + i / 3 - 1) * WIDTH + x + i % 3 - 1];
            assert_near(picture[y * WIDTH + x], sum / 9.0, bound, "a pixel of a wide box");
        }
    assert_int_equal(compared, (WIDTH - 2) * (HEIGHT - 2));
    triangles_destroy(&t);
}

// ---- reports ------------------------------------------------------------------------------------

static void test_report(void **state)
{
    static float picture[PIXELS];
    struct weft_supersample_params params = usual(contexts[0]);
    struct weft_supersample_report full, sums, blocks;
    struct weft_marks marks = mark_middle();
    struct triangles t;
    (void)state;
    params.count = 16;
    make_scene(contexts[0], &t);
    draw(&params, &t, NULL, picture, &full);
    draw(&params, &t, &marks, picture, &sums);
    params.store = WEFT_STORE_BLOCKS;
    draw(&params, &t, &marks, picture, &blocks);
    assert_int_equal(full.formula_bytes, 112 * PIXELS);
    assert_int_equal(sums.formula_bytes, 11 * PIXELS + 112 * marks.count);
    assert_int_equal(blocks.formula_bytes, sums.formula_bytes);
    assert_true(sums.bytes < full.bytes && sums.bytes < blocks.bytes);
    // A scratch of 8 bytes a pixel; blocks of 4 bytes a sample and two lists besides. Sums of four
    // words for each pixel of the list, which takes 4 bytes of it; on software GL as many for the
    // pixel that is picked, and 32 rows that it is picked from.
    const bool picks = !weft_context_get_info(contexts[0])->hardware;
    assert_true(sums.bytes >= (uint64_t)(8 * PIXELS + (16 + 4) * marks.count) +
                                  (picks ? (uint64_t)(4 * marks.count + 32 * 4 * WIDTH) : 0));
    assert_true(blocks.bytes >= (uint64_t)(8 * PIXELS + 4 * PIXELS + 4 * 16 * marks.count));
    assert_near(full.discrepancy, 0.125, 1e-9, "discrepancy of 4 x 4");
    weft_marks_clear(&marks);
    triangles_destroy(&t);
}

// ---- what ends a picture ------------------------------------------------------------------------

struct patience {
    int left, calls;
    double last;
};

static bool ask(void *priv, double fraction)
{
    struct patience *p = priv;
    assert_true(fraction >= p->last && fraction <= 1.0);
    p->last = fraction;
    p->calls++;
    return p->left-- > 0;
}

// A picture that is stopped at any step is none; the next one is whole.
static void test_cancel(void **state)
{
    static float first[PIXELS], again[PIXELS];
    struct triangles t;
    int stopped = 0;
    (void)state;
    make_scene(contexts[0], &t);
    for (int store = 0; store < WEFT_STORE_COUNT; store++) {
        struct weft_supersample_params params = usual(contexts[0]);
        params.store = (enum weft_supersample_store)store;
        weft_supersample *s = create(&params);
        enum weft_result res = WEFT_ERR_CANCELLED;
        assert_int_equal(weft_supersample_run(s, triangles_drawing(&t), NULL, NULL), WEFT_OK);
        assert_int_equal(weft_supersample_read(s, 0, first, 0), WEFT_OK);
        for (int steps = 0; res != WEFT_OK; steps++) {
            struct patience patience = {.left = steps};
            res = weft_supersample_run(s, triangles_drawing(&t), NULL,
                                       &(struct weft_progress){ask, &patience});
            assert_true(res == WEFT_OK || res == WEFT_ERR_CANCELLED);
            assert_int_equal(weft_supersample_read(s, 0, again, 0),
                             res == WEFT_OK ? WEFT_OK : WEFT_ERR_ARGUMENT);
            stopped += res != WEFT_OK;
            assert_true(res != WEFT_OK || patience.last == 1.0);
        }
        assert_memory_equal(first, again, sizeof first);
        weft_supersample_destroy(&s);
    }
    assert_int_equal(stopped, 5 + 9);
    triangles_destroy(&t);
}

static const char not_finite[] = "flat in vec4 flat_colour;\n"
                                 "flat in uint surface;\n"
                                 "uniform float zero;\n"
                                 "void main()\n"
                                 "{\n"
                                 "    weft_write(flat_colour / zero, surface);\n"
                                 "}\n";

// What the callback returns comes back; values that are not finite, marks of other sizes, reading
// without a picture and kernels that a method cannot add up are refused, with a line.
static void test_errors(void **state)
{
    static float out[PIXELS];
    struct weft_supersample_params params = usual(contexts[0]);
    struct weft_marks marks = mark_middle();
    struct triangles t;
    (void)state;
    params.format = WEFT_ANTIALIAS_RGBA32F;
    make_scene(contexts[0], &t);
    weft_supersample *s = create(&params);
    assert_int_equal(weft_supersample_read(s, 0, out, 0), WEFT_ERR_ARGUMENT);
    t.result = WEFT_ERR_OPEN;
    assert_int_equal(weft_supersample_run(s, triangles_drawing(&t), NULL, NULL), WEFT_ERR_OPEN);
    t.result = WEFT_OK;
    t.fragment[WEFT_STAGE_COLOUR] = not_finite;
    for (int masked = 0; masked < 2; masked++)
        assert_int_equal(
            weft_supersample_run(s, triangles_drawing(&t), masked ? &marks : NULL, NULL),
            WEFT_ERR_FORMAT);
    t.fragment[WEFT_STAGE_COLOUR] = NULL;
    marks.width = HEIGHT;
    marks.height = WIDTH;
    message.text[0] = '\0';
    assert_int_equal(weft_supersample_run(s, triangles_drawing(&t), &marks, NULL),
                     WEFT_ERR_ARGUMENT);
    assert_string_equal(message.text, "supersample: marks of 17 x 21 pixels, not 21 x 17");
    assert_int_equal(weft_supersample_run(s, triangles_drawing(&t), NULL, NULL), WEFT_OK);
    assert_int_equal(weft_supersample_read(s, 4, out, 0), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_supersample_read(s, -1, out, 0), WEFT_ERR_ARGUMENT);
    weft_supersample_destroy(&s);

    params.filter = kernel_named("lanczos:2");
    params.method = WEFT_ACCUMULATE_TREE;
    assert_int_equal(weft_supersample_create(&params, &s), WEFT_ERR_UNSUPPORTED);
    assert_string_equal(message.text, "supersample: the kernel lanczos has weights below 0, which "
                                      "tree cannot add up: exact and float can");
    params = usual(contexts[0]);
    params.count = 15;
    assert_int_equal(weft_supersample_create(&params, &s), WEFT_ERR_ARGUMENT);
    assert_string_equal(message.text, "supersample: 15 samples are no k x k grid");
    params.count = 1;
    params.width = weft_context_get_info(contexts[0])->max_target_size + 1;
    assert_int_equal(weft_supersample_create(&params, &s), WEFT_ERR_LIMIT);
    weft_marks_clear(&marks);
    triangles_destroy(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods), cmocka_unit_test(test_widths),
        cmocka_unit_test(test_report),  cmocka_unit_test(test_cancel),
        cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests_name("supersample runs", tests, create_contexts,
                                       destroy_contexts);
}
