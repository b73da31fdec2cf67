// SPDX-License-Identifier: BSD-3-Clause
// Images resampled on the CPU engine: every set of instructions and both sums, beside double
// precision and beside OpenGL; the same bytes for any number of threads.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "weft.h"

enum { WIDTH = 61, HEIGHT = 47, CHANNELS = 3, STRIDE = 67, MOST = 200 * 160 };

static weft_context *context; // NULL: none is to be had

static float samples[CHANNELS][STRIDE * HEIGHT];

static void make_samples(void)
{
    for (int c = 0; c < CHANNELS; c++)
        for (int i = 0; i < STRIDE * HEIGHT; i++)
            samples[c][i] = (float)sin(0.3 * (i % STRIDE) + c) * 3.0f +
                            (float)((uint32_t)(i + 1) * 2654435761u >> 9 & 1023) / 1024.0f;
}

static weft_resample_source *make_source(const char *kernel)
{
    weft_resample_source *source = NULL;
    assert_int_equal(
        weft_resample_source_create(
            weft_resample_source_params(.kernel = kernel_named(kernel), .width = WIDTH,
                                        .height = HEIGHT, .stride = STRIDE, .channels = CHANNELS,
                                        .plane = {samples[0], samples[1], samples[2]},
                                        .log = &log_to_stderr),
            &source),
        WEFT_OK);
    return source;
}

struct request {
    const char *kernel;
    int width, height;
    enum weft_engine engine;
    enum weft_sums sums;
    struct weft_cpu cpu;
};

// Runs, verifies and returns the bound for what came out.
static double run(const weft_resample_source *source, const struct request *r,
                  float pixels[CHANNELS][MOST])
{
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    struct weft_resample_report report;
    struct weft_verify_report error;
    const bool gl = r->engine == WEFT_ENGINE_GL;
    assert_int_equal(
        weft_resample_plan_create(
            weft_resample_params(.kernel = weft_resample_source_get_info(source)->kernel,
                                 .size = {WIDTH, HEIGHT}, .width = r->width, .height = r->height,
                                 .unstretched =
                                     weft_resample_source_get_info(source)->kernel.prefiltered,
                                 .engine = r->engine, .sums = r->sums, .log = &log_to_stderr),
            &plan),
        WEFT_OK);
    assert_int_equal(
        weft_resample_compile(
            plan, weft_resample_compile_params(.context = gl ? context : NULL, .cpu = r->cpu),
            &compiled),
        WEFT_OK);
    assert_int_equal(
        weft_resample_run(compiled,
                          weft_resample_run_params(.source = source,
                                                   .plane = {pixels[0], pixels[1], pixels[2]},
                                                   .log = &log_to_stderr),
                          &report),
        WEFT_OK);
    assert_int_equal(report.work.cpu.threads, gl ? 0 : r->cpu.threads);
    assert_int_equal(report.work.cpu.instructions, r->cpu.instructions);
    assert_int_equal(report.pixels.count, CHANNELS * r->width * r->height);
    assert_int_equal(weft_resample_verify(plan,
                                          &(struct weft_resample_verify_params){
                                              .source = source,
                                              .plane = {pixels[0], pixels[1], pixels[2]},
                                              .how = {.max_seconds = 0.05},
                                              .log = &log_to_stderr},
                                          &error),
                     WEFT_OK);
    const double bound =
        weft_resample_bound(plan, &weft_resample_source_get_info(source)->statistics,
                            weft_statistics_magnitude(&report.pixels))
            .total;
    if (!(error.maximum <= bound) || error.not_finite_mismatches || !error.pixels_checked)
        fail_msg("%s to %d x %d, %s: error %.3g of %.3g", r->kernel, r->width, r->height,
                 weft_instruction_set_names[r->cpu.instructions], error.maximum, bound);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    return bound;
}

static void assert_close(float a[CHANNELS][MOST], float b[CHANNELS][MOST], int count, double bound)
{
    for (int c = 0; c < CHANNELS; c++)
        for (int i = 0; i < count; i++)
            assert_near((double)a[c][i], (double)b[c][i], bound, "OpenGL and the CPU engine");
}

static void every_set_meets_the_reference(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "linear", "lanczos:3", "bspline3i"};
    static const int sizes[][2] = {{200, 160}, {15, 12}, {61, 47}, {31, 90}};
    static const int threads[] = {2, 3, 7};
    static float pixels[CHANNELS][MOST], again[CHANNELS][MOST], gl[CHANNELS][MOST];
    int ran = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(kernels) * WEFT_COUNT(sizes); i++) {
        struct request r = {.kernel = kernels[i / WEFT_COUNT(sizes)]};
        weft_resample_source *source = make_source(r.kernel);
        r.width = sizes[i % WEFT_COUNT(sizes)][0];
        r.height = sizes[i % WEFT_COUNT(sizes)][1];
        const double gl_bound = context ? run(source, &r, gl) : 0.0;
        r.engine = WEFT_ENGINE_CPU;
        for (int set = WEFT_INSTRUCTIONS_PLAIN; weft_instruction_set_names[set]; set++) {
            if (!weft_instruction_set_runs((enum weft_instruction_set)set))
                continue;
            for (int sums = WEFT_SUMS_FLOAT; sums <= WEFT_SUMS_DOUBLE; sums++, ran++) {
                r.sums = (enum weft_sums)sums;
                r.cpu = (struct weft_cpu){1, (enum weft_instruction_set)set};
                const double bound = run(source, &r, pixels);
                if (context)
                    assert_close(gl, pixels, r.width * r.height, bound + gl_bound);
                r.cpu.threads = threads[(i + (size_t)set) % WEFT_COUNT(threads)];
                run(source, &r, again);
                for (int c = 0; c < CHANNELS; c++)
                    assert_memory_equal(again[c], pixels[c],
                                        sizeof(float) * (size_t)r.width * (size_t)r.height);
            }
        }
        r.cpu = (struct weft_cpu){0};
        weft_resample_source_destroy(&source);
    }
    assert_true(ran >= 2 * (int)(WEFT_COUNT(kernels) * WEFT_COUNT(sizes)));
}

// Rounded once: 2^-24 of the largest pixel, and what doubles lose.
static void double_sums_are_rounded_once(void **state)
{
    static float pixels[CHANNELS][MOST];
    (void)state;
    weft_resample_source *source = make_source("catmull-rom");
    const struct request r = {.kernel = "catmull-rom",
                              .width = 200,
                              .height = 160,
                              .engine = WEFT_ENGINE_CPU,
                              .sums = WEFT_SUMS_DOUBLE,
                              .cpu = {2, weft_instruction_set_best()}};
    const double bound = run(source, &r, pixels);
    double largest = 0.0;
    for (int c = 0; c < CHANNELS; c++)
        for (int i = 0; i < MOST; i++)
            largest = fmax(largest, fabs((double)pixels[c][i]));
    assert_true(bound <= largest * 0x1.0001p-24);
    weft_resample_source_destroy(&source);
}

static int setup(void **state)
{
    (void)state;
    make_samples();
    if (!WITHOUT_GL)
        weft_context_create(&(struct weft_context_params){.kind = WEFT_CONTEXT_AUTO}, &context);
    if (!context)
        print_message("[  SKIPPED ] what OpenGL would do: no context is to be had\n");
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    weft_context_destroy(&context);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_set_meets_the_reference),
        cmocka_unit_test(double_sums_are_rounded_once),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
