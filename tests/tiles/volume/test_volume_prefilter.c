// SPDX-License-Identifier: BSD-3-Clause
// Volumes of coefficients, against the line filter over everything at once.
#include "tiles/volume/volume.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/samples.h"
#include "tests/support/common.h"
#include "tests/support/data.h"
#include "filter/kernels/prefilter.h"
#include "filter/analysis/reference.h"
#include "tiles/volume/brick_store.h"

enum { MARGIN = 48 }; // where data ends nothing changes any more

static float noise(int x, int y, int z)
{
    uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)z * 83492791u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (float)((double)(h ^ h >> 16) / 2147483647.5 - 1.0);
}

static const struct weft_region everywhere = {
    {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
    {WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT},
    0,
    {{{0}, 0, 0}}};

static weft_volume *make_dense(int nx, int ny, int nz, float background, float odd_one)
{
    float *data = malloc((size_t)nx * (size_t)ny * (size_t)nz * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < nx * ny * nz; i++)
        data[i] = noise(i % nx, i / nx % ny, i / nx / ny);
    data[(nz / 2 * ny + ny / 2) * nx + nx / 2] = odd_one;
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {nx, ny, nz}, .origin = {-3, 5, 1},
                                              .data = data, .background = background),
                           &volume),
        WEFT_OK);
    free(data);
    return volume;
}

// Two bricks, a tile of 8 and one of 128, far from each other and near.
static weft_volume *make_sparse(void)
{
    static const int32_t origins[2][3] = {{-8, 0, 0}, {64, 64, -8}};
    static const struct weft_volume_tile tiles[2] = {{{16, 16, 0}, 8, 0.75f}, {{0}, 128, 0.5f}};
    struct weft_volume_tile moved[2] = {tiles[0], tiles[1]};
    float values[2 * WEFT_BRICK_VOXELS];
    weft_volume *volume = NULL;
    moved[0].origin[2] = -32;
    for (int i = 0; i < 2 * WEFT_BRICK_VOXELS; i++)
        values[i] = noise(i, 0, 0);
    const struct weft_volume_bricks_params params = {.brick_count = 2,
                                                     .brick_origin = origins,
                                                     .brick_values = values,
                                                     .tile_count = 2,
                                                     .tiles = moved,
                                                     .background = -0.25f,
                                                     .log = &log_to_stderr};
    assert_int_equal(weft_volume_create_bricks(&params, &volume), WEFT_OK);
    return volume;
}

static weft_volume *prefilter(weft_volume *base, const char *name)
{
    const struct weft_kernel kernel = kernel_named(name);
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_prefilter(&log_to_stderr, base, &kernel, &volume), WEFT_OK);
    return volume;
}

struct whole {
    struct weft_brick_list list;
    float *values;
    weft_brick_store *store;
};

static struct whole load(weft_volume *volume, const struct weft_region *region)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct whole whole = {0};
    assert_int_equal(weft_volume_find(volume, region, &whole.list), WEFT_OK);
    whole.values = malloc(whole.list.brick_count * 2048 + 1);
    assert_non_null(whole.values);
    assert_int_equal(weft_volume_read(volume, whole.list.brick_count,
                                      (const int32_t(*)[3])whole.list.brick_origin, whole.values),
                     WEFT_OK);
    assert_int_equal(weft_brick_store_create(NULL, 0, info->background, &whole.store), WEFT_OK);
    assert_int_equal(weft_brick_store_add_list(whole.store, &whole.list, whole.values), WEFT_OK);
    assert_int_equal(weft_brick_store_check_disjoint(whole.store), WEFT_OK);
    if (info->clamp_to_edge)
        weft_brick_store_clamp(whole.store, info->active_min, info->active_max);
    return whole;
}

static void unload(struct whole *whole)
{
    weft_brick_store_destroy(&whole->store);
    weft_brick_list_clear(&whole->list);
    free(whole->values);
}

// ---- the truth ----------------------------------------------------------------------------------

struct dense {
    int32_t min[3];
    int size[3];
    double *values;
    double largest; // |voxel|
};

// Everything, and room around it. No voxel is missing.
static struct dense filter_all(weft_volume *base, const char *name)
{
    const struct weft_kernel kernel = kernel_named(name);
    const struct weft_volume_info *info = weft_volume_get_info(base);
    struct weft_prefilter p;
    struct dense d = {.values = NULL};
    struct whole whole = load(base, &everywhere);
    assert_int_equal(weft_prefilter_compute(NULL, &kernel, &p), WEFT_OK);
    for (int a = 0; a < 3; a++) {
        d.min[a] = info->active_min[a] - MARGIN;
        d.size[a] = info->active_max[a] - info->active_min[a] + 1 + 2 * MARGIN;
    }
    const ptrdiff_t stride[3] = {1, d.size[0], (ptrdiff_t)d.size[0] * d.size[1]};
    const ptrdiff_t count = stride[2] * d.size[2];
    struct weft_brick_cursor cursor = {.store = whole.store};
    d.values = malloc((size_t)count * sizeof *d.values);
    assert_non_null(d.values);
    for (ptrdiff_t i = 0; i < count; i++) {
        const float voxel = weft_brick_cursor_voxel(&cursor, d.min[0] + (int32_t)(i % stride[1]),
                                                    d.min[1] + (int32_t)(i / stride[1] % d.size[1]),
                                                    d.min[2] + (int32_t)(i / stride[2]));
        assert_true(isfinite(voxel));
        d.values[i] = (double)voxel;
        d.largest = fmax(d.largest, fabs(d.values[i]));
    }
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (int i = 0; i < d.size[b]; i++)
            for (int j = 0; j < d.size[c]; j++)
                weft_prefilter_line(&p, d.values + i * stride[b] + j * stride[c], (size_t)d.size[a],
                                    stride[a], NAN, NAN);
    }
    unload(&whole);
    return d;
}

static double coefficient(const struct dense *d, const int32_t at[3])
{
    size_t i = 0;
    for (int a = 2; a >= 0; a--)
        i = i * (size_t)d->size[a] + (size_t)(at[a] - d->min[a]);
    return d->values[i];
}

// As the header says, all of them finite as the voxels are. Returns the largest difference,
// relative to the largest |voxel|.
static double assert_coefficients(const struct dense *d, const weft_brick_store *store,
                                  const char *name, const struct weft_region *within)
{
    const struct weft_kernel kernel = kernel_named(name);
    struct weft_prefilter p;
    assert_int_equal(weft_prefilter_compute(NULL, &kernel, &p), WEFT_OK);
    struct weft_brick_cursor cursor = {.store = store};
    double worst = 0.0;
    int compared = 0;
    int32_t at[3], low[3], high[3];
    for (int a = 0; a < 3; a++) {
        low[a] = within->min[a] > d->min[a] ? within->min[a] : d->min[a];
        high[a] = d->min[a] + d->size[a] - 1;
        high[a] = within->max[a] < high[a] ? within->max[a] : high[a];
    }
    for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                const double value = weft_brick_cursor_voxel(&cursor, at[0], at[1], at[2]);
                const double expected = coefficient(d, at);
                const double bound =
                    3.0 * p.gain * p.gain * WEFT_VOLUME_PREFILTER_ERROR * d->largest +
                    0x1p-24 * fabs(expected);
                if (!(fabs(value - expected) <= bound))
                    fail_msg("%s at (%d, %d, %d): %.9g instead of %.9g", name, at[0], at[1], at[2],
                             value, expected);
                worst = fmax(worst, fabs(value - expected) / d->largest);
                compared++;
            }
    assert_true(compared > 0);
    return worst;
}

// ---- tests --------------------------------------------------------------------------------------

static void dense_volumes_are_filtered_everywhere(void **state)
{
    (void)state;
    static const char *const names[] = {"bspline2i", "bspline3i", "bspline5i", "bspline7i"};
    static const float backgrounds[] = {NAN, 0.25f};
    for (size_t b = 0; b < WEFT_COUNT(backgrounds); b++) {
        weft_volume *base = make_dense(21, 10, 33, backgrounds[b], 0.5f);
        for (size_t i = 0; i < WEFT_COUNT(names); i++) {
            weft_volume *volume = prefilter(base, names[i]);
            struct dense d = filter_all(base, names[i]);
            struct whole whole = load(volume, &everywhere);
            const double worst = assert_coefficients(&d, whole.store, names[i], &everywhere);
            print_message("%s, background %g: %.3g\n", names[i], (double)backgrounds[b], worst);
            unload(&whole);
            free(d.values);
            weft_volume_destroy(&volume);
        }
        weft_volume_destroy(&base);
    }
}

static void sparse_volumes_keep_their_constant_regions(void **state)
{
    (void)state;
    weft_volume *base = make_sparse(), *volume = prefilter(base, "bspline3i");
    struct dense d = filter_all(base, "bspline3i");
    struct whole whole = load(volume, &everywhere);
    assert_coefficients(&d, whole.store, "bspline3i", &everywhere);
    bool inner = false;
    for (size_t i = 0; i < whole.list.tile_count; i++) {
        assert_true(whole.list.tiles[i].size == 8 && whole.list.tiles[i].value == 0.5f);
        inner =
            inner || (whole.list.tiles[i].origin[0] == 64 && whole.list.tiles[i].origin[1] == 64 &&
                      whole.list.tiles[i].origin[2] == 64);
    }
    assert_true(inner);
    // Deep in the tile and far outside nothing is left of the borders.
    assert_true(brick_voxel(whole.store, 64, 64, 64) == 0.5f);
    assert_true(brick_voxel(whole.store, 16, 64, 64) == 0.5f);
    assert_true(brick_voxel(whole.store, -40, -40, 64) == -0.25f);
    assert_true(brick_voxel(whole.store, -1, 64, 64) != -0.25f);
    unload(&whole);
    free(d.values);
    weft_volume_destroy(&volume);
    weft_volume_destroy(&base);
}

static void regions_find_what_lies_in_them(void **state)
{
    (void)state;
    weft_volume *base = make_sparse(), *volume = prefilter(base, "bspline3i");
    struct dense d = filter_all(base, "bspline3i");
    const struct weft_region regions[] = {
        {{-20, -20, -20}, {40, 40, 40}, 0, {{{0}, 0, 0}}},
        {{60, 60, 60}, {61, 61, 61}, 0, {{{0}, 0, 0}}},
        {{-30, 60, -14}, {200, 60, -14}, 0, {{{0}, 0, 0}}},
        {{-40, -40, -40}, {170, 170, 170}, 1, {{{0.3, 0.5, -0.8}, 3.0, 4.0}}},
    };
    for (size_t i = 0; i < WEFT_COUNT(regions); i++) {
        struct whole whole = load(volume, &regions[i]);
        if (!regions[i].slab_count)
            assert_coefficients(&d, whole.store, "bspline3i", &regions[i]);
        struct whole all = load(volume, &everywhere);
        // What a region lists is what everything lists and the region meets.
        for (size_t n = 0; n < whole.list.brick_count; n++) {
            const float *values;
            float constant;
            assert_int_equal(
                weft_brick_store_find(all.store, whole.list.brick_origin[n], &values, &constant),
                WEFT_BRICK_VALUES);
            assert_memory_equal(values, whole.values + n * WEFT_BRICK_VOXELS, 2048);
        }
        unload(&all);
        unload(&whole);
    }
    free(d.values);
    weft_volume_destroy(&volume);
    weft_volume_destroy(&base);
}

static void bytes_do_not_depend_on_what_else_is_read(void **state)
{
    (void)state;
    static const char *const names[] = {"bspline3i", "bspline6i"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        weft_volume *base = make_dense(90, 20, 75, 0.0f, NAN), *volume = prefilter(base, names[i]);
        struct whole whole = load(volume, &everywhere);
        float *values = malloc(whole.list.brick_count * 2048);
        int32_t(*reversed)[3] = malloc(whole.list.brick_count * sizeof *reversed);
        assert_true(values && reversed);
        for (size_t n = 0; n < whole.list.brick_count; n += 7) {
            assert_int_equal(weft_volume_read(volume, 1,
                                              (const int32_t(*)[3])whole.list.brick_origin + n,
                                              values),
                             WEFT_OK);
            assert_memory_equal(values, whole.values + n * WEFT_BRICK_VOXELS, 2048);
        }
        const size_t count = whole.list.brick_count / 2;
        for (size_t n = 0; n < count; n++)
            memcpy(reversed[n], whole.list.brick_origin[2 * (count - 1 - n)], sizeof *reversed);
        assert_int_equal(weft_volume_read(volume, count, (const int32_t(*)[3])reversed, values),
                         WEFT_OK);
        for (size_t n = 0; n < count; n++)
            assert_memory_equal(values + n * WEFT_BRICK_VOXELS,
                                whole.values + 2 * (count - 1 - n) * WEFT_BRICK_VOXELS, 2048);
        free(values);
        free(reversed);
        unload(&whole);
        weft_volume_destroy(&volume);
        weft_volume_destroy(&base);
    }
}

// sum over missing voxels of |inverse filter|, from its poles.
static double dependence(const struct weft_prefilter *p, const int32_t (*missing)[3], int count,
                         const int32_t at[3])
{
    double total = 0.0;
    for (int i = 0; i < count; i++) {
        double product = 1.0;
        for (int a = 0; a < 3; a++) {
            double tap = 0.0;
            for (int k = 0; k < p->poles; k++)
                tap += p->factor[k] * pow(p->pole[k], abs(at[a] - missing[i][a]));
            product *= fabs(tap);
        }
        total += product;
    }
    return total;
}

enum { SIDE = 20, HOLES = 3 };
static const int32_t holes[HOLES][3] = {{7, 15, 11}, {9, 15, 12}, {-3, 5, 1}};

static weft_volume *make_holes(float value, float background)
{
    float *data = malloc(SIDE * SIDE * SIDE * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        data[i] = noise(i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE);
    for (int i = 0; i < HOLES; i++)
        data[((holes[i][2] - 1) * SIDE + holes[i][1] - 5) * SIDE + holes[i][0] + 3] = value;
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .origin = {-3, 5, 1},
                                              .data = data, .background = background),
                           &volume),
        WEFT_OK);
    free(data);
    return volume;
}

// What is finite is what any missing voxels would have made of it; what is not depends on them.
static void what_depends_on_missing_voxels_is_missing(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        float odd, background;
    } cases[] = {{"bspline3i", NAN, 0.125f},
                 {"bspline3i", INFINITY, 1e6f},
                 {"bspline2i", -INFINITY, 0.0f},
                 {"omomsi", NAN, -0.5f}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        weft_volume *base = make_holes(cases[i].odd, cases[i].background);
        weft_volume *volume = prefilter(base, cases[i].kernel);
        struct whole whole = load(volume, &everywhere);
        struct weft_brick_cursor cursor = {.store = whole.store};
        struct weft_prefilter p;
        assert_int_equal(weft_prefilter_compute(NULL, &kernel, &p), WEFT_OK);
        const double off = 3.0 * p.gain * p.gain * WEFT_VOLUME_PREFILTER_ERROR;
        int there = 0, missing = 0;
        for (int high = 0; high < 2; high++) {
            weft_volume *filled = make_holes(high ? 1.0f : -1.0f, cases[i].background);
            struct dense d = filter_all(filled, cases[i].kernel);
            const double largest = fmax(d.largest, fabs((double)cases[i].background));
            int32_t at[3];
            for (at[2] = 1; at[2] < 1 + SIDE; at[2]++)
                for (at[1] = 5; at[1] < 5 + SIDE; at[1]++)
                    for (at[0] = -3; at[0] < SIDE - 3; at[0]++) {
                        const double value = weft_brick_cursor_voxel(&cursor, at[0], at[1], at[2]);
                        const double depends = dependence(&p, holes, HOLES, at);
                        if (!isfinite(value)) {
                            assert_true(depends > 0.9 * WEFT_PREFILTER_MISSING);
                            missing++;
                            continue;
                        }
                        assert_true(depends < 1.1 * WEFT_PREFILTER_MISSING);
                        const double expected = coefficient(&d, at);
                        assert_near(value, expected,
                                    WEFT_PREFILTER_MISSING + off * largest +
                                        0x1p-24 * fabs(expected),
                                    cases[i].kernel);
                        there++;
                    }
            free(d.values);
            weft_volume_destroy(&filled);
        }
        assert_true(there > 100 && missing > 1000);
        const float at = brick_voxel(whole.store, 7, 15, 11);
        assert_true(isnan(cases[i].odd) ? isnan(at) : at == cases[i].odd);
        unload(&whole);
        weft_volume_destroy(&volume);
        weft_volume_destroy(&base);
    }
}

// Ones in the middle of nothing: 9 (the gain across, twice) sum_k>=n r(k) is 2^-23 at n = 14.
static void a_missing_background_leaves_what_is_far_from_it(void **state)
{
    (void)state;
    const struct weft_volume_tile tile = {{0, 0, 0}, 128, 1.0f};
    const struct weft_volume_bricks_params params = {
        .tile_count = 1, .tiles = &tile, .background = NAN, .log = &log_to_stderr};
    weft_volume *base = NULL;
    assert_int_equal(weft_volume_create_bricks(&params, &base), WEFT_OK);
    weft_volume *volume = prefilter(base, "bspline3i");
    struct whole whole = load(volume, &everywhere);
    for (int32_t x = -20; x < 148; x++) {
        const double value = brick_voxel(whole.store, x, 64, 64);
        const int distance = x < 64 ? x + 1 : 128 - x; // from the nearest missing voxel
        assert_int_equal(isfinite(value), distance > 14);
        if (isfinite(value))
            assert_near(value, 1.0, WEFT_PREFILTER_MISSING + 0x1p-24, "ones");
    }
    unload(&whole);
    weft_volume_destroy(&volume);
    weft_volume_destroy(&base);
}

static double fetch(void *priv, const int64_t index[3])
{
    return weft_brick_cursor_voxel(priv, (int32_t)index[0], (int32_t)index[1], (int32_t)index[2]);
}

// The largest |spline - voxel| at voxels of a region, relative to the largest |voxel|.
static double interpolation_error(weft_volume *base, const char *name,
                                  const struct weft_region *region)
{
    const struct weft_kernel kernel = kernel_named(name);
    weft_volume *volume = prefilter(base, name);
    struct weft_region wide = *region;
    for (int a = 0; a < 3; a++) {
        wide.min[a] -= kernel.width;
        wide.max[a] += kernel.width;
    }
    struct whole voxels = load(base, region), coefficients = load(volume, &wide);
    struct weft_brick_cursor cursor = {.store = coefficients.store};
    double largest = 0.0, worst = 0.0;
    for (int z = region->min[2]; z <= region->max[2]; z++)
        for (int y = region->min[1]; y <= region->max[1]; y++)
            for (int x = region->min[0]; x <= region->max[0]; x++) {
                const double voxel = brick_voxel(voxels.store, x, y, z);
                const double value =
                    weft_reference_compute(&kernel, 3, (double[]){x, y, z}, fetch, &cursor).value;
                largest = fmax(largest, fabs(voxel));
                worst = larger(worst, fabs(value - voxel));
            }
    unload(&voxels);
    unload(&coefficients);
    weft_volume_destroy(&volume);
    return worst / largest;
}

static void the_spline_passes_through_the_voxels(void **state)
{
    (void)state;
    static const char *const names[] = {"bspline2i", "bspline3i", "omomsi"};
    weft_volume *base = make_dense(24, 12, 19, NAN, 0.5f);
    const struct weft_region inside = {{-6, 3, -2}, {24, 19, 22}, 0, {{{0}, 0, 0}}};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        const double error = interpolation_error(base, names[i], &inside);
        print_message("%s, noise: %.3g\n", names[i], error);
        assert_true(error <= 1e-6);
    }
    weft_volume_destroy(&base);
}

static void real_volumes_are_interpolated(void **state)
{
    (void)state;
    static const char *const files[] = {"mri.vdb", "smoke.vdb"};
    int missing = 0;
    for (size_t f = 0; f < WEFT_COUNT(files); f++) {
        weft_volume *base = open_data_volume(files[f]);
        if (!base) {
            missing++;
            continue;
        }
        const struct weft_volume_info *info = weft_volume_get_info(base);
        struct weft_region region = {.slab_count = 0};
        for (int a = 0; a < 3; a++) { // the lower end of the box, where most is background
            region.min[a] = info->active_min[a] + (a < 2 ? 40 : 60);
            region.max[a] = region.min[a] + 40;
        }
        const double error = interpolation_error(base, "bspline3i", &region);
        print_message("%s: %.3g\n", files[f], error);
        assert_true(error <= 1e-6);
        weft_volume_destroy(&base);
    }
    if (missing == WEFT_COUNT(files))
        skip();
}

static void bad_requests_are_named(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    const struct weft_kernel mitchell = kernel_named("mitchell"), cubic = kernel_named("bspline3i");
    weft_volume *base = make_dense(8, 8, 8, 0.0f, 0.0f), *volume = NULL, *far = NULL;
    assert_int_equal(weft_volume_prefilter(&log, base, &mitchell, &volume), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(message.text, "mitchell has no prefilter"));
    assert_null(volume);
    assert_int_equal(weft_volume_prefilter(&log, base, &cubic, &volume), WEFT_OK);
    float values[WEFT_BRICK_VOXELS];
    const int32_t odd[1][3] = {{0, 4, 0}};
    assert_int_equal(weft_volume_read(volume, 1, odd, values), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_volume_save(volume, &(struct weft_volume_save_params){.path = "x.vdb"}),
                     WEFT_ERR_ARGUMENT);
    weft_volume_destroy(&volume);
    const float one[1] = {1.0f};
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {1, 1, 1}, .data = one,
                                                           .origin = {WEFT_INDEX_LIMIT - 20}),
                                        &far),
                     WEFT_OK);
    assert_int_equal(weft_volume_prefilter(&log, far, &cubic, &volume), WEFT_ERR_LIMIT);
    assert_non_null(strstr(message.text, "1073741824"));
    weft_volume_destroy(&far);
    weft_volume_destroy(&base);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dense_volumes_are_filtered_everywhere),
        cmocka_unit_test(sparse_volumes_keep_their_constant_regions),
        cmocka_unit_test(regions_find_what_lies_in_them),
        cmocka_unit_test(bytes_do_not_depend_on_what_else_is_read),
        cmocka_unit_test(what_depends_on_missing_voxels_is_missing),
        cmocka_unit_test(a_missing_background_leaves_what_is_far_from_it),
        cmocka_unit_test(the_spline_passes_through_the_voxels),
        cmocka_unit_test(real_volumes_are_interpolated),
        cmocka_unit_test(bad_requests_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
