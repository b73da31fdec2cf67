// SPDX-License-Identifier: BSD-3-Clause
// Parts of slices: the pixels that the whole slice has there, bit for bit, by every engine, and no
// brick read that they do not need.
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
#include "tests/support/plans.h"
#include "tiles/volume/volume_impl.h"
#include "weft.h"

enum { N = 44, BRICKS = 6, ALL_BRICKS = BRICKS * BRICKS * BRICKS };

// ---- volumes ------------------------------------------------------------------------------------

// Waves, and a corner of one value; `rough`: with voxels that floats do not stand.
static void fill(float *data, bool rough)
{
    for (int i = 0; i < N * N * N; i++) {
        const int x = i % N, y = i / N % N, z = i / N / N;
        const bool flat = x < 20 && y < 20;
        data[i] = flat ? 0.75f
                       : (float)(0.5 + 0.4 * sin(0.11 * x + 0.07 * y - 0.09 * z)) +
                             (x > 30 ? (float)(i * 7919 % 101) / 505.0f : 0.0f);
    }
    if (!rough)
        return;
    data[(13 * N + 21) * N + 17] = NAN;
    data[(13 * N + 18) * N + 27] = INFINITY;
    data[(15 * N + 27) * N + 11] = 3e38f;
    data[(22 * N + 22) * N + 30] = NAN;
}

static weft_volume *make_volume(bool rough)
{
    float *data = malloc((size_t)N * N * N * sizeof *data);
    weft_volume *volume = NULL;
    assert_non_null(data);
    fill(data, rough);
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .background = 0.0f, .data = data),
                           &volume),
        WEFT_OK);
    free(data);
    return volume;
}

// Bricks that were read since `forget`, by place.
static const struct weft_volume_backend *memory;
static int reads[ALL_BRICKS];

static enum weft_result count_reads(weft_volume *volume, size_t count, const int32_t (*origin)[3],
                                    float *values)
{
    for (size_t i = 0; i < count; i++)
        reads[(origin[i][2] / 8 * BRICKS + origin[i][1] / 8) * BRICKS + origin[i][0] / 8]++;
    return memory->read(volume, count, origin, values);
}

static weft_volume *make_counted(bool rough)
{
    static struct weft_volume_backend counting;
    weft_volume *volume = make_volume(rough);
    memory = volume->backend;
    counting = *memory;
    counting.read = count_reads;
    volume->backend = &counting;
    return volume;
}

// ---- what is sliced, and how --------------------------------------------------------------------

static const struct weft_slice_geometry oblique = {{4, 3, 5}, {30, 9, 6}, {-3, 27, 10}, 300, 262};
static const struct weft_slice_geometry shrunk = {{1, 3, 5}, {39, 9, 30}, {-1, 37, -5}, 70, 51};
static const struct weft_slice_geometry across = {{2, 3, 22.3}, {38, 0, 0}, {0, 36, 0}, 300, 262};
static const struct weft_slice_geometry turned = {{2, 22.5, 40}, {0, 0, -34}, {38, 0, 0}, 262, 99};
static const struct weft_slice_geometry tilted = {{2, 3, 20.3}, {38, 5, 0}, {-4, 36, 0}, 280, 90};
static const struct weft_slice_geometry tiny = {{2, 3, 22.3}, {38, 0, 0}, {0, 36, 0}, 31, 33};

// What a row of `how` leaves out is the default.
struct how {
    const char *name, *kernel;
    const struct weft_slice_geometry *cut;
    bool rough;          // voxels
    const char *profile; // of passes
    bool passes_on_cpu, hardware;
    struct weft_slice_params params;
};
#define GL_SLICE(...)                                                                              \
    {                                                                                              \
        .engine = WEFT_ENGINE_GL, __VA_ARGS__                                                      \
    }
#define CPU_SLICE(...)                                                                             \
    {                                                                                              \
        .engine = WEFT_ENGINE_CPU, __VA_ARGS__                                                     \
    }
static const struct how hows[] = {
    {"fused", "catmull-rom", &oblique, true, .params = GL_SLICE()},
    {"fused, shrunk", "lanczos", &shrunk, true, .params = GL_SLICE()},
    {"fused, in little memory", "mitchell", &oblique, false,
     .params = GL_SLICE(.memory_bytes = 2 << 20)},
    {"fused, in less", "catmull-rom", &shrunk, false,
     .params = GL_SLICE(.memory_bytes = 400 << 10)},
    {"fused, aligned", "bspline3", &oblique, true,
     .params = GL_SLICE(.layout = WEFT_LAYOUT_ALIGNED)},
    {"fused, plain", "nearest", &oblique, true, .params = GL_SLICE(.layout = WEFT_LAYOUT_PLAIN)},
    {"fused, unorm8", "linear", &oblique, false,
     .params = GL_SLICE(.source = WEFT_SOURCE_UNORM8, .low = 0.0, .high = 1.3)},
    {"fused, half, looked up", "bspline5", &tilted, false,
     .params = GL_SLICE(.source = WEFT_SOURCE_HALF, .low = 0.0, .high = 1.3,
                        .lookup = WEFT_LOOKUP_LINEAR, .samples = 32)},
    {"fused, smooth", "catmull-rom", &oblique, true, .params = GL_SLICE(.smooth_error = 2e-3)},
    {"fused, smooth, in tiles", "catmull-rom", &oblique, false,
     .params = GL_SLICE(.smooth_error = 2e-3, .memory_bytes = 2 << 20)},
    {"fused, clamped", "catmull-rom", &oblique, true, .params = GL_SLICE(.clamp_to_samples = true)},
    {"fused, prefiltered", "bspline3i", &oblique, false, .params = GL_SLICE()},
    {"summed", "keys6", &tilted, true, .params = GL_SLICE()},
    {"summed, a tiny one", "catmull-rom", &tiny, false, .params = GL_SLICE()},
    {"separable", "catmull-rom", &across, true, .params = GL_SLICE()},
    {"separable, turned", "lanczos", &turned, true, .params = GL_SLICE()},
    {"separable, prefiltered", "omomsi", &across, false, .params = GL_SLICE()},
    {"hardware", "bspline3", &oblique, false, .hardware = true,
     .params = GL_SLICE(.without = WEFT_SAVING_AXIS, .layout = WEFT_LAYOUT_PLAIN)},
    {"CPU", "catmull-rom", &oblique, true, .params = CPU_SLICE()},
    {"CPU, shrunk", "gaussian", &shrunk, true, .params = CPU_SLICE()},
    {"CPU, double", "mitchell", &oblique, true, .params = CPU_SLICE(.sums = WEFT_SUMS_DOUBLE)},
    {"CPU, smooth", "catmull-rom", &oblique, true, .params = CPU_SLICE(.smooth_error = 2e-3)},
    {"CPU, separable", "catmull-rom", &across, true, .params = CPU_SLICE()},
    {"CPU, separable, in tiles", "catmull-rom", &across, true,
     .params = CPU_SLICE(.memory_bytes = 400 << 10)},
    {"CPU, separable, double", "lanczos", &turned, false,
     .params = CPU_SLICE(.sums = WEFT_SUMS_DOUBLE)},
    {"CPU, prefiltered", "bspline5i", &shrunk, false, .params = CPU_SLICE()},
    {"passes", "linear", &oblique, false, .profile = "unorm8",
     .params = GL_SLICE(.without = WEFT_SAVING_AXIS)},
    {"passes of floats", "catmull-rom", &shrunk, false, .profile = "fp32",
     .params = GL_SLICE(.without = WEFT_SAVING_AXIS)},
    {"passes on the CPU", "linear", &tilted, false, .profile = "unorm16", .passes_on_cpu = true,
     .params = GL_SLICE(.without = WEFT_SAVING_AXIS)},
};

// A run's own plans.
struct made {
    weft_slice_plan *plan;
    weft_pass_plan *passes;
    weft_hardware_plan *hardware;
};

static struct weft_slice_params params_of(const struct how *how, const struct weft_rectangle *part)
{
    struct weft_slice_params params = how->params;
    params.kernel = kernel_named(how->kernel);
    params.space = WEFT_SPACE_INDEX;
    params.geometry = *how->cut;
    params.part = *part;
    params.log = &log_to_stderr;
    return params;
}

// Plans, runs and verifies nothing: the pixels of a part, `gap` floats between its rows.
static void run(const struct how *how, weft_volume *volume, const struct weft_rectangle *part,
                weft_footprint *footprint, int gap, float *pixels, struct weft_slice_report *report)
{
    struct weft_slice_params params = params_of(how, part);
    struct made m = {NULL, NULL, NULL};
    params.footprint = footprint;
    assert_int_equal(weft_slice_plan_create(volume, &params, &m.plan), WEFT_OK);
    if (how->profile)
        m.passes = make_plan(weft_pass_plan_params(.kernel = params.kernel, .dims = 3, .samples = 8,
                                                   .profile = profile_named(how->profile)));
    if (how->hardware)
        assert_int_equal(
            weft_hardware_plan_create(weft_hardware_params(.slice = m.plan, .log = &log_to_stderr),
                                      &m.hardware),
            WEFT_OK);
    const struct weft_slice_passes passes = {.plan = m.passes, .log = &log_to_stderr};
    const bool gl = params.engine == WEFT_ENGINE_GL && !how->passes_on_cpu;
    const struct weft_slice_compile_params where = {.context = gl ? contexts[0] : NULL,
                                                    .passes = m.passes ? &passes : NULL,
                                                    .hardware = m.hardware};
    const int width = weft_slice_plan_get_info(m.plan)->part.width;
    assert_int_equal(
        weft_slice_run_once(m.plan, &where,
                            weft_slice_run_params(.pixels = pixels, .stride = width + gap), report),
        WEFT_OK);
    weft_hardware_plan_destroy(&m.hardware);
    weft_slice_plan_destroy(&m.plan);
    weft_pass_plan_destroy(&m.passes);
}

// ---- pixels -------------------------------------------------------------------------------------

static void compare(const struct how *how, const float *whole, const struct weft_rectangle *at,
                    int gap, const float *pixels)
{
    for (int y = 0; y < at->height; y++) {
        for (int x = 0; x < at->width; x++) {
            const float *a = whole + (size_t)(at->y + y) * (size_t)how->cut->width + at->x + x;
            const float *b = pixels + (size_t)y * (size_t)(at->width + gap) + x;
            if (memcmp(a, b, sizeof *a) != 0)
                fail_msg("%s: pixel (%d, %d) of part (%d, %d) %d x %d is %.9g, and %.9g in the "
                         "whole slice",
                         how->name, at->x + x, at->y + y, at->x, at->y, at->width, at->height,
                         (double)*b, (double)*a);
        }
    }
}

// A part by itself, with no footprint of the whole slice's.
static void check_part(const struct how *how, weft_volume *volume, const float *whole,
                       const struct weft_rectangle *at)
{
    enum { GAP = 3 };
    struct weft_slice_report report;
    float *pixels = malloc((size_t)(at->width + GAP) * (size_t)at->height * sizeof *pixels);
    assert_non_null(pixels);
    run(how, volume, at, NULL, GAP, pixels, &report);
    compare(how, whole, at, GAP, pixels);
    free(pixels);
}

// Parts that cover the slice: what they tell is joined to what the whole tells.
static void check_cover(const struct how *how, weft_volume *volume, const float *whole,
                        const struct weft_slice_report *told, int width, int height)
{
    const struct weft_slice_params params = params_of(how, &(struct weft_rectangle){0});
    weft_footprint *footprint = NULL;
    float *pixels = malloc((size_t)width * (size_t)height * sizeof *pixels);
    float minimum = INFINITY, maximum = -INFINITY;
    uint64_t not_finite = 0, exact = 0, bricks = 0;
    assert_non_null(pixels);
    assert_int_equal(
        weft_footprint_create(
            weft_footprint_params(.volume = volume, .kernel = params.kernel, .space = params.space,
                                  .geometry = params.geometry, .log = &log_to_stderr),
            &footprint),
        WEFT_OK);
    for (int y = 0; y < how->cut->height; y += height) {
        for (int x = 0; x < how->cut->width; x += width) {
            struct weft_slice_report report;
            struct weft_rectangle at = {x, y, width, height};
            at.width = how->cut->width - x < width ? how->cut->width - x : width;
            at.height = how->cut->height - y < height ? how->cut->height - y : height;
            run(how, volume, &at, footprint, 0, pixels, &report);
            compare(how, whole, &at, 0, pixels);
            minimum = fminf(minimum, report.minimum);
            maximum = fmaxf(maximum, report.maximum);
            not_finite += report.not_finite;
            exact += report.exact_pixels;
            bricks += report.bricks_read;
        }
    }
    assert_true(minimum == told->minimum && maximum == told->maximum);
    assert_int_equal(not_finite, told->not_finite);
    assert_int_equal(exact, told->exact_pixels);
    if (!params.memory_bytes && !how->profile)
        assert_int_equal(bricks, told->bricks_read);
    weft_footprint_destroy(&footprint);
    free(pixels);
}

static void check_how(const struct how *how, bool all)
{
    const int width = how->cut->width, height = how->cut->height;
    const struct weft_rectangle parts[] = {
        {width / 2, height / 2, 1, 1},
        {width - 9, height - 8, 7, 7},
        {width > 260 ? 251 : 20, 17, 9, 7},
        {0, height / 3, width, 5},
        {width / 3 + 1, 0, 1, height},
        {3, 1, width < 64 + 3 ? 20 : 64, height < 64 + 1 ? 20 : 64},
        {0, 0, width, height},
    };
    weft_volume *volume = make_volume(how->rough);
    float *whole = malloc((size_t)width * (size_t)height * sizeof *whole);
    struct weft_slice_report report;
    assert_non_null(whole);
    run(how, volume, &(struct weft_rectangle){0}, NULL, 0, whole, &report);
    assert_true(report.maximum > report.minimum);
    if (how->rough && (how->cut == &oblique || how->cut == &across))
        assert_true(report.exact_pixels > 10 && report.not_finite > 10);
    for (size_t i = 0; i < WEFT_COUNT(parts); i++)
        check_part(how, volume, whole, &parts[i]);
    check_cover(how, volume, whole, &report, width, 64);
    if (all) {
        check_cover(how, volume, whole, &report, 64, 64);
        check_cover(how, volume, whole, &report, 7, 61);
        check_cover(how, volume, whole, &report, width, 1);
    }
    weft_volume_destroy(&volume);
    free(whole);
}

static void parts_have_the_pixels_of_the_whole(void **state)
{
    const char *full = getenv("WEFT_RANKS");
    int rough = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(hows); i++) {
        check_how(&hows[i], full && !strcmp(full, "full"));
        rough += hows[i].rough;
    }
    assert_true(rough > 10);
}

// ---- bricks -------------------------------------------------------------------------------------

// Whether a brick is as near to a pixel of the part as its cell's taps reach.
static bool is_near(const struct how *how, const struct weft_rectangle *at, int width,
                    const int brick[3])
{
    const struct weft_slice_geometry *g = how->cut;
    for (int i = 0; i < at->width * at->height; i++) {
        bool near = true;
        for (int a = 0; a < 3; a++) {
            const double p = g->origin[a] + (at->x + i % at->width + 0.5) * g->u[a] / g->width +
                             (at->y + i / at->width + 0.5) * g->v[a] / g->height;
            // The tap's cell may begin 7 voxels before, and end 7 behind.
            near = near && p > 8 * brick[a] - 8 - 0.5 * width &&
                   p < 8 * brick[a] + 8 + 8 + 0.5 * width;
        }
        if (near)
            return true;
    }
    return false;
}

static void only_bricks_in_reach_are_read(void **state)
{
    static const struct weft_rectangle parts[] = {
        {150, 130, 1, 1}, {20, 10, 64, 64}, {0, 200, 300, 7}, {250, 0, 30, 20}};
    static const char *const some[] = {"fused", "fused, smooth",  "separable",    "hardware",
                                       "CPU",   "CPU, separable", "fused, unorm8"};
    int checked = 0, never = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(hows); i++) {
        bool wanted = false;
        for (size_t k = 0; k < WEFT_COUNT(some); k++)
            wanted = wanted || !strcmp(hows[i].name, some[k]);
        for (size_t p = 0; wanted && p < WEFT_COUNT(parts); p++) {
            static float pixels[64 * 64];
            struct weft_rectangle at = parts[p];
            struct weft_slice_report report;
            weft_volume *volume = make_counted(hows[i].rough);
            memset(reads, 0, sizeof reads);
            run(&hows[i], volume, &at, NULL, 0, pixels, &report);
            // Cheaper pieces are drawn in squares.
            if (hows[i].params.smooth_error > 0.0)
                at = (struct weft_rectangle){at.x & -32, at.y & -32, (at.width + 62) & -32,
                                             (at.height + 62) & -32};
            const int width = kernel_named(hows[i].kernel).width;
            int sum = 0;
            for (int b = 0; b < ALL_BRICKS; b++) {
                const int brick[3] = {b % BRICKS, b / BRICKS % BRICKS, b / BRICKS / BRICKS};
                if (reads[b] && !is_near(&hows[i], &at, width, brick))
                    fail_msg("%s: brick %d, %d, %d is read for part %zu", hows[i].name, brick[0],
                             brick[1], brick[2], p);
                assert_true(reads[b] <= 1);
                sum += reads[b];
                never += !reads[b];
            }
            assert_int_equal(sum, report.bricks_read);
            checked++;
            weft_volume_destroy(&volume);
        }
    }
    assert_int_equal(checked, WEFT_COUNT(some) * WEFT_COUNT(parts));
    assert_true(never > checked * ALL_BRICKS / 2);
}

// ---- statistics ---------------------------------------------------------------------------------

static void statistics_of_parts_join(void **state)
{
    (void)state;
    for (int rough = 0; rough < 2; rough++) {
        weft_volume *volume = make_counted(rough);
        weft_footprint *footprint = NULL, *other = NULL;
        const struct weft_footprint_params *params =
            weft_footprint_params(.volume = volume, .kernel = kernel_named("catmull-rom"),
                                  .space = WEFT_SPACE_INDEX, .geometry = oblique);
        struct weft_slice_statistics whole, sum = {0}, one, all;
        assert_int_equal(weft_footprint_create(params, &footprint), WEFT_OK);
        assert_int_equal(weft_footprint_create(params, &other), WEFT_OK);
        assert_int_equal(weft_footprint_statistics(footprint, NULL, &whole), WEFT_OK);
        for (int y = 0; y < oblique.height; y += 50) {
            const int left = oblique.height - y;
            const struct weft_rectangle at = {0, y, oblique.width, left < 50 ? left : 50};
            assert_int_equal(weft_footprint_part_statistics(other, &at, NULL, &one), WEFT_OK);
            assert_true(one.voxels > 100 && one.voxels < whole.voxels);
            sum = weft_slice_statistics_join(&sum, &one);
        }
        assert_int_equal(
            weft_footprint_part_statistics(other, &(struct weft_rectangle){0}, NULL, &all),
            WEFT_OK);
        assert_memory_equal(&all, &whole, sizeof all);
        assert_true(sum.voxels > whole.voxels && sum.voxels < 2 * whole.voxels);
        assert_true(rough ? whole.not_finite > 1 : whole.not_finite == 0);
        assert_true(sum.not_finite >= whole.not_finite);
        sum.voxels = whole.voxels;
        sum.not_finite = whole.not_finite;
        assert_memory_equal(&sum, &whole, sizeof sum);
        weft_footprint_destroy(&other);
        // Told, they are not measured.
        assert_int_equal(weft_footprint_create(params, &other), WEFT_OK);
        weft_footprint_set_statistics(other, &sum);
        memset(reads, 0, sizeof reads);
        assert_int_equal(weft_footprint_statistics(other, NULL, &one), WEFT_OK);
        assert_memory_equal(&one, &whole, sizeof one);
        for (int b = 0; b < ALL_BRICKS; b++)
            assert_int_equal(reads[b], 0);
        weft_footprint_destroy(&other);
        weft_footprint_destroy(&footprint);
        weft_volume_destroy(&volume);
    }
}

// ---- bad parts ----------------------------------------------------------------------------------

static void parts_that_are_not_of_the_slice_are_refused(void **state)
{
    static const struct weft_rectangle bad[] = {
        {0, 0, 301, 1}, {-1, 0, 2, 2}, {0, 262, 1, 1}, {5, 5, 0, 3}, {299, 0, 2, 1}};
    (void)state;
    weft_volume *volume = make_volume(false);
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_slice_params params = params_of(&hows[0], &bad[i]);
        weft_slice_plan *plan = NULL;
        params.log = &log;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_ERR_ARGUMENT);
        assert_null(plan);
        assert_int_equal(message.count, 1);
        assert_non_null(strstr(message.text, "300 x 262"));
    }
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_have_the_pixels_of_the_whole),
        cmocka_unit_test(only_bricks_in_reach_are_read),
        cmocka_unit_test(statistics_of_parts_join),
        cmocka_unit_test(parts_that_are_not_of_the_slice_are_refused),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
