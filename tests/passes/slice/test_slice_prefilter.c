// SPDX-License-Identifier: BSD-3-Clause
// Slices with prefiltered kernels: coefficients on GL, against the cardinal spline over voxels.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/data.h"
#include "tests/support/contexts.h"
#include "weft.h"

static float noise(int x, int y, int z)
{
    uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)z * 83492791u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (float)((double)(h ^ h >> 16) / 2147483647.5 - 1.0);
}

static const double wave[3] = {0.5, 0.4, -0.3};
static double wave_scale = 1.0;

static double smooth(double x, double y, double z)
{
    return cos(wave_scale * (wave[0] * x + wave[1] * y + wave[2] * z) + 0.3);
}

enum content { NOISE, WAVE, NOISE_AND_NAN, ALTERNATING };

enum { N = 24 };

static weft_volume *make_volume(enum content content, int side, float background)
{
    float *data = malloc((size_t)side * (size_t)side * (size_t)side * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < side * side * side; i++) {
        const int x = i % side, y = i / side % side, z = i / side / side;
        data[i] = content == WAVE          ? (float)smooth(x, y, z)
                  : content == ALTERNATING ? ((x + y + z) % 2 ? -1.0f : 1.0f)
                                           : noise(x, y, z);
    }
    if (content == NOISE_AND_NAN) {
        data[(12 * side + 12) * side + 9] = NAN;
        data[(13 * side + 4) * side + 17] = INFINITY;
    }
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {side, side, side}, .data = data,
                                                           .background = background),
                                        &volume),
                     WEFT_OK);
    free(data);
    return volume;
}

static struct weft_slice_geometry oblique(double n, int width, int height)
{
    struct weft_slice_geometry g = {.width = width, .height = height};
    const double u[3] = {0.9, 0.4, 0.2}, v[3] = {-0.3, 0.8, 0.5};
    for (int a = 0; a < 3; a++) {
        g.u[a] = u[a] * n;
        g.v[a] = v[a] * n;
        g.origin[a] = 0.5 * n - 0.5 * (g.u[a] + g.v[a]);
    }
    return g;
}

struct result {
    float *pixels;          // to be freed
    double bound, absolute; // of the source's format, in values
    int overlap, tiles;
    struct weft_verify_report error;
};

static struct result slice(weft_context *context, weft_volume *volume,
                           const struct weft_slice_params *params, bool verify)
{
    struct result r = {.pixels = NULL};
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    r.bound = info->output[0].error_bound;
    r.absolute = info->output[0].error_absolute;
    r.overlap = info->prefilter_overlap;
    r.tiles = info->tile_count;
    r.pixels =
        malloc((size_t)params->geometry.width * (size_t)params->geometry.height * sizeof(float));
    assert_non_null(r.pixels);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                         weft_slice_run_params(.pixels = r.pixels), NULL),
                     WEFT_OK);
    if (verify)
        assert_int_equal(weft_slice_verify(plan, r.pixels, NULL, &r.error), WEFT_OK);
    weft_slice_plan_destroy(&plan);
    return r;
}

// Within the bounds of the plan and of the coefficients, and a relative error that was measured.
static void assert_within(const struct result *r, double measured, const char *what)
{
    const struct weft_verify_report *e = &r->error;
    const bool floats = r->absolute == 0.0;
    if (!(e->relative_maximum <= (floats ? fmin(measured, r->bound) : measured) &&
          e->maximum <= e->bound) ||
        e->not_finite_mismatches || e->pixels_checked == 0)
        fail_msg("%s: error %.3g, relative %.3g, of bounds %.3g and %.3g (%.3g measured); %d of %d "
                 "not finite",
                 what, e->maximum, e->relative_maximum, e->bound, r->bound, measured,
                 (int)e->not_finite_mismatches, (int)e->pixels_checked);
}

// Regression limits for noise: the largest error measured is 4e-7 for the cubic, and grows with the
// gain's cube.
static void slices_meet_the_cardinal_spline(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        double tolerance;
    } cases[] = {{"bspline2i", 2e-6},   {"bspline3i", 2e-6},   {"bspline4i", 4e-6},
                 {"bspline5i", 8e-6},   {"bspline6i", 2e-5},   {"bspline7i", 4e-5},
                 {"omomsi", 4e-6},      {"d-bspline3i", 2e-5}, {"bsplinei", 2e-6},
                 {"d-bspline2i", 2e-5}, {"dd-bspline5i", 4e-4}};
    static const float backgrounds[] = {0.25f, NAN};
    for (size_t b = 0; b < WEFT_COUNT(backgrounds); b++) {
        weft_volume *volume = make_volume(NOISE, N, backgrounds[b]);
        for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
            for (int c = 0; c < 2 && contexts[c]; c++) {
                const struct weft_slice_params params = {.kernel = kernel_named(cases[i].kernel),
                                                         .space = WEFT_SPACE_INDEX,
                                                         .geometry = oblique(N + 12, 19, 17)};
                struct result r = slice(contexts[c], volume, &params, true);
                assert_true(r.error.pixels_checked == r.error.pixels_total);
                assert_within(&r, cases[i].tolerance, cases[i].kernel);
                assert_true(r.overlap > 0);
                free(r.pixels);
            }
        }
        weft_volume_destroy(&volume);
    }
}

static void slices_pass_through_the_voxels(void **state)
{
    (void)state;
    static const char *const kernels[] = {"bspline2i", "bspline3i", "omomsi"};
    weft_volume *volume = make_volume(NOISE, N, 0.0f);
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        const struct weft_slice_params params = {.kernel = kernel_named(kernels[k]),
                                                 .space = WEFT_SPACE_INDEX,
                                                 .geometry = {.origin = {-0.5, -0.5, 7.0},
                                                              .u = {N, 0, 0},
                                                              .v = {0, N, 0},
                                                              .width = N,
                                                              .height = N}};
        struct result r = slice(contexts[0], volume, &params, false);
        // No voxel is larger than 1; a millionth was measured.
        for (int i = 0; i < N * N; i++)
            assert_near((double)r.pixels[i], (double)noise(i % N, i / N, 7), fmin(r.bound, 1e-6),
                        kernels[k]);
        free(r.pixels);
    }
    weft_volume_destroy(&volume);
}

static void tiles_change_no_byte(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(NOISE, 70, 0.0f);
    struct weft_slice_params params = {.kernel = kernel_named("bspline3i"),
                                       .space = WEFT_SPACE_INDEX,
                                       .geometry = oblique(70, 300, 290)};
    struct result whole = slice(contexts[0], volume, &params, false);
    params.max_target_size = 64;
    struct result tiled = slice(contexts[0], volume, &params, false);
    assert_true(tiled.tiles > whole.tiles);
    assert_memory_equal(whole.pixels, tiled.pixels, 300 * 290 * sizeof(float));
    free(whole.pixels);
    free(tiled.pixels);
    weft_volume_destroy(&volume);
}

// Finite pixels are those of a volume where nothing is missing, and there are such; verification
// calls others wrong.
static void finite_pixels_know_nothing_of_missing_voxels(void **state)
{
    (void)state;
    enum { BIG = 40, SIDE = 60 };
    static const char *const kernels[] = {"bspline2i", "bspline3i", "omomsi", "d-bspline3i"};
    weft_volume *volume = make_volume(NOISE_AND_NAN, BIG, 0.0f),
                *whole = make_volume(NOISE, BIG, 0);
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        for (int along = 0; along < 2; along++) {
            struct weft_slice_params params = {.kernel = kernel_named(kernels[k]),
                                               .space = WEFT_SPACE_INDEX,
                                               .geometry = oblique(BIG, SIDE, SIDE)};
            if (along)
                params.geometry = (struct weft_slice_geometry){.origin = {-1, -1, 12.25},
                                                               .u = {BIG + 2},
                                                               .v = {0, BIG + 2},
                                                               .width = SIDE,
                                                               .height = SIDE};
            struct result r = slice(contexts[0], volume, &params, true);
            struct result full = slice(contexts[0], whole, &params, false);
            int missing = 0;
            for (int i = 0; i < SIDE * SIDE; i++) {
                missing += !isfinite(r.pixels[i]);
                if (isfinite(r.pixels[i]))
                    assert_near((double)r.pixels[i], (double)full.pixels[i], 2.0 * r.bound,
                                kernels[k]);
            }
            assert_true(missing > 100 && missing < SIDE * SIDE - 100);
            assert_within(&r, INFINITY, kernels[k]);
            // Pixels made as if nothing were missing are wrong.
            weft_slice_plan *plan = NULL;
            struct weft_verify_report error;
            assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
            assert_int_equal(weft_slice_verify(plan, full.pixels, NULL, &error), WEFT_OK);
            assert_true(error.not_finite_mismatches > 100);
            weft_slice_plan_destroy(&plan);
            free(r.pixels);
            free(full.pixels);
        }
    }
    weft_volume_destroy(&whole);
    weft_volume_destroy(&volume);
}

// Verification that believed the coefficients would not see the plain B-spline's blur.
static void verification_sees_blur(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(NOISE, N, 0.0f);
    struct weft_slice_params params = {.kernel = kernel_named("bspline3"),
                                       .space = WEFT_SPACE_INDEX,
                                       .geometry = oblique(N, 40, 40)};
    struct result plain = slice(contexts[0], volume, &params, false);
    weft_slice_plan *plan = NULL;
    struct weft_verify_report error;
    params.kernel = kernel_named("bspline3i");
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(weft_slice_verify(plan, plain.pixels, NULL, &error), WEFT_OK);
    assert_true(error.relative_maximum > 0.1);
    weft_slice_plan_destroy(&plan);
    free(plain.pixels);
    weft_volume_destroy(&volume);
}

// Axis slices sum along their axis first, formats store coefficients, and clamping has no samples.
static void savings_and_formats_work_on_coefficients(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(NOISE_AND_NAN, N, 0.0f);
    const struct weft_slice_geometry plane = {
        .origin = {-4, -4, 12}, .u = {32, 0, 0}, .v = {0, 32, 0}, .width = 50, .height = 50};
    struct weft_slice_params params = {
        .kernel = kernel_named("bspline3i"), .space = WEFT_SPACE_INDEX, .geometry = plane};
    struct result r = slice(contexts[0], volume, &params, true);
    assert_within(&r, 2e-6, "along an axis");
    free(r.pixels);
    weft_volume_destroy(&volume);

    volume = make_volume(NOISE, N, 0.0f);
    weft_slice_plan *plan = NULL;
    struct weft_slice_statistics range;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(weft_footprint_statistics(weft_slice_plan_get_footprint(plan), NULL, &range),
                     WEFT_OK);
    weft_slice_plan_destroy(&plan);
    assert_true(range.high > 1.5f && range.low < -1.5f);
    params.source = WEFT_SOURCE_UNORM16;
    params.low = (double)range.low;
    params.high = (double)range.high;
    r = slice(contexts[0], volume, &params, true);
    assert_within(&r, 2e-4, "16 bits"); // of a range that is 20 wide
    free(r.pixels);
    params.clamp_to_samples = true;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_ERR_UNSUPPORTED);
    weft_volume_destroy(&volume);
}

// The largest error against the function itself, well inside the volume.
static double function_error(const char *kernel, double scale)
{
    enum { SIDE = 56, PIXELS = 60 };
    wave_scale = scale;
    weft_volume *volume = make_volume(WAVE, SIDE, 0.0f);
    const struct weft_slice_params params = {.kernel = kernel_named(kernel),
                                             .space = WEFT_SPACE_INDEX,
                                             .geometry = {.origin = {22, 22, 27.4},
                                                          .u = {11, 0, 1},
                                                          .v = {0, 11, 0},
                                                          .width = PIXELS,
                                                          .height = PIXELS}};
    struct result r = slice(contexts[0], volume, &params, false);
    double worst = 0.0;
    for (int i = 0; i < PIXELS * PIXELS; i++) {
        const double s = (i % PIXELS + 0.5) / PIXELS, t = (i / PIXELS + 0.5) / PIXELS;
        worst = larger(
            worst, fabs((double)r.pixels[i] - smooth(22.0 + 11.0 * s, 22.0 + 11.0 * t, 27.4 + s)));
    }
    free(r.pixels);
    weft_volume_destroy(&volume);
    return worst;
}

// Signs that make every voxel count in full at one position.
static weft_volume *make_adverse(const struct weft_kernel *kernel, const double at[3])
{
    static float data[N * N * N];
    double weights[3][WEFT_PREFILTER_MAX_WEIGHTS];
    struct weft_prefilter p;
    int64_t first[3];
    assert_int_equal(weft_prefilter_compute(NULL, kernel, &p), WEFT_OK);
    for (int a = 0; a < 3; a++)
        first[a] = weft_prefilter_weights(&p, kernel, 40, at[a], weights[a]);
    for (int i = 0; i < N * N * N; i++)
        data[i] = weights[0][i % N - first[0]] * weights[1][i / N % N - first[1]] *
                              weights[2][i / N / N - first[2]] <
                          0.0
                      ? -1.0f
                      : 1.0f;
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .data = data), &volume), WEFT_OK);
    return volume;
}

// Random cuts, oblique and along axes, through voxels of every kind. Bounds hold, and where voxels
// are smooth, without a border in reach, they are within 100 times the error, since it is the
// coefficients that they know (20 were measured; of noise 370, where roundings cancel).
// WEFT_PREFILTER_JOBS: how many.
static void bounds_hold_and_are_near(void **state)
{
    (void)state;
    static const char *const kernels[] = {"bspline2i", "bspline3i",   "bspline4i",
                                          "bspline5i", "bspline6i",   "bspline7i",
                                          "omomsi",    "d-bspline3i", "dd-bspline5i"};
    static const enum content contents[] = {NOISE, WAVE, ALTERNATING};
    const char *const wanted = getenv("WEFT_PREFILTER_JOBS");
    const int jobs = wanted ? atoi(wanted) : 36;
    int near = 0;
    srand(5);
    for (int i = 0; i < jobs; i++) {
        const char *name = kernels[i % (int)WEFT_COUNT(kernels)];
        const struct weft_kernel kernel = kernel_named(name);
        const int kind = i / (int)WEFT_COUNT(kernels) % 4;
        const double middle = 0.5 * N + 0.01 * (rand() % 100), half = 0.01 * (rand() % 200 + 1);
        const double slant = rand() % 2 ? 0.0 : 0.1 * (rand() % 20);
        const bool border = kind != 1;
        weft_volume *volume = kind < 3 ? make_volume(contents[kind], N, border ? 0.5f : NAN)
                                       : make_adverse(&kernel, (double[]){middle, middle, middle});
        const struct weft_slice_params params = {
            .kernel = kernel,
            .space = WEFT_SPACE_INDEX,
            .without = rand() % 3 ? 0 : WEFT_SAVING_ALL,
            .geometry = {.origin = {middle - half, middle - half, middle - 0.5 * slant},
                         .u = {2.0 * half, 0.0, slant},
                         .v = {0.0, 2.0 * half, 0.0},
                         .width = 15,
                         .height = 15}};
        struct result r = slice(contexts[0], volume, &params, true);
        assert_within(&r, INFINITY, name);
        if (!border && half > 0.5 && kernel.info->derivation == 0) {
            near++;
            if (!(r.error.bound <= 100.0 * r.error.maximum))
                fail_msg("%d: %s: error %.3g, bound %.3g", i, name, r.error.maximum, r.error.bound);
        }
        free(r.pixels);
        weft_volume_destroy(&volume);
    }
    assert_true(near >= jobs / 10);
}

// ---- much larger voxels just out of reach -------------------------------------------------------

enum { FAR_SIDE = 6, FAR_PIXELS = 3, FAR_LENGTH = 200, FAR_MIDDLE = 60 };

// A bar of noise along an axis, in which one voxel is larger.
static weft_volume *make_bar(int axis, const int at[3], float value, float *data, int size[3])
{
    weft_volume *volume = NULL;
    for (int a = 0; a < 3; a++)
        size[a] = a == axis ? FAR_LENGTH : FAR_SIDE;
    for (int i = 0; i < FAR_LENGTH * FAR_SIDE * FAR_SIDE; i++)
        data[i] = noise(i, axis, 3);
    data[(at[2] * size[1] + at[1]) * size[0] + at[0]] = value;
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {size[0], size[1], size[2]},
                                                           .data = data, .background = 0.0f),
                                        &volume),
                     WEFT_OK);
    return volume;
}

// The cardinal spline out to where it is below 2^-80.
static double cardinal(const struct weft_kernel *kernel, const float *data, const int size[3],
                       const double at[3])
{
    static double weights[3][WEFT_PREFILTER_MAX_WEIGHTS];
    struct weft_prefilter p;
    int64_t first[3];
    double sum = 0.0;
    assert_int_equal(weft_prefilter_compute(NULL, kernel, &p), WEFT_OK);
    for (int a = 0; a < 3; a++)
        first[a] =
            weft_prefilter_weights(&p, kernel, WEFT_PREFILTER_MAX_OVERLAP, at[a], weights[a]);
    const int count = kernel->width + 2 * WEFT_PREFILTER_MAX_OVERLAP;
    for (int i = 0; i < size[0] * size[1] * size[2]; i++) {
        const int index[3] = {i % size[0], i / size[0] % size[1], i / size[0] / size[1]};
        double weight = 1.0;
        for (int a = 0; a < 3; a++) {
            const int64_t k = index[a] - first[a];
            weight *= k >= 0 && k < count ? weights[a][k] : 0.0;
        }
        sum += weight * (double)data[i];
    }
    return sum;
}

static double far_error(const struct weft_slice_params *p, const float *data, const int size[3],
                        const float *pixels)
{
    const struct weft_slice_geometry *g = &p->geometry;
    double worst = 0.0;
    for (int i = 0; i < FAR_PIXELS * FAR_PIXELS; i++) {
        double at[3];
        for (int a = 0; a < 3; a++)
            at[a] = g->origin[a] + (i % FAR_PIXELS + 0.5) / FAR_PIXELS * g->u[a] +
                    (i / FAR_PIXELS + 0.5) / FAR_PIXELS * g->v[a];
        worst = larger(worst, fabs((double)pixels[i] - cardinal(&p->kernel, data, size, at)));
    }
    return worst;
}

struct far_counts {
    int ran, beyond, broken, seen, tried, refused;
};

// No way promises an error that the slice exceeds.
static bool is_refused(weft_volume *volume, const struct weft_slice_params *slice, double max_error)
{
    const struct weft_choose_params params = {.slice = *slice, .max_error = max_error};
    struct weft_choice choice;
    assert_int_equal(weft_choose(volume, &params, &choice), WEFT_OK);
    const bool refused = choice.chosen < 0;
    assert_true(choice.best >= 0 && choice.statistics.beyond > 0.0);
    weft_choice_clear(&choice);
    return refused;
}

// A voxel of the given size, `away` voxels farther than the overlap from the last tap.
static void check_far(const struct weft_kernel *kernel, int axis, int away, float value,
                      struct far_counts *counts)
{
    static float data[FAR_LENGTH * FAR_SIDE * FAR_SIDE];
    float pixels[FAR_PIXELS * FAR_PIXELS];
    struct weft_slice_params params = {.kernel = *kernel,
                                       .space = WEFT_SPACE_INDEX,
                                       .geometry = {.width = FAR_PIXELS, .height = FAR_PIXELS}};
    int at[3], size[3];
    for (int a = 0; a < 3; a++) {
        params.geometry.origin[a] = (a == axis ? FAR_MIDDLE : 2) + 0.05;
        at[a] = 2;
    }
    params.geometry.u[axis] = 0.4; // one cell, also of kernels of odd width
    params.geometry.v[(axis + 1) % 3] = 0.3;
    struct weft_prefilter p;
    assert_int_equal(weft_prefilter_compute(NULL, kernel, &p), WEFT_OK);
    const int overlap = weft_prefilter_overlap(&p, WEFT_VOLUME_PREFILTER_ERROR);
    at[axis] = FAR_MIDDLE + kernel->width / 2 + overlap + away;
    weft_volume *volume = make_bar(axis, at, value, data, size);
    weft_slice_plan *plan = NULL;
    struct weft_verify_report error;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    assert_int_equal(info->prefilter_overlap, overlap);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = contexts[0]),
                                         weft_slice_run_params(.pixels = pixels), NULL),
                     WEFT_OK);
    assert_int_equal(weft_slice_verify(plan, pixels, NULL, &error), WEFT_OK);
    assert_int_equal(error.pixels_checked, error.pixels_total);
    const double found = far_error(&params, data, size, pixels);
    const double near = info->output[0].error_bound * (away > 0 ? 1.0 : (double)value) +
                        info->output[0].error_absolute;
    const double stated = near + (away > 0 ? info->output[0].error_beyond * (double)value : 0.0);
    if (!(found <= stated && found <= error.bound))
        fail_msg("%s: %g, %d voxels past the overlap: error %.3g, stated %.3g, bound %.3g",
                 kernel->info->name, (double)value, away, found, stated, error.bound);
    // Verification leaves no more out than a small part of the bound.
    if (!(fabs(found - error.maximum) <= 0.05 * fmin(stated, error.bound)))
        fail_msg("%s: %g, %d voxels past the overlap: error %.3g, verified %.3g",
                 kernel->info->name, (double)value, away, found, error.maximum);
    if (found > near && away == 1)
        counts->refused += is_refused(volume, &params, 0.5 * found);
    counts->ran++;
    counts->tried += found > near && away == 1;
    counts->beyond += away > 0;
    counts->broken += found > near;
    counts->seen += error.maximum > near;
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

// Bounds know what inverse filters are cut off by: where a much larger voxel lies just out of
// reach, the part that is relative to voxels in reach is not enough, and verification shows it.
static void larger_voxels_out_of_reach_count(void **state)
{
    (void)state;
    static const char *const kernels[] = {"bspline2i", "bspline3i", "bspline5i", "bspline7i",
                                          "omomsi"};
    static const int away[] = {-1, 0, 1, 2, 4, 9, 20, 40};
    static const float values[] = {1e7f, 1e12f};
    const bool all = getenv("WEFT_PREFILTER_JOBS") != NULL;
    struct far_counts counts = {0};
    for (int i = 0; i < (int)(WEFT_COUNT(kernels) * WEFT_COUNT(away) * 2); i++) {
        const int k = i % (int)WEFT_COUNT(kernels), d = i / (int)WEFT_COUNT(kernels) / 2;
        const int large = i / (int)WEFT_COUNT(kernels) % 2;
        const struct weft_kernel kernel = kernel_named(kernels[k]);
        if (all || (k + d + large) % 2 == 0)
            check_far(&kernel, (k + d) % 3, away[d], values[large], &counts);
    }
    print_message("%d slices, %d with the voxel out of reach; in %d the rest of the bound is not "
                  "enough, in %d verification sees it\n",
                  counts.ran, counts.beyond, counts.broken, counts.seen);
    assert_true(counts.ran >= 40 && counts.beyond >= 30);
    assert_true(counts.broken >= 10);
    assert_int_equal(counts.seen, counts.broken);
    assert_true(counts.tried > 0 && counts.refused == counts.tried);
}

// ---- orders -------------------------------------------------------------------------------------

static void errors_fall_with_the_fourth_power(void **state)
{
    (void)state;
    const double error = function_error("bspline3i", 2.0), half = function_error("bspline3i", 1.0);
    const double plain = function_error("bspline3", 2.0);
    const double plain_half = function_error("bspline3", 1.0);
    print_message("bspline3i: %.3g, %.3g; bspline3: %.3g, %.3g\n", error, half, plain, plain_half);
    assert_near(log2(error / half), 4.0, 0.3, "order of bspline3i");
    assert_near(log2(plain / plain_half), 2.0, 0.3, "order of bspline3");
    assert_true(half < 0.01 * plain_half);
}

static void passes_run_on_coefficients(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(NOISE, N, NAN);
    const struct weft_slice_params params = {.kernel = kernel_named("bspline3i"),
                                             .space = WEFT_SPACE_INDEX,
                                             .geometry = oblique(N, 20, 20)};
    static const struct {
        const char *profile;
        int samples;
    } cases[] = {{"fp32", 16}, {"unorm8", 8}};
    weft_slice_plan *slice_plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &params, &slice_plan), WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        float pixels[20 * 20];
        weft_pass_plan *plan = NULL;
        struct weft_slice_report report;
        struct weft_verify_report error;
        struct weft_pass_plan_params *plan_params =
            weft_pass_plan_params(.kernel = params.kernel, .dims = 3, .samples = cases[i].samples);
        assert_int_equal(weft_profile_parse(NULL, cases[i].profile, &plan_params->profile),
                         WEFT_OK);
        assert_int_equal(weft_pass_plan_create(plan_params, &plan), WEFT_OK);
        assert_int_equal(weft_slice_run_once(
                             slice_plan,
                             weft_slice_compile_params(.context = contexts[0],
                                                       .passes = weft_slice_passes(.plan = plan)),
                             weft_slice_run_params(.pixels = pixels), &report),
                         WEFT_OK);
        // Coefficients of noise reach farther than its voxels.
        assert_true(report.high > 1.5 && report.low < -1.5);
        assert_int_equal(weft_slice_verify(slice_plan, pixels, NULL, &error), WEFT_OK);
        const struct weft_bound_terms terms = weft_slice_multipass_bound_terms(slice_plan, plan);
        const struct weft_bound_values values = {
            .low = report.low, .high = report.high, .sample_low = -1.0, .sample_high = 1.0};
        const double bound = weft_bound_compute(&terms, &values).total;
        if (!(error.maximum <= bound) || error.not_finite_mismatches)
            fail_msg("%s: error %.3g, bound %.3g; %d not finite", cases[i].profile, error.maximum,
                     bound, (int)error.not_finite_mismatches);
        weft_pass_plan_destroy(&plan);
    }
    weft_slice_plan_destroy(&slice_plan);
    weft_volume_destroy(&volume);
}

static void real_volumes_are_verified(void **state)
{
    (void)state;
    static const char *const names[] = {"smoke.vdb", "mri.vdb"};
    int missing = 0;
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        weft_volume *volume = open_data_volume(names[i]);
        if (!volume) {
            missing++;
            continue;
        }
        struct weft_slice_params params = {.kernel = kernel_named("bspline3i"),
                                           .space = WEFT_SPACE_INDEX};
        params.geometry = oblique(weft_volume_get_info(volume)->active_max[1], 64, 64);
        struct result r = slice(contexts[0], volume, &params, true);
        print_message("%s: %.3g\n", names[i], r.error.relative_maximum);
        assert_within(&r, 2e-6, names[i]);
        free(r.pixels);
        weft_volume_destroy(&volume);
    }
    if (missing == WEFT_COUNT(names))
        skip();
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_meet_the_cardinal_spline),
        cmocka_unit_test(slices_pass_through_the_voxels),
        cmocka_unit_test(tiles_change_no_byte),
        cmocka_unit_test(finite_pixels_know_nothing_of_missing_voxels),
        cmocka_unit_test(verification_sees_blur),
        cmocka_unit_test(savings_and_formats_work_on_coefficients),
        cmocka_unit_test(bounds_hold_and_are_near),
        cmocka_unit_test(larger_voxels_out_of_reach_count),
        cmocka_unit_test(errors_fall_with_the_fourth_power),
        cmocka_unit_test(passes_run_on_coefficients),
        cmocka_unit_test(real_volumes_are_verified),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
