// SPDX-License-Identifier: BSD-3-Clause
// Slices that the texture sampler filters: within their bounds on every context, the same bytes
// however they are cut, the voxels on the lattice, and values that floats do not stand.
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
#include "tests/support/slice_jobs.h"

// A cut, planned for a context.
struct cut {
    weft_slice_plan *slice;
    weft_hardware_plan *plan;
    struct weft_slice_statistics statistics;
    size_t pixels;
};

static struct weft_slice_params params_of(const char *kernel, const struct weft_slice_geometry *g)
{
    return (struct weft_slice_params){.kernel = kernel_named(kernel),
                                      .space = WEFT_SPACE_INDEX,
                                      .geometry = *g,
                                      .without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE,
                                      .log = &log_to_stderr};
}

static void plan_slice(weft_volume *volume, struct weft_slice_params *params,
                       enum weft_source_format source, struct cut *cut)
{
    *cut = (struct cut){.pixels = (size_t)params->geometry.width * (size_t)params->geometry.height};
    assert_int_equal(weft_slice_plan_create(volume, params, &cut->slice), WEFT_OK);
    assert_int_equal(weft_footprint_statistics(weft_slice_plan_get_footprint(cut->slice), NULL,
                                               &cut->statistics),
                     WEFT_OK);
    if (source == WEFT_SOURCE_FLOAT)
        return;
    weft_slice_plan_destroy(&cut->slice);
    params->source = source;
    params->low = cut->statistics.low;
    params->high = cut->statistics.high > cut->statistics.low ? cut->statistics.high
                                                              : cut->statistics.low + 1.0;
    assert_int_equal(weft_slice_plan_create(volume, params, &cut->slice), WEFT_OK);
}

static enum weft_result plan_cut(weft_context *context, uint64_t memory_bytes,
                                 const struct weft_log *log, struct cut *cut)
{
    struct weft_sampler sampler;
    assert_int_equal(
        weft_sampler_measure(context, weft_slice_plan_get_info(cut->slice)->source, &sampler),
        WEFT_OK);
    return weft_hardware_plan_create(weft_hardware_params(.slice = cut->slice, .sampler = sampler,
                                                          .memory_bytes = memory_bytes, .log = log),
                                     &cut->plan);
}

static void destroy_cut(struct cut *cut)
{
    weft_hardware_plan_destroy(&cut->plan);
    weft_slice_plan_destroy(&cut->slice);
}

static float *new_pixels(size_t count)
{
    float *pixels = malloc(count * sizeof *pixels);
    assert_non_null(pixels);
    return pixels;
}

static struct weft_slice_report run(weft_context *context, const struct cut *cut, float *pixels)
{
    struct weft_slice_report report;
    assert_int_equal(
        weft_slice_run_once(cut->slice,
                            weft_slice_compile_params(.context = context, .hardware = cut->plan),
                            weft_slice_run_params(.pixels = pixels), &report),
        WEFT_OK);
    return report;
}

static double bound_of(const struct cut *cut)
{
    const struct weft_slice_statistics *s = &cut->statistics;
    const struct weft_bound_values values = {.low = s->low,
                                             .high = s->high,
                                             .sample_low = s->voxel_low,
                                             .sample_high = s->voxel_high,
                                             .beyond = s->beyond};
    return weft_bound_compute(&weft_hardware_plan_get_info(cut->plan)->bound, &values).total;
}

// Returns the part of the bound that pixels are off by.
static double verify(const struct cut *cut, const float *pixels, const char *what)
{
    struct weft_verify_report error;
    const double bound = bound_of(cut);
    assert_int_equal(
        weft_slice_verify(cut->slice, pixels, weft_slice_verify_params(.max_seconds = 0.2), &error),
        WEFT_OK);
    assert_true(error.pixels_checked > 0);
    if (!(error.maximum <= bound) || error.not_finite_mismatches)
        fail_msg("%s, %s: error %.3g at (%d, %d), %.9g instead of %.9g; the bound is %.3g; %d not "
                 "finite on one side",
                 what, weft_slice_plan_get_info(cut->slice)->kernel.info->name, error.maximum,
                 error.at_x, error.at_y, error.at_value, error.at_reference, bound,
                 (int)error.not_finite_mismatches);
    return error.maximum / bound;
}

// ---- random jobs --------------------------------------------------------------------------------

static void test_bounds(void **state)
{
    const char *asked = getenv("WEFT_HARDWARE_JOBS");
    const int jobs = asked ? atoi(asked) : 40;
    struct random r = {11};
    double largest[WEFT_SOURCE_FORMATS] = {0};
    int ran = 0, refused = 0;
    (void)state;
    for (int i = 0; i < jobs; i++) {
        struct job job;
        struct cut cut;
        set_job(&r, 1, &job);
        const enum weft_source_format source = (enum weft_source_format)(i % WEFT_SOURCE_FORMATS);
        weft_context *context = contexts[1] ? contexts[i / WEFT_SOURCE_FORMATS % 2] : contexts[0];
        job.params.slice.without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE;
        plan_slice(job.volume, &job.params.slice, source, &cut);
        const enum weft_result res = plan_cut(context, 0, NULL, &cut);
        const int width = job.params.slice.kernel.width;
        if (res == WEFT_OK) {
            float *pixels = new_pixels(cut.pixels);
            run(context, &cut, pixels);
            const double share = verify(&cut, pixels, weft_source_format_name(source));
            largest[source] = larger(largest[source], share);
            free(pixels);
            ran++;
        } else { // nearest: one tap
            assert_int_equal(res, WEFT_ERR_UNSUPPORTED);
            assert_int_equal(width, 1);
            refused++;
        }
        destroy_cut(&cut);
        weft_volume_destroy(&job.volume);
    }
    print_message("%d ran, %d have no pairs; of their bounds: 32f %.2g, 16f %.2g, unorm16 %.2g, "
                  "unorm8 %.2g\n",
                  ran, refused, largest[0], largest[1], largest[2], largest[3]);
    assert_true(ran > jobs / 2 && refused > 0);
}

// ---- volumes in memory --------------------------------------------------------------------------

enum { N = 20, CELLS = N * N * N };

static float voxels[CELLS];

static double noise(uint32_t i)
{
    uint32_t h = i * 73856093u + 1u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (double)(h ^ h >> 16) / 4294967296.0;
}

static weft_volume *make_volume(void)
{
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .data = voxels), &volume),
        WEFT_OK);
    return volume;
}

static void fill_noise(void)
{
    for (uint32_t i = 0; i < CELLS; i++)
        voxels[i] = (float)(noise(i) - 0.5);
}

static const struct weft_slice_geometry oblique = {
    .width = 70,
    .height = 60,
    .origin = {1.5, 2.25, 3.0},
    .u = {15.0, 3.0, 2.0},
    .v = {-1.0, 13.0, 9.0},
};

static const char *const formats_kernels[] = {"catmull-rom", "bspline3", "bspline3i", "bspline2"};

// A plan for little memory is cut into tiles; pixels are the same bytes, and in a second run, which
// lays nothing out where there is one tile.
static void test_cut(void **state)
{
    float *whole = new_pixels(70 * 60), *cut_up = new_pixels(70 * 60);
    (void)state;
    fill_noise();
    weft_volume *volume = make_volume();
    for (size_t k = 0; k < WEFT_COUNT(formats_kernels); k++) {
        struct weft_slice_params params = params_of(formats_kernels[k], &oblique);
        struct cut cut;
        weft_slice *compiled = NULL;
        struct weft_slice_report first, second;
        plan_slice(volume, &params, WEFT_SOURCE_FLOAT, &cut);
        assert_int_equal(plan_cut(contexts[0], 0, &log_to_stderr, &cut), WEFT_OK);
        assert_int_equal(weft_hardware_plan_get_info(cut.plan)->tile_count, 1);
        assert_int_equal(weft_slice_compile(cut.slice,
                                            weft_slice_compile_params(.context = contexts[0],
                                                                      .hardware = cut.plan),
                                            &compiled),
                         WEFT_OK);
        for (int turn = 0; turn < 2; turn++)
            assert_int_equal(weft_slice_run(compiled,
                                            weft_slice_run_params(.pixels = turn ? cut_up : whole),
                                            turn ? &second : &first),
                             WEFT_OK);
        assert_memory_equal(whole, cut_up, 70 * 60 * sizeof *whole);
        assert_true(first.uploaded_bytes > 0 && second.uploaded_bytes == 0);
        assert_int_equal(first.fetches,
                         70 * 60 * weft_hardware_plan_get_info(cut.plan)->fetches_per_pixel);
        verify(&cut, whole, "whole");
        const uint64_t little = weft_hardware_plan_get_info(cut.plan)->memory_bytes / 2;
        weft_slice_destroy(&compiled);
        weft_hardware_plan_destroy(&cut.plan);
        assert_int_equal(plan_cut(contexts[0], little, &log_to_stderr, &cut), WEFT_OK);
        assert_true(weft_hardware_plan_get_info(cut.plan)->tile_count > 1);
        assert_true(weft_hardware_plan_get_info(cut.plan)->memory_bytes <= little);
        run(contexts[0], &cut, cut_up);
        assert_memory_equal(whole, cut_up, 70 * 60 * sizeof *whole);
        destroy_cut(&cut);
    }
    weft_volume_destroy(&volume);
    free(whole);
    free(cut_up);
}

// Interpolating kernels give voxels on the lattice, bit by bit, whatever the sampler.
static void test_lattice(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "linear", "lanczos:3"};
    const struct weft_slice_geometry g = {.width = N - 4,
                                          .height = N - 6,
                                          .origin = {1.5, 2.5, 7.0},
                                          .u = {N - 4, 0.0, 0.0},
                                          .v = {0.0, N - 6, 0.0}};
    float pixels[N * N];
    int checked = 0;
    (void)state;
    fill_noise();
    weft_volume *volume = make_volume();
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        for (int c = 0; c < 2 && contexts[c]; c++) {
            struct weft_slice_params params = params_of(kernels[k], &g);
            struct cut cut;
            plan_slice(volume, &params, WEFT_SOURCE_FLOAT, &cut);
            assert_int_equal(plan_cut(contexts[c], 0, &log_to_stderr, &cut), WEFT_OK);
            run(contexts[c], &cut, pixels);
            for (int y = 0; y < g.height; y++)
                for (int x = 0; x < g.width; x++, checked++)
                    assert_true(pixels[y * g.width + x] == voxels[(7 * N + (y + 3)) * N + (x + 2)]);
            destroy_cut(&cut);
        }
    }
    assert_true(checked >= (int)WEFT_COUNT(kernels) * g.width * g.height);
    weft_volume_destroy(&volume);
}

// NaN, infinity and what sums of overflow: as the fused pass, whose bytes those pixels are.
static void test_values(void **state)
{
    float *pixels = new_pixels(70 * 60), *fused = new_pixels(70 * 60);
    int not_finite = 0, same = 0;
    (void)state;
    fill_noise();
    voxels[(9 * N + 9) * N + 9] = NAN;
    voxels[(7 * N + 5) * N + 12] = INFINITY;
    voxels[(9 * N + 12) * N + 5] = 3e38f;
    weft_volume *volume = make_volume();
    for (int half = 0; half < 2; half++) {
        for (size_t k = 0; k < 2; k++) {
            struct weft_slice_params params = params_of(formats_kernels[k], &oblique);
            struct cut cut;
            struct weft_verify_report error;
            params.source = half ? WEFT_SOURCE_HALF : WEFT_SOURCE_FLOAT;
            params.low = -0.5;
            params.high = 0.5;
            plan_slice(volume, &params, WEFT_SOURCE_FLOAT, &cut);
            assert_int_equal(plan_cut(contexts[0], 0, &log_to_stderr, &cut), WEFT_OK);
            const struct weft_slice_report report = run(contexts[0], &cut, pixels);
            assert_true(report.exact_pixels > 100);
            assert_int_equal(weft_slice_verify(cut.slice, pixels, NULL, &error), WEFT_OK);
            assert_int_equal(error.not_finite_mismatches, 0);
            assert_int_equal(weft_slice_run_once(cut.slice,
                                                 weft_slice_compile_params(.context = contexts[0]),
                                                 weft_slice_run_params(.pixels = fused), NULL),
                             WEFT_OK);
            for (int i = 0; i < 70 * 60; i++) {
                assert_int_equal(isfinite(fused[i]) != 0, isfinite(pixels[i]) != 0);
                not_finite += !isfinite(fused[i]);
                same += memcmp(&fused[i], &pixels[i], sizeof *fused) == 0;
            }
            destroy_cut(&cut);
        }
    }
    assert_true(not_finite > 100 && same >= not_finite);
    weft_volume_destroy(&volume);
    free(pixels);
    free(fused);
}

// Formats of fixed point have no code for what is not finite.
static void test_not_finite_codes(void **state)
{
    float pixels[70 * 60];
    (void)state;
    fill_noise();
    voxels[(9 * N + 9) * N + 9] = NAN;
    weft_volume *volume = make_volume();
    for (int f = WEFT_SOURCE_UNORM16; f <= WEFT_SOURCE_UNORM8; f++) {
        struct weft_slice_params params = params_of("bspline3", &oblique);
        struct message message = {0};
        const struct weft_log log = {keep_message, &message};
        struct cut cut;
        params.log = &log;
        plan_slice(volume, &params, (enum weft_source_format)f, &cut);
        assert_int_equal(plan_cut(contexts[0], 0, &log, &cut), WEFT_OK);
        assert_int_equal(weft_slice_run_once(cut.slice,
                                             weft_slice_compile_params(.context = contexts[0],
                                                                       .hardware = cut.plan),
                                             weft_slice_run_params(.pixels = pixels), NULL),
                         WEFT_ERR_UNSUPPORTED);
        assert_non_null(strstr(message.text, weft_source_format_name((enum weft_source_format)f)));
        destroy_cut(&cut);
    }
    weft_volume_destroy(&volume);
}

// Constant cells share blocks, and are that constant within the bound.
static void test_constant(void **state)
{
    float *pixels = new_pixels(70 * 60);
    (void)state;
    for (int i = 0; i < CELLS; i++)
        voxels[i] = i % N < 4 ? (float)noise((uint32_t)i) : 0.75f;
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(
            weft_volume_params(.size = {N, N, N}, .data = voxels, .background = 3.0f), &volume),
        WEFT_OK);
    struct weft_slice_geometry g = oblique;
    g.u[0] = 150.0;
    struct weft_slice_params params = params_of("bspline3", &g);
    struct cut cut;
    plan_slice(volume, &params, WEFT_SOURCE_FLOAT, &cut);
    assert_int_equal(plan_cut(contexts[0], 0, &log_to_stderr, &cut), WEFT_OK);
    const struct weft_slice_report report = run(contexts[0], &cut, pixels);
    assert_true(report.cells_constant > 10);
    verify(&cut, pixels, "constant");
    destroy_cut(&cut);
    weft_volume_destroy(&volume);
    free(pixels);
}

// ---- refusals -----------------------------------------------------------------------------------

static enum weft_result try_plan(const struct weft_hardware_params *params)
{
    weft_hardware_plan *plan = NULL;
    const enum weft_result res = weft_hardware_plan_create(params, &plan);
    assert_true((plan != NULL) == (res == WEFT_OK));
    weft_hardware_plan_destroy(&plan);
    return res;
}

static void test_refusals(void **state)
{
    struct weft_slice_params params = params_of("catmull-rom", &oblique);
    struct weft_slice_plan *slice = NULL;
    struct message message = {0};
    const struct weft_log log = {keep_message, &message};
    (void)state;
    fill_noise();
    weft_volume *volume = make_volume();
    assert_int_equal(try_plan(weft_hardware_params(.log = &log)), WEFT_ERR_ARGUMENT);
    params.clamp_to_samples = true;
    assert_int_equal(weft_slice_plan_create(volume, &params, &slice), WEFT_OK);
    assert_int_equal(try_plan(weft_hardware_params(.slice = slice)), WEFT_ERR_ARGUMENT);
    weft_slice_plan_destroy(&slice);
    // Along an axis, with its saving.
    params = params_of("catmull-rom", &(struct weft_slice_geometry){.width = 5,
                                                                    .height = 5,
                                                                    .origin = {1.0, 1.0, 4.5},
                                                                    .u = {9.0, 4.0, 0.0},
                                                                    .v = {-4.0, 9.0, 0.0}});
    params.without = 0;
    assert_int_equal(weft_slice_plan_create(volume, &params, &slice), WEFT_OK);
    assert_int_equal(try_plan(weft_hardware_params(.slice = slice)), WEFT_ERR_ARGUMENT);
    weft_slice_plan_destroy(&slice);
    params = params_of("catmull-rom", &oblique);
    assert_int_equal(weft_slice_plan_create(volume, &params, &slice), WEFT_OK);
    assert_int_equal(try_plan(weft_hardware_params(.slice = slice)), WEFT_OK);
    assert_int_equal(try_plan(weft_hardware_params(.slice = slice,
                                                   .sampler = {.fraction = 0.6, .max_size = 256})),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(try_plan(weft_hardware_params(.slice = slice, .sampler = {.max_size = 8})),
                     WEFT_ERR_ARGUMENT);
    message.count = 0;
    assert_int_equal(
        try_plan(weft_hardware_params(.slice = slice, .memory_bytes = 10000, .log = &log)),
        WEFT_ERR_LIMIT);
    assert_int_equal(message.count, 1);
    // A sampler that the context does not have.
    weft_hardware_plan *plan = NULL;
    weft_slice *compiled = NULL;
    message.count = 0;
    assert_int_equal(
        weft_hardware_plan_create(
            weft_hardware_params(.slice = slice,
                                 .sampler = {.fraction = 0.0, .rounding = 0.0, .max_size = 512},
                                 .log = &log),
            &plan),
        WEFT_OK);
    assert_int_equal(
        weft_slice_compile(
            slice, weft_slice_compile_params(.context = contexts[0], .hardware = plan), &compiled),
        WEFT_ERR_LIMIT);
    assert_null(compiled);
    assert_int_equal(message.count, 1);
    assert_int_equal(
        weft_slice_compile(slice, weft_slice_compile_params(.hardware = plan), &compiled),
        WEFT_ERR_ARGUMENT);
    weft_hardware_plan_destroy(&plan);
    weft_slice_plan_destroy(&slice);
    weft_volume_destroy(&volume);
}

static void test_text(void **state)
{
    (void)state;
    fill_noise();
    weft_volume *volume = make_volume();
    struct weft_slice_params params = params_of("catmull-rom", &oblique);
    struct cut cut;
    plan_slice(volume, &params, WEFT_SOURCE_FLOAT, &cut);
    assert_int_equal(weft_hardware_plan_create(weft_hardware_params(.slice = cut.slice), &cut.plan),
                     WEFT_OK);
    const struct weft_hardware_plan_info *info = weft_hardware_plan_get_info(cut.plan);
    assert_int_equal(info->fetches_per_axis, 3);
    assert_int_equal(info->pairs_per_axis, 1);
    assert_int_equal(info->fetches_per_pixel, 27);
    assert_true(info->sampler.fraction >= 0x1p-8);
    assert_non_null(strstr(info->text, "hardware filtering: taps 0 1+2 3 along each axis"));
    assert_non_null(strstr(info->text, "pass 00: taps (0,0,0)-(3,3,3), 27 filtered 32f fetches"));
    destroy_cut(&cut);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds),           cmocka_unit_test(test_cut),
        cmocka_unit_test(test_lattice),          cmocka_unit_test(test_values),
        cmocka_unit_test(test_not_finite_codes), cmocka_unit_test(test_constant),
        cmocka_unit_test(test_refusals),         cmocka_unit_test(test_text),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
