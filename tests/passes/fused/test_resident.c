// SPDX-License-Identifier: BSD-3-Clause
// Resident volumes: slices that read them are those that have their voxels to themselves, whatever
// was there before, gave way, or failed; and nothing is read, laid out or made twice.
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
#include "filter/check.h"
#include "passes/fused/resident_impl.h"
#include "passes/gl/context_backend.h"
#include "tiles/volume/volume_impl.h"
#include "weft.h"

enum { N = 40, WIDTH = 70, HEIGHT = 60, PIXELS = WIDTH * HEIGHT };

// ---- volumes ------------------------------------------------------------------------------------

static uint64_t random_state;

static double uniform(void) // splitmix64, in [0, 1)
{
    uint64_t h = random_state += UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((h ^ h >> 31) >> 11) * 0x1p-53;
}

static int below(int n)
{
    return (int)(uniform() * n);
}

// What is in a volume: noise everywhere, in a part of it, or with voxels that floats do not stand.
enum content { NOISE, SPARSE, UNFIT, CONTENTS, SMOOTH = CONTENTS };

static weft_volume *make_volume(enum content content, bool clamped)
{
    float *data = malloc((size_t)N * N * N * sizeof *data);
    weft_volume *volume = NULL;
    assert_non_null(data);
    for (int i = 0; i < N * N * N; i++) {
        const int x = i % N, y = i / N % N, z = i / N / N;
        data[i] = content == SPARSE && (x < 20 || y > 25) ? 0.0f : (float)(uniform() - 0.4);
        if (content == SMOOTH)
            data[i] = (float)sin(0.05 * x + 0.04 * y + 0.03 * z) + (x > 30 ? data[i] : 0.0f);
        if (content == UNFIT && x + 3 * y + 5 * z == 170)
            data[i] = y % 3 == 0 ? NAN : y % 3 == 1 ? INFINITY : 1e38f;
    }
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .origin = {-3, 5, 0}, .data = data,
                                              .background = clamped ? NAN : 0.0f,
                                              .log = &log_to_stderr),
                           &volume),
        WEFT_OK);
    free(data);
    return volume;
}

// A volume that is not in memory as far as its readers know: it hands another's bricks over, counts
// them, and fails when it is told to.
struct distant {
    weft_volume *base;
    uint64_t bricks_read;
    int calls_left; // before reading fails; -1: never
};

static enum weft_result find_distant(weft_volume *volume, const struct weft_region *region,
                                     struct weft_brick_list *out)
{
    return weft_volume_find(((struct distant *)volume->data)->base, region, out);
}

static enum weft_result read_distant(weft_volume *volume, size_t count, const int32_t (*origin)[3],
                                     float *values)
{
    struct distant *d = volume->data;
    if (d->calls_left == 0)
        return WEFT_ERR_READER;
    d->calls_left -= d->calls_left > 0;
    d->bricks_read += count;
    return weft_volume_read(d->base, count, origin, values);
}

static void clear_distant(void *data)
{
    (void)data;
}

static weft_volume *make_distant(weft_volume *base, struct distant **out)
{
    static const struct weft_volume_backend backend = {sizeof(struct distant), find_distant,
                                                       read_distant, clear_distant};
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_make(&log_to_stderr, &backend, &volume), WEFT_OK);
    volume->info = base->info;
    volume->info.metadata = NULL;
    volume->info.metadata_count = 0;
    *out = volume->data;
    **out = (struct distant){.base = base, .calls_left = -1};
    return volume;
}

// ---- slices -------------------------------------------------------------------------------------

// A plane through the volume: oblique, or, one in five, across an axis and turned in its plane.
static struct weft_slice_geometry random_plane(void)
{
    struct weft_slice_geometry g = {.width = WIDTH, .height = HEIGHT};
    const bool across = below(5) == 0;
    const int axis = below(3);
    for (int a = 0; a < 3; a++) {
        g.u[a] = across && a == axis ? 0.0 : 60.0 * (uniform() - 0.5);
        g.v[a] = across && a == axis ? 0.0 : 60.0 * (uniform() - 0.5);
        g.origin[a] = (a == 1 ? 25.0 : 18.0) - 0.5 * (g.u[a] + g.v[a]) + 10.0 * (uniform() - 0.5);
    }
    return g;
}

static struct weft_slice_params params_of(const struct weft_slice_geometry *g, const char *kernel)
{
    return (struct weft_slice_params){.kernel = kernel_named(kernel),
                                      .space = WEFT_SPACE_INDEX,
                                      .geometry = *g,
                                      .log = &log_to_stderr};
}

// Runs a slice and returns its plan's bound in the volume's values.
static double run_slice(weft_volume *volume, const struct weft_slice_params *params, float *pixels,
                        struct weft_slice_report *report)
{
    weft_slice_plan *plan = NULL;
    struct weft_slice_statistics s;
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = contexts[0]),
                                         weft_slice_run_params(.pixels = pixels), report),
                     WEFT_OK);
    assert_int_equal(weft_footprint_statistics(weft_slice_plan_get_footprint(plan), NULL, &s),
                     WEFT_OK);
    const struct weft_bound_values values = {.low = s.low,
                                             .high = s.high,
                                             .sample_low = s.voxel_low,
                                             .sample_high = s.voxel_high,
                                             .beyond = s.beyond};
    const double bound =
        weft_bound_compute(&weft_slice_plan_get_info(plan)->output[0].bound, &values).total;
    weft_slice_plan_destroy(&plan);
    return bound;
}

static size_t count_different(const float *a, const float *b)
{
    size_t count = 0;
    for (int i = 0; i < PIXELS; i++)
        count += memcmp(&a[i], &b[i], sizeof a[i]) != 0 && !(isnan(a[i]) && isnan(b[i]));
    return count;
}

static double largest_difference(const float *a, const float *b)
{
    double most = 0.0;
    for (int i = 0; i < PIXELS; i++)
        most = larger(most, fabs((double)a[i] - (double)b[i]));
    return most;
}

static weft_resident *make_resident(const struct weft_resident_params *params)
{
    weft_resident *resident = NULL;
    assert_int_equal(weft_resident_create(params, &resident), WEFT_OK);
    return resident;
}

// ---- the same pixels ----------------------------------------------------------------------------

// What is resident: its layout and format, how many taps, and how many blocks it holds.
static const struct hold {
    enum weft_layout layout;
    enum weft_source_format source;
    const char *kernel;
    uint64_t blocks; // 0: all
} holds[] = {
    {WEFT_LAYOUT_INTERLEAVED, WEFT_SOURCE_FLOAT, "catmull-rom", 14},
    {WEFT_LAYOUT_INTERLEAVED, WEFT_SOURCE_HALF, "lanczos:3", 0},
    {WEFT_LAYOUT_ALIGNED, WEFT_SOURCE_FLOAT, "catmull-rom", 20},
    {WEFT_LAYOUT_PLAIN, WEFT_SOURCE_UNORM8, "bspline3", 12},
    {WEFT_LAYOUT_PLAIN, WEFT_SOURCE_FLOAT, "lanczos:3", 0},
};

static const char *const kernels[] = {"nearest",     "linear",   "bspline2",
                                      "catmull-rom", "bspline3", "lanczos:3"};

// Kernels of as many taps or fewer; in aligned rows of as many, or a pixel's taps are added up in
// another order.
static const char *random_kernel(const struct hold *hold)
{
    const int taps = kernel_named(hold->kernel).width;
    for (;;) {
        const char *name = kernels[below(WEFT_COUNT(kernels))];
        const int width = kernel_named(name).width;
        if (hold->layout == WEFT_LAYOUT_ALIGNED ? width == taps : width <= taps)
            return name;
    }
}

struct totals {
    int slices, tiled, clamped;
    uint64_t evicted;
};

static void check_hold(weft_volume *volume, const struct hold *hold, struct totals *totals)
{
    static float alone[PIXELS], shared[PIXELS];
    struct weft_resident_params how = {.volume = volume,
                                       .context = contexts[0],
                                       .kernel = kernel_named(hold->kernel),
                                       .layout = hold->layout,
                                       .source = hold->source,
                                       .low = -0.5,
                                       .high = 0.7,
                                       .log = &log_to_stderr};
    weft_resident *resident = make_resident(&how);
    const struct weft_resident_info *info = weft_resident_get_info(resident);
    if (hold->blocks) {
        how.memory_bytes = hold->blocks * info->block_bytes;
        weft_resident_destroy(&resident);
        resident = make_resident(&how);
        info = weft_resident_get_info(resident);
        assert_int_equal(info->capacity, hold->blocks);
    }
    for (int i = 0; i < 6; i++) {
        const struct weft_slice_geometry g = random_plane();
        struct weft_slice_params params = params_of(&g, random_kernel(hold));
        struct weft_slice_report report;
        params.layout = hold->layout;
        params.source = hold->source;
        params.low = how.low;
        params.high = how.high;
        params.without = WEFT_SAVING_CONSTANT; // whose cells blocks may be too large for
        params.clamp_to_samples = below(4) == 0;
        if (params.source >= WEFT_SOURCE_UNORM16 && volume->info.name[0] == 'u')
            continue; // which hold no NaN
        run_slice(volume, &params, alone, NULL);
        params.resident = resident;
        run_slice(volume, &params, shared, &report);
        assert_int_equal(count_different(alone, shared), 0);
        assert_true(info->blocks <= info->capacity);
        totals->slices++;
        totals->clamped += params.clamp_to_samples;
        totals->tiled += report.passes > 1;
    }
    totals->evicted += info->evicted;
    weft_resident_destroy(&resident);
}

static void slices_are_the_same_bytes(void **state)
{
    (void)state;
    struct totals totals = {0};
    random_state = 1;
    for (int content = 0; content < CONTENTS; content++) {
        for (int clamped = 0; clamped < 2; clamped++) {
            weft_volume *volume = make_volume((enum content)content, clamped);
            strcpy(volume->info.name, content == UNFIT ? "unfit" : "fit");
            for (size_t h = 0; h < WEFT_COUNT(holds); h++)
                check_hold(volume, &holds[h], &totals);
            weft_volume_destroy(&volume);
        }
    }
    assert_true(totals.slices >= 160 && totals.clamped > 20 && totals.tiled > 20);
    assert_true(totals.evicted > 1000);
}

// ---- counts -------------------------------------------------------------------------------------

static const struct weft_slice_geometry oblique = {{2, 7, 4}, {28, 9, 6}, {-5, 25, 10}, 70, 60};

static weft_resident *hold_volume(weft_volume *volume, const char *kernel, uint64_t blocks)
{
    const struct weft_resident_params *how =
        weft_resident_params(.volume = volume, .context = contexts[0],
                             .kernel = kernel_named(kernel), .log = &log_to_stderr);
    weft_resident *resident = make_resident(how);
    if (!blocks)
        return resident;
    struct weft_resident_params limited = *how;
    limited.memory_bytes = blocks * weft_resident_get_info(resident)->block_bytes;
    weft_resident_destroy(&resident);
    return make_resident(&limited);
}

static size_t count_cells(weft_volume *volume, const struct weft_slice_params *params)
{
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, params, &plan), WEFT_OK);
    const size_t count = plan->cells->map.count;
    weft_slice_plan_destroy(&plan);
    return count;
}

static void nothing_is_read_or_laid_out_twice(void **state)
{
    static float alone[PIXELS], first[PIXELS], second[PIXELS];
    (void)state;
    random_state = 2;
    struct distant *distant;
    weft_volume *base = make_volume(NOISE, false), *volume = make_distant(base, &distant);
    struct weft_slice_params params = params_of(&oblique, "catmull-rom");
    struct weft_slice_report report;
    run_slice(base, &params, alone, NULL);
    const size_t cells = count_cells(base, &params);
    weft_resident *resident = hold_volume(volume, "lanczos:3", 0);
    const struct weft_resident_info *info = weft_resident_get_info(resident);
    params.resident = resident;
    run_slice(volume, &params, first, &report);
    const uint64_t laid_out = info->laid_out, bricks = distant->bricks_read;
    assert_int_equal(count_different(alone, first), 0);
    assert_true(laid_out > 0 && laid_out <= cells && info->blocks == laid_out);
    assert_int_equal(info->reused, 0);
    assert_true(bricks > 0 && bricks <= base->info.bricks);
    assert_int_equal(info->bricks_read, bricks);
    // run_slice measured the voxels in reach, too: from the same bricks.
    assert_int_equal(report.bricks_read, bricks);
    run_slice(volume, &params, second, &report);
    assert_int_equal(count_different(alone, second), 0);
    assert_int_equal(info->laid_out, laid_out);
    assert_int_equal(info->reused, laid_out);
    assert_int_equal(distant->bricks_read, bricks);
    assert_int_equal(report.bricks_read, 0);
    // A plane beside it needs some more of both, and none of what is there again.
    params.geometry.origin[2] += 3.0;
    run_slice(volume, &params, second, NULL);
    assert_true(info->laid_out > laid_out && info->reused > laid_out);
    assert_true(distant->bricks_read <= base->info.bricks);
    // Neither do planes across an axis, which read bricks.
    for (int pass = 0; pass < 2; pass++) {
        const uint64_t before = distant->bricks_read, blocks = info->laid_out;
        for (int i = 0; i < 4; i++) {
            params.geometry =
                (struct weft_slice_geometry){{2, 7, 8 + 7 * i}, {30, 0, 0}, {0, 30, 0}, 70, 60};
            run_slice(volume, &params, second, NULL);
        }
        assert_true(pass == 0 || distant->bricks_read == before);
        assert_int_equal(info->laid_out, blocks);
    }
    assert_true(distant->bricks_read <= base->info.bricks);
    weft_resident_destroy(&resident);
    weft_volume_destroy(&volume);
    weft_volume_destroy(&base);
}

// Two planes that fit by themselves and not together: what was read last stays.
static void the_least_recently_read_gives_way(void **state)
{
    static float pixels[PIXELS];
    (void)state;
    random_state = 3;
    weft_volume *volume = make_volume(NOISE, false);
    struct weft_slice_params near = params_of(&oblique, "catmull-rom"), far = near;
    far.geometry.origin[2] += 16.0; // no cell of the near one
    const size_t a = count_cells(volume, &near), b = count_cells(volume, &far);
    weft_resident *resident = hold_volume(volume, "catmull-rom", a > b ? a : b);
    const struct weft_resident_info *info = weft_resident_get_info(resident);
    near.resident = far.resident = resident;
    run_slice(volume, &near, pixels, NULL);
    const uint64_t own = info->laid_out;
    run_slice(volume, &near, pixels, NULL);
    assert_int_equal(info->laid_out, own);
    assert_int_equal(info->evicted, 0);
    run_slice(volume, &far, pixels, NULL);
    assert_true(info->evicted > 0 && info->evicted <= own);
    // Of the other blocks some are still there.
    const uint64_t before = info->laid_out;
    run_slice(volume, &far, pixels, NULL);
    assert_int_equal(info->laid_out, before);
    assert_true(info->blocks <= info->capacity);
    weft_resident_destroy(&resident);
    weft_volume_destroy(&volume);
}

// ---- what does not fit, or fails ----------------------------------------------------------------

static void a_tile_that_does_not_fit_is_refused(void **state)
{
    (void)state;
    random_state = 4;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_volume *volume = make_volume(NOISE, false);
    weft_resident *resident = hold_volume(volume, "catmull-rom", 3);
    // Pixels 4 voxels apart: 16 x 16 of them meet more than three cells.
    struct weft_slice_params params = params_of(&oblique, "catmull-rom");
    params.geometry = (struct weft_slice_geometry){{2, 7, 4}, {30, 3, 3}, {-3, 30, 5}, 8, 8};
    params.resident = resident;
    params.log = &log;
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_ERR_LIMIT);
    assert_null(plan);
    assert_int_equal(message.count, 1);
    unsigned long needed = 0, places = 0;
    assert_int_equal(sscanf(message.text,
                            "the smallest tile of the slice needs %lu blocks; the resident volume "
                            "has places for %lu",
                            &needed, &places),
                     2);
    assert_true(needed > 3);
    assert_int_equal(places, 3);
    weft_resident_destroy(&resident);
    // A budget without room for one block.
    assert_int_equal(
        weft_resident_create(weft_resident_params(.volume = volume, .context = contexts[0],
                                                  .memory_bytes = 100, .log = &log),
                             &resident),
        WEFT_ERR_LIMIT);
    assert_null(resident);
    assert_non_null(strstr(message.text, "the budget is 100"));
    weft_volume_destroy(&volume);
}

// Stops at the n-th look.
struct stopper {
    int left;
};

static bool stop(void *priv, double fraction)
{
    struct stopper *s = priv;
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    return s->left-- > 0;
}

// A run that is cancelled, or a volume that fails, after n calls; then one that is let be.
static void interrupted_runs_leave_a_valid_state(void **state)
{
    static float alone[PIXELS], shared[PIXELS];
    (void)state;
    random_state = 5;
    struct distant *distant;
    weft_volume *base = make_volume(UNFIT, true), *volume = make_distant(base, &distant);
    weft_resident *resident = hold_volume(volume, "catmull-rom", 20);
    int cancelled = 0, failed = 0;
    for (int n = 0; n < 24; n++) {
        const struct weft_slice_geometry g = random_plane();
        struct weft_slice_params params = params_of(&g, "catmull-rom");
        params.layout = WEFT_LAYOUT_INTERLEAVED;
        run_slice(base, &params, alone, NULL);
        struct stopper stopper = {n / 2};
        const struct weft_progress progress = {stop, &stopper};
        weft_slice_plan *plan = NULL;
        weft_slice *slice = NULL;
        params.resident = resident;
        params.log = NULL;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
        assert_int_equal(
            weft_slice_compile(plan, weft_slice_compile_params(.context = contexts[0]), &slice),
            WEFT_OK);
        if (n % 2)
            distant->calls_left = n / 4;
        const enum weft_result res = weft_slice_run(
            slice, weft_slice_run_params(.pixels = shared, .progress = n % 2 ? NULL : &progress),
            NULL);
        assert_true(res == WEFT_OK || res == (n % 2 ? WEFT_ERR_READER : WEFT_ERR_CANCELLED));
        cancelled += res == WEFT_ERR_CANCELLED;
        failed += res == WEFT_ERR_READER;
        distant->calls_left = -1;
        assert_int_equal(weft_slice_run(slice, weft_slice_run_params(.pixels = shared), NULL),
                         WEFT_OK);
        assert_int_equal(count_different(alone, shared), 0);
        weft_slice_destroy(&slice);
        weft_slice_plan_destroy(&plan);
    }
    assert_true(cancelled > 3 && failed > 1);
    weft_resident_destroy(&resident);
    weft_volume_destroy(&volume);
    weft_volume_destroy(&base);
}

// ---- coefficients, and cheaper pieces -----------------------------------------------------------

static void coefficients_are_one_kernels(void **state)
{
    static float alone[PIXELS], shared[PIXELS];
    (void)state;
    random_state = 6;
    int slices = 0;
    for (int clamped = 0; clamped < 2; clamped++) {
        struct distant *distant;
        weft_volume *base = make_volume(SPARSE, clamped), *volume = make_distant(base, &distant);
        weft_resident *resident = hold_volume(volume, "bspline3i", 24);
        for (int i = 0; i < 5; i++, slices++) {
            const struct weft_slice_geometry g = random_plane();
            struct weft_slice_params params = params_of(&g, "bspline3i");
            params.without = WEFT_SAVING_CONSTANT;
            params.layout = WEFT_LAYOUT_INTERLEAVED;
            run_slice(base, &params, alone, NULL);
            params.resident = resident;
            run_slice(volume, &params, shared, NULL);
            assert_int_equal(count_different(alone, shared), 0);
        }
        assert_true(distant->bricks_read <= base->info.bricks);
        struct weft_slice_params plain = params_of(&oblique, "bspline3");
        weft_slice_plan *plan = NULL;
        plain.resident = resident;
        plain.log = NULL;
        assert_int_equal(weft_slice_plan_create(volume, &plain, &plan), WEFT_ERR_ARGUMENT);
        weft_resident_destroy(&resident);
        resident = hold_volume(volume, "bspline3", 0);
        plain = params_of(&oblique, "bspline3i");
        plain.resident = resident;
        plain.log = NULL;
        assert_int_equal(weft_slice_plan_create(volume, &plain, &plan), WEFT_ERR_ARGUMENT);
        plain.kernel = kernel_named("lanczos:3"); // of more taps
        assert_int_equal(weft_slice_plan_create(volume, &plain, &plan), WEFT_ERR_ARGUMENT);
        weft_resident_destroy(&resident);
        weft_volume_destroy(&volume);
        weft_volume_destroy(&base);
    }
    assert_int_equal(slices, 10);
}

// With savings that go by cells pixels may differ, and are within the bound of each other; where
// the constant is 0 they do not.
static void savings_stay_within_the_bound(void **state)
{
    static float alone[PIXELS], shared[PIXELS];
    (void)state;
    random_state = 7;
    weft_volume *volumes[2] = {make_volume(SPARSE, false), make_volume(SMOOTH, false)};
    weft_resident *residents[2];
    for (int v = 0; v < 2; v++)
        residents[v] = hold_volume(volumes[v], "catmull-rom", 0);
    uint64_t constant = 0, smooth = 0;
    for (int i = 0; i < 24; i++) {
        const struct weft_slice_geometry g = random_plane();
        struct weft_slice_params params = params_of(&g, i % 2 ? "catmull-rom" : "linear");
        struct weft_slice_report report;
        weft_volume *volume = volumes[i >= 12];
        params.layout = WEFT_LAYOUT_INTERLEAVED;
        params.smooth_error = i < 12 ? 0.0 : i % 4 > 1 ? 0.02 : 1.0;
        const double bound = run_slice(volume, &params, alone, NULL);
        params.resident = residents[i >= 12];
        run_slice(volume, &params, shared, &report);
        if (i < 12)
            assert_int_equal(count_different(alone, shared), 0);
        assert_true(largest_difference(alone, shared) <= 2.0 * bound);
        constant += report.cells_constant;
        smooth += report.cells_smooth;
    }
    assert_true(constant > 0 && smooth > 0);
    for (int v = 0; v < 2; v++) {
        weft_resident_destroy(&residents[v]);
        weft_volume_destroy(&volumes[v]);
    }
}

// ---- in memory ----------------------------------------------------------------------------------

// Taps lie where the header of resident volumes says.
static void blocks_in_memory_hold_the_voxels(void **state)
{
    (void)state;
    random_state = 8;
    uint64_t taps = 0;
    for (int i = 0; i < 8; i++) {
        weft_volume *volume = make_volume(i % 2 ? UNFIT : NOISE, i % 4 > 1);
        struct weft_slice_params params = params_of(&oblique, kernels[i % 6]);
        weft_resident *resident = make_resident(
            weft_resident_params(.volume = volume, .kernel = kernel_named("lanczos:3"),
                                 .log = &log_to_stderr));
        struct weft_slice_blocks blocks;
        weft_slice_plan *plan = NULL;
        params.engine = WEFT_ENGINE_CPU;
        params.resident = resident;
        params.without = WEFT_SAVING_CONSTANT;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
        assert_int_equal(weft_slice_blocks_create(plan, &blocks), WEFT_OK);
        assert_int_equal(weft_resident_load(resident, plan, 0, NULL, &blocks), WEFT_OK);
        struct weft_brick_cursor cursor = {.store = weft_volume_in_memory(volume)->store};
        const struct weft_slice_cells *cells = plan->tile_plans[0].cells;
        const int width = plan->info.kernel.width, offset = plan->footprint->grid.tap_offset;
        for (size_t c = 0; c < cells->map.count; c++) {
            const int start[3] = {below(8), below(8), below(8)};
            int at[3];
            for (int a = 0; a < 3; a++)
                at[a] = start[a] + blocks.lead;
            const float *first = (const float *)blocks.texels + blocks.entries[c] +
                                 weft_block_layout_offset(&blocks.layout, at);
            const int32_t *key = cells->map.keys[c].at;
            for (int t = 0; t < width * width * width; t++, taps++) {
                const int x = t % width, y = t / width % width, z = t / width / width;
                const float stored =
                    first[(z * blocks.layout.span[1] + y) * blocks.layout.row_texels + x];
                const float voxel = weft_brick_cursor_voxel(
                    &cursor, key[0] * 8 + start[0] - offset + x, key[1] * 8 + start[1] - offset + y,
                    key[2] * 8 + start[2] - offset + z);
                assert_true(stored == (isfinite(voxel) ? voxel : 0.0f));
            }
        }
        assert_true(blocks.any_unfit == (i % 2 != 0));
        weft_slice_blocks_destroy(&blocks);
        weft_slice_plan_destroy(&plan);
        weft_resident_destroy(&resident);
        weft_volume_destroy(&volume);
    }
    assert_true(taps > 10000);
}

// ---- what is made in GL -------------------------------------------------------------------------

static int made;
static PFNGLGENBUFFERSPROC gen_buffers;
static PFNGLGENTEXTURESPROC gen_textures;
static PFNGLGENFRAMEBUFFERSPROC gen_framebuffers;
static PFNGLCREATEPROGRAMPROC create_program;
static PFNGLBUFFERDATAPROC buffer_data;
static PFNGLTEXIMAGE2DPROC tex_image;

static void GLAD_API_PTR count_buffers(GLsizei n, GLuint *names)
{
    made += n;
    gen_buffers(n, names);
}

static void GLAD_API_PTR count_textures(GLsizei n, GLuint *names)
{
    made += n;
    gen_textures(n, names);
}

static void GLAD_API_PTR count_framebuffers(GLsizei n, GLuint *names)
{
    made += n;
    gen_framebuffers(n, names);
}

static GLuint GLAD_API_PTR count_program(void)
{
    made++;
    return create_program();
}

static void GLAD_API_PTR count_data(GLenum target, GLsizeiptr size, const void *data, GLenum usage)
{
    made++;
    buffer_data(target, size, data, usage);
}

static void GLAD_API_PTR count_image(GLenum target, GLint level, GLint format, GLsizei width,
                                     GLsizei height, GLint border, GLenum channels, GLenum type,
                                     const void *texels)
{
    made++;
    tex_image(target, level, format, width, height, border, channels, type, texels);
}

// Hands what makes objects, or their storage, through a counter; and back.
static void count_objects(GladGLContext *gl)
{
    gen_buffers = gl->GenBuffers;
    gen_textures = gl->GenTextures;
    gen_framebuffers = gl->GenFramebuffers;
    create_program = gl->CreateProgram;
    buffer_data = gl->BufferData;
    tex_image = gl->TexImage2D;
    gl->GenBuffers = count_buffers;
    gl->GenTextures = count_textures;
    gl->GenFramebuffers = count_framebuffers;
    gl->CreateProgram = count_program;
    gl->BufferData = count_data;
    gl->TexImage2D = count_image;
}

static void stop_counting(GladGLContext *gl)
{
    gl->GenBuffers = gen_buffers;
    gl->GenTextures = gen_textures;
    gl->GenFramebuffers = gen_framebuffers;
    gl->CreateProgram = create_program;
    gl->BufferData = buffer_data;
    gl->TexImage2D = tex_image;
}

// The first slice makes them; those after it, of other planes and narrower kernels, none.
static void a_sweep_makes_nothing_anew(void **state)
{
    static float pixels[PIXELS];
    (void)state;
    random_state = 9;
    weft_volume *volume = make_volume(NOISE, false);
    weft_resident *resident = hold_volume(volume, "lanczos:3", 0);
    struct weft_slice_params params = params_of(&oblique, "lanczos:3");
    params.resident = resident;
    made = 0;
    count_objects(&contexts[0]->gl);
    run_slice(volume, &params, pixels, NULL);
    const int first = made;
    for (int i = 0; i < 40; i++) {
        params.geometry.origin[2] = 4.0 + 0.5 * i;
        run_slice(volume, &params, pixels, NULL);
    }
    assert_int_equal(made, first);
    // Of another kernel, its program; and in a smaller slice nothing.
    params.kernel = kernel_named("catmull-rom");
    run_slice(volume, &params, pixels, NULL);
    assert_true(made <= first + 1);
    const int second = made;
    params.geometry.width = 30;
    for (int i = 0; i < 5; i++)
        run_slice(volume, &params, pixels, NULL);
    assert_int_equal(made, second);
    // Planes across an axis, filtered one axis after the other, which all are alike.
    static float alone[PIXELS];
    params =
        params_of(&(struct weft_slice_geometry){{2, 7, 8}, {30, 0, 0}, {0, 30, 0}, WIDTH, HEIGHT},
                  "catmull-rom");
    params.resident = resident;
    run_slice(volume, &params, pixels, NULL);
    const int third = made;
    assert_true(third > second);
    for (int i = 0; i < 10; i++) {
        params.geometry.origin[2] = 8.0 + 1.7 * i;
        run_slice(volume, &params, pixels, NULL);
    }
    assert_int_equal(made, third);
    params.resident = NULL;
    run_slice(volume, &params, alone, NULL);
    assert_int_equal(count_different(alone, pixels), 0);
    // Another size is another filter, and so is what comes after it.
    params.resident = resident;
    params.geometry.height = HEIGHT / 2;
    run_slice(volume, &params, pixels, NULL);
    params.geometry.height = HEIGHT;
    run_slice(volume, &params, pixels, NULL);
    assert_int_equal(count_different(alone, pixels), 0);
    stop_counting(&contexts[0]->gl);
    assert_true(first > 5);
    weft_resident_destroy(&resident);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_are_the_same_bytes),
        cmocka_unit_test(nothing_is_read_or_laid_out_twice),
        cmocka_unit_test(the_least_recently_read_gives_way),
        cmocka_unit_test(a_tile_that_does_not_fit_is_refused),
        cmocka_unit_test(interrupted_runs_leave_a_valid_state),
        cmocka_unit_test(coefficients_are_one_kernels),
        cmocka_unit_test(savings_stay_within_the_bound),
        cmocka_unit_test(blocks_in_memory_hold_the_voxels),
        cmocka_unit_test(a_sweep_makes_nothing_anew),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
