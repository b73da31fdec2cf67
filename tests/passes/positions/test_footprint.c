// SPDX-License-Identifier: BSD-3-Clause
// What a footprint finds, against all pixels and all taps one by one.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "passes/positions/footprint_impl.h"
#include "weft.h"

static bool refuse_progress(void *priv, double fraction)
{
    (void)priv;
    (void)fraction;
    return false;
}

// ---- volumes ------------------------------------------------------------------------------------

enum { SIDE = 37 };

static float value_at(int x, int y, int z)
{
    uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)z * 83492791u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (float)((double)(h ^ h >> 16) / 2147483647.5 - 1.0);
}

// A cube of noise from `offset` on along every axis.
static weft_volume *make_volume(int32_t offset, float background)
{
    float *data = malloc((size_t)SIDE * SIDE * SIDE * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        data[i] = value_at(i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE);
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE},
                                                           .origin = {offset, offset, offset},
                                                           .background = background, .data = data),
                                        &volume),
                     WEFT_OK);
    free(data);
    return volume;
}

// The same by coordinates.
static float voxel_at(const weft_volume *volume, int32_t offset, const int32_t at[3])
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    int i[3];
    for (int a = 0; a < 3; a++) {
        i[a] = at[a] - offset;
        if (info->clamp_to_edge)
            i[a] = i[a] < 0 ? 0 : i[a] >= SIDE ? SIDE - 1 : i[a];
        else if (i[a] < 0 || i[a] >= SIDE)
            return info->background;
    }
    return value_at(i[0], i[1], i[2]);
}

// ---- cuts ---------------------------------------------------------------------------------------

static const struct cut {
    const char *name;
    double origin[3], u[3], v[3]; // from the volume's first voxel
    int width, height;
} cuts[] = {
    {"across z", {0, 0, 12.3}, {30, 0, 0}, {0, 30, 0}, 70, 60},
    {"on a plane", {0, 0, 12}, {30, 0, 0}, {0, 30, 0}, 70, 60},
    {"oblique", {3, 2, 1}, {30, 11, 7}, {-6, 24, 17}, 90, 80},
    {"past the faces", {-20, -9, -5}, {70, 25, 12}, {-12, 50, 40}, 60, 50},
    {"beside", {-50, -9, -5}, {20, 5, 2}, {-2, 20, 10}, 30, 20},
    {"over blocks", {4, 4, 4}, {20, 6, 3}, {-3, 18, 9}, 300, 270},
    {"one pixel", {9, 9, 9}, {1, 0.2, 0}, {0, 1, 0.1}, 1, 1},
};
static const char *const kernels[] = {"nearest", "linear", "catmull-rom", "bspline2", "lanczos:3"};

static weft_footprint *make_footprint(weft_volume *volume, const struct cut *cut,
                                      const char *kernel, int32_t offset, uint64_t memory_bytes)
{
    struct weft_footprint_params params = {.volume = volume,
                                           .space = WEFT_SPACE_INDEX,
                                           .memory_bytes = memory_bytes,
                                           .log = &log_to_stderr};
    assert_int_equal(weft_kernel_parse(&log_to_stderr, kernel, &params.kernel), WEFT_OK);
    params.geometry.width = cut->width;
    params.geometry.height = cut->height;
    for (int a = 0; a < 3; a++) {
        params.geometry.origin[a] = cut->origin[a] + offset;
        params.geometry.u[a] = cut->u[a];
        params.geometry.v[a] = cut->v[a];
    }
    weft_footprint *footprint = NULL;
    assert_int_equal(weft_footprint_create(&params, &footprint), WEFT_OK);
    return footprint;
}

static void first_tap(const weft_footprint *f, int x, int y, int32_t tap[3], int32_t at[3])
{
    struct weft_slice_block block;
    double fraction[3];
    weft_slice_grid_block(&f->grid, x / WEFT_GRID_BLOCK, y / WEFT_GRID_BLOCK, &block);
    weft_slice_grid_pixel(&f->grid, &block, x, y, at, fraction);
    for (int a = 0; a < 3; a++)
        tap[a] = at[a] - f->grid.tap_offset;
}

// ---- cells and boxes ----------------------------------------------------------------------------

// Every pixel lies in its cell's bounds, every bound is met by a pixel, and there are no other
// cells; the rectangle's box is that of all taps.
static void check_rectangle(weft_footprint *f, const struct weft_rectangle *r)
{
    const struct weft_slice_cells *cells = NULL;
    const int width = f->info.kernel.width;
    int32_t low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    int32_t min[3], max[3];
    assert_int_equal(weft_footprint_cells(f, r, NULL, 0.0, &cells), WEFT_OK);
    struct weft_slice_cell *seen = malloc(cells->map.count * sizeof *seen);
    assert_non_null(seen);
    for (size_t i = 0; i < cells->map.count; i++)
        seen[i] = (struct weft_slice_cell){{255, 255, 255}, {0, 0, 0}};
    for (int i = 0; i < r->width * r->height; i++) {
        int32_t tap[3], at[3];
        struct weft_cell_key key;
        first_tap(f, r->x + i % r->width, r->y + i / r->width, tap, at);
        for (int a = 0; a < 3; a++)
            key.at[a] = at[a] >> 3;
        const int64_t number = weft_cell_map_find(&cells->map, key);
        assert_true(number >= 0);
        for (int a = 0; a < 3; a++) {
            const uint8_t in_cell = (uint8_t)(at[a] & 7);
            seen[number].low[a] = in_cell < seen[number].low[a] ? in_cell : seen[number].low[a];
            seen[number].high[a] = in_cell > seen[number].high[a] ? in_cell : seen[number].high[a];
            low[a] = tap[a] < low[a] ? tap[a] : low[a];
            high[a] = tap[a] + width - 1 > high[a] ? tap[a] + width - 1 : high[a];
        }
    }
    assert_memory_equal(seen, cells->at, cells->map.count * sizeof *seen);
    weft_footprint_box(f, r, min, max);
    assert_memory_equal(min, low, sizeof min);
    assert_memory_equal(max, high, sizeof max);
    free(seen);
    weft_footprint_release(f, &cells);
    assert_null(cells);
}

static void cells_are_those_of_the_pixels(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(0, NAN);
    int checked = 0;
    for (size_t c = 0; c < WEFT_COUNT(cuts); c++) {
        for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
            weft_footprint *f = make_footprint(volume, &cuts[c], kernels[k], 0, 0);
            const int w = cuts[c].width, h = cuts[c].height;
            const struct weft_rectangle rectangles[] = {
                {0, 0, w, h}, {w / 2, h / 3, w - w / 2, h - h / 3}, {w - 1, h - 1, 1, 1}};
            for (size_t i = 0; i < WEFT_COUNT(rectangles); i++, checked++)
                check_rectangle(f, &rectangles[i]);
            weft_footprint_destroy(&f);
        }
    }
    assert_int_equal(checked, 3 * WEFT_COUNT(cuts) * WEFT_COUNT(kernels));
    weft_volume_destroy(&volume);
}

// Cells of one rectangle are found once while somebody holds them, those of the whole for good.
static void cells_are_shared(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(0, NAN);
    weft_footprint *f = make_footprint(volume, &cuts[2], "catmull-rom", 0, 0);
    const struct weft_rectangle whole = {0, 0, cuts[2].width, cuts[2].height};
    const struct weft_rectangle part = {0, 0, 10, 10};
    const struct weft_slice_cells *one = NULL, *two = NULL;
    assert_int_equal(weft_footprint_cells(f, &part, NULL, 0.0, &one), WEFT_OK);
    assert_int_equal(weft_footprint_cells(f, &part, NULL, 0.0, &two), WEFT_OK);
    assert_ptr_equal(one, two);
    weft_footprint_release(f, &one);
    assert_int_equal(f->cells_count, 1);
    weft_footprint_release(f, &two);
    assert_int_equal(f->cells_count, 0);
    assert_int_equal(weft_footprint_cells(f, &whole, NULL, 0.0, &one), WEFT_OK);
    const struct weft_slice_cells *known = one;
    weft_footprint_release(f, &one);
    assert_int_equal(weft_footprint_cells(f, &whole, NULL, 0.0, &one), WEFT_OK);
    assert_ptr_equal(one, known);
    weft_footprint_release(f, &one);
    // Cancelled in its first row.
    const struct weft_progress stop = {refuse_progress, NULL};
    assert_int_equal(weft_footprint_cells(f, &part, &stop, 0.0, &one), WEFT_ERR_CANCELLED);
    assert_null(one);
    weft_footprint_destroy(&f);
    weft_volume_destroy(&volume);
}

// ---- statistics ---------------------------------------------------------------------------------

// Of the voxels in a box of flags around the volume, marked tap by tap.
static struct weft_slice_statistics statistics_by_hand(const weft_footprint *f,
                                                       const weft_volume *volume, int32_t offset)
{
    enum { MARGIN = 60, BOX = SIDE + 2 * MARGIN };
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    const int width = f->info.kernel.width, pixels = f->grid.index.width * f->grid.index.height;
    struct weft_slice_statistics out = {.low = INFINITY, .high = -INFINITY};
    char *flags = calloc((size_t)BOX * BOX * BOX, 1);
    assert_non_null(flags);
    for (int p = 0; p < pixels; p++) {
        int32_t tap[3], whole[3];
        first_tap(f, p % f->grid.index.width, p / f->grid.index.width, tap, whole);
        for (int t = 0; t < width * width * width; t++) {
            int32_t at[3] = {tap[0] + t % width, tap[1] + t / width % width,
                             tap[2] + t / width / width};
            for (int a = 0; a < 3 && info->clamp_to_edge; a++)
                at[a] = at[a] < info->active_min[a]   ? info->active_min[a]
                        : at[a] > info->active_max[a] ? info->active_max[a]
                                                      : at[a];
            size_t index = 0;
            for (int a = 2; a >= 0; a--) {
                const int32_t i = at[a] - offset + MARGIN;
                assert_true(i >= 0 && i < BOX);
                index = index * BOX + (size_t)i;
            }
            const float value = voxel_at(volume, offset, at);
            out.voxels += !flags[index];
            flags[index] = 1;
            out.low = fmin(out.low, (double)value);
            out.high = fmax(out.high, (double)value);
        }
    }
    free(flags);
    return out;
}

static void statistics_are_those_of_the_taps(void **state)
{
    (void)state;
    const float backgrounds[] = {NAN, 0.0f, 5.0f};
    int reaching_background = 0, not_reaching = 0;
    for (size_t b = 0; b < WEFT_COUNT(backgrounds); b++) {
        // Wherever bricks begin.
        for (int32_t offset = -3; offset <= 5; offset += 8) {
            weft_volume *volume = make_volume(offset, backgrounds[b]);
            for (size_t c = 0; c < WEFT_COUNT(cuts); c++) {
                for (size_t k = c % 2; k < WEFT_COUNT(kernels); k += 2) {
                    weft_footprint *f = make_footprint(volume, &cuts[c], kernels[k], offset, 0);
                    struct weft_slice_statistics own, exact = statistics_by_hand(f, volume, offset);
                    assert_int_equal(weft_footprint_statistics(f, NULL, &own), WEFT_OK);
                    assert_true(own.low == exact.low && own.high == exact.high);
                    assert_true(own.voxel_low == exact.low && own.voxel_high == exact.high);
                    assert_true(own.voxels == exact.voxels && own.not_finite == 0);
                    assert_true(own.beyond == 0.0);
                    reaching_background += own.high == 5.0;
                    not_reaching += own.high < 5.0 && b == 2;
                    weft_footprint_destroy(&f);
                }
            }
            weft_volume_destroy(&volume);
        }
    }
    assert_true(reaching_background > 10 && not_reaching > 10);
}

// Tiles and the background count where a tap lies on them, and voxels that are not finite do.
static void constants_count_where_they_are_reached(void **state)
{
    (void)state;
    float values[2 * WEFT_BRICK_VOXELS];
    for (int i = 0; i < 2 * WEFT_BRICK_VOXELS; i++)
        values[i] = i % 8 == 7 ? NAN : 1.0f + (float)(i % 7);
    const int32_t origins[2][3] = {{0, 0, 0}, {8, 0, 0}};
    const struct weft_volume_tile tile = {{16, 0, 0}, 8, -50.0f};
    const struct weft_volume_bricks_params params = {.brick_count = 2,
                                                     .brick_origin = origins,
                                                     .brick_values = values,
                                                     .tile_count = 1,
                                                     .tiles = &tile,
                                                     .background = 90.0f,
                                                     .log = &log_to_stderr};
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create_bricks(&params, &volume), WEFT_OK);
    const struct {
        struct cut cut;
        double low, high;
        uint64_t not_finite;
    } cases[] = {
        // nearest: the voxels that pixels lie on
        {{"one brick", {-0.5, 2, 2}, {7, 0, 0}, {0, 1, 0}, 7, 1}, 1, 7, 0},
        {{"its last voxel", {-0.5, 2, 2}, {8, 0, 0}, {0, 1, 0}, 8, 1}, 1, 7, 1},
        {{"the tile", {-0.5, 2, 2}, {24, 0, 0}, {0, 1, 0}, 24, 1}, -50, 7, 2},
        {{"the background", {-0.5, 2, 2}, {32, 0, 0}, {0, 1, 0}, 32, 1}, -50, 90, 2},
        {{"nothing else", {30, 2, 2}, {4, 0, 0}, {0, 1, 0}, 4, 1}, 90, 90, 0},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_footprint *f = make_footprint(volume, &cases[i].cut, "nearest", 0, 0);
        struct weft_slice_statistics own;
        assert_int_equal(weft_footprint_statistics(f, NULL, &own), WEFT_OK);
        assert_true(own.low == cases[i].low && own.high == cases[i].high);
        assert_true(own.not_finite == cases[i].not_finite);
        weft_footprint_destroy(&f);
    }
    weft_volume_destroy(&volume);
}

// ---- reading ------------------------------------------------------------------------------------

static uint64_t bricks_in_reach(weft_footprint *f)
{
    const struct weft_rectangle whole = {0, 0, f->grid.index.width, f->grid.index.height};
    const struct weft_slice_cells *cells;
    struct weft_cell_map bricks = {0};
    assert_int_equal(weft_footprint_cells(f, &whole, NULL, 0.0, &cells), WEFT_OK);
    for (size_t i = 0; i < cells->map.count; i++) {
        int32_t min[3], max[3];
        weft_footprint_cell_box(f, cells, i, min, max);
        assert_true(weft_brick_reader_note(&f->bricks, min, max, &bricks));
    }
    const uint64_t count = bricks.count;
    const weft_brick_store *store;
    assert_int_equal(weft_footprint_load(f, &bricks, 0, &store), WEFT_OK);
    // Each of them is there, with the volume's own voxels.
    for (size_t i = 0; i < bricks.count; i++) {
        int32_t origin[3];
        for (int a = 0; a < 3; a++)
            origin[a] = bricks.keys[i].at[a] * WEFT_BRICK_SIZE;
        float exact[WEFT_BRICK_VOXELS];
        const float *values;
        float constant;
        assert_int_equal(weft_brick_store_find(store, origin, &values, &constant),
                         WEFT_BRICK_VALUES);
        assert_int_equal(weft_volume_read(f->volume, 1, (const int32_t(*)[3])origin, exact),
                         WEFT_OK);
        assert_memory_equal(values, exact, sizeof exact);
    }
    weft_footprint_release(f, &cells);
    weft_cell_map_destroy(&bricks);
    return count;
}

static void bricks_are_read_once_while_there_is_room(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(0, NAN);
    struct weft_slice_statistics wide, narrow;
    weft_footprint *f = make_footprint(volume, &cuts[2], "catmull-rom", 0, 0);
    assert_int_equal(weft_footprint_statistics(f, NULL, &wide), WEFT_OK);
    const uint64_t first = weft_footprint_get_info(f)->bricks_read;
    const uint64_t count = bricks_in_reach(f);
    assert_true(first > 10 && first <= count);
    assert_int_equal(weft_footprint_get_info(f)->bricks_read, count);
    assert_int_equal(weft_footprint_get_info(f)->kept_bytes, count * 2048);
    assert_int_equal(bricks_in_reach(f), count);
    assert_int_equal(weft_footprint_statistics(f, NULL, &narrow), WEFT_OK);
    assert_int_equal(weft_footprint_get_info(f)->bricks_read, count);
    weft_footprint_destroy(&f);
    // Without room they are read again, and what is found is the same.
    f = make_footprint(volume, &cuts[2], "catmull-rom", 0, 2048);
    assert_int_equal(weft_footprint_statistics(f, NULL, &narrow), WEFT_OK);
    assert_memory_equal(&wide, &narrow, sizeof wide);
    assert_int_equal(bricks_in_reach(f), count);
    assert_true(weft_footprint_get_info(f)->bricks_read > count);
    assert_true(weft_footprint_get_info(f)->kept_bytes <= count * 2048);
    weft_footprint_destroy(&f);
    weft_volume_destroy(&volume);
}

// One footprint, several plans: voxels are read for the first of them alone.
static void plans_share_a_footprint(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(0, NAN);
    weft_footprint *f = make_footprint(volume, &cuts[2], "catmull-rom", 0, 0);
    const struct weft_footprint_info *info = weft_footprint_get_info(f);
    struct weft_slice_params params = {.kernel = info->kernel,
                                       .space = info->space,
                                       .geometry = info->geometry,
                                       .footprint = f,
                                       .log = &log_to_stderr};
    weft_slice_plan *one = NULL, *two = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &params, &one), WEFT_OK);
    params.layout = WEFT_LAYOUT_PLAIN;
    assert_int_equal(weft_slice_plan_create(volume, &params, &two), WEFT_OK);
    assert_ptr_equal(weft_slice_plan_get_footprint(one), f);
    assert_ptr_equal(weft_slice_plan_get_footprint(two), f);
    assert_int_equal(f->cells_count, 1);
    weft_footprint_destroy(&f);
    assert_null(f);
    // It lives as long as a plan does.
    struct weft_slice_statistics statistics;
    weft_footprint *held = weft_slice_plan_get_footprint(two);
    weft_slice_plan_destroy(&one);
    assert_int_equal(weft_footprint_statistics(held, NULL, &statistics), WEFT_OK);
    assert_true(statistics.high > statistics.low);
    // A plan is of its footprint's cut.
    params.footprint = held;
    params.geometry.width++;
    assert_int_equal(weft_slice_plan_create(volume, &params, &one), WEFT_ERR_ARGUMENT);
    params.geometry.width--;
    params.space = WEFT_SPACE_WORLD;
    assert_int_equal(weft_slice_plan_create(volume, &params, &one), WEFT_ERR_ARGUMENT);
    weft_slice_plan_destroy(&two);
    weft_volume_destroy(&volume);
}

static void bad_footprints_are_refused(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(0, NAN);
    weft_footprint *f = NULL;
    const struct weft_footprint_params good = {.volume = volume,
                                               .space = WEFT_SPACE_INDEX,
                                               .geometry = {{0, 0, 3}, {9, 0, 0}, {0, 9, 0}, 4, 4},
                                               .log = &log_to_stderr};
    struct weft_footprint_params p = good;
    p.volume = NULL;
    assert_int_equal(weft_footprint_create(&p, &f), WEFT_ERR_ARGUMENT);
    p = good;
    p.geometry.width = 0;
    assert_int_equal(weft_footprint_create(&p, &f), WEFT_ERR_ARGUMENT);
    p = good;
    p.geometry.origin[0] = 1e12;
    assert_int_equal(weft_footprint_create(&p, &f), WEFT_ERR_LIMIT);
    p = good;
    assert_int_equal(weft_kernel_parse(&log_to_stderr, "catmull-rom", &p.kernel), WEFT_OK);
    p.kernel.radial = true;
    assert_int_equal(weft_footprint_create(&p, &f), WEFT_ERR_UNSUPPORTED);
    assert_null(f);
    assert_int_equal(weft_footprint_create(&good, &f), WEFT_OK);
    weft_footprint_destroy(&f);
    weft_footprint_destroy(&f);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_are_those_of_the_pixels),
        cmocka_unit_test(cells_are_shared),
        cmocka_unit_test(statistics_are_those_of_the_taps),
        cmocka_unit_test(constants_count_where_they_are_reached),
        cmocka_unit_test(bricks_are_read_once_while_there_is_room),
        cmocka_unit_test(plans_share_a_footprint),
        cmocka_unit_test(bad_footprints_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
