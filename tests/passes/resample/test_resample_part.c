// SPDX-License-Identifier: BSD-3-Clause
// Parts of a resampling, from windows of the samples: the bytes of the whole, by every engine.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/passes/separable/wheres.h"
#include "tests/support/plans.h"

enum { CHANNELS = 3, MOST_SAMPLES = 720 * 96, MOST_PIXELS = 1500 * 192, GAP = 3 };

// ---- what is resampled --------------------------------------------------------------------------

struct shape {
    int from[2], to[2];
    struct weft_window_map map[2]; // all 0: plain
};

static const struct shape shapes[] = {
    {{64, 48}, {128, 96}, {{0}, {0}}},                        // twice
    {{61, 47}, {211, 31}, {{0}, {0}}},                        // odd factors, up and down
    {{40, 35}, {87, 64}, {{37, 80, -5, 2}, {33, 61, 3, -1}}}, // windows with an overscan
    {{700, 20}, {1490, 43}, {{0}, {0}}},                      // several tiles of passes
    {{33, 41}, {33, 41}, {{0}, {0}}},                         // the samples themselves
};

static float samples[CHANNELS][MOST_SAMPLES], whole[CHANNELS][MOST_PIXELS],
    pixels[CHANNELS][MOST_PIXELS];

static uint32_t mix(uint32_t h)
{
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return h ^ h >> 16;
}

// Noise, in the third channel with what is not finite and what is very large.
static void make_samples(const struct shape *s, bool prefiltered)
{
    const int count = s->from[0] * s->from[1];
    for (int c = 0; c < CHANNELS; c++)
        for (int i = 0; i < count; i++)
            samples[c][i] = (float)(mix((uint32_t)(i + c * 65537)) / 2147483648.0 - 1.0);
    samples[2][count / 3] = NAN;
    samples[2][count - 2] = prefiltered ? 3e36f : 3e38f; // coefficients are larger
    samples[1][1] = -1e-42f;
}

// How it is resampled: separable on one of wheres, or by passes on a context or the CPU.
struct way {
    const char *kernel;
    const struct where *where; // NULL: passes
    const char *profile;
    int together;
    weft_context *context;
};

struct work {
    weft_pass_plan *passes;
    weft_resample_plan *plan;
    weft_resample_compiled *compiled;
    weft_resample_source *source;
};

static struct weft_resample_source_params source_params(const struct way *way,
                                                        const struct shape *s)
{
    return *weft_resample_source_params(.kernel = kernel_named(way->kernel), .width = s->from[0],
                                        .height = s->from[1], .channels = CHANNELS,
                                        .plane = {samples[0], samples[1], samples[2]},
                                        .log = &log_to_stderr);
}

static struct work prepare(const struct way *way, const struct shape *s)
{
    struct work w = {NULL, NULL, NULL, NULL};
    const struct weft_kernel kernel = kernel_named(way->kernel);
    if (!way->where)
        w.passes = make_plan(weft_pass_plan_params(.kernel = kernel,
                                                   .profile = profile_named(way->profile),
                                                   .channels = way->together, .samples = 16));
    struct weft_resample_params params =
        *weft_resample_params(.passes = w.passes, .kernel = kernel,
                              .size = {s->from[0], s->from[1]}, .width = s->to[0],
                              .height = s->to[1], .map = {s->map[0], s->map[1]},
                              .unstretched = w.passes || kernel.prefiltered,
                              .memory_bytes = 1 << 19, .log = &log_to_stderr);
    struct weft_resample_compile_params compile = {.context = way->context};
    if (way->where) {
        params.engine = way->where->engine;
        params.sums = way->where->sums;
        compile = (struct weft_resample_compile_params){way->where->compile.context,
                                                        way->where->compile.cpu};
    } else {
        params.memory_bytes = 0;
    }
    assert_int_equal(weft_resample_plan_create(&params, &w.plan), WEFT_OK);
    assert_int_equal(weft_resample_compile(w.plan, &compile, &w.compiled), WEFT_OK);
    const struct weft_resample_source_params from = source_params(way, s);
    assert_int_equal(weft_resample_source_create(&from, &w.source), WEFT_OK);
    assert_int_equal(
        weft_resample_run(w.compiled,
                          weft_resample_run_params(.source = w.source,
                                                   .plane = {whole[0], whole[1], whole[2]},
                                                   .log = &log_to_stderr),
                          NULL),
        WEFT_OK);
    return w;
}

static void clear(struct work *w)
{
    weft_resample_source_destroy(&w->source);
    weft_resample_compiled_destroy(&w->compiled);
    weft_resample_plan_destroy(&w->plan);
    weft_pass_plan_destroy(&w->passes);
}

// ---- windows ------------------------------------------------------------------------------------

// A window's samples and no more, so that a tool that watches memory sees what reads beyond.
static void cut_window(const struct shape *s, const struct weft_rectangle *window,
                       float *plane[CHANNELS])
{
    for (int c = 0; c < CHANNELS; c++) {
        plane[c] = malloc((size_t)window->width * (size_t)window->height * sizeof(float));
        assert_non_null(plane[c]);
        for (int y = 0; y < window->height; y++)
            memcpy(plane[c] + y * window->width,
                   samples[c] + (window->y + y) * s->from[0] + window->x,
                   (size_t)window->width * sizeof(float));
    }
}

static void free_planes(float *plane[CHANNELS])
{
    for (int c = 0; c < CHANNELS; c++)
        free(plane[c]);
}

// Of bands of rows, each measured with the rows past it that differences need, and no others.
static struct weft_resample_measured measure(const struct way *way, const struct shape *s)
{
    struct weft_resample_measured sum = WEFT_RESAMPLE_MEASURED_NONE, one;
    const int height = s->from[1], order = kernel_named(way->kernel).order;
    for (int first = 0; first < height; first += 7) {
        const int rows = height - first < 7 ? height - first : 7, more = height - first - rows;
        const struct weft_rectangle window = {0, first, s->from[0],
                                              rows + (more < order ? more : order)};
        struct weft_resample_source_params from = source_params(way, s);
        float *plane[CHANNELS];
        cut_window(s, &window, plane);
        from.window = window;
        memcpy(from.plane, plane, sizeof plane);
        assert_int_equal(weft_resample_measure(&from, first, rows, true, &one), WEFT_OK);
        weft_resample_measured_join(&sum, &one);
        free_planes(plane);
    }
    return sum;
}

static struct weft_resample_survey survey(const struct work *w, const struct way *way,
                                          const struct shape *s,
                                          const struct weft_resample_measured *measured)
{
    struct weft_resample_survey sum = {{{0}}}, one;
    for (int first = 0; first < s->from[1]; first += 9) {
        const int left = s->from[1] - first;
        struct weft_resample_source_params from = source_params(way, s);
        weft_resample_source *source = NULL;
        from.window = (struct weft_rectangle){0, first, s->from[0], left < 9 ? left : 9};
        from.measured = measured;
        for (int c = 0; c < CHANNELS; c++)
            from.plane[c] += first * s->from[0];
        assert_int_equal(weft_resample_source_create(&from, &source), WEFT_OK);
        assert_int_equal(weft_resample_survey_source(w->plan, source, &one), WEFT_OK);
        weft_resample_survey_join(&sum, &one);
        weft_resample_source_destroy(&source);
    }
    return sum;
}

// ---- parts --------------------------------------------------------------------------------------

static void check_pixels(const struct shape *s, const struct weft_rectangle *part)
{
    const int stride = part->width + GAP;
    for (int c = 0; c < CHANNELS; c++)
        for (int y = 0; y < part->height; y++) {
            const float *row = pixels[c] + y * stride;
            assert_memory_equal(row, whole[c] + (part->y + y) * s->to[0] + part->x,
                                (size_t)part->width * sizeof *row);
            for (int x = 0; x < GAP; x++)
                assert_true(row[part->width + x] == 4711.0f);
        }
}

// Returns what verifying it shows.
static struct weft_verify_report run_part(const struct work *w, const struct way *way,
                                          const struct shape *s, const struct weft_rectangle *part,
                                          const struct weft_resample_measured *measured,
                                          const struct weft_resample_survey *surveyed)
{
    const bool all = kernel_named(way->kernel).prefiltered;
    const struct weft_rectangle window = weft_resample_reach(w->plan, part);
    struct weft_resample_source_params from = source_params(way, s);
    struct weft_resample_report report;
    struct weft_verify_report error;
    weft_resample_source *source = NULL;
    float *plane[CHANNELS];
    cut_window(s, &window, plane);
    from.window = window;
    from.measured = all ? NULL : measured;
    memcpy(from.plane, plane, sizeof plane);
    assert_int_equal(weft_resample_source_create(&from, &source), WEFT_OK);
    const struct weft_resample_source_info *info = weft_resample_source_get_info(source);
    assert_memory_equal(&info->statistics, &weft_resample_source_get_info(w->source)->statistics,
                        sizeof info->statistics);
    struct weft_resample_run_params run = {.source = source,
                                           .part = *part,
                                           .survey = all ? NULL : surveyed,
                                           .plane = {pixels[0], pixels[1], pixels[2]},
                                           .stride = part->width + GAP,
                                           .log = &log_to_stderr};
    for (int c = 0; c < CHANNELS; c++)
        for (int i = 0; i < (part->width + GAP) * part->height; i++)
            pixels[c][i] = 4711.0f;
    assert_int_equal(weft_resample_run(w->compiled, &run, &report), WEFT_OK);
    assert_int_equal(report.pixels.count, CHANNELS * part->width * part->height);
    check_pixels(s, part);
    struct weft_resample_verify_params verify = {.source = source,
                                                 .part = *part,
                                                 .plane = {pixels[0], pixels[1], pixels[2]},
                                                 .stride = run.stride,
                                                 .how = {.max_seconds = 0.001},
                                                 .log = &log_to_stderr};
    assert_int_equal(weft_resample_verify(w->plan, &verify, &error), WEFT_OK);
    assert_int_equal(error.not_finite_mismatches, 0);
    weft_resample_source_destroy(&source);
    free_planes(plane);
    return error;
}

// Parts of a size, all over or some of them.
static int run_parts(const struct work *w, const struct way *way, const struct shape *s, int width,
                     int height, int some)
{
    struct weft_resample_measured measured = WEFT_RESAMPLE_MEASURED_NONE;
    struct weft_resample_survey surveyed = {{{0}}};
    if (!kernel_named(way->kernel).prefiltered) {
        measured = measure(way, s);
        surveyed = survey(w, way, s, &measured);
    }
    int ran = 0, number = 0;
    for (int y = 0; y < s->to[1]; y += height)
        for (int x = 0; x < s->to[0]; x += width) {
            if (some > 1 && number++ % some)
                continue;
            const struct weft_rectangle part = {x, y, s->to[0] - x < width ? s->to[0] - x : width,
                                                s->to[1] - y < height ? s->to[1] - y : height};
            const struct weft_verify_report error =
                run_part(w, way, s, &part, &measured, &surveyed);
            assert_true(error.pixels_total == (uint64_t)part.width * (uint64_t)part.height);
            ran++;
        }
    return ran;
}

static int check_way(const struct way *way, const struct shape *s)
{
    const bool slow = kernel_named(way->kernel).prefiltered;
    int ran = 0;
    make_samples(s, slow);
    struct work w = prepare(way, s);
    const int area = s->to[0] * s->to[1];
    ran += run_parts(&w, way, s, 1, 1, area / (slow ? 3 : 9) + 1);
    ran += run_parts(&w, way, s, 7, 7, area / 49 / (slow ? 2 : 8) + 1);
    ran += run_parts(&w, way, s, 64, 64, area / 4096 / (slow ? 1 : 6) + 1);
    ran += run_parts(&w, way, s, s->to[0], 5, s->to[1] / 5 / 3 + 1);
    clear(&w);
    return ran;
}

static bool full(void)
{
    const char *asked = getenv("WEFT_RANKS");
    return asked && strcmp(asked, "full") == 0;
}

// A covering few, or with WEFT_RANKS=full every kernel in every shape by every engine.
static void separable_parts_are_the_crop(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "nearest",  "lanczos:3",
                                          "linear",      "mitchell", "bspline3i"};
    int ran = 0, number = 0;
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++)
        for (size_t s = 0; s < WEFT_COUNT(shapes); s++)
            for (int w = 0; w < where_count; w++, number++)
                if (full() || (k + s + (size_t)w) % 7 == 0)
                    ran +=
                        check_way(&(struct way){kernels[k], &wheres[w], NULL, 0, NULL}, &shapes[s]);
    assert_true(ran > number);
}

static void parts_by_passes_are_the_crop(void **state)
{
    static const struct way ways[] = {
        {"catmull-rom", NULL, "radeon8500", 1, NULL}, {"lanczos:2", NULL, "fp32", 1, NULL},
        {"mitchell", NULL, "radeon8500", 4, NULL},    {"nearest", NULL, "fp32", 4, NULL},
        {"bspline3i", NULL, "fp32", 1, NULL},         {"catmull-rom", NULL, "fp16", 1, NULL}};
    int ran = 0, number = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(ways); i++)
        for (size_t s = 0; s < WEFT_COUNT(shapes); s++)
            for (int on = -1; on < first_cpu; on++, number++) {
                struct way way = ways[i];
                way.context = on < 0 ? NULL : wheres[on].compile.context;
                if (full() || (i + 2 * s + (size_t)(on + 1)) % 5 == 0)
                    ran += check_way(&way, &shapes[s]);
            }
    assert_true(ran > number);
}

// ---- what is joined -----------------------------------------------------------------------------

static void measured_parts_are_the_whole(void **state)
{
    static const char *const kernels[] = {"nearest", "linear", "catmull-rom", "mitchell"};
    int ran = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(kernels) * WEFT_COUNT(shapes); i++, ran++) {
        const struct shape *s = &shapes[i / WEFT_COUNT(kernels)];
        const struct way way = {.kernel = kernels[i % WEFT_COUNT(kernels)]};
        struct weft_resample_source_params from = source_params(&way, s);
        weft_resample_source *one = NULL, *parts = NULL;
        make_samples(s, false);
        const struct weft_resample_measured measured = measure(&way, s);
        assert_int_equal(weft_resample_source_create(&from, &one), WEFT_OK);
        from.measured = &measured;
        assert_int_equal(weft_resample_source_create(&from, &parts), WEFT_OK);
        assert_memory_equal(&weft_resample_source_get_info(parts)->statistics,
                            &weft_resample_source_get_info(one)->statistics,
                            sizeof(struct weft_resample_statistics));
        assert_true(weft_resample_e1(parts) == weft_resample_e1(one));
        weft_resample_source_destroy(&one);
        weft_resample_source_destroy(&parts);
    }
    assert_int_equal(ran, WEFT_COUNT(kernels) * WEFT_COUNT(shapes));
}

static void a_range_counts_what_is_outside(void **state)
{
    const struct shape *s = &shapes[0];
    const struct way way = {.kernel = "linear"};
    struct weft_resample_source_params from = source_params(&way, s);
    struct weft_resample_measured sum = WEFT_RESAMPLE_MEASURED_NONE, one;
    weft_resample_source *source = NULL;
    (void)state;
    make_samples(s, false);
    from.low = -0.5;
    from.high = 0.25;
    assert_int_equal(weft_resample_source_create(&from, &source), WEFT_OK);
    const uint64_t clamped = weft_resample_source_get_info(source)->statistics.clamped;
    weft_resample_source_destroy(&source);
    for (int first = 0; first < s->from[1]; first += 12) {
        assert_int_equal(weft_resample_measure(&from, first, 12, false, &one), WEFT_OK);
        weft_resample_measured_join(&sum, &one);
    }
    assert_true(clamped > 0 && sum.outside == clamped);
    from.measured = &sum;
    assert_int_equal(weft_resample_source_create(&from, &source), WEFT_OK);
    assert_true(weft_resample_source_get_info(source)->statistics.clamped == clamped);
    weft_resample_source_destroy(&source);
}

// ---- integers -----------------------------------------------------------------------------------

static void moved_parts_are_the_crop(void **state)
{
    static uint32_t codes[MOST_SAMPLES], all[MOST_PIXELS], some[MOST_PIXELS];
    static const int sides[][2] = {{1, 1}, {7, 7}, {64, 64}, {1500, 3}};
    int ran = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(shapes) * WEFT_COUNT(sides); i++) {
        const struct shape *s = &shapes[i / WEFT_COUNT(sides)];
        const int *side = sides[i % WEFT_COUNT(sides)];
        weft_resample_plan *plan = NULL;
        for (int k = 0; k < s->from[0] * s->from[1]; k++)
            codes[k] = mix((uint32_t)k);
        assert_int_equal(
            weft_resample_plan_create(weft_resample_params(.kernel = kernel_named("nearest"),
                                                           .size = {s->from[0], s->from[1]},
                                                           .width = s->to[0], .height = s->to[1],
                                                           .map = {s->map[0], s->map[1]},
                                                           .log = &log_to_stderr),
                                      &plan),
            WEFT_OK);
        struct weft_resample_integers from = {
            .width = s->from[0], .height = s->from[1], .plane = codes};
        assert_int_equal(weft_resample_move(plan, &from, NULL, all, 0), WEFT_OK);
        for (int k = 0; k < 9; k++, ran++) {
            struct weft_rectangle part = {(int)(mix((uint32_t)k) % (uint32_t)s->to[0]),
                                          (int)(mix((uint32_t)k + 99) % (uint32_t)s->to[1]),
                                          side[0], side[1]};
            struct weft_verify_report error;
            if (side[0] == 1500)
                part.x = 0;
            part = weft_rectangle_common(&part, &(struct weft_rectangle){0, 0, s->to[0], s->to[1]});
            from.window = weft_resample_reach(plan, &part);
            from.plane = codes + from.window.y * s->from[0] + from.window.x;
            from.stride = s->from[0];
            assert_int_equal(weft_resample_move(plan, &from, &part, some, part.width + GAP),
                             WEFT_OK);
            for (int y = 0; y < part.height; y++)
                assert_memory_equal(some + y * (part.width + GAP),
                                    all + (part.y + y) * s->to[0] + part.x,
                                    (size_t)part.width * sizeof *some);
            assert_int_equal(
                weft_resample_move_verify(plan, &from, &part, some, part.width + GAP, NULL, &error),
                WEFT_OK);
            assert_true(error.maximum == 0.0 && error.not_finite_mismatches == 0);
            assert_true(error.pixels_total == (uint64_t)part.width * (uint64_t)part.height);
        }
        weft_resample_plan_destroy(&plan);
    }
    assert_int_equal(ran, 9 * WEFT_COUNT(shapes) * WEFT_COUNT(sides));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(separable_parts_are_the_crop),
        cmocka_unit_test(parts_by_passes_are_the_crop),
        cmocka_unit_test(measured_parts_are_the_whole),
        cmocka_unit_test(a_range_counts_what_is_outside),
        cmocka_unit_test(moved_parts_are_the_crop),
    };
    return cmocka_run_group_tests(tests, create_wheres, destroy_wheres);
}
