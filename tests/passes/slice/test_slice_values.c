// SPDX-License-Identifier: BSD-3-Clause
// Slices on the lattice, half-way between voxels, and of values that floats do not stand.
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
#include "tests/support/contexts.h"
#include "weft.h"

enum { N = 12, VOXELS = N * N * N, MAX_PIXELS = 800 * 40 };

static float voxels[VOXELS], pixels[MAX_PIXELS], others[MAX_PIXELS];

static weft_volume *make_volume(float background)
{
    weft_volume *volume = NULL;
    const struct weft_volume_params *params =
        weft_volume_params(.size = {N, N, N}, .data = voxels, .background = background);
    assert_int_equal(weft_volume_create(params, &volume), WEFT_OK);
    return volume;
}

static double noise(uint32_t i)
{
    uint32_t h = i * 73856093u + 1u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (double)(h ^ h >> 16) / 4294967296.0;
}

static void fill_noise(void)
{
    for (uint32_t i = 0; i < VOXELS; i++)
        voxels[i] = (float)noise(i);
}

static float voxel_at(int i, int j, int k)
{
    return voxels[(k * N + j) * N + i];
}

// Across axis 2 at `depth`, turned so that it is across `axis`; `turned`: rows and columns run the
// other way.
static struct weft_slice_geometry across(int axis, bool turned, double depth, int width, int height)
{
    struct weft_slice_geometry g = {.width = width, .height = height};
    const int p = (axis + 1) % 3, q = (axis + 2) % 3;
    g.u[p] = turned ? -N : N;
    g.v[q] = turned ? -N : N;
    g.origin[p] = g.origin[q] = turned ? N - 0.5 : -0.5;
    g.origin[axis] = depth;
    return g;
}

// Every method of running a slice that promises single precision.
static const struct engine {
    enum weft_layout layout;
    unsigned without;
    const char *what;
} engines[] = {
    {WEFT_LAYOUT_AUTO, 0, "all savings"},
    {WEFT_LAYOUT_AUTO, WEFT_SAVING_SEPARABLE, "not separable"},
    {WEFT_LAYOUT_AUTO, WEFT_SAVING_CONSTANT | WEFT_SAVING_SEPARABLE, "no constants"},
    {WEFT_LAYOUT_AUTO, WEFT_SAVING_AXIS, "no axis"},
    {WEFT_LAYOUT_INTERLEAVED, WEFT_SAVING_ALL, "interleaved"},
    {WEFT_LAYOUT_ALIGNED, WEFT_SAVING_ALL, "aligned"},
    {WEFT_LAYOUT_PLAIN, WEFT_SAVING_ALL, "plain"},
    {WEFT_LAYOUT_ALIGNED, WEFT_SAVING_SEPARABLE, "aligned, summed"},
};

static struct weft_slice_params params_of(const struct engine *engine, const char *kernel,
                                          const struct weft_slice_geometry *g)
{
    return (struct weft_slice_params){.kernel = kernel_named(kernel),
                                      .space = WEFT_SPACE_INDEX,
                                      .geometry = *g,
                                      .layout = engine->layout,
                                      .without = engine->without,
                                      .log = &log_to_stderr};
}

// Runs into `out`; with a `what`, verifies within the plan's own bound. Returns what the run tells.
static struct weft_slice_report run(weft_context *context, weft_volume *volume,
                                    const struct weft_slice_params *params, float *out,
                                    const char *what)
{
    weft_slice_plan *plan = NULL;
    struct weft_slice_report report;
    struct weft_verify_report error = {0};
    assert_true(params->geometry.width * params->geometry.height <= MAX_PIXELS);
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                         weft_slice_run_params(.pixels = out), &report),
                     WEFT_OK);
    if (what)
        assert_int_equal(weft_slice_verify(plan, out, NULL, &error), WEFT_OK);
    const double bound =
        info->output[0].error_bound * error.magnitude + info->output[0].error_absolute;
    if (!(error.maximum <= bound) || error.not_finite_mismatches)
        fail_msg("%s, %s: error %.3g at (%d, %d), %.9g instead of %.9g; the bound is %.3g; %d not "
                 "finite on one side",
                 params->kernel.info->name, what, error.maximum, error.at_x, error.at_y,
                 error.at_value, error.at_reference, bound, (int)error.not_finite_mismatches);
    weft_slice_plan_destroy(&plan);
    return report;
}

static size_t pixel_count(const struct weft_slice_geometry *g)
{
    return (size_t)g->width * (size_t)g->height;
}

// ---- half-way and whole -------------------------------------------------------------------------

// The voxel nearest to pixel i of `count` along an edge from -1/2 to N - 1/2 or back, exactly in
// integers: floor(position + 1/2), half-way up.
static int nearest_voxel(int i, int count, bool turned, int half)
{
    // position + 1/2 + half / 2 = (2 i + 1) N / (2 count), or N minus that
    const int along = (2 * i + 1) * N, whole = 2 * count;
    const int up = (turned ? N * whole - along : along) + half * count;
    return (up >= 0 ? up : up - whole + 1) / whole;
}

// Sizes for which every pixel is half-way or some are, in and past blocks of 256 pixels.
static const int tie_sizes[] = {N, 3 * N, 5 * N, 35 * N, 65 * N, 7, 257, 300};

static void check_ties(weft_context *context, weft_volume *volume, const struct engine *engine,
                       int size, int axis, bool turned)
{
    // Moved by half a voxel along rows and columns, and half-way along the axis too.
    struct weft_slice_geometry g =
        across(axis, turned, 4.5, size > 40 && turned ? 3 : size, size > 40 && !turned ? 3 : size);
    g.origin[(axis + 1) % 3] += 0.5;
    g.origin[(axis + 2) % 3] += 0.5;
    const struct weft_slice_params params = params_of(engine, "nearest", &g);
    run(context, volume, &params, pixels, size < 40 ? engine->what : NULL);
    for (int y = 0; y < g.height; y++) {
        for (int x = 0; x < g.width; x++) {
            int at[3];
            at[axis] = 5;
            at[(axis + 1) % 3] = nearest_voxel(x, g.width, turned, 1);
            at[(axis + 2) % 3] = nearest_voxel(y, g.height, turned, 1);
            const bool inside = at[0] < N && at[1] < N && at[2] < N;
            const float expected = inside ? voxel_at(at[0], at[1], at[2]) : -1.0f;
            if (pixels[y * g.width + x] != expected)
                fail_msg("%s, %d x %d across %d: pixel (%d, %d) is not voxel (%d, %d, %d)",
                         engine->what, g.width, g.height, axis, x, y, at[0], at[1], at[2]);
        }
    }
}

static void half_way_goes_up(void **state)
{
    (void)state;
    for (int i = 0; i < VOXELS; i++)
        voxels[i] = (float)i;
    weft_volume *volume = make_volume(-1.0f);
    for (size_t e = 0; e < WEFT_COUNT(engines); e++)
        for (size_t s = 0; s < WEFT_COUNT(tie_sizes); s++)
            for (int t = 0; t < 2; t++)
                check_ties(contexts[e % 2 && contexts[1] ? 1 : 0], volume, &engines[e],
                           tie_sizes[s], (int)((e + s) % 3), t);
    weft_volume_destroy(&volume);
}

// Of N samples on m N pixels, m odd, every m-th pixel lies on a voxel: whatever is beside it.
static void voxels_come_back(void **state)
{
    (void)state;
    static const int multiples[] = {1, 3, 33};
    int checked = 0;
    for (int i = 0; i < VOXELS; i++)
        voxels[i] = (i + i / N + i / (N * N)) % 2 ? 1e30f : (float)noise((uint32_t)i);
    weft_volume *volume = make_volume(NAN);
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        for (size_t e = 0; (*k)->interpolating && e < WEFT_COUNT(engines); e++) {
            const int m = multiples[e % WEFT_COUNT(multiples)], axis = (int)(e % 3);
            const bool turned = e % 2;
            struct weft_slice_geometry g = across(axis, turned, 7.0, m * N, m > 3 ? N : m * N);
            const struct weft_slice_params params = params_of(&engines[e], (*k)->name, &g);
            run(contexts[0], volume, &params, pixels, m == 1 ? engines[e].what : NULL);
            const int rows = g.height / N;
            for (int i = 0; i < N * N; i++) {
                const int x = i % N * m + m / 2, y = i / N * rows + rows / 2;
                int at[3];
                at[axis] = 7;
                at[(axis + 1) % 3] = turned ? N - 1 - i % N : i % N;
                at[(axis + 2) % 3] = turned ? N - 1 - i / N : i / N;
                if (pixels[y * g.width + x] != voxel_at(at[0], at[1], at[2]))
                    fail_msg("%s, %s, %d x %d: pixel (%d, %d) is %.9g, not %.9g", (*k)->name,
                             engines[e].what, g.width, g.height, x, y, pixels[y * g.width + x],
                             voxel_at(at[0], at[1], at[2]));
                checked++;
            }
        }
    }
    assert_true(checked > 10 * N * N);
    weft_volume_destroy(&volume);
}

// ---- not finite ---------------------------------------------------------------------------------

// On the lattice only the voxels themselves count: the background neither eats the last row and
// column nor the planes beside the slice, whatever is saved.
static void weights_of_zero_do_not_count(void **state)
{
    (void)state;
    static const char *const kernels[] = {"linear", "catmull-rom", "lanczos:3", "keys6", "nearest"};
    const float backgrounds[] = {NAN, INFINITY, -INFINITY};
    fill_noise();
    voxels[(5 * N + 4) * N + 3] = NAN; // in the slice
    for (int i = 0; i < N * N; i++)
        voxels[6 * N * N + i] = INFINITY; // beside it
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        for (size_t e = 0; e < WEFT_COUNT(engines); e++) {
            weft_volume *volume = make_volume(backgrounds[(k + e) % 3]);
            const struct weft_slice_geometry g = across(2, false, 5.0, N, N);
            const struct weft_slice_params params = params_of(&engines[e], kernels[k], &g);
            const struct weft_slice_report r =
                run(contexts[0], volume, &params, pixels, engines[e].what);
            assert_int_equal(r.not_finite, 1);
            assert_true(isnan(pixels[4 * N + 3]));
            for (int i = 0; i < N * N; i++)
                assert_true(i == 4 * N + 3 || pixels[i] == voxel_at(i % N, i / N, 5));
            weft_volume_destroy(&volume);
        }
    }
}

// A pixel 2^-29 voxels off has weights beside its voxel; one that rounds to it has not.
static void positions_are_rounded_before_weights_count(void **state)
{
    (void)state;
    const struct {
        double off;
        int not_finite;
    } cases[] = {{0.0, 0}, {0x1p-31, 0}, {-0x1p-31, 0}, {0x1p-29, N * N}, {-0x1p-29, N * N}};
    fill_noise();
    for (int i = 0; i < N * N; i++)
        voxels[4 * N * N + i] = voxels[6 * N * N + i] = NAN;
    weft_volume *volume = make_volume(0.0f);
    for (size_t c = 0; c < WEFT_COUNT(cases); c++) {
        for (size_t e = 0; e < WEFT_COUNT(engines); e++) {
            const struct weft_slice_geometry g = across(2, false, 5.0 + cases[c].off, N, N);
            const struct weft_slice_params params = params_of(&engines[e], "linear", &g);
            assert_int_equal(run(contexts[0], volume, &params, pixels, engines[e].what).not_finite,
                             cases[c].not_finite);
        }
    }
    weft_volume_destroy(&volume);
}

// Values of a kind, one after another: what a test sprinkles over a volume.
static float wild_value(uint32_t i)
{
    const float values[] = {NAN,   INFINITY, -INFINITY, FLT_MAX, -FLT_MAX,
                            1e37f, 1e-38f,   -1e-36f,   1e-44f,  FLT_MAX};
    return values[i % WEFT_COUNT(values)];
}

// Oblique, about an axis, or along the axes on the lattice or off it.
static struct weft_slice_geometry some_plane(int i)
{
    struct weft_slice_geometry g = across(i % 3, i / 3 % 2, 5.0 + (i % 2) * 0.3, 40, 30);
    if (i % 4 == 3) {
        const double u[3] = {0.9, 0.4, 0.2}, v[3] = {-0.3, 0.8, 0.5};
        for (int a = 0; a < 3; a++) {
            g.u[a] = u[a] * N;
            g.v[a] = v[a] * N;
            g.origin[a] = 0.5 * N - 0.5 * (g.u[a] + g.v[a]);
        }
    }
    return g;
}

// Against the reference and the plan's bound, and so that layouts and savings agree on what is
// finite.
static void wild_values_meet_the_reference(void **state)
{
    (void)state;
    static const char *const kernels[] = {"catmull-rom", "linear",   "bspline3", "lanczos:3",
                                          "mitchell",    "bspline2", "nearest",  "d-catmull-rom"};
    const int densities[] = {1, 2, 7, 200, 1000};
    uint64_t exact = 0, not_finite = 0;
    for (int j = 0; j < 40; j++) {
        const int density = densities[j % 5];
        fill_noise();
        for (uint32_t i = 0; i < VOXELS; i++)
            if ((int)(noise(i + 7919u * (uint32_t)j) * density) == 0)
                voxels[i] = wild_value(j < 20 ? (uint32_t)j : i);
        weft_volume *volume = make_volume(j % 3 ? 0.5f : wild_value((uint32_t)j));
        const struct weft_slice_geometry g = some_plane(j);
        const char *kernel = kernels[j % (int)WEFT_COUNT(kernels)];
        uint64_t count = 0;
        for (size_t e = 0; e < WEFT_COUNT(engines); e++) {
            const struct weft_slice_params params = params_of(&engines[e], kernel, &g);
            weft_context *context = contexts[e % 2 && contexts[1] ? 1 : 0];
            const struct weft_slice_report r =
                run(context, volume, &params, pixels, engines[e].what);
            if (e > 0)
                assert_int_equal(r.not_finite, count);
            count = r.not_finite;
            exact += r.exact_pixels;
            not_finite += r.not_finite;
        }
        weft_volume_destroy(&volume);
    }
    assert_true(exact > 0 && not_finite > 0 && not_finite < exact);
}

static void clamping_keeps_nan(void **state)
{
    (void)state;
    fill_noise();
    voxels[(5 * N + 4) * N + 3] = NAN;
    voxels[(5 * N + 8) * N + 8] = INFINITY;
    weft_volume *volume = make_volume(0.0f);
    for (int i = 0; i < 12; i++) {
        const struct weft_slice_geometry g = some_plane(i);
        for (int l = WEFT_LAYOUT_INTERLEAVED; l <= WEFT_LAYOUT_PLAIN; l++) {
            struct weft_slice_params params = params_of(
                &(struct engine){(enum weft_layout)l, WEFT_SAVING_ALL, ""}, "catmull-rom", &g);
            run(contexts[0], volume, &params, pixels, "not clamped");
            params.clamp_to_samples = true;
            run(contexts[0], volume, &params, others, "clamped");
            for (size_t p = 0; p < pixel_count(&g); p++)
                assert_true(isfinite(pixels[p]) == isfinite(others[p]));
        }
    }
    weft_volume_destroy(&volume);
}

// ---- large and small ----------------------------------------------------------------------------

// Weights that add up to one leave a constant, the largest float too.
static void the_largest_float_stays(void **state)
{
    (void)state;
    for (int i = 0; i < VOXELS; i++)
        voxels[i] = FLT_MAX;
    weft_volume *volume = make_volume(FLT_MAX);
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        struct weft_kernel kernel = kernel_named((*k)->name);
        for (size_t e = 0; kernel.unit_sum && e < WEFT_COUNT(engines); e++) {
            const struct weft_slice_geometry g = some_plane((int)e);
            struct weft_slice_params params = params_of(&engines[e], (*k)->name, &g);
            params.geometry.width = params.geometry.height = 9;
            const struct weft_slice_report r =
                run(contexts[0], volume, &params, pixels, engines[e].what);
            assert_int_equal(r.not_finite, 0);
            assert_true(r.minimum >= FLT_MAX * (1.0f - 0x1p-22f));
        }
    }
    weft_volume_destroy(&volume);
}

// Of FLT_MAX beside others: what a kernel makes of it may be past the largest float, and is
// infinite then; clamped to the samples it is not.
static void no_data_of_the_largest_float(void **state)
{
    (void)state;
    fill_noise();
    for (int i = 0; i < VOXELS; i++)
        if (i / N % 5 == 2)
            voxels[i] = FLT_MAX;
    weft_volume *volume = make_volume(FLT_MAX);
    uint64_t infinite = 0;
    for (int i = 0; i < 8; i++) {
        const struct weft_slice_geometry g = some_plane(i);
        struct weft_slice_params params = params_of(&engines[i], "catmull-rom", &g);
        infinite += run(contexts[0], volume, &params, pixels, engines[i].what).not_finite;
        params.clamp_to_samples = true;
        assert_int_equal(run(contexts[0], volume, &params, pixels, "clamped").not_finite, 0);
        params.clamp_to_samples = false;
        params.kernel = kernel_named("bspline3");
        assert_int_equal(run(contexts[0], volume, &params, pixels, "smooth").not_finite, 0);
    }
    assert_true(infinite > 0);
    weft_volume_destroy(&volume);
}

// A budget is met by what can hold the voxels: halves cannot hold this range.
static void budgets_skip_sources_that_cannot_hold_the_voxels(void **state)
{
    (void)state;
    struct message message = {0};
    const struct weft_log log = {keep_message, &message};
    struct weft_choice choice;
    fill_noise();
    const struct weft_slice_geometry g = some_plane(3);
    voxels[((N / 2) * N + N / 2) * N + N / 2] = FLT_MAX; // where the plane's middle lies
    weft_volume *volume = make_volume(0.0f);
    struct weft_choose_params params = {.slice = params_of(&engines[0], "catmull-rom", &g),
                                        .max_error = 1e-3 * FLT_MAX};
    params.slice.log = &log;
    assert_int_equal(weft_choose(volume, &params, &choice), WEFT_OK);
    assert_int_equal(message.count, 0);
    assert_true(choice.chosen >= 0);
    int refused = 0;
    for (size_t i = 0; i < choice.count; i++) {
        const struct weft_candidate *c = &choice.candidates[i];
        const bool holds =
            c->method.algorithm != WEFT_ALGORITHM_FUSED || c->method.source == WEFT_SOURCE_FLOAT;
        refused += !holds;
        assert_true(holds || c->state == WEFT_CANDIDATE_REFUSED);
    }
    assert_true(refused >= 9);
    weft_choice_clear(&choice);
    weft_volume_destroy(&volume);
}

// What is not finite stays so in halves, which hold a range; fixed point refuses it, in reach.
static void halves_keep_what_is_not_finite(void **state)
{
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 12; i++) {
        fill_noise();
        voxels[(5 * N + 5) * N + 5] = bad[i % 3];
        weft_volume *volume = make_volume(i % 2 ? 0.0f : bad[i % 3]);
        const struct weft_slice_geometry g = some_plane(i);
        struct weft_slice_params params = params_of(&engines[1], "catmull-rom", &g);
        params.low = 0.0;
        params.high = 1.0;
        const uint64_t count = run(contexts[0], volume, &params, pixels, "floats").not_finite;
        assert_true(count > 0);
        params.source = WEFT_SOURCE_HALF;
        assert_int_equal(run(contexts[0], volume, &params, pixels, "halves").not_finite, count);
        struct message message = {0};
        const struct weft_log log = {keep_message, &message};
        weft_slice_plan *plan = NULL;
        params.source = WEFT_SOURCE_UNORM8;
        params.log = &log;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
        assert_int_equal(weft_slice_run_once(plan,
                                             weft_slice_compile_params(.context = contexts[0]),
                                             weft_slice_run_params(.pixels = pixels), NULL),
                         WEFT_ERR_UNSUPPORTED);
        assert_int_equal(message.count, 1);
        weft_slice_plan_destroy(&plan);
        weft_volume_destroy(&volume);
    }
}

// Where all voxels are fit nothing is computed on the CPU.
static void fit_voxels_cost_nothing(void **state)
{
    (void)state;
    fill_noise();
    weft_volume *volume = make_volume(0.0f);
    for (size_t e = 0; e < WEFT_COUNT(engines); e++) {
        const struct weft_slice_geometry g = some_plane((int)e);
        const struct weft_slice_params params = params_of(&engines[e], "lanczos:3", &g);
        assert_int_equal(run(contexts[0], volume, &params, pixels, engines[e].what).exact_pixels,
                         0);
    }
    weft_volume_destroy(&volume);
}

// ---- passes -------------------------------------------------------------------------------------

// Plans, runs and verifies; returns how many pixels are not finite.
static uint64_t run_passes(weft_volume *volume, const char *kernel, const char *profile,
                           const struct weft_slice_geometry *g)
{
    struct weft_method_params params = {.method = {.algorithm = WEFT_ALGORITHM_MULTIPASS,
                                                   .samples = 16,
                                                   .profile = *weft_profile_find(profile)},
                                        .slice = params_of(&engines[3], kernel, g)};
    weft_slice_plan *plan = NULL;
    weft_method_plan *method = NULL;
    struct weft_method_report report;
    struct weft_verify_report error;
    assert_int_equal(weft_slice_plan_create(volume, &params.slice, &plan), WEFT_OK);
    assert_int_equal(
        weft_footprint_statistics(weft_slice_plan_get_footprint(plan), NULL, &params.statistics),
        WEFT_OK);
    assert_int_equal(weft_method_plan_create(volume, &params, &method), WEFT_OK);
    assert_int_equal(
        weft_method_run(method, weft_method_run_params(.context = contexts[0], .pixels = pixels),
                        &report),
        WEFT_OK);
    assert_int_equal(weft_slice_verify(weft_method_plan_get_slice(method), pixels, NULL, &error),
                     WEFT_OK);
    const double bound = weft_method_plan_get_info(method)->bound;
    if (!(error.maximum <= bound) || error.not_finite_mismatches)
        fail_msg("%s on %s: error %.3g, the bound is %.3g; %d not finite on one side", kernel,
                 profile, error.maximum, bound, (int)error.not_finite_mismatches);
    weft_method_plan_destroy(&method);
    weft_slice_plan_destroy(&plan);
    return report.slice.not_finite;
}

static void passes_follow_the_same_rules(void **state)
{
    (void)state;
    static const char *const profiles[] = {"fp32", "unorm8"};
    for (int i = 0; i < VOXELS; i++)
        voxels[i] = (float)(i % 199);
    for (int i = 0; i < 4; i++) {
        weft_volume *volume = make_volume(0.0f);
        struct weft_slice_geometry g =
            across(i % 3, i % 2, 4.5, i < 2 ? 65 * N : 3, i < 2 ? 3 : 65 * N);
        g.origin[(i + 1) % 3] += 0.5;
        g.origin[(i + 2) % 3] += 0.5;
        assert_int_equal(run_passes(volume, "nearest", "fp32", &g),
                         0); // within 1e-4, of steps of 1
        weft_volume_destroy(&volume);
    }
    voxels[(5 * N + 4) * N + 3] = NAN;
    for (int i = 0; i < N * N; i++)
        voxels[6 * N * N + i] = INFINITY;
    weft_volume *volume = make_volume(NAN);
    const struct weft_slice_geometry lattice = across(2, false, 5.0, N, N);
    for (size_t p = 0; p < WEFT_COUNT(profiles); p++)
        assert_int_equal(run_passes(volume, "linear", profiles[p], &lattice), 1);
    weft_volume_destroy(&volume);
    for (int i = 0; i < VOXELS; i++)
        voxels[i] = i % 3 ? FLT_MAX : -FLT_MAX;
    volume = make_volume(FLT_MAX);
    for (size_t p = 0; p < WEFT_COUNT(profiles); p++)
        assert_int_equal(run_passes(volume, "linear", profiles[p], &lattice), 0);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_way_goes_up),
        cmocka_unit_test(voxels_come_back),
        cmocka_unit_test(weights_of_zero_do_not_count),
        cmocka_unit_test(positions_are_rounded_before_weights_count),
        cmocka_unit_test(wild_values_meet_the_reference),
        cmocka_unit_test(clamping_keeps_nan),
        cmocka_unit_test(the_largest_float_stays),
        cmocka_unit_test(no_data_of_the_largest_float),
        cmocka_unit_test(budgets_skip_sources_that_cannot_hold_the_voxels),
        cmocka_unit_test(halves_keep_what_is_not_finite),
        cmocka_unit_test(fit_voxels_cost_nothing),
        cmocka_unit_test(passes_follow_the_same_rules),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
