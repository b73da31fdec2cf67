// SPDX-License-Identifier: BSD-3-Clause
// Slices whose rows and columns run along axes, on the CPU engine: random jobs on every set of
// instructions and in both sums, beside double precision and beside OpenGL.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/slice_jobs.h"
#include "weft.h"

enum { MOST = 100 * 90, JOBS = 12, GAP = 5 };

static weft_context *context; // NULL: none is to be had

static const char *const kernels[] = {"catmull-rom", "linear",    "bspline3", "lanczos:3",
                                      "nearest",     "bspline3i", "keys6",    "lanczos:8",
                                      "d-bspline3",  "bspline2",  "mitchell", "gaussian:2,0.11"};

// Rows and columns along any two axes, either way; so many pixels that it pays.
static struct weft_slice_geometry axis_plane(struct random *r)
{
    const int depth = below(r, 3), row = (depth + 1 + below(r, 2)) % 3, column = 3 - depth - row;
    struct weft_slice_geometry g = {.width = 60 + below(r, 40), .height = 50 + below(r, 40)};
    g.u[row] = (below(r, 2) ? 1.0 : -1.0) * SIDE * (0.2 + uniform(r));
    g.v[column] = (below(r, 2) ? 1.0 : -1.0) * SIDE * (0.2 + uniform(r));
    for (int a = 0; a < 3; a++)
        g.origin[a] = SIDE * uniform(r) - 0.5 * (g.u[a] + g.v[a]);
    if (below(r, 2))
        g.origin[depth] = floor(g.origin[depth]);
    return g;
}

// With values that single precision does not stand in a few places.
static weft_volume *hostile_volume(struct random *r)
{
    static const float values[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1e38f};
    float *data = malloc(VOXELS * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < VOXELS; i++)
        data[i] = (float)uniform(r);
    for (int i = 0; i < 200; i++)
        data[below(r, VOXELS)] = values[below(r, (int)WEFT_COUNT(values))];
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data,
                                                           .background = 0.5f),
                                        &volume),
                     WEFT_OK);
    free(data);
    return volume;
}

// Plans and runs once, with rows `GAP` floats apart; what lies between stays. error may be NULL.
static void run(weft_volume *volume, struct weft_slice_params *params, const struct weft_cpu *cpu,
                float *pixels, struct weft_verify_report *error)
{
    static float apart[MOST * 2];
    const int width = params->geometry.width, height = params->geometry.height;
    const bool gl = params->engine == WEFT_ENGINE_GL;
    struct weft_slice_report report;
    weft_slice_plan *plan = NULL;
    assert_true((width + GAP) * height <= MOST * 2);
    for (int i = 0; i < MOST * 2; i++)
        apart[i] = 4711.0f;
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    assert_int_equal(
        weft_slice_run_once(plan,
                            weft_slice_compile_params(.context = gl ? context : NULL, .cpu = *cpu),
                            weft_slice_run_params(.pixels = apart, .stride = width + GAP), &report),
        WEFT_OK);
    for (int y = 0; y < height; y++) {
        memcpy(pixels + y * width, apart + y * (width + GAP), (size_t)width * sizeof *pixels);
        for (int x = width; x < width + GAP; x++)
            assert_true(apart[y * (width + GAP) + x] == 4711.0f);
    }
    assert_true(report.peak_bytes <= (params->memory_bytes ? params->memory_bytes : 1u << 30));
    // Of wide and of prefiltered kernels the reference takes long: some of the pixels are enough.
    const double seconds = params->kernel.width > 6 || params->kernel.prefiltered ? 0.02 : INFINITY;
    if (error) {
        assert_int_equal(weft_slice_verify(plan, pixels,
                                           weft_slice_verify_params(.max_seconds = seconds), error),
                         WEFT_OK);
        assert_in_range(error->pixels_checked, 1, width * height);
    }
    weft_slice_plan_destroy(&plan);
}

static void assert_within(const struct weft_verify_report *error, int job, const char *what)
{
    if (!(error->maximum <= error->bound) || error->not_finite_mismatches)
        fail_msg("job %d, %s: error %.3g of %.3g at (%d, %d), %d not finite", job, what,
                 error->maximum, error->bound, error->at_x, error->at_y,
                 (int)error->not_finite_mismatches);
}

static void assert_close(const float *a, const float *b, int count, double bound, int job)
{
    for (int i = 0; i < count; i++)
        if (!(fabs((double)a[i] - (double)b[i]) <= bound) && (isfinite(a[i]) || isfinite(b[i])))
            fail_msg("job %d: pixel %d is %.9g and %.9g, farther than %.3g", job, i, (double)a[i],
                     (double)b[i], bound);
}

// Every set of instructions and kind of sums, and numbers of threads; returns the bound of floats.
static double run_sets(weft_volume *volume, struct weft_slice_params *params, int job,
                       float *pixels)
{
    static const int threads[] = {1, 2, 3, 7};
    static float again[MOST];
    const size_t bytes = (size_t)params->geometry.width * (size_t)params->geometry.height * 4;
    double bound = NAN;
    params->engine = WEFT_ENGINE_CPU;
    for (int set = WEFT_INSTRUCTIONS_PLAIN; weft_instruction_set_names[set]; set++) {
        if (!weft_instruction_set_runs((enum weft_instruction_set)set))
            continue;
        for (int sums = WEFT_SUMS_DOUBLE; sums >= WEFT_SUMS_FLOAT; sums--) {
            struct weft_cpu cpu = {.instructions = (enum weft_instruction_set)set, .threads = 1};
            params->sums = (enum weft_sums)sums;
            struct weft_verify_report error;
            run(volume, params, &cpu, pixels, &error);
            assert_within(&error, job, weft_instruction_set_names[set]);
            bound = error.bound;
            cpu.threads = threads[(job + set + sums) % (int)WEFT_COUNT(threads)];
            params->memory_bytes = 4u << 20; // in tiles
            run(volume, params, &cpu, again, NULL);
            params->memory_bytes = 0;
            assert_memory_equal(again, pixels, bytes);
        }
    }
    return bound;
}

static void axis_slices_meet_the_reference(void **state)
{
    static float pixels[MOST], gl[MOST];
    struct random r = {2026};
    int compared = 0;
    (void)state;
    for (int job = 0; job < JOBS; job++) {
        weft_volume *volume = job % 4 == 3 ? hostile_volume(&r) : random_volume(&r);
        struct weft_slice_params params = {.kernel = kernel_named(kernels[job % 12]),
                                           .space = WEFT_SPACE_INDEX,
                                           .geometry = axis_plane(&r),
                                           .log = &log_to_stderr};
        const double bound = run_sets(volume, &params, job, pixels);
        if (context) {
            params.engine = WEFT_ENGINE_GL;
            struct weft_verify_report error;
            run(volume, &params, &(struct weft_cpu){0}, gl, &error);
            assert_within(&error, job, "OpenGL");
            assert_close(gl, pixels, params.geometry.width * params.geometry.height,
                         bound + error.bound, job);
            compared++;
        }
        weft_volume_destroy(&volume);
    }
    assert_int_equal(compared, context ? JOBS : 0);
}

// Rounded once: within 2^-24 of the largest pixel, and what positions are off by.
static void double_sums_are_rounded_once(void **state)
{
    static float pixels[MOST];
    struct random r = {7};
    (void)state;
    for (int job = 0; job < 12; job++) {
        weft_volume *volume = random_volume(&r);
        struct weft_slice_params params = {.kernel = kernel_named(kernels[job % 4]),
                                           .space = WEFT_SPACE_INDEX,
                                           .geometry = axis_plane(&r),
                                           .engine = WEFT_ENGINE_CPU,
                                           .sums = WEFT_SUMS_DOUBLE,
                                           .log = &log_to_stderr};
        struct weft_verify_report error;
        run(volume, &params, &(struct weft_cpu){0}, pixels, &error);
        double largest = 0.0;
        for (int i = 0; i < params.geometry.width * params.geometry.height; i++)
            largest = fmax(largest, fabs((double)pixels[i]));
        const double voxel = error.maximum / error.relative_maximum;
        assert_within(&error, job, "double sums");
        assert_true(error.maximum <= 0x1p-24 * largest + 1e-8 * voxel);
        weft_volume_destroy(&volume);
    }
}

static int setup(void **state)
{
    (void)state;
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
        cmocka_unit_test(axis_slices_meet_the_reference),
        cmocka_unit_test(double_sums_are_rounded_once),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
