// SPDX-License-Identifier: BSD-3-Clause
// Slices in one pass on the CPU engine: every set of instructions that this machine runs, both
// precisions of sums, against the reference in double; and the same bytes from any number of
// threads and in any cut into tiles. WEFT_CPU_JOBS: how many random jobs (default 12).
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/support/common.h"
#include "tests/support/slice_jobs.h"

enum { MAX_PIXELS = 300 * 300 };

static float pixels[MAX_PIXELS], others[MAX_PIXELS];

static const enum weft_instruction_set sets[] = {WEFT_INSTRUCTIONS_PLAIN, WEFT_INSTRUCTIONS_SSE2,
                                                 WEFT_INSTRUCTIONS_AVX2, WEFT_INSTRUCTIONS_AVX512};

static weft_slice_plan *plan_of(weft_volume *volume, const struct weft_slice_params *params)
{
    weft_slice_plan *plan = NULL;
    assert_true(params->geometry.width * params->geometry.height <= MAX_PIXELS);
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    return plan;
}

static struct weft_slice_report run(const weft_slice_plan *plan, int threads,
                                    enum weft_instruction_set set, float *out)
{
    struct weft_slice_report report;
    const struct weft_cpu cpu = {threads, set};
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.cpu = cpu),
                                         weft_slice_run_params(.pixels = out), &report),
                     WEFT_OK);
    assert_int_equal(report.cpu.instructions, set);
    assert_int_equal(report.cpu.threads, threads);
    return report;
}

static size_t bytes_of(const weft_slice_plan *plan)
{
    const struct weft_slice_geometry *g = &weft_slice_plan_get_info(plan)->geometry;
    return (size_t)g->width * (size_t)g->height * sizeof(float);
}

// Runs by one thread and verifies within the plan's bound.
static struct weft_verify_report verify(const weft_slice_plan *plan, enum weft_instruction_set set,
                                        int job)
{
    struct weft_verify_report error;
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    run(plan, 1, set, pixels);
    const struct weft_slice_verify_params *how = weft_slice_verify_params(.max_seconds = 0.005);
    assert_int_equal(weft_slice_verify(plan, pixels, how, &error), WEFT_OK);
    if (!(error.share <= 1.0) || error.not_finite_mismatches)
        fail_msg("job %d, %s, %s sums, %s: %.3g of the bound %.3g at (%d, %d), %.9g instead of "
                 "%.9g; %d not finite on one side",
                 job, info->kernel.info->name, weft_sums_names[info->sums],
                 weft_instruction_set_names[set], error.share, error.bound, error.at_x, error.at_y,
                 error.at_value, error.at_reference, (int)error.not_finite_mismatches);
    return error;
}

static void check_threads(const weft_slice_plan *plan, enum weft_instruction_set set)
{
    for (int i = 0; i < 3; i++) {
        memset(others, 0xff, bytes_of(plan));
        run(plan, ((const int[]){2, 3, 7})[i], set, others);
        assert_memory_equal(pixels, others, bytes_of(plan));
    }
}

// ---- random jobs --------------------------------------------------------------------------------

static const char *const kernels[] = {"catmull-rom",    "bspline3",  "linear",   "bspline3i",
                                      "nearest",        "mitchell",  "bspline2", "lanczos:3",
                                      "lanczos:2",      "keys6",     "bspline5", "lanczos:4",
                                      "lanczos:5+unit", "lanczos:8", "bspline7", "d-bspline"};

// Noise with voxels that are not finite, and huge ones; clamped to the edge or in a background.
static weft_volume *hostile_volume(struct random *r)
{
    enum { SIZE = 21 };
    static float data[SIZE * SIZE * SIZE];
    weft_volume *volume = NULL;
    for (int i = 0; i < SIZE * SIZE * SIZE; i++)
        data[i] = (float)(uniform(r) - 0.5);
    for (int i = 0; i < 12; i++)
        data[below(r, SIZE * SIZE * SIZE)] =
            ((const float[]){NAN, INFINITY, -INFINITY, 3e38f})[below(r, 4)];
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {SIZE, SIZE, SIZE}, .data = data,
                                                           .background = below(r, 2) ? NAN : 0.25f),
                                        &volume),
                     WEFT_OK);
    return volume;
}

struct counts {
    int runs, exact, tiles, smooth, summed, resident;
};

// The same from blocks that stay, laid out for more taps at times: within the bound, and the same
// bytes from any number of threads. Bytes may differ from those without: cells that are constant or
// smooth go by whole blocks.
static void check_resident(weft_volume *volume, const struct weft_slice_params *params, int job,
                           struct counts *counts)
{
    weft_resident *resident = NULL;
    struct weft_resident_params places = {
        .volume = volume, .kernel = params->kernel, .log = &log_to_stderr};
    struct weft_slice_params own = *params;
    if (job % 2 && !params->kernel.prefiltered && params->kernel.width < 6)
        places.kernel = kernel_named("lanczos:3");
    assert_int_equal(weft_resident_create(&places, &resident), WEFT_OK);
    own.resident = resident;
    weft_slice_plan *plan = plan_of(volume, &own);
    for (size_t s = 0; s < WEFT_COUNT(sets); s++) {
        if (!weft_instruction_set_runs(sets[s]))
            continue;
        verify(plan, sets[s], job);
        run(plan, 3, sets[s], others);
        assert_memory_equal(pixels, others, bytes_of(plan));
        counts->resident++;
    }
    weft_slice_plan_destroy(&plan);
    weft_resident_destroy(&resident);
}

static void check_job(struct random *r, int job, struct counts *counts)
{
    weft_volume *volume = job % 3 ? random_volume(r) : hostile_volume(r);
    struct weft_slice_params params = {
        .space = WEFT_SPACE_INDEX,
        .geometry = random_plane(r),
        .kernel = kernel_named(kernels[below(r, (int)WEFT_COUNT(kernels))]),
        .engine = WEFT_ENGINE_CPU,
        .without = WEFT_SAVING_SEPARABLE | (below(r, 3) ? 0 : WEFT_SAVING_AXIS) |
                   (below(r, 3) ? 0 : WEFT_SAVING_CONSTANT),
        .log = &log_to_stderr,
    };
    if (below(r, 3) == 0) {
        params.geometry.width = 200 + below(r, 100);
        params.geometry.height = 200 + below(r, 100);
    }
    if (!params.kernel.prefiltered)
        params.clamp_to_samples = below(r, 4) == 0;
    if (job % 3 == 1)
        params.smooth_error = 0.02;
    for (int sums = 0; sums < 2; sums++) {
        params.sums = (enum weft_sums)sums;
        params.memory_bytes = 0;
        weft_slice_plan *plan = plan_of(volume, &params), *cut = NULL;
        params.memory_bytes = weft_slice_plan_get_info(plan)->memory_bytes * 3 / 5;
        const struct weft_log *log = params.log;
        params.log = NULL; // may not fit
        if (weft_slice_plan_create(volume, &params, &cut) != WEFT_OK)
            cut = NULL;
        params.log = log;
        for (size_t s = 0; s < WEFT_COUNT(sets); s++) {
            if (!weft_instruction_set_runs(sets[s]))
                continue;
            verify(plan, sets[s], job);
            check_threads(plan, sets[s]);
            const struct weft_slice_report report = run(plan, 2, sets[s], others);
            counts->runs++;
            counts->exact += report.exact_pixels > 0;
            counts->smooth += report.cells_smooth > 0;
            if (cut) {
                run(cut, 2, sets[s], others);
                assert_memory_equal(pixels, others, bytes_of(plan));
                counts->tiles += weft_slice_plan_get_info(cut)->tile_count > 1;
            }
        }
        params.memory_bytes = 0;
        check_resident(volume, &params, job, counts);
        counts->summed += weft_slice_plan_get_info(plan)->summed_axis >= 0;
        weft_slice_plan_destroy(&cut);
        weft_slice_plan_destroy(&plan);
    }
    weft_volume_destroy(&volume);
}

static void test_random_jobs(void **state)
{
    (void)state;
    const char *asked = getenv("WEFT_CPU_JOBS");
    const int jobs = asked ? atoi(asked) : 12;
    struct random r = {.state = 20261127};
    struct counts counts = {0};
    for (int job = 0; job < jobs; job++)
        check_job(&r, job, &counts);
    print_message(
        "%d runs, %d with exact pixels, %d cut into tiles, %d with smooth cells, %d plans "
        "of planes summed before, %d runs of resident volumes\n",
        counts.runs, counts.exact, counts.tiles, counts.smooth, counts.summed, counts.resident);
    assert_true(counts.runs >= 2 * jobs && counts.resident >= 2 * jobs && counts.exact > 0 &&
                counts.tiles > 0 && counts.smooth > 0 && counts.summed > 0);
}

// ---- widths, sets, the lattice ------------------------------------------------------------------

static weft_volume *noise_volume(int size, struct random *r, float *data)
{
    weft_volume *volume = NULL;
    for (int i = 0; i < size * size * size; i++)
        data[i] = (float)uniform(r);
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {size, size, size}, .data = data), &volume),
        WEFT_OK);
    return volume;
}

// Kernels of every width, oblique and across an axis: each has a loop of its own.
static void test_every_width(void **state)
{
    (void)state;
    enum { SIZE = 24 };
    static float data[SIZE * SIZE * SIZE];
    struct random r = {.state = 5};
    weft_volume *volume = noise_volume(SIZE, &r, data);
    unsigned widths = 0;
    static const char *const every[] = {"nearest",   "linear",    "bspline2",  "catmull-rom",
                                        "bspline4",  "keys6",     "bspline6",  "lanczos:4",
                                        "lanczos:5", "lanczos:6", "lanczos:7", "lanczos:8"};
    for (size_t k = 0; k < WEFT_COUNT(every); k++) {
        for (int turn = 0; turn < 4; turn++) {
            struct weft_slice_params params = {
                .space = WEFT_SPACE_INDEX,
                .geometry = {.origin = {3.1, 2.2, turn % 2 ? 11.3 : 4.4},
                             .u = {14.0, 3.0, turn % 2 ? 0.0 : 2.5},
                             .v = {-2.0, 13.0, turn % 2 ? 0.0 : 5.5},
                             .width = 67,
                             .height = 45},
                .kernel = kernel_named(every[k]),
                .engine = WEFT_ENGINE_CPU,
                .sums = (enum weft_sums)(turn / 2),
                .log = &log_to_stderr,
            };
            weft_slice_plan *plan = plan_of(volume, &params);
            for (size_t s = 0; s < WEFT_COUNT(sets); s++)
                if (weft_instruction_set_runs(sets[s]))
                    verify(plan, sets[s], (int)k);
            widths |= 1u << params.kernel.width;
            weft_slice_plan_destroy(&plan);
        }
    }
    weft_volume_destroy(&volume);
    assert_int_equal(widths & 0x15576u, 0x15576u); // 1, 2, 4, 5, 6, 8, 10, 12, 14, 16
}

// Where pixels lie on voxels, interpolating kernels give these, bit by bit.
static void test_lattice(void **state)
{
    (void)state;
    enum { SIZE = 20 };
    static float data[SIZE * SIZE * SIZE];
    struct random r = {.state = 6};
    weft_volume *volume = noise_volume(SIZE, &r, data);
    static const char *const own[] = {"linear", "catmull-rom", "keys6", "lanczos:3", "nearest"};
    int checked = 0;
    for (size_t k = 0; k < WEFT_COUNT(own); k++) {
        for (int sums = 0; sums < 2; sums++) {
            // Along a diagonal: x = i + j, y = j, z = i.
            struct weft_slice_params params = {
                .space = WEFT_SPACE_INDEX,
                .geometry = {.origin = {-1.0, -0.5, -0.5},
                             .u = {10.0, 0.0, 10.0},
                             .v = {10.0, 10.0, 0.0},
                             .width = 10,
                             .height = 10},
                .kernel = kernel_named(own[k]),
                .engine = WEFT_ENGINE_CPU,
                .sums = (enum weft_sums)sums,
                .log = &log_to_stderr,
            };
            weft_slice_plan *plan = plan_of(volume, &params);
            for (size_t s = 0; s < WEFT_COUNT(sets); s++) {
                if (!weft_instruction_set_runs(sets[s]))
                    continue;
                run(plan, 2, sets[s], pixels);
                for (int j = 0; j < 10; j++)
                    for (int i = 0; i < 10; i++, checked++)
                        assert_memory_equal(&pixels[j * 10 + i],
                                            &data[(i * SIZE + j) * SIZE + i + j], sizeof(float));
            }
            weft_slice_plan_destroy(&plan);
        }
    }
    assert_true(checked >= 2000);
    weft_volume_destroy(&volume);
}

// ---- double sums --------------------------------------------------------------------------------

// What single precision can be said with: half a unit of the result, and positions.
static void test_double_sums(void **state)
{
    (void)state;
    static float data[SIDE * SIDE * SIDE];
    weft_volume *volume = NULL;
    const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        data[i] = (float)signal->value((double[]){weft_signal_coordinate(i % SIDE, SIDE),
                                                  weft_signal_coordinate(i / SIDE % SIDE, SIDE),
                                                  weft_signal_coordinate(i / (SIDE * SIDE), SIDE)});
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data), &volume),
        WEFT_OK);
    static const char *const own[] = {"catmull-rom", "bspline3", "keys6", "lanczos:3+unit"};
    for (size_t k = 0; k < WEFT_COUNT(own); k++) {
        struct weft_slice_params params = {
            .space = WEFT_SPACE_INDEX,
            .geometry = {.origin = {6.3, 4.1, 8.2},
                         .u = {25.0, 9.0, 4.0},
                         .v = {-3.0, 22.0, 11.0},
                         .width = 256,
                         .height = 256},
            .kernel = kernel_named(own[k]),
            .engine = WEFT_ENGINE_CPU,
            .log = &log_to_stderr,
        };
        weft_slice_plan *single = plan_of(volume, &params);
        params.sums = WEFT_SUMS_DOUBLE;
        weft_slice_plan *plan = plan_of(volume, &params);
        const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
        // Half a unit of a result that is at most the gain times the largest voxel, and positions.
        const double gain = info->output[0].bound.rounded_gain;
        print_message("%s: bound %.3g, of it half a unit of the result %.3g\n", own[k],
                      info->output[0].error_bound, 0x1p-24 * gain);
        assert_true(info->output[0].error_bound <= 0x1p-24 * gain + 4e-8);
        assert_true(info->output[0].error_bound <
                    0.5 * weft_slice_plan_get_info(single)->output[0].error_bound);
        for (size_t s = 0; s < WEFT_COUNT(sets); s++) {
            if (!weft_instruction_set_runs(sets[s]))
                continue;
            const struct weft_verify_report error = verify(plan, sets[s], (int)k);
            print_message("    by %s %.3g\n", weft_instruction_set_names[sets[s]],
                          error.maximum / error.magnitude);
            assert_true(error.maximum <= 6e-8 * error.magnitude);
        }
        weft_slice_plan_destroy(&plan);
        weft_slice_plan_destroy(&single);
    }
    weft_volume_destroy(&volume);
}

// ---- refusals -----------------------------------------------------------------------------------

static void test_refusals(void **state)
{
    (void)state;
    struct random r = {.state = 7};
    weft_volume *volume = random_volume(&r);
    weft_slice_plan *plan = NULL;
    const struct weft_slice_params good = {
        .space = WEFT_SPACE_INDEX,
        .geometry = {.origin = {5, 5, 5}, .u = {9, 1, 0}, .v = {0, 9, 1}, .width = 8, .height = 8},
        .engine = WEFT_ENGINE_CPU,
    };
    struct weft_slice_params bad = good;
    bad.layout = WEFT_LAYOUT_INTERLEAVED;
    assert_int_equal(weft_slice_plan_create(volume, &bad, &plan), WEFT_ERR_UNSUPPORTED);
    bad = good;
    bad.source = WEFT_SOURCE_UNORM8;
    bad.high = 1.0;
    assert_int_equal(weft_slice_plan_create(volume, &bad, &plan), WEFT_ERR_UNSUPPORTED);
    bad = good;
    bad.engine = WEFT_ENGINE_GL;
    bad.sums = WEFT_SUMS_DOUBLE;
    assert_int_equal(weft_slice_plan_create(volume, &bad, &plan), WEFT_ERR_UNSUPPORTED);
    assert_null(plan);
    plan = plan_of(volume, &good);
    weft_slice *slice = NULL;
    assert_int_equal(weft_slice_compile(plan, weft_slice_compile_params(.cpu.threads = -1), &slice),
                     WEFT_ERR_ARGUMENT);
    assert_null(slice);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

static bool stop_later(void *priv, double fraction)
{
    (void)fraction;
    return (*(int *)priv)-- > 0;
}

static void test_cancelled(void **state)
{
    (void)state;
    struct random r = {.state = 8};
    weft_volume *volume = random_volume(&r);
    struct weft_slice_params params = {
        .space = WEFT_SPACE_INDEX,
        .geometry =
            {.origin = {1, 2, 3}, .u = {30, 5, 2}, .v = {2, 28, 9}, .width = 300, .height = 300},
        .engine = WEFT_ENGINE_CPU,
    };
    weft_slice_plan *plan = plan_of(volume, &params);
    int left = 3;
    const struct weft_progress progress = {stop_later, &left};
    assert_int_equal(
        weft_slice_run_once(plan, weft_slice_compile_params(.cpu.threads = 1),
                            weft_slice_run_params(.pixels = pixels, .progress = &progress), NULL),
        WEFT_ERR_CANCELLED);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_jobs), cmocka_unit_test(test_every_width),
        cmocka_unit_test(test_lattice),     cmocka_unit_test(test_double_sums),
        cmocka_unit_test(test_refusals),    cmocka_unit_test(test_cancelled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
