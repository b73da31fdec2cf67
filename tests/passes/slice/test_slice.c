// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/data.h"
#include "tests/support/contexts.h"
#include "filter/check.h"
#include "passes/positions/grid.h"
#include "weft.h"

// What the engine promises: |pixel - reference| <= 2e-6 x the largest |voxel| in reach.
static const double TOLERANCE = 2e-6;

// ---- volumes and slices -------------------------------------------------------------------------

// A repeatable value in [-1, 1] for every voxel: the hardest signal for interpolation.
static float noise(int x, int y, int z)
{
    uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)z * 83492791u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (float)((double)(h ^ h >> 16) / 2147483647.5 - 1.0);
}

static weft_volume *make_volume(int nx, int ny, int nz, int32_t offset, float background,
                                const double transform[3][4])
{
    float *data = malloc((size_t)nx * (size_t)ny * (size_t)nz * sizeof *data);
    assert_non_null(data);
    for (int z = 0; z < nz; z++)
        for (int y = 0; y < ny; y++)
            for (int x = 0; x < nx; x++)
                data[(z * ny + y) * nx + x] = noise(x, y, z);
    struct weft_volume_params params = {.size = {nx, ny, nz},
                                        .origin = {offset, offset, offset},
                                        .background = background,
                                        .data = data};
    if (transform)
        memcpy(params.index_to_world, transform, sizeof params.index_to_world);
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create(&params, &volume), WEFT_OK);
    free(data);
    return volume;
}

// A plane tilted against every axis, through the middle of an n-cube and past its faces.
static struct weft_slice_geometry oblique(double n, double offset, int width, int height)
{
    struct weft_slice_geometry g = {.width = width, .height = height};
    const double u[3] = {0.9, 0.4, 0.2}, v[3] = {-0.3, 0.8, 0.5};
    for (int a = 0; a < 3; a++) {
        g.u[a] = u[a] * n;
        g.v[a] = v[a] * n;
        g.origin[a] = offset + 0.5 * n - 0.5 * (g.u[a] + g.v[a]);
    }
    return g;
}

// Plans, runs and verifies; returns the pixels (to be freed).
static float *run_slice(weft_context *context, weft_volume *volume,
                        const struct weft_slice_params *params, struct weft_verify_report *error,
                        struct weft_slice_report *report)
{
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    const struct weft_slice_geometry *g = &params->geometry;
    float *pixels = malloc((size_t)g->width * (size_t)g->height * sizeof *pixels);
    assert_non_null(pixels);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                         weft_slice_run_params(.pixels = pixels), report),
                     WEFT_OK);
    if (error)
        assert_int_equal(weft_slice_verify(plan, pixels, NULL, error), WEFT_OK);
    weft_slice_plan_destroy(&plan);
    return pixels;
}

static void assert_within(const struct weft_verify_report *error, double tolerance,
                          const char *what)
{
    if (!(error->relative_maximum <= tolerance) || error->not_finite_mismatches)
        fail_msg("%s: error %.3g at (%d, %d): %.9g instead of %.9g; %d not finite", what,
                 error->relative_maximum, error->at_x, error->at_y, error->at_value,
                 error->at_reference, (int)error->not_finite_mismatches);
}

static void assert_accurate(const struct weft_verify_report *error, const char *what)
{
    assert_within(error, TOLERANCE, what);
}

// Kernels that reconstruct derivatives have weights far above 1: rounding grows with their sum, in
// each dimension.
static double tolerance_for(const struct weft_kernel_info *info)
{
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_create(NULL, info, NULL, &kernel), WEFT_OK);
    return info->derivation > 0 ? TOLERANCE * pow(weft_analysis_gain(&kernel), 3) : TOLERANCE;
}

// ---- tests --------------------------------------------------------------------------------------

static void every_kernel_layout_and_context_meets_the_reference(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(29, 31, 27, 0, 0.25f, NULL);
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
            for (int l = WEFT_LAYOUT_AUTO; l <= WEFT_LAYOUT_PLAIN; l++) {
                char what[128];
                struct weft_verify_report error;
                struct weft_slice_params params = {.kernel = kernel_named((*k)->name),
                                                   .space = WEFT_SPACE_INDEX,
                                                   .geometry = oblique(30, 0, 83, 71),
                                                   .layout = (enum weft_layout)l};
                // The reference takes width^3 products a pixel.
                if (params.kernel.width > 4 || (*k)->derivation > 0)
                    params.geometry = oblique(30, 0, 23, 19);
                free(run_slice(contexts[c], volume, &params, &error, NULL));
                snprintf(what, sizeof what, "%s, %s, layout %s",
                         weft_context_get_info(contexts[c])->platform, (*k)->name,
                         weft_layout_name((enum weft_layout)l));
                assert_within(&error, tolerance_for(*k), what);
            }
        }
    }
    weft_volume_destroy(&volume);
}

static void axis_slices_meet_the_reference(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(20, 24, 17, -5, 0.0f, NULL);
    for (int axis = 0; axis < 3; axis++) {
        // On the lattice, between, at the border and outside.
        const double at[] = {3.0, 3.5, NAN, -5.0, -6.25, 100.0};
        for (size_t i = 0; i < WEFT_COUNT(at); i++) {
            for (int l = WEFT_LAYOUT_INTERLEAVED; l <= WEFT_LAYOUT_PLAIN; l++) {
                struct weft_verify_report error;
                struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                                   .layout = (enum weft_layout)l};
                assert_int_equal(weft_slice_axis_geometry(NULL, volume, WEFT_SPACE_INDEX, axis,
                                                          at[i], 100, 0, &params.geometry),
                                 WEFT_OK);
                free(run_slice(contexts[0], volume, &params, &error, NULL));
                assert_accurate(&error, "axis slice");
            }
        }
    }
    weft_volume_destroy(&volume);
}

static void interpolating_kernels_return_voxels_exactly(void **state)
{
    (void)state;
    int kernels = 0;
    enum { N = 16 };
    weft_volume *volume = make_volume(N, N, N, 0, 0.0f, NULL);
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        if (!(*k)->interpolating)
            continue;
        // One pixel per voxel, centred on it.
        struct weft_slice_params params = {.kernel = kernel_named((*k)->name),
                                           .space = WEFT_SPACE_INDEX,
                                           .geometry = {.origin = {-0.5, -0.5, 7.0},
                                                        .u = {N, 0, 0},
                                                        .v = {0, N, 0},
                                                        .width = N,
                                                        .height = N}};
        float *pixels = run_slice(contexts[0], volume, &params, NULL, NULL);
        for (int i = 0; i < N * N; i++)
            assert_true(pixels[i] == noise(i % N, i / N, 7));
        free(pixels);
        kernels++;
    }
    assert_true(kernels >= 5);
    weft_volume_destroy(&volume);
}

static void far_offsets_cost_no_accuracy(void **state)
{
    (void)state;
    const int32_t offsets[] = {0, 1000000, -1000003, 500000000};
    for (size_t i = 0; i < WEFT_COUNT(offsets); i++) {
        weft_volume *volume = make_volume(30, 30, 30, offsets[i], 0.0f, NULL);
        struct weft_verify_report error;
        struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                           .geometry = oblique(30, offsets[i], 90, 90)};
        free(run_slice(contexts[0], volume, &params, &error, NULL));
        assert_accurate(&error, "offset");
        weft_volume_destroy(&volume);
    }
}

static void any_affine_transform_is_inverted(void **state)
{
    (void)state;
    const double transforms[][3][4] = {
        {{0.5, 0, 0, 10}, {0, 0.25, 0, -3}, {0, 0, 2, 7}},          // anisotropic
        {{0, -1e-3, 0, 5}, {1e-3, 0, 0, 0}, {0, 0, 1e-3, 1}},       // rotated, tiny
        {{100, 30, -20, 1e5}, {0, 80, 10, 2e5}, {5, 0, 120, -3e5}}, // sheared
        {{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},                // mirrored
    };
    for (size_t t = 0; t < WEFT_COUNT(transforms); t++) {
        weft_volume *volume = make_volume(21, 22, 23, 0, 0.0f, transforms[t]);
        struct weft_slice_params index = {.space = WEFT_SPACE_INDEX,
                                          .geometry = oblique(22, 0, 64, 48)};
        struct weft_slice_params world = index;
        const struct weft_slice_geometry *g = &index.geometry;
        world.space = WEFT_SPACE_WORLD;
        for (int r = 0; r < 3; r++) {
            const double *m = transforms[t][r];
            const double *edges[3] = {g->origin, g->u, g->v};
            double out[3];
            for (int e = 0; e < 3; e++)
                out[e] = m[0] * edges[e][0] + m[1] * edges[e][1] + m[2] * edges[e][2];
            world.geometry.origin[r] = out[0] + m[3];
            world.geometry.u[r] = out[1];
            world.geometry.v[r] = out[2];
        }
        struct weft_verify_report error;
        float *a = run_slice(contexts[0], volume, &index, NULL, NULL);
        float *b = run_slice(contexts[0], volume, &world, &error, NULL);
        assert_accurate(&error, "world space");
        // Positions differ by the inversion's rounding alone.
        for (int i = 0; i < 64 * 48; i++)
            assert_near((double)a[i], (double)b[i], 1e-5, "world space");
        free(a);
        free(b);
        weft_volume_destroy(&volume);
    }
}

static void tiles_and_layouts_change_no_byte(void **state)
{
    (void)state;
    enum { W = 700, H = 600 };
    weft_volume *volume = make_volume(64, 64, 64, 0, 0.0f, NULL);
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                       .geometry = oblique(64, 0, W, H),
                                       .layout = WEFT_LAYOUT_INTERLEAVED};
    float *whole = run_slice(contexts[0], volume, &params, NULL, NULL);
    const struct {
        uint64_t memory_bytes;
        int max_target_size;
    } cuts[] = {{0, 512}, {0, 100}, {2 << 20, 0}, {400 << 10, 0}};
    for (size_t i = 0; i < WEFT_COUNT(cuts); i++) {
        weft_slice_plan *plan = NULL;
        params.memory_bytes = cuts[i].memory_bytes;
        params.max_target_size = cuts[i].max_target_size;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
        const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
        assert_true(info->tile_count > 1);
        if (cuts[i].memory_bytes)
            assert_true(info->memory_bytes <= cuts[i].memory_bytes);
        int64_t covered = 0;
        for (int t = 0; t < info->tile_count; t++)
            covered += (int64_t)info->tiles[t].width * info->tiles[t].height;
        assert_int_equal(covered, W * H);
        weft_slice_plan_destroy(&plan);
        float *tiled = run_slice(contexts[0], volume, &params, NULL, NULL);
        assert_memory_equal(whole, tiled, sizeof *whole * W * H);
        free(tiled);
    }
    // Plain rows sum in the same order as interleaved ones.
    params = (struct weft_slice_params){
        .space = WEFT_SPACE_INDEX, .geometry = oblique(64, 0, W, H), .layout = WEFT_LAYOUT_PLAIN};
    float *plain = run_slice(contexts[0], volume, &params, NULL, NULL);
    assert_memory_equal(whole, plain, sizeof *whole * W * H);
    free(plain);
    free(whole);
    weft_volume_destroy(&volume);
}

// Blocks of one value, of another one, and of noise: cells that are constant, or smooth, for the
// pixels of one tile and not for those of the next.
static weft_volume *make_patches(int n)
{
    weft_volume *volume = NULL;
    float *data = malloc((size_t)n * (size_t)n * (size_t)n * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < n * n * n; i++) {
        const int x = i % n, y = i / n % n, z = i / n / n;
        const int patch = (x / 13 + y / 17 + z / 11) % 3;
        data[i] = patch == 0 ? 0.1f : patch == 1 ? 0.7f : noise(x, y, z);
    }
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {n, n, n}, .data = data, .background = 0.3f),
                           &volume),
        WEFT_OK);
    free(data);
    return volume;
}

static void tiles_change_no_byte_near_constants(void **state)
{
    (void)state;
    enum { W = 300, H = 290 };
    static const char *const kernels[] = {"catmull-rom", "linear", "bspline3i"};
    static const int sides[] = {128, 37, 16};
    weft_volume *volume = make_patches(96);
    uint64_t saved = 0;
    for (size_t i = 0; i < 2 * WEFT_COUNT(kernels); i++) {
        struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                           .kernel = kernel_named(kernels[i / 2]),
                                           .geometry = {.origin = {-8.0, -7.0, 3.0},
                                                        .u = {110.0, 5.0, 9.0},
                                                        .v = {4.0, 107.0, 70.0},
                                                        .width = W,
                                                        .height = H},
                                           .layout = WEFT_LAYOUT_INTERLEAVED + (int)(i % 3),
                                           .smooth_error = i % 2 ? 0.02 : 0.0};
        struct weft_slice_report report;
        float *whole = run_slice(contexts[0], volume, &params, NULL, &report);
        saved += report.cells_constant + report.cells_smooth;
        for (size_t cut = 0; cut < WEFT_COUNT(sides); cut++) {
            params.max_target_size = sides[cut];
            float *tiled = run_slice(contexts[0], volume, &params, NULL, NULL);
            assert_memory_equal(whole, tiled, sizeof *whole * W * H);
            free(tiled);
        }
        free(whole);
    }
    assert_true(saved > 100);
    weft_volume_destroy(&volume);
}

static void memory_chooses_the_layout(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(96, 96, 96, 0, 0.0f, NULL);
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                       .geometry = oblique(96, 0, 300, 300)};
    const struct {
        uint64_t memory_bytes;
        const char *kernel;
        enum weft_layout expected;
    } cases[] = {
        {0, "catmull-rom", WEFT_LAYOUT_INTERLEAVED},
        {3 << 20, "catmull-rom", WEFT_LAYOUT_ALIGNED},
        {0, "linear", WEFT_LAYOUT_PLAIN},
        {0, "nearest", WEFT_LAYOUT_PLAIN},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_slice_plan *plan = NULL;
        params.memory_bytes = cases[i].memory_bytes;
        params.kernel = kernel_named(cases[i].kernel);
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
        assert_int_equal(weft_slice_plan_get_info(plan)->layout, cases[i].expected);
        weft_slice_plan_destroy(&plan);
    }
    struct message message = {.count = 0};
    struct weft_log log = {keep_message, &message};
    weft_slice_plan *plan = NULL;
    params.log = &log;
    params.memory_bytes = 1000;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_ERR_LIMIT);
    assert_null(plan);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "1000"));
    weft_volume_destroy(&volume);
}

// NaN and infinity reach exactly the pixels whose taps hold them, in every layout.
static void not_finite_voxels_stay_in_reach(void **state)
{
    (void)state;
    enum { N = 24 };
    static float data[N * N * N];
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t b = 0; b < WEFT_COUNT(bad); b++) {
        for (int i = 0; i < N * N * N; i++)
            data[i] = noise(i % N, i / N % N, i / N / N);
        data[(11 * N + 12) * N + 13] = bad[b];
        struct weft_volume_params volume_params = {.size = {N, N, N}, .data = data};
        weft_volume *volume = NULL;
        assert_int_equal(weft_volume_create(&volume_params, &volume), WEFT_OK);
        for (int l = WEFT_LAYOUT_INTERLEAVED; l <= WEFT_LAYOUT_PLAIN; l++) {
            struct weft_verify_report error;
            struct weft_slice_report report;
            struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                               .geometry = oblique(N, 0, 128, 128),
                                               .layout = (enum weft_layout)l};
            free(run_slice(contexts[0], volume, &params, &error, &report));
            assert_accurate(&error, weft_layout_name((enum weft_layout)l));
            assert_true(report.not_finite > 0);
            assert_true(report.exact_pixels >= report.not_finite);
            assert_true(isfinite(report.minimum) && isfinite(report.maximum));
        }
        weft_volume_destroy(&volume);
    }
}

static void a_clamped_volume_holds_its_edge(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(13, 9, 11, 3, NAN, NULL);
    struct weft_verify_report error;
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                       .geometry = oblique(60, -15, 128, 128)};
    free(run_slice(contexts[0], volume, &params, &error, NULL));
    assert_accurate(&error, "clamped");
    // Outside, the corner's own value.
    params.geometry = (struct weft_slice_geometry){
        .origin = {-50, -50, -50}, .u = {4, 0, 0}, .v = {0, 4, 0}, .width = 4, .height = 4};
    float *pixels = run_slice(contexts[0], volume, &params, NULL, NULL);
    for (int i = 0; i < 16; i++)
        assert_near((double)pixels[i], (double)noise(0, 0, 0), 1e-6, "clamped");
    free(pixels);
    weft_volume_destroy(&volume);
}

static void a_missing_slice_is_background_and_a_warning(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(10, 10, 10, 0, -2.5f, NULL);
    struct message message = {.count = 0};
    struct weft_log log = {keep_message, &message};
    struct weft_slice_params params = {
        .space = WEFT_SPACE_INDEX, .log = &log, .geometry = oblique(10, 5000, 33, 17)};
    float *pixels = run_slice(contexts[0], volume, &params, NULL, NULL);
    for (int i = 0; i < 33 * 17; i++)
        assert_true(pixels[i] == -2.5f);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "misses"));
    free(pixels);
    weft_volume_destroy(&volume);
}

static void thin_volumes_and_wide_steps_work(void **state)
{
    (void)state;
    const int sizes[][3] = {{1, 1, 1}, {1, 20, 20}, {200, 1, 3}};
    for (size_t s = 0; s < WEFT_COUNT(sizes); s++) {
        weft_volume *volume = make_volume(sizes[s][0], sizes[s][1], sizes[s][2], 0, 0.0f, NULL);
        for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
            struct weft_verify_report error;
            struct weft_slice_params params = {.kernel = kernel_named((*k)->name),
                                               .space = WEFT_SPACE_INDEX,
                                               .geometry = oblique(8, -3, 40, 40)};
            if (params.kernel.width > 4 || (*k)->derivation > 0)
                params.geometry = oblique(8, -3, 11, 11);
            free(run_slice(contexts[0], volume, &params, &error, NULL));
            assert_within(&error, tolerance_for(*k), (*k)->name);
        }
        weft_volume_destroy(&volume);
    }
    // Minified: far more than a cell from pixel to pixel, up to the index limit.
    weft_volume *volume = make_volume(30, 30, 30, 0, 0.0f, NULL);
    const double lengths[] = {300, 1e5, 1e8};
    for (size_t i = 0; i < WEFT_COUNT(lengths); i++) {
        struct weft_verify_report error;
        struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                           .geometry =
                                               oblique(lengths[i], 15 - lengths[i] / 2, 65, 65)};
        free(run_slice(contexts[0], volume, &params, &error, NULL));
        assert_accurate(&error, "minified");
    }
    weft_volume_destroy(&volume);
}

static void a_slice_of_one_pixel_and_odd_sizes_work(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(20, 20, 20, 0, 0.0f, NULL);
    const int sizes[][2] = {{1, 1}, {1, 300}, {300, 1}, {257, 255}, {513, 2}};
    for (size_t i = 0; i < WEFT_COUNT(sizes); i++) {
        struct weft_verify_report error;
        struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                           .geometry = oblique(20, 0, sizes[i][0], sizes[i][1])};
        free(run_slice(contexts[0], volume, &params, &error, NULL));
        assert_accurate(&error, "size");
    }
    weft_volume_destroy(&volume);
}

static void bad_requests_are_named(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(8, 8, 8, 0, 0.0f, NULL);
    const struct {
        struct weft_slice_geometry geometry;
        enum weft_result expected;
        const char *text;
    } cases[] = {
        {{.u = {1, 0, 0}, .v = {0, 1, 0}, .width = 0, .height = 4}, WEFT_ERR_ARGUMENT, "0 x 4"},
        {{.u = {1, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = -1}, WEFT_ERR_ARGUMENT, "4 x -1"},
        {{.u = {1, 0, 0}, .v = {0, 1, 0}, .width = 1000000000, .height = 4},
         WEFT_ERR_ARGUMENT,
         "1000000000"},
        {{.u = {1, 0, 0}, .v = {0, 1, 0}, .width = 1000000, .height = 1000000},
         WEFT_ERR_ARGUMENT,
         "2147483648"},
        {{.u = {0, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = 4}, WEFT_ERR_ARGUMENT, "parallel"},
        {{.u = {1, 1, 0}, .v = {2, 2, 0}, .width = 4, .height = 4}, WEFT_ERR_ARGUMENT, "parallel"},
        {{.u = {1, NAN, 0}, .v = {0, 1, 0}, .width = 4, .height = 4}, WEFT_ERR_ARGUMENT, "finite"},
        {{.origin = {INFINITY, 0, 0}, .u = {1, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = 4},
         WEFT_ERR_ARGUMENT,
         "finite"},
        {{.origin = {3e9, 0, 0}, .u = {1, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = 4},
         WEFT_ERR_LIMIT,
         "3e+09"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        struct weft_log log = {keep_message, &message};
        weft_slice_plan *plan = NULL;
        struct weft_slice_params params = {
            .space = WEFT_SPACE_INDEX, .geometry = cases[i].geometry, .log = &log};
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), cases[i].expected);
        assert_null(plan);
        assert_int_equal(message.count, 1);
        assert_non_null(strstr(message.text, cases[i].text));
    }
    weft_volume_destroy(&volume);
}

static bool stop_at_once(void *priv, double fraction)
{
    (void)priv;
    (void)fraction;
    return false;
}

static void runs_and_verification_can_be_cancelled(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(16, 16, 16, 0, 0.0f, NULL);
    struct weft_progress progress = {stop_at_once, NULL};
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                       .geometry = oblique(16, 0, 32, 32)};
    float pixels[32 * 32] = {0};
    weft_slice_plan *plan = NULL;
    struct weft_verify_report error;
    params.progress = &progress;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_ERR_CANCELLED);
    assert_null(plan);
    params.progress = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(
        weft_slice_run_once(plan, weft_slice_compile_params(.context = contexts[0]),
                            weft_slice_run_params(.pixels = pixels, .progress = &progress), NULL),
        WEFT_ERR_CANCELLED);
    assert_int_equal(weft_slice_verify(plan, pixels,
                                       &(struct weft_slice_verify_params){.progress = &progress},
                                       &error),
                     WEFT_ERR_CANCELLED);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

// The CPU's cells come from the same fixed-point numbers as the shader's, and these from double.
static void grid_positions_follow_the_double_ones(void **state)
{
    (void)state;
    struct weft_volume_info info = {.name = "test"};
    const double lengths[] = {0.01, 30, 4000, 1e6, 1e9};
    for (size_t i = 0; i < WEFT_COUNT(lengths); i++) {
        struct weft_slice_params params = {.kernel = kernel_named("catmull-rom"),
                                           .space = WEFT_SPACE_INDEX,
                                           .geometry =
                                               oblique(lengths[i], -lengths[i] / 2, 600, 500)};
        struct weft_slice_grid grid;
        assert_int_equal(weft_slice_grid_create(NULL, &params.geometry, params.space,
                                                params.kernel.width, &info, &grid),
                         WEFT_OK);
        const double step = ldexp(1.0, -grid.fraction_bits);
        for (int y = 0; y < 500; y += 31) {
            for (int x = 0; x < 600; x += 29) {
                struct weft_slice_block block;
                double exact[3], fraction[3];
                int32_t whole[3];
                weft_slice_grid_block(&grid, x / 256, y / 256, &block);
                weft_slice_grid_pixel(&grid, &block, x, y, whole, fraction);
                weft_slice_grid_position(&grid, x, y, NULL, exact);
                // Both are rounded to 2^-29.
                for (int a = 0; a < 3; a++)
                    assert_true(fabs(whole[a] + fraction[a] - exact[a]) <=
                                0x1p-29 + 256 * step + 4 * DBL_EPSILON * fabs(exact[a]) +
                                    4 * DBL_EPSILON * lengths[i]);
            }
        }
    }
}

// The files of the data folder, axis-aligned and oblique, through the reader.
// Each kernel on one of the two planes of each volume; on both with WEFT_KERNELS=full.
static void real_volumes_meet_the_reference(void **state)
{
    (void)state;
    const char *const names[] = {"smoke.vdb", "mri.vdb"};
    const char *size = getenv("WEFT_KERNELS");
    const bool full = size && strcmp(size, "full") == 0;
    int missing = 0;
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        weft_volume *volume = open_data_volume(names[i]);
        if (!volume) {
            missing++;
            continue;
        }
        const struct weft_volume_info *info = weft_volume_get_info(volume);
        struct weft_slice_geometry planes[2] = {0};
        assert_int_equal(
            weft_slice_axis_geometry(NULL, volume, WEFT_SPACE_INDEX, 2, NAN, 128, 128, &planes[0]),
            WEFT_OK);
        planes[1] =
            oblique(info->active_max[1] - info->active_min[1], info->active_min[1], 128, 128);
        for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
            for (int p = 0; p < 2; p++) {
                if (!full && ((size_t)(k - weft_kernel_list) + i + (size_t)p) % 2)
                    continue;
                struct weft_verify_report error;
                struct weft_slice_params params = {.kernel = kernel_named((*k)->name),
                                                   .space = WEFT_SPACE_INDEX,
                                                   .geometry = planes[p]};
                if (params.kernel.width > 4 || (*k)->derivation > 0)
                    params.geometry.width = params.geometry.height = 24;
                free(run_slice(contexts[0], volume, &params, &error, NULL));
                assert_within(&error, tolerance_for(*k), (*k)->name);
            }
        }
        weft_volume_destroy(&volume);
    }
    if (missing == WEFT_COUNT(names))
        skip();
}

// Every record with parameters at both ends of their ranges and between: radii in tenths have jumps
// and kinks inside tiles, and pixels lie on them.
static void any_parameters_can_be_sliced(void **state)
{
    (void)state;
    enum { SIDE = 20, ROUNDS = 6 };
    static float data[SIDE * SIDE * SIDE];
    weft_volume *volume = NULL;
    srand(3);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        data[i] = (float)(rand() % 1000) / 1000.0f;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data), &volume),
        WEFT_OK);
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX,
                                       .without = WEFT_SAVING_ALL,
                                       .geometry = {.origin = {9.95, 9.95, 9.95},
                                                    .u = {1, 0, 2},
                                                    .v = {0, 1, 1},
                                                    .width = 10,
                                                    .height = 10}};
    int count = 0, bounded = 0;
    for (int i = 0; i < ROUNDS; i++) {
        for (int k = 0; weft_kernel_list[k]; k++) {
            const struct weft_kernel_info *info = weft_kernel_list[k];
            double p[WEFT_KERNEL_PARAMS] = {0};
            if (info->derivation || !info->params[0].name)
                continue;
            for (int n = 0; n < WEFT_KERNEL_PARAMS && info->params[n].name; n++) {
                const double low = info->params[n].min, high = info->params[n].max;
                const double tenths = round(10.0 * (low + (high - low) * (rand() % 1000) / 1e3));
                p[n] = i == 0 ? low : i == 1 ? high : fmax(low, 0.1 * tenths);
            }
            struct weft_verify_report error;
            char name[100];
            assert_int_equal(weft_kernel_create(NULL, info, p, &params.kernel), WEFT_OK);
            weft_kernel_format(&params.kernel, name, sizeof name);
            weft_slice_plan *plan = NULL;
            float pixels[100];
            if (weft_slice_plan_create(volume, &params, &plan) != WEFT_OK)
                fail_msg("%s cannot be sliced", name);
            assert_int_equal(weft_slice_run_once(plan,
                                                 weft_slice_compile_params(.context = contexts[0]),
                                                 weft_slice_run_params(.pixels = pixels), NULL),
                             WEFT_OK);
            assert_int_equal(weft_slice_verify(plan, pixels, NULL, &error), WEFT_OK);
            const struct weft_slice_output *value = weft_slice_plan_get_info(plan)->output;
            const double bound = value->error_bound * error.magnitude + value->error_absolute;
            if (!(error.maximum <= bound))
                fail_msg("%s: error %.3g, bound %.3g", name, error.maximum, bound);
            bounded += bound <= 1e-4 * error.magnitude;
            count++;
            weft_slice_plan_destroy(&plan);
        }
    }
    assert_true(count >= 60 && bounded > count / 2); // others have weights of hundreds
    weft_volume_destroy(&volume);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kernel_layout_and_context_meets_the_reference),
        cmocka_unit_test(axis_slices_meet_the_reference),
        cmocka_unit_test(any_parameters_can_be_sliced),
        cmocka_unit_test(interpolating_kernels_return_voxels_exactly),
        cmocka_unit_test(far_offsets_cost_no_accuracy),
        cmocka_unit_test(any_affine_transform_is_inverted),
        cmocka_unit_test(tiles_and_layouts_change_no_byte),
        cmocka_unit_test(tiles_change_no_byte_near_constants),
        cmocka_unit_test(memory_chooses_the_layout),
        cmocka_unit_test(not_finite_voxels_stay_in_reach),
        cmocka_unit_test(a_clamped_volume_holds_its_edge),
        cmocka_unit_test(a_missing_slice_is_background_and_a_warning),
        cmocka_unit_test(thin_volumes_and_wide_steps_work),
        cmocka_unit_test(a_slice_of_one_pixel_and_odd_sizes_work),
        cmocka_unit_test(bad_requests_are_named),
        cmocka_unit_test(runs_and_verification_can_be_cancelled),
        cmocka_unit_test(grid_positions_follow_the_double_ones),
        cmocka_unit_test(real_volumes_meet_the_reference),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
