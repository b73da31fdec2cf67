// SPDX-License-Identifier: BSD-3-Clause
// Volumes on other lattices, against sums over all taps in double that are made here from the
// voxels, the map and filter/kernels/stretch.h alone.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include "filter/kernels/stretch.h"
#include "passes/lattice/lattice.h"
#include "tests/support/common.h"
#include "tiles/volume/brick_store.h"

static struct message last;
static const struct weft_log test_log = {keep_message, &last};

// ---- a sparse volume ----------------------------------------------------------------------------

enum { SIDE = 5, BRICKS = SIDE * SIDE * SIDE };

// Bricks here and there in (-16, -16, -16) to (23, 23, 23), and tiles of two sizes beside them.
struct sparse {
    int32_t origin[BRICKS][3];
    float values[BRICKS][WEFT_BRICK_VOXELS];
    size_t bricks;
    struct weft_volume_tile tiles[3];
    size_t tile_count;
    float background;
    const char *grid_class;
    double index_to_world[3][4];
    weft_volume *volume;
    weft_brick_store *store;
};

static double signal(double x, double y, double z)
{
    return 2.0 + sin(0.61 * x + 0.3) * cos(0.43 * y) + 0.7 * sin(0.37 * z - 0.2 * x);
}

static void add_brick(struct sparse *s, int x, int y, int z, double (*f)(double, double, double))
{
    float *values = s->values[s->bricks];
    int32_t *origin = s->origin[s->bricks++];
    origin[0] = x;
    origin[1] = y;
    origin[2] = z;
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++)
        values[v] = (float)f(x + (v & 7), y + (v >> 3 & 7), z + (v >> 6));
}

static void finish_sparse(struct sparse *s)
{
    struct weft_volume_bricks_params params = {.brick_count = s->bricks,
                                               .brick_origin = (const int32_t(*)[3])s->origin,
                                               .brick_values = s->values[0],
                                               .tile_count = s->tile_count,
                                               .tiles = s->tiles,
                                               .background = s->background,
                                               .grid_class = s->grid_class};
    memcpy(params.index_to_world, s->index_to_world, sizeof params.index_to_world);
    assert_int_equal(weft_volume_create_bricks(&params, &s->volume), WEFT_OK);
    assert_int_equal(weft_brick_store_create(NULL, 0, s->background, &s->store), WEFT_OK);
    const struct weft_brick_list list = {s->bricks, s->origin, s->tile_count, s->tiles};
    assert_int_equal(weft_brick_store_add_list(s->store, &list, s->values[0]), WEFT_OK);
}

static void clear_sparse(struct sparse *s)
{
    weft_volume_destroy(&s->volume);
    weft_brick_store_destroy(&s->store);
    free(s);
}

// A fog volume with holes, tiles of 8 and 128 voxels, and a voxel that is not finite.
static struct sparse *make_fog(float background)
{
    struct sparse *s = calloc(1, sizeof *s);
    s->background = background;
    for (int z = -2; z < 3; z++)
        for (int y = -2; y < 3; y++)
            for (int x = -2; x < 3; x++)
                if ((x + 2 * y + 3 * z + 20) % 4 == 0)
                    add_brick(s, 8 * x, 8 * y, 8 * z, signal);
    s->values[3][100] = NAN;
    s->tiles[s->tile_count++] = (struct weft_volume_tile){{24, 0, 0}, 8, 1.7f};
    s->tiles[s->tile_count++] = (struct weft_volume_tile){{128, 0, 0}, 128, -0.3f};
    finish_sparse(s);
    return s;
}

static double sphere(double x, double y, double z)
{
    const double d = 0.5 * (sqrt(x * x + y * y + z * z) - 9.3);
    return d < -1.5 ? -1.5 : d > 1.5 ? 1.5 : d;
}

// A level set of half-width 3 voxels of 0.5: radius 9.3 voxels.
static struct sparse *make_level_set(void)
{
    struct sparse *s = calloc(1, sizeof *s);
    s->background = 1.5f;
    s->grid_class = "level set";
    for (int a = 0; a < 3; a++)
        s->index_to_world[a][a] = 0.5;
    for (int z = -2; z < 2; z++)
        for (int y = -2; y < 2; y++)
            for (int x = -2; x < 2; x++)
                add_brick(s, 8 * x, 8 * y, 8 * z, sphere);
    finish_sparse(s);
    return s;
}

// ---- what comes out -----------------------------------------------------------------------------

// All lots of grid 0, with planes of several components as they are.
struct gathered {
    int components;
    size_t bricks, tiles, brick_capacity, tile_capacity;
    int32_t (*origin)[3];
    float *values;
    struct weft_volume_tile *tile;
    bool sorted;
};

static void *grow(void *items, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity)
        return items;
    *capacity = 2 * count;
    items = realloc(items, *capacity * size);
    assert_non_null(items);
    return items;
}

static bool comes_before(const int32_t a[3], const int32_t b[3])
{
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

static enum weft_result gather(void *priv, const struct weft_volume_lot *lot)
{
    struct gathered *g = priv;
    if (lot->grid != 0)
        return WEFT_OK;
    const size_t size = (size_t)g->components * WEFT_BRICK_VOXELS;
    size_t capacity = g->brick_capacity;
    g->origin = grow(g->origin, &capacity, g->bricks + lot->brick_count, sizeof *g->origin);
    g->values =
        grow(g->values, &g->brick_capacity, g->bricks + lot->brick_count, size * sizeof *g->values);
    g->tile = grow(g->tile, &g->tile_capacity, g->tiles + lot->tile_count, sizeof *g->tile);
    for (size_t i = 0; i < lot->brick_count; i++) {
        if (g->bricks && !comes_before(g->origin[g->bricks - 1], lot->brick_origin[i]))
            g->sorted = false;
        memcpy(g->origin[g->bricks], lot->brick_origin[i], sizeof *g->origin);
        memcpy(g->values + g->bricks++ * size, lot->values + i * size, size * sizeof *g->values);
    }
    for (size_t i = 0; i < lot->tile_count; i++)
        g->tile[g->tiles++] = lot->tiles[i];
    return WEFT_OK;
}

static void clear_gathered(struct gathered *g)
{
    free(g->origin);
    free(g->values);
    free(g->tile);
}

static struct gathered run(weft_lattice_plan *plan, int threads, double share,
                           struct weft_lattice_report *report)
{
    struct gathered out = {.components = weft_lattice_plan_get_info(plan)->grid[0].components,
                           .sorted = true};
    struct weft_lattice_run_params params = {
        .sink = gather, .priv = &out, .cpu = {.threads = threads}, .verify = {.share = share}};
    assert_int_equal(weft_lattice_run(plan, &params, report), WEFT_OK);
    assert_true(out.sorted);
    return out;
}

static weft_lattice_plan *make_plan(const struct weft_lattice_params *params)
{
    weft_lattice_plan *plan = NULL;
    assert_int_equal(weft_lattice_plan_create(params, &plan), WEFT_OK);
    return plan;
}

// ---- the truth ----------------------------------------------------------------------------------

struct truth {
    const struct sparse *s;
    struct weft_kernel kernel[3]; // along each of the source's axes
    double stretch[3];
    const double (*map)[4];
};

struct true_value {
    double value, magnitude, gain; // NAN where a sample that counts is not finite
};

static struct true_value compute(const struct truth *t, const int64_t r[3])
{
    double *weights[3];
    int64_t first[3], width[3];
    struct true_value out = {0.0, 0.0, 0.0};
    struct weft_brick_cursor cursor = {.store = t->s->store};
    for (int a = 0; a < 3; a++) {
        const double *row = t->map[a];
        const double x =
            row[0] * (double)r[0] + row[1] * (double)r[1] + row[2] * (double)r[2] + row[3];
        width[a] = weft_stretch_width(&t->kernel[a], t->stretch[a]);
        weights[a] = malloc((size_t)width[a] * sizeof(double));
        first[a] = weft_stretch_weights(&t->kernel[a], t->stretch[a], rint(x * 0x1p32) * 0x1p-32,
                                        weights[a]);
    }
    for (int64_t z = 0; z < width[2]; z++)
        for (int64_t y = 0; y < width[1]; y++)
            for (int64_t x = 0; x < width[0]; x++) {
                const double w = weights[0][x] * weights[1][y] * weights[2][z];
                const double v = (double)weft_brick_cursor_voxel(&cursor, (int32_t)(first[0] + x),
                                                                 (int32_t)(first[1] + y),
                                                                 (int32_t)(first[2] + z));
                if (w == 0.0)
                    continue;
                out.value += w * v;
                out.gain += fabs(w);
                out.magnitude = isfinite(v) ? fmax(out.magnitude, fabs(v)) : out.magnitude;
            }
    for (int a = 0; a < 3; a++)
        free(weights[a]);
    return out;
}

// What is promised of a voxel: sums in double of a few hundred terms, rounded to a float.
static double promised(const struct weft_lattice_info *info, int d, const struct true_value *t)
{
    return info->bound[d].relative * t->magnitude + fabs(t->value) * 0x1p-24 +
           info->bound[d].absolute;
}

// A result's voxel, wherever it comes from; *kind: 0 background, 1 brick, 2 tile.
static float voxel_of(const struct gathered *g, float background, const int64_t r[3], int *kind)
{
    const int32_t o[3] = {(int32_t)r[0] & -8, (int32_t)r[1] & -8, (int32_t)r[2] & -8};
    size_t low = 0, high = g->bricks; // they are sorted
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (comes_before(g->origin[middle], o))
            low = middle + 1;
        else
            high = middle;
    }
    *kind = 1;
    if (low < g->bricks && memcmp(g->origin[low], o, sizeof o) == 0)
        return g->values[low * (size_t)g->components * WEFT_BRICK_VOXELS +
                         (size_t)((r[2] - o[2]) << 6 | (r[1] - o[1]) << 3 | (r[0] - o[0]))];
    *kind = 2;
    for (size_t i = 0; i < g->tiles; i++) {
        bool in = true;
        for (int a = 0; a < 3; a++)
            in =
                in && r[a] >= g->tile[i].origin[a] && r[a] < g->tile[i].origin[a] + g->tile[i].size;
        if (in)
            return g->tile[i].value;
    }
    *kind = 0;
    return background;
}

// Compares voxels of a box: every `step`-th. Counts those of each kind.
static void compare(const struct truth *t, const struct weft_lattice_info *info,
                    const struct gathered *g, const int64_t min[3], const int64_t max[3], int step,
                    size_t count[3])
{
    int64_t r[3];
    size_t n = 0;
    const double most = info->clamps ? fabs((double)t->s->background) : INFINITY;
    for (r[2] = min[2]; r[2] <= max[2]; r[2]++)
        for (r[1] = min[1]; r[1] <= max[1]; r[1]++)
            for (r[0] = min[0]; r[0] <= max[0]; r[0]++) {
                if (n++ % (size_t)step)
                    continue;
                int kind;
                const float value = voxel_of(g, t->s->background, r, &kind);
                struct true_value want = compute(t, r);
                count[kind]++;
                if (isnan(want.value) || isnan(value)) {
                    assert_true(isnan(want.value) && isnan(value));
                    continue;
                }
                const double clamped = fmin(fmax(want.value, -most), most);
                if (!(fabs((double)value - clamped) <= promised(info, 0, &want)))
                    fail_msg("(%lld, %lld, %lld): %.9g, not %.9g, kind %d", (long long)r[0],
                             (long long)r[1], (long long)r[2], (double)value, clamped, kind);
            }
}

// ---- scales, turns, flips -----------------------------------------------------------------------

static const struct {
    const char *kernel;
    double map[3][4];
    bool separable;
    double stretch[3];
} cases[] = {
    {"catmull-rom", {{0.5, 0, 0, 0}, {0, 0.5, 0, 0}, {0, 0, 0.5, 0}}, true, {1, 1, 1}},
    {"catmull-rom", {{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}}, true, {2, 2, 2}},
    {"bspline3", {{0.77, 0, 0, 0.3}, {0, 1.9, 0, -2}, {0, 0, 1, 0.25}}, true, {1, 1.9, 1}},
    {"lanczos:3+unit", {{0, 0, 0.8, 0}, {-0.9, 0, 0, 3}, {0, 1.25, 0, 0.5}}, true, {1, 1, 1.25}},
    {"linear", {{-1, 0, 0, 0.5}, {0, 0.5, 0, 0}, {0, 0, 0.5, 0}}, true, {1, 1, 1}},
    {"nearest", {{1.5, 0, 0, 0.2}, {0, 0.6, 0, 0}, {0, 0, 1, 0}}, true, {1, 1, 1}},
    {"mitchell", {{0.8, -0.6, 0, 0.1}, {0.6, 0.8, 0, 0}, {0, 0, 1, 0}}, false, {1, 1, 1}},
    {"catmull-rom",
     {{1.6, -1.2, 0, 1}, {1.2, 1.6, 0, 0}, {0, 0.1, 1, 0}},
     false,
     {2, 2, 1.004987562112089}},
    {"linear", {{9.5, 0, 0, 0}, {0, 33.0, 0, 1}, {0, 0, 9.5, 0}}, true, {9.5, 33.0, 9.5}},
};

static void test_against_double(void **state)
{
    (void)state;
    size_t all[3] = {0};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct sparse *s = make_fog(i % 2 ? 0.0f : 0.25f);
        struct truth t = {.s = s, .map = cases[i].map};
        struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
        memcpy(params.to_source, cases[i].map, sizeof params.to_source);
        // What there is but the large tile's inside.
        params.boxed = true;
        for (int a = 0; a < 3; a++) {
            params.box_min[a] = -90;
            params.box_max[a] = 90;
            t.stretch[a] = cases[i].stretch[a];
        }
        assert_int_equal(weft_kernel_parse(NULL, cases[i].kernel, &params.kernel), WEFT_OK);
        t.kernel[0] = t.kernel[1] = t.kernel[2] = params.kernel;
        weft_lattice_plan *plan = make_plan(&params);
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(plan);
        assert_int_equal(info->separable, cases[i].separable);
        for (int a = 0; a < 3; a++)
            assert_true(fabs(info->stretch[a] - cases[i].stretch[a]) < 1e-12);
        struct weft_lattice_report report;
        struct gathered g = run(plan, 2, i == 8 ? 1e-3 : 4e-3, &report);
        const int64_t min[3] = {-60, -60, -60}, max[3] = {80, 70, 70};
        compare(&t, info, &g, min, max, i == 8 ? 9001 : 307, all);
        // And every voxel of some bricks.
        for (size_t b = 0; b < g.bricks; b += 1 + g.bricks / 4) {
            int64_t from[3], to[3];
            size_t count[3] = {0};
            for (int a = 0; a < 3; a++) {
                from[a] = g.origin[b][a] < -90 ? -90 : g.origin[b][a];
                to[a] = g.origin[b][a] + 7 > 90 ? 90 : g.origin[b][a] + 7;
            }
            compare(&t, info, &g, from, to, i == 8 ? 131 : 11, count);
        }
        assert_true(report.verify.values_compared > 100 || i == 8);
        assert_int_equal(report.verify.not_finite_mismatches, 0);
        assert_true(report.verify.share <= 1.0);
        clear_gathered(&g);
        weft_lattice_plan_destroy(&plan);
        clear_sparse(s);
    }
    assert_true(all[0] > 1000 && all[1] > 1000 && all[2] > 3);
}

// ---- what stays exactly what it is
// ----------------------------------------------------------------

static void set_scale(struct weft_lattice_params *params, double scale, double shift)
{
    memset(params->to_source, 0, sizeof params->to_source);
    for (int a = 0; a < 3; a++) {
        params->to_source[a][a] = scale;
        params->to_source[a][3] = shift;
    }
}

// Constants come out as they are, to the bit: tiles as tiles, and nothing where the background is.
static void test_constants(void **state)
{
    (void)state;
    struct sparse *s = calloc(1, sizeof *s);
    s->background = 0.1f;
    for (int i = 0; i < 8; i++) {
        struct weft_volume_tile tile = {{i & 1, i >> 1 & 1, i >> 2}, 4096, 0.3f};
        for (int a = 0; a < 3; a++)
            tile.origin[a] *= 4096;
        if (i < 3)
            s->tiles[s->tile_count++] = tile;
    }
    // Three of eight, side by side along x and y.
    finish_sparse(s);
    struct weft_lattice_params params = {.volume = s->volume, .log = &test_log, .boxed = true};
    set_scale(&params, 0.5, 0.0);
    params.to_source[2][3] = 1024.0;
    const int32_t max[3] = {4095, 4095, 4095};
    memcpy(params.box_max, max, sizeof max);
    weft_kernel_parse(NULL, "bspline5", &params.kernel);
    // Inside one tile: the box is 0 to 2047 of it, of which the first voxels meet the background.
    params.to_source[0][3] = params.to_source[1][3] = 64.0;
    weft_lattice_plan *plan = make_plan(&params);
    struct gathered g = run(plan, 1, 0.0, NULL);
    assert_int_equal(g.bricks, 0);
    assert_int_equal(g.tiles, 1);
    assert_int_equal(g.tile[0].size, 4096);
    assert_true(g.tile[0].value == 0.3f);
    clear_gathered(&g);
    weft_lattice_plan_destroy(&plan);
    // At the tile's corner: bricks at its faces, smaller tiles inside.
    for (int a = 0; a < 3; a++) {
        params.to_source[a][3] = 0.0;
        params.box_min[a] = -128;
        params.box_max[a] = 255;
    }
    plan = make_plan(&params);
    struct weft_lattice_report report;
    g = run(plan, 2, 0.01, &report);
    int sizes[3] = {0};
    for (size_t i = 0; i < g.tiles; i++) {
        assert_true(g.tile[i].value == 0.3f);
        sizes[g.tile[i].size == 8 ? 0 : g.tile[i].size == 128 ? 1 : 2]++;
    }
    assert_true(sizes[0] > 100 && sizes[1] == 1 && sizes[2] == 0);
    assert_true(g.bricks > 100);
    assert_true(report.verify.share <= 1.0 && report.verify.values_compared > 100);
    size_t exact = 0, outside = 0;
    for (size_t i = 0; i < g.bricks; i++)
        for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
            const float value = g.values[i * WEFT_BRICK_VOXELS + (size_t)v];
            const int at[3] = {g.origin[i][0] + (v & 7), g.origin[i][1] + (v >> 3 & 7),
                               g.origin[i][2] + (v >> 6)};
            if (at[0] > 6 && at[1] > 6 && at[2] > 6) {
                assert_true(value == 0.3f);
                exact++;
            }
            if (at[0] < -6 || at[1] < -6 || at[2] < -6) {
                assert_true(value == 0.1f);
                outside++;
            }
        }
    assert_true(exact + outside > 100);
    clear_gathered(&g);
    weft_lattice_plan_destroy(&plan);
    clear_sparse(s);
}

// Voxels of `a` are those of `b`, moved by so many voxels, byte for byte; *count of bricks'.
static void assert_moved(const struct gathered *a, const struct gathered *b, const int by[3],
                         float background, size_t *count)
{
    *count = 0;
    for (size_t i = 0; i < a->bricks; i++)
        for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
            const int64_t at[3] = {a->origin[i][0] + (v & 7) + by[0],
                                   a->origin[i][1] + (v >> 3 & 7) + by[1],
                                   a->origin[i][2] + (v >> 6) + by[2]};
            int kind;
            const float want = voxel_of(b, background, at, &kind);
            assert_memory_equal(&a->values[i * WEFT_BRICK_VOXELS + (size_t)v], &want, sizeof want);
            ++*count;
        }
}

static void drop_tiles(struct sparse *s)
{
    weft_volume_destroy(&s->volume);
    weft_brick_store_destroy(&s->store);
    s->tile_count = 0;
    finish_sparse(s);
}

// The source moved by 3, -5 and 8 voxels, on the lattice that is moved by as much, and on its own.
static void test_translations(void **state)
{
    (void)state;
    static const double scales[] = {0.5, 2.0, 1.0 / 3.0};
    struct sparse *s = make_fog(0.0f);
    drop_tiles(s);
    for (size_t i = 0; i < 3; i++) {
        struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
        set_scale(&params, scales[i], 0.0);
        weft_lattice_plan *plan = make_plan(&params);
        struct gathered still = run(plan, 1, 0.0, NULL);
        weft_lattice_plan_destroy(&plan);
        // What lay at 0 lies at 6, -10 and 8 now.
        const double by[3] = {6.0, -10.0, 8.0};
        int moved[3];
        for (int a = 0; a < 3; a++) {
            params.to_source[a][3] = -by[a];
            moved[a] = (int)rint(by[a] / scales[i]);
        }
        plan = make_plan(&params);
        struct gathered other = run(plan, 2, 0.0, NULL);
        weft_lattice_plan_destroy(&plan);
        size_t count = 0, back = 0;
        assert_moved(&still, &other, moved, 0.0f, &count);
        for (int a = 0; a < 3; a++)
            moved[a] = -moved[a];
        assert_moved(&other, &still, moved, 0.0f, &back);
        assert_true(count > 10000 || scales[i] > 1.0);
        assert_true(count > 1000 && back > 1000);
        clear_gathered(&still);
        clear_gathered(&other);
    }
    clear_sparse(s);
}

// A gathered result is a volume again.
static weft_volume *volume_of(const struct gathered *g)
{
    weft_volume *out = NULL;
    struct weft_volume_bricks_params params = {.brick_count = g->bricks,
                                               .brick_origin = (const int32_t(*)[3])g->origin,
                                               .brick_values = g->values,
                                               .tile_count = g->tiles,
                                               .tiles = g->tile};
    assert_int_equal(weft_volume_create_bricks(&params, &out), WEFT_OK);
    return out;
}

// Moved by half a voxel and doubled is doubled and moved by one: linear interpolation, of which the
// composition is itself, at the samples. Both ways are whole maps, so that any kernel commutes,
// too.
static void test_half_voxels(void **state)
{
    (void)state;
    static const char *const kernels[] = {"linear", "catmull-rom", "bspline3"};
    struct sparse *s = make_fog(0.0f);
    drop_tiles(s);
    for (size_t k = 0; k < 3; k++) {
        struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
        weft_kernel_parse(NULL, kernels[k], &params.kernel);
        set_scale(&params, 0.5, 0.0);
        weft_lattice_plan *plan = make_plan(&params);
        struct gathered doubled = run(plan, 1, 0.0, NULL);
        weft_lattice_plan_destroy(&plan);
        set_scale(&params, 0.5, -0.5); // moved by half a voxel of the source
        plan = make_plan(&params);
        struct gathered moved = run(plan, 1, 0.0, NULL);
        weft_lattice_plan_destroy(&plan);
        const int by[3] = {1, 1, 1}, back[3] = {-1, -1, -1};
        size_t count = 0;
        assert_moved(&doubled, &moved, by, 0.0f, &count);
        assert_true(count > 10000);
        assert_moved(&moved, &doubled, back, 0.0f, &count);
        // Moving the doubled volume by a whole voxel gives its bytes, too.
        weft_volume *again = volume_of(&doubled);
        struct weft_lattice_params whole = {
            .volume = again, .log = &test_log, .kernel = params.kernel};
        set_scale(&whole, 1.0, -1.0);
        plan = make_plan(&whole);
        struct gathered twice = run(plan, 1, 0.0, NULL);
        if (params.kernel.interpolating)
            assert_moved(&moved, &twice, (const int[3]){0, 0, 0}, 0.0f, &count);
        weft_lattice_plan_destroy(&plan);
        weft_volume_destroy(&again);
        clear_gathered(&doubled);
        clear_gathered(&moved);
        clear_gathered(&twice);
    }
    clear_sparse(s);
}

// ---- level sets ---------------------------------------------------------------------------------

static void test_level_sets(void **state)
{
    (void)state;
    static const double scales[] = {0.5, 2.0, 0.8};
    for (size_t i = 0; i < 3; i++) {
        struct sparse *s = make_level_set();
        struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
        struct truth t = {.s = s, .map = (const double(*)[4])params.to_source};
        set_scale(&params, scales[i], 0.125);
        weft_kernel_parse(NULL, "catmull-rom", &params.kernel);
        for (int a = 0; a < 3; a++) {
            t.stretch[a] = fmax(1.0, scales[i]);
            t.kernel[a] = params.kernel;
        }
        weft_lattice_plan *plan = make_plan(&params);
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(plan);
        struct weft_lattice_report report;
        struct gathered g = run(plan, 2, 0.02, &report);
        assert_true(info->clamps);
        assert_string_equal(info->grid[0].grid.grid_class, "level set");
        assert_true(fabs(info->band_voxels - 1.5 / (0.5 * scales[i])) < 1e-9);
        assert_true(info->grid[0].grid.background == 1.5f);
        assert_true(report.verify.share <= 1.0 && report.verify.values_compared > 100);
        size_t count[3] = {0};
        const int64_t min[3] = {-30, -30, -30}, max[3] = {30, 30, 30};
        compare(&t, info, &g, min, max, 17, count);
        // Deep inside it is the background, negative, exactly; the surface stays where it was.
        int kind;
        assert_true(voxel_of(&g, 1.5f, (const int64_t[3]){0, 0, 0}, &kind) == -1.5f);
        const int64_t near[3] = {(int64_t)floor(9.0 / scales[i]), 0, 0};
        const double wanted = sphere(scales[i] * (double)near[0] + 0.125, 0.125, 0.125);
        assert_true(fabs((double)voxel_of(&g, 1.5f, near, &kind) - wanted) < 0.05);
        assert_true(report.active_voxels[0] > 100);
        clear_gathered(&g);
        weft_lattice_plan_destroy(&plan);
        clear_sparse(s);
    }
}

// ---- derivatives, pruning, boxes
// ------------------------------------------------------------------

static void test_gradients(void **state)
{
    (void)state;
    struct sparse *s = make_fog(0.0f);
    drop_tiles(s);
    static const enum weft_quantity asked[] = {WEFT_QUANTITY_GRADIENT, WEFT_QUANTITY_VALUE,
                                               WEFT_QUANTITY_LAPLACIAN};
    struct weft_quantities list;
    assert_int_equal(weft_quantities_create(NULL, asked, 3, &list), WEFT_OK);
    for (int turned = 0; turned < 2; turned++) {
        struct weft_lattice_params params = {
            .volume = s->volume, .log = &test_log, .quantities = &list};
        set_scale(&params, 0.5, 0.25);
        if (turned) {
            const double map[3][4] = {{0.3, -0.4, 0, 0}, {0.4, 0.3, 0, 0.5}, {0, 0, 0.5, 0}};
            memcpy(params.to_source, map, sizeof map);
            params.boxed = true;
            for (int a = 0; a < 3; a++) {
                params.box_min[a] = -16;
                params.box_max[a] = 23;
            }
        }
        weft_kernel_parse(NULL, "bspline4", &params.kernel);
        weft_lattice_plan *plan = make_plan(&params);
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(plan);
        assert_int_equal(info->grid_count, 3);
        assert_int_equal(info->separable, !turned);
        assert_string_equal(info->grid[0].grid.name, "density.gradient");
        assert_string_equal(info->grid[1].grid.name, "density");
        assert_string_equal(info->grid[2].grid.name, "density.laplacian");
        struct weft_lattice_report report;
        struct gathered g = run(plan, 2, turned ? 5e-3 : 1e-3, &report);
        assert_true(report.verify.values_compared > 100);
        assert_true(report.verify.share <= 1.0);
        assert_true(g.components == 3 && g.bricks > 50);
        size_t compared = 0, missing = 0;
        for (int c = 0; c < 3; c++) {
            struct truth t = {
                .s = s, .stretch = {1, 1, 1}, .map = (const double(*)[4])params.to_source};
            t.kernel[0] = t.kernel[1] = t.kernel[2] = params.kernel;
            assert_int_equal(weft_kernel_derive(NULL, &params.kernel, &t.kernel[c]), WEFT_OK);
            for (size_t b = 0; b < g.bricks; b += 7)
                for (int v = 0; v < WEFT_BRICK_VOXELS; v += 19) {
                    const int64_t r[3] = {g.origin[b][0] + (v & 7), g.origin[b][1] + (v >> 3 & 7),
                                          g.origin[b][2] + (v >> 6)};
                    const struct true_value want = compute(&t, r);
                    const double got =
                        (double)g.values[(b * 3 + (size_t)c) * WEFT_BRICK_VOXELS + (size_t)v];
                    // In world space a component depends on all three.
                    missing += isnan(got);
                    assert_true(isnan(got) || !isnan(want.value));
                    if (isnan(got))
                        continue;
                    // World space is index space here; the products with 0 and 1 add nothing.
                    if (!(fabs(got - want.value) <= 1e-6 * fmax(want.magnitude, 1e-3)))
                        fail_msg("%d: %.9g, not %.9g", c, got, want.value);
                    compared++;
                }
        }
        assert_true(compared > 200 && missing < compared / 20);
        clear_gathered(&g);
        weft_lattice_plan_destroy(&plan);
    }
    clear_sparse(s);
}

static void test_prune_and_box(void **state)
{
    (void)state;
    struct sparse *s = make_fog(0.0f);
    drop_tiles(s);
    struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
    set_scale(&params, 0.5, 0.0);
    struct weft_lattice_report all, pruned, boxed;
    weft_lattice_plan *plan = make_plan(&params);
    struct gathered whole = run(plan, 1, 0.01, &all);
    weft_lattice_plan_destroy(&plan);
    params.prune = 1.0;
    plan = make_plan(&params);
    struct gathered less = run(plan, 1, 0.01, &pruned);
    weft_lattice_plan_destroy(&plan);
    assert_true(pruned.active_voxels[0] < all.active_voxels[0] && pruned.active_voxels[0] > 1000);
    assert_true(pruned.verify.share <= 1.0 && all.verify.share <= 1.0);
    size_t zeros = 0, kept = 0;
    for (size_t i = 0; i < less.bricks * WEFT_BRICK_VOXELS; i++) {
        const float value = less.values[i];
        assert_true(value == 0.0f || !(fabsf(value) <= 1.0f));
        zeros += value == 0.0f;
        kept += value != 0.0f;
    }
    assert_true(zeros > 100 && kept == pruned.active_voxels[0]);
    params.prune = 0.0;
    params.boxed = true;
    const int32_t min[3] = {-5, -3, 0}, max[3] = {6, 20, 9};
    memcpy(params.box_min, min, sizeof min);
    memcpy(params.box_max, max, sizeof max);
    plan = make_plan(&params);
    struct gathered part = run(plan, 1, 0.5, &boxed);
    weft_lattice_plan_destroy(&plan);
    size_t inside = 0;
    for (size_t i = 0; i < part.bricks; i++)
        for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
            const int64_t r[3] = {part.origin[i][0] + (v & 7), part.origin[i][1] + (v >> 3 & 7),
                                  part.origin[i][2] + (v >> 6)};
            bool in = true;
            int kind;
            for (int a = 0; a < 3; a++)
                in = in && r[a] >= min[a] && r[a] <= max[a];
            const float want = in ? voxel_of(&whole, 0.0f, r, &kind) : 0.0f;
            assert_memory_equal(&want, &part.values[i * WEFT_BRICK_VOXELS + (size_t)v],
                                sizeof want);
            inside += in;
        }
    assert_true(inside > 500);
    assert_true(boxed.verify.share <= 1.0);
    clear_gathered(&whole);
    clear_gathered(&less);
    clear_gathered(&part);
    clear_sparse(s);
}

// The same bytes whatever the threads; sets of instructions agree within the bound (2^-23).
static void test_threads(void **state)
{
    (void)state;
    struct sparse *s = make_fog(0.25f);
    drop_tiles(s);
    struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
    set_scale(&params, 0.7, 0.1);
    weft_lattice_plan *plan = make_plan(&params);
    struct gathered one = run(plan, 1, 0.0, NULL);
    size_t sets = 0;
    for (int set = WEFT_INSTRUCTIONS_AUTO; set <= WEFT_INSTRUCTIONS_AVX512; set++) {
        struct gathered other = {.components = 1, .sorted = true};
        struct weft_lattice_run_params how = {
            .sink = gather, .priv = &other, .cpu = {3, (enum weft_instruction_set)set}};
        if (!weft_instruction_set_runs((enum weft_instruction_set)set))
            continue;
        assert_int_equal(weft_lattice_run(plan, &how, NULL), WEFT_OK);
        assert_int_equal(one.bricks, other.bricks);
        assert_memory_equal(one.origin, other.origin, one.bricks * sizeof *one.origin);
        for (size_t i = 0; i < one.bricks * WEFT_BRICK_VOXELS; i++)
            assert_true(fabsf(one.values[i] - other.values[i]) <= 4.0f * 0x1p-23f ||
                        (isnan(one.values[i]) && isnan(other.values[i])));
        if (set == WEFT_INSTRUCTIONS_AUTO)
            assert_memory_equal(one.values, other.values,
                                one.bricks * WEFT_BRICK_VOXELS * sizeof(float));
        clear_gathered(&other);
        sets++;
    }
    assert_true(sets >= 2);
    clear_gathered(&one);
    weft_lattice_plan_destroy(&plan);
    clear_sparse(s);
}

// ---- prefiltered kernels, clamped volumes -------------------------------------------------------

// An interpolating spline has every second voxel of its own; and a volume that holds its edge is
// made within its box.
static void test_dense(void **state)
{
    (void)state;
    enum { N = 20 };
    static float data[N * N * N];
    for (int i = 0; i < N * N * N; i++)
        data[i] = (float)signal(i % N, i / N % N, i / (N * N));
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .data = data), &volume), WEFT_OK);
    struct weft_lattice_params params = {.volume = volume, .log = &test_log};
    set_scale(&params, 0.5, 0.0);
    weft_kernel_parse(NULL, "bspline3i", &params.kernel);
    weft_lattice_plan *plan = make_plan(&params);
    struct weft_lattice_report report;
    struct gathered g = run(plan, 2, 0.01, &report);
    // From -0.5 to 19.5.
    assert_int_equal(report.active_voxels[0], 41 * 41 * 41);
    assert_true(report.verify.share <= 1.0);
    for (int i = 0; i < N * N * N; i += 7) {
        const int64_t r[3] = {2 * (i % N), 2 * (i / N % N), 2 * (i / (N * N))};
        int kind;
        assert_true(fabsf(voxel_of(&g, 0.0f, r, &kind) - data[i]) < 4e-6f);
        assert_int_equal(kind, 1);
    }
    clear_gathered(&g);
    weft_lattice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

// ---- refusals -----------------------------------------------------------------------------------

static void test_refusals(void **state)
{
    (void)state;
    struct sparse *s = make_fog(0.25f);
    weft_lattice_plan *plan = NULL;
    struct weft_lattice_params params = {.volume = s->volume, .log = &test_log};
    set_scale(&params, 1e-4, 0.0); // 10^12 voxels and more
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_LIMIT);
    assert_non_null(strstr(last.text, "voxels"));
    set_scale(&params, 1e-9, 0.0);
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_LIMIT);
    set_scale(&params, 1.0, 0.0);
    params.to_source[1][1] = 0.0;
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_ARGUMENT);
    params.to_source[1][1] = NAN;
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_ARGUMENT);
    set_scale(&params, 2.0, 0.0);
    weft_kernel_parse(NULL, "bspline3i", &params.kernel);
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_UNSUPPORTED);
    weft_kernel_parse(NULL, "gaussian", &params.kernel);
    if (!params.kernel.unit_sum)
        assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_UNSUPPORTED);
    weft_kernel_parse(NULL, "linear+radial", &params.kernel);
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_UNSUPPORTED);
    params.kernel = (struct weft_kernel){0};
    params.prune = -1.0;
    assert_int_equal(weft_lattice_plan_create(&params, &plan), WEFT_ERR_ARGUMENT);
    assert_null(plan);
    // Nothing in the box is nothing made.
    params.prune = 0.0;
    params.boxed = true;
    for (int a = 0; a < 3; a++)
        params.box_min[a] = params.box_max[a] = 5000;
    plan = make_plan(&params);
    assert_true(weft_lattice_plan_get_info(plan)->empty);
    struct gathered g = run(plan, 1, 1.0, NULL);
    assert_true(g.bricks == 0 && g.tiles == 0);
    clear_gathered(&g);
    weft_lattice_plan_destroy(&plan);
    // Maps: what is singular is told.
    const double one[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const double flat[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0}};
    double out[3][4];
    assert_int_equal(weft_lattice_map_compute(&test_log, one, flat, one, out), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last.text, "the matrix is singular"));
    // Tiny voxels are no singular ones, and a volume moved by itself is a lattice moved back.
    const double tiny[3][4] = {{1e-5, 0, 0, 3}, {0, 1e-5, 0, 0}, {0, 0, 1e-5, 0}};
    const double moved[3][4] = {{1, 0, 0, 2e-5}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    assert_int_equal(weft_lattice_map_compute(&test_log, tiny, moved, tiny, out), WEFT_OK);
    assert_true(fabs(out[0][0] - 1.0) < 1e-12 && fabs(out[0][3] + 2.0) < 1e-9);
    clear_sparse(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_double), cmocka_unit_test(test_constants),
        cmocka_unit_test(test_translations),   cmocka_unit_test(test_half_voxels),
        cmocka_unit_test(test_level_sets),     cmocka_unit_test(test_gradients),
        cmocka_unit_test(test_prune_and_box),  cmocka_unit_test(test_threads),
        cmocka_unit_test(test_dense),          cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
