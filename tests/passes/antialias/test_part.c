// SPDX-License-Identifier: BSD-3-Clause
// Parts of pictures: their pixels are, bit for bit, those of the whole picture, by all ways of
// anti-aliasing, and what is told of parts that cover a picture adds up to what is told of it.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "filter/kernels/kernel.h"
#include "passes/antialias/accumulative.h"
#include "passes/antialias/multisample.h"
#include "passes/antialias/supersample.h"
#include "tests/passes/antialias/samples.h"
#include "tests/support/common.h"
#include "tests/support/contexts.h"

enum {
    WIDTH = 131,
    HEIGHT = 75,
    PIXELS = WIDTH * HEIGHT,
    TRIANGLES = 60,
    VERTICES = 3 * TRIANGLES
};
enum { GUARD = 3 }; // floats behind each row of a part that nobody may touch

static const int size[2] = {WIDTH, HEIGHT};
static const struct weft_rectangle whole = {0, 0, WIDTH, HEIGHT};

typedef float picture[4][PIXELS];

// The second context is another window of the same GL, mostly: a few cases tell.
static size_t cases_of(int context, size_t count)
{
    return context == 0 ? count : 1;
}

// One way of drawing: what is there of these draws. The last two together are adaptive
// supersampling.
struct way {
    weft_acaa *acaa;
    weft_msaa *msaa;
    weft_marker *marker;
    weft_supersample *supersample;
    struct weft_marks marks; // of the last picture
};

static void end_way(struct way *way)
{
    weft_acaa_destroy(&way->acaa);
    weft_msaa_destroy(&way->msaa);
    weft_marker_destroy(&way->marker);
    weft_supersample_destroy(&way->supersample);
    weft_marks_clear(&way->marks);
}

static enum weft_result run(struct way *way, const struct weft_antialias_drawing *drawing)
{
    if (way->acaa)
        return weft_acaa_run(way->acaa, drawing, NULL);
    if (way->msaa)
        return weft_msaa_run(way->msaa, drawing);
    if (!way->marker)
        return weft_supersample_run(way->supersample, drawing, NULL, NULL);
    weft_marks_clear(&way->marks);
    const enum weft_result res = weft_marker_run(way->marker, drawing, &way->marks);
    return res == WEFT_OK ? weft_supersample_run(way->supersample, drawing, &way->marks, NULL)
                          : res;
}

static enum weft_result read_channel(struct way *way, int channel, float *out, size_t stride)
{
    if (way->acaa)
        return weft_acaa_read(way->acaa, channel, out, stride);
    if (way->msaa)
        return weft_msaa_read(way->msaa, channel, out, stride);
    const enum weft_result res =
        way->marker ? weft_marker_read(way->marker, channel, out, stride) : WEFT_OK;
    return res == WEFT_OK ? weft_supersample_read(way->supersample, channel, out, stride) : res;
}

static struct weft_antialias_drawing drawing_of(struct triangles *t, struct weft_rectangle part)
{
    return (struct weft_antialias_drawing){.draw = triangles_draw, .priv = t, .part = part};
}

static void draw_whole(struct way *way, struct triangles *t, picture out)
{
    const struct weft_antialias_drawing drawing = drawing_of(t, (struct weft_rectangle){0});
    assert_int_equal(run(way, &drawing), WEFT_OK);
    for (int c = 0; c < 4; c++)
        assert_int_equal(read_channel(way, c, out[c], 0), WEFT_OK);
}

static void check_part(struct way *way, struct triangles *t, struct weft_rectangle part,
                       const picture all, const char *name)
{
    static float out[HEIGHT * (WIDTH + GUARD)];
    const size_t stride = (size_t)part.width + GUARD;
    const struct weft_antialias_drawing drawing = drawing_of(t, part);
    assert_int_equal(run(way, &drawing), WEFT_OK);
    for (int c = 0; c < 4; c++) {
        memset(out, 0x5a, sizeof out);
        assert_int_equal(read_channel(way, c, out, stride), WEFT_OK);
        for (int y = 0; y < part.height; y++)
            for (int x = 0; x < (int)stride; x++) {
                const float *found = &out[(size_t)y * stride + (size_t)x];
                const int at = (part.y + y) * WIDTH + part.x + x;
                if (x >= part.width ? *(const uint32_t *)found != 0x5a5a5a5au
                                    : memcmp(found, &all[c][at], sizeof *found) != 0)
                    fail_msg("%s: channel %d of %d x %d from (%d, %d) on at (%d, %d): %.9g, not "
                             "%.9g",
                             name, c, part.width, part.height, part.x, part.y, x, y, (double)*found,
                             x < part.width ? (double)all[c][at] : 0.0);
            }
    }
}

// Parts of 1 and 7 pixels at corners and within, and all of those of 64 and of whole rows.
static int check_parts(struct way *way, struct triangles *t, const picture all, const char *name)
{
    static const struct weft_rectangle some[] = {{0, 0, 1, 1},
                                                 {WIDTH - 1, 0, 1, 1},
                                                 {WIDTH - 1, HEIGHT - 1, 1, 1},
                                                 {65, 33, 1, 1},
                                                 {0, 0, 7, 7},
                                                 {63, 61, 7, 7},
                                                 {40, 20, 7, 7},
                                                 {124, HEIGHT - 7, 7, 7},
                                                 {1, 0, WIDTH - 1, HEIGHT}};
    int checked = 0;
    for (size_t i = 0; i < WEFT_COUNT(some); i++, checked++)
        check_part(way, t, some[i], all, name);
    for (int y = 0; y < HEIGHT; y += 64)
        for (int x = 0; x < WIDTH; x += 64, checked++) {
            const struct weft_rectangle square = {x, y, 64, 64};
            check_part(way, t, weft_rectangle_common(&square, &whole), all, name);
        }
    for (int y = 0; y < HEIGHT; y += 25, checked++)
        check_part(way, t, (struct weft_rectangle){0, y, WIDTH, 25}, all, name);
    return checked;
}

// Whole, parts, and whole again: nothing of one picture is left in the next.
static int check_way(struct way *way, struct triangles *t, const char *name)
{
    static picture all, again;
    draw_whole(way, t, all);
    const int checked = check_parts(way, t, all, name);
    draw_whole(way, t, again);
    assert_memory_equal(all, again, sizeof all);
    end_way(way);
    return checked;
}

static void make_scene(weft_context *context, float range, struct triangles *out)
{
    static struct triangle_vertex vertices[VERTICES];
    samples_scene(7, size, TRIANGLES, range, vertices);
    triangles_create(context, vertices, VERTICES, out);
    out->fragment[WEFT_STAGE_COLOUR] = triangles_smooth;
}

static struct weft_kernel mitchell(void)
{
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_parse(&log_to_stderr, "mitchell", &kernel), WEFT_OK);
    return kernel;
}

// ---- accumulative -------------------------------------------------------------------------------

static const struct acaa_case {
    const char *name;
    struct weft_acaa_params params;
    bool filtered;
} acaa_cases[] = {
    {"post-depth", {.form = WEFT_ACAA_POST_DEPTH}, false},
    {"post-depth filtered", {.form = WEFT_ACAA_POST_DEPTH, .depth_bits = 32}, true},
    {"sample-id", {.form = WEFT_ACAA_SAMPLE_ID}, false},
    {"16 samples filtered", {.form = WEFT_ACAA_POST_DEPTH, .samples = 16}, true},
    {"16 samples", {.samples = 16, .coincident = WEFT_COINCIDENT_MASK}, false},
    {"no care", {.coincident = WEFT_COINCIDENT_NONE}, true},
    {"alpha", {.coincident = WEFT_COINCIDENT_ALPHA}, false},
    {"floats", {.sums = WEFT_ACAA_FLOAT}, false},
    {"jitter", {.form = WEFT_ACAA_JITTER, .samples = 4}, false},
    {"jitter filtered", {.form = WEFT_ACAA_JITTER, .samples = 4}, true},
};

static bool has_forms(const weft_context *context)
{
    return context->gl.VERSION_4_5;
}

static weft_acaa *make_acaa(weft_context *context, const struct acaa_case *c)
{
    struct weft_acaa_params params = c->params;
    weft_acaa *acaa;
    params.width = WIDTH;
    params.height = HEIGHT;
    params.context = context;
    params.log = &log_to_stderr;
    params.background[0] = 0.3;
    params.background[3] = 0.5;
    if (c->filtered)
        params.filter = mitchell();
    assert_int_equal(weft_acaa_create(&params, &acaa), WEFT_OK);
    return acaa;
}

static void accumulative(void **state)
{
    int checked = 0;
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (size_t i = 0; i < cases_of(k, WEFT_COUNT(acaa_cases)) && has_forms(contexts[k]); i++) {
            struct triangles t;
            make_scene(contexts[k], 1.0f, &t);
            struct way way = {.acaa = make_acaa(contexts[k], &acaa_cases[i])};
            checked += check_way(&way, &t, acaa_cases[i].name);
            triangles_destroy(&t);
        }
    print_message("%d parts by accumulative anti-aliasing\n", checked);
}

// A scene whose brightest colours are beyond the range at first: parts come to the whole picture's
// room together, and have its bytes with it.
static void room(void **state)
{
    int less = 0;
    (void)state;
    if (!has_forms(contexts[0]))
        skip();
    for (size_t i = 0; i < 6; i += 3) {
        static picture all;
        struct triangles t;
        struct weft_acaa_room first, found, most = {0};
        make_scene(contexts[0], 9.0f, &t);
        struct way way = {.acaa = make_acaa(contexts[0], &acaa_cases[i])};
        weft_acaa_get_room(way.acaa, &first);
        draw_whole(&way, &t, all);
        struct weft_acaa_room of_whole;
        weft_acaa_get_room(way.acaa, &of_whole);
        for (int y = 0; y < HEIGHT; y += 15)
            for (int x = 0; x < WIDTH; x += 16) {
                const struct weft_rectangle square = {x, y, 16, 15};
                const struct weft_antialias_drawing drawing =
                    drawing_of(&t, weft_rectangle_common(&square, &whole));
                assert_int_equal(weft_acaa_set_room(way.acaa, &first), WEFT_OK);
                assert_int_equal(run(&way, &drawing), WEFT_OK);
                weft_acaa_get_room(way.acaa, &found);
                less += found.range < of_whole.range || found.weight < of_whole.weight;
                most.range = fmax(most.range, found.range);
                most.weight = fmax(most.weight, found.weight);
            }
        assert_true(most.range == of_whole.range && most.weight == of_whole.weight);
        assert_int_equal(weft_acaa_set_room(way.acaa, &most), WEFT_OK);
        check_parts(&way, &t, all, acaa_cases[i].name);
        end_way(&way);
        triangles_destroy(&t);
    }
    assert_true(less > 0);
}

static void note_first(const int32_t at[2], int32_t first[2])
{
    if (at[0] >= 0 && (first[0] < 0 || at[1] < first[1] || (at[1] == first[1] && at[0] < first[0])))
        memcpy(first, at, 2 * sizeof *at);
}

// Surfaces that lie in the same place have more weight than they should: pixels of parts, and the
// first of them, are the whole picture's.
static void weights(void **state)
{
    static picture all;
    static float weight[PIXELS], part_weight[PIXELS];
    static struct triangle_vertex vertices[6];
    (void)state;
    if (!has_forms(contexts[0]))
        skip();
    struct triangles t;
    const double corner[3][2] = {{20.3, 10.1}, {110.7, 31.9}, {44.4, 66.6}};
    const float red[4] = {1.0f, 0.25f, 0.125f, 1.0f};
    for (int i = 0; i < 2; i++)
        triangle_at(size, corner, 0.5, red, (uint32_t)i + 1, &vertices[3 * i]);
    triangles_create(contexts[0], vertices, 6, &t);
    struct way way = {.acaa = make_acaa(contexts[0], &acaa_cases[5])};
    struct weft_acaa_report of_whole, report,
        sum = {.first_less = {-1, -1}, .first_more = {-1, -1}};
    draw_whole(&way, &t, all);
    assert_int_equal(weft_acaa_read_weight(way.acaa, weight, 0), WEFT_OK);
    weft_acaa_get_report(way.acaa, &of_whole);
    for (int y = 0; y < HEIGHT; y += 19)
        for (int x = 0; x < WIDTH; x += 22) {
            const struct weft_rectangle square = {x, y, 22, 19};
            const struct weft_rectangle part = weft_rectangle_common(&square, &whole);
            const struct weft_antialias_drawing drawing = drawing_of(&t, part);
            assert_int_equal(run(&way, &drawing), WEFT_OK);
            assert_int_equal(weft_acaa_read_weight(way.acaa, part_weight, 0), WEFT_OK);
            for (int i = 0; i < part.width * part.height; i++)
                assert_true(part_weight[i] ==
                            weight[(y + i / part.width) * WIDTH + x + i % part.width]);
            weft_acaa_get_report(way.acaa, &report);
            sum.less += report.less;
            sum.more += report.more;
            sum.largest = fmax(sum.largest, report.largest);
            note_first(report.first_less, sum.first_less);
            note_first(report.first_more, sum.first_more);
        }
    assert_true(of_whole.more > 100);
    assert_true(sum.less == of_whole.less && sum.more == of_whole.more &&
                sum.largest == of_whole.largest);
    assert_memory_equal(sum.first_less, of_whole.first_less, sizeof sum.first_less);
    assert_memory_equal(sum.first_more, of_whole.first_more, sizeof sum.first_more);
    end_way(&way);
    triangles_destroy(&t);
}

// ---- multisampling ------------------------------------------------------------------------------

static void multisampled(void **state)
{
    int checked = 0;
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (size_t i = 0; i < cases_of(k, 6); i++) {
            struct triangles t;
            struct way way = {0};
            char name[64];
            const enum weft_antialias_format format = (enum weft_antialias_format)(i % 3);
            make_scene(contexts[k], 1.0f, &t);
            snprintf(name, sizeof name, "msaa %zu", i);
            assert_int_equal(
                weft_msaa_create(weft_msaa_params(.width = WIDTH, .height = HEIGHT,
                                                  .samples = i < 4 ? 4 : 1, .format = format,
                                                  .resolve = (enum weft_msaa_resolve)(i / 2 % 2),
                                                  .depth_bits = i % 2 ? 24 : 32, .range = 8.0,
                                                  .background = {0.2371, 0.611, 0.0029, 0.4999},
                                                  .context = contexts[k], .log = &log_to_stderr),
                                 &way.msaa),
                WEFT_OK);
            checked += check_way(&way, &t, name);
            triangles_destroy(&t);
        }
    print_message("%d parts by multisampling\n", checked);
}

// ---- supersampling ------------------------------------------------------------------------------

static const struct supersample_case {
    const char *name;
    struct weft_supersample_params params;
    bool filtered;
} supersample_cases[] = {
    {"sums", {.store = WEFT_STORE_SUMS, .format = WEFT_ANTIALIAS_RGBA32F}, false},
    {"sums of codes", {.store = WEFT_STORE_SUMS, .format = WEFT_ANTIALIAS_RGBA8}, false},
    {"sums filtered", {.store = WEFT_STORE_SUMS, .format = WEFT_ANTIALIAS_RGBA16F}, true},
    {"blocks", {.store = WEFT_STORE_BLOCKS, .format = WEFT_ANTIALIAS_RGBA16F}, false},
    {"blocks filtered", {.store = WEFT_STORE_BLOCKS, .format = WEFT_ANTIALIAS_RGBA32F}, true},
    {"tree", {.method = WEFT_ACCUMULATE_TREE, .format = WEFT_ANTIALIAS_RGBA8}, false},
    {"floats", {.method = WEFT_ACCUMULATE_FLOAT, .format = WEFT_ANTIALIAS_RGBA32F}, true},
    {"blend", {.method = WEFT_ACCUMULATE_BLEND, .format = WEFT_ANTIALIAS_RGBA8}, false},
    {"buffer", {.method = WEFT_ACCUMULATE_BUFFER, .format = WEFT_ANTIALIAS_RGBA8}, false},
};

static weft_supersample *make_supersample(weft_context *context, const struct supersample_case *c)
{
    struct weft_supersample_params params = c->params;
    weft_supersample *s;
    params.width = WIDTH;
    params.height = HEIGHT;
    params.count = 4;
    params.context = context;
    params.log = &log_to_stderr;
    params.background[1] = 0.2371;
    if (c->filtered)
        params.filter = mitchell();
    assert_int_equal(weft_supersample_create(&params, &s), WEFT_OK);
    return s;
}

static void supersampled(void **state)
{
    int checked = 0;
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (size_t i = 0; i < cases_of(k, WEFT_COUNT(supersample_cases)); i++) {
            struct triangles t;
            make_scene(contexts[k], 1.0f, &t);
            struct way way = {.supersample = make_supersample(contexts[k], &supersample_cases[i])};
            checked += check_way(&way, &t, supersample_cases[i].name);
            triangles_destroy(&t);
        }
    print_message("%d parts by supersampling\n", checked);
}

// ---- marks --------------------------------------------------------------------------------------

static weft_marker *make_marker(weft_context *context, enum weft_antialias_format format, int reach,
                                int number)
{
    weft_marker *marker;
    assert_int_equal(
        weft_marker_create(weft_marker_params(.width = WIDTH, .height = HEIGHT, .format = format,
                                              .mark = (enum weft_mark)(number % 2),
                                              .contrast = number % 3 ? 0.0 : 0.05, .reach = reach,
                                              .background = {0.0, 0.2371, 0.0, 0.0},
                                              .context = context, .log = &log_to_stderr),
                           &marker),
        WEFT_OK);
    return marker;
}

// Counts of parts that cover the picture, and their marks with what is around them.
static void check_marks(struct way *way, struct triangles *t, const struct weft_marks *all,
                        int reach)
{
    struct weft_marks sum = {0};
    for (int y = 0; y < HEIGHT; y += 20)
        for (int x = 0; x < WIDTH; x += 33) {
            const struct weft_rectangle square = {x, y, 33, 20};
            const struct weft_antialias_drawing drawing =
                drawing_of(t, weft_rectangle_common(&square, &whole));
            struct weft_marks marks;
            assert_int_equal(weft_marker_run(way->marker, &drawing, &marks), WEFT_OK);
            assert_int_equal(marks.part.x, x > reach ? x - reach : 0);
            for (int i = 0; i < marks.part.width * marks.part.height; i++)
                assert_int_equal(marks.marked[i],
                                 all->marked[(marks.part.y + i / marks.part.width) * WIDTH +
                                             marks.part.x + i % marks.part.width]);
            sum.count += marks.count;
            sum.by_edges += marks.by_edges;
            sum.by_contrast += marks.by_contrast;
            weft_marks_clear(&marks);
        }
    assert_int_equal(sum.count, all->count);
    assert_int_equal(sum.by_edges, all->by_edges);
    assert_int_equal(sum.by_contrast, all->by_contrast);
}

static void adaptive(void **state)
{
    int checked = 0, by_contrast = 0;
    (void)state;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (size_t i = 0; i < cases_of(k, 5); i++) {
            struct triangles t;
            struct weft_supersample_report report;
            static picture all;
            make_scene(contexts[k], 1.0f, &t);
            struct way way = {.supersample = make_supersample(contexts[k], &supersample_cases[i])};
            weft_supersample_get_report(way.supersample, &report);
            way.marker =
                make_marker(contexts[k], supersample_cases[i].params.format, report.radius, (int)i);
            draw_whole(&way, &t, all);
            assert_true(way.marks.count > 100 && way.marks.count < PIXELS);
            by_contrast += way.marks.by_contrast > 0;
            struct weft_marks marks = way.marks;
            way.marks = (struct weft_marks){0};
            check_marks(&way, &t, &marks, report.radius);
            weft_marks_clear(&marks);
            checked += check_way(&way, &t, supersample_cases[i].name);
            triangles_destroy(&t);
        }
    assert_true(by_contrast > 0);
    print_message("%d parts by adaptive supersampling\n", checked);
}

// ---- what is refused ----------------------------------------------------------------------------

static void refused(void **state)
{
    static const struct weft_rectangle wrong[] = {
        {0, 0, WIDTH + 1, 1}, {-1, 0, 2, 2}, {0, HEIGHT, 1, 1}, {5, 5, 0, 3}, {5, 5, 3, -3}};
    struct message message;
    const struct weft_log kept = {keep_message, &message};
    struct triangles t;
    (void)state;
    make_scene(contexts[0], 1.0f, &t);
    struct way way = {.supersample = make_supersample(contexts[0], &supersample_cases[2])};
    for (size_t i = 0; i < WEFT_COUNT(wrong); i++) {
        const struct weft_antialias_drawing drawing = drawing_of(&t, wrong[i]);
        assert_int_equal(run(&way, &drawing), WEFT_ERR_ARGUMENT);
    }
    // Marks of the part alone are not enough for a filter that reaches two pixels.
    way.marker = make_marker(contexts[0], WEFT_ANTIALIAS_RGBA16F, 0, 0);
    const struct weft_antialias_drawing part = drawing_of(&t, (struct weft_rectangle){9, 9, 9, 9});
    assert_int_equal(run(&way, &part), WEFT_ERR_ARGUMENT);
    end_way(&way);
    // A share of marks is the whole picture's.
    assert_int_equal(
        weft_marker_create(weft_marker_params(.width = WIDTH, .height = HEIGHT, .max_share = 0.1,
                                              .context = contexts[0], .log = &kept),
                           &way.marker),
        WEFT_OK);
    assert_int_equal(weft_marker_run(way.marker, &part, &way.marks), WEFT_ERR_UNSUPPORTED);
    assert_non_null(strstr(message.text, "whole picture"));
    const struct weft_antialias_drawing all = drawing_of(&t, whole);
    assert_int_equal(weft_marker_run(way.marker, &all, &way.marks), WEFT_OK);
    assert_true(way.marks.left > 0);
    end_way(&way);
    triangles_destroy(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accumulative), cmocka_unit_test(room),         cmocka_unit_test(weights),
        cmocka_unit_test(multisampled), cmocka_unit_test(supersampled), cmocka_unit_test(adaptive),
        cmocka_unit_test(refused),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
