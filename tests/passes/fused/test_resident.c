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
enum content { NOISE, SPARSE, UNFIT, CONTENTS };

static weft_volume *make_volume(enum content content, bool clamped)
{
    float *data = malloc((size_t)N * N * N * sizeof *data);
    weft_volume *volume = NULL;
    assert_non_null(data);
    for (int i = 0; i < N * N * N; i++) {
        const int x = i % N, y = i / N % N, z = i / N / N;
        data[i] = content == SPARSE && (x < 20 || y > 25) ? 0.0f : (float)(uniform() - 0.4);
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

__attribute__((unused)) static weft_volume *make_distant(weft_volume *base, struct distant **out)
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
    const double bound = weft_bound_compute(&weft_slice_plan_get_info(plan)->bound, &values).total;
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

__attribute__((unused)) static double largest_difference(const float *a, const float *b)
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
    print_message("%d slices, %d clamped, %d tiled, %llu blocks gave way\n", totals.slices,
                  totals.clamped, totals.tiled, (unsigned long long)totals.evicted);
    assert_true(totals.slices >= 160 && totals.clamped > 20 && totals.tiled > 20);
    assert_true(totals.evicted > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_are_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
