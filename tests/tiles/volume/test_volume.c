// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/volume.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "tests/support/samples.h"
#include "filter/check.h"
#include "tests/support/vdb_files.h"
#include "tiles/volume/brick_store.h"
#include "tiles/volume/region.h"

static const int32_t nowhere[3] = {0, 0, 0};

// All of a volume, to look voxels up in.
struct whole {
    struct weft_brick_list list;
    float *values;
    weft_brick_store *store;
};

static struct whole load_whole(weft_volume *volume)
{
    struct whole whole = {0};
    assert_int_equal(weft_volume_find(volume, &everywhere, &whole.list), WEFT_OK);
    whole.values = malloc(whole.list.brick_count * 2048 + 1);
    assert_non_null(whole.values);
    assert_int_equal(weft_volume_read(volume, whole.list.brick_count,
                                      (const int32_t(*)[3])whole.list.brick_origin, whole.values),
                     WEFT_OK);
    assert_int_equal(weft_brick_store_create(&test_log, 0, weft_volume_get_info(volume)->background,
                                             &whole.store),
                     WEFT_OK);
    assert_int_equal(weft_brick_store_add_list(whole.store, &whole.list, whole.values), WEFT_OK);
    assert_int_equal(weft_brick_store_check_disjoint(whole.store), WEFT_OK);
    return whole;
}

static void free_whole(struct whole *whole)
{
    weft_brick_store_destroy(&whole->store);
    weft_brick_list_clear(&whole->list);
    free(whole->values);
}

static weft_volume *open_file(const char *path, const char *grid)
{
    weft_volume *volume = NULL;
    struct weft_volume_open_params params = {.path = path, .grid = grid, .log = &test_log};
    enum weft_result res = weft_volume_open(&params, &volume);
    if (res)
        print_message("%s\n", last_error.message);
    assert_int_equal(res, WEFT_OK);
    return volume;
}

static weft_volume *save_and_open(const weft_volume *volume, const char *name)
{
    struct weft_volume_save_params params = {.path = file_path(name), .log = &test_log};
    enum weft_result res = weft_volume_save(volume, &params);
    if (res)
        print_message("%s\n", last_error.message);
    assert_int_equal(res, WEFT_OK);
    return open_file(params.path, NULL);
}

static void test_dense(void **state)
{
    (void)state;
    enum { W = 21, H = 10, D = 9 };
    float data[D][H][W];
    for (int n = 0; n < W * H * D; n++)
        (&data[0][0][0])[n] = (float)(n % 97) - 5;
    weft_volume *made = NULL;
    struct weft_volume_params *params =
        weft_volume_params(.size = {W, H, D}, .origin = {-3, 5, 1}, .data = &data[0][0][0],
                           .log = &test_log);
    for (int clamped = 0; clamped < 2; clamped++) {
        params->background = clamped ? NAN : 2;
        assert_int_equal(weft_volume_create(params, &made), WEFT_OK);
        const struct weft_volume_info *info = weft_volume_get_info(made);
        assert_int_equal(info->clamp_to_edge, clamped);
        assert_int_equal(info->active_min[0], -3);
        assert_int_equal(info->active_max[2], 9);
        // A saved clamp-to-edge volume has the background 0 outside.
        weft_volume *read = save_and_open(made, "dense.vdb");
        assert_int_equal(weft_volume_get_info(read)->active_voxels, info->active_voxels);
        struct whole whole = load_whole(read);
        for (int k = -9; k < 20; k++)
            for (int j = -9; j < 30; j++)
                for (int i = -9; i < 30; i++) {
                    bool in = i >= -3 && i < W - 3 && j >= 5 && j < H + 5 && k >= 1 && k < D + 1;
                    float expected = in ? data[k - 1][j - 5][i + 3] : clamped ? 0 : 2;
                    assert_true(brick_voxel(whole.store, i, j, k) == expected);
                }
        free_whole(&whole);
        weft_volume_destroy(&read);
        weft_volume_destroy(&made);
    }
}

static void test_clamped_find(void **state)
{
    (void)state;
    float data[32 * 32 * 32] = {0};
    weft_volume *volume = NULL;
    struct weft_brick_list list;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {32, 32, 32}, .data = data, .log = &test_log),
                           &volume),
        WEFT_OK);
    struct weft_region beside = {{40, 0, 0}, {50, 7, 7}, 0, {{{0}, 0, 0}}};
    assert_int_equal(weft_volume_find(volume, &beside, &list), WEFT_OK);
    assert_int_equal(list.brick_count, 1);
    assert_int_equal(list.brick_origin[0][0], 24);
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
}

static void test_level_set(void **state)
{
    (void)state;
    // A million voxels off, a rotated and sheared transform.
    static const double transform[3][4] = {
        {0.5, -0.1, 0.2, 7}, {0.3, 0.6, 0, -1000.25}, {0.01, 0.2, 0.9, 3e6}};
    const int32_t centre[3] = {1000000, -1000000, 1000000};
    weft_volume *made = make_sphere(40, centre, transform);
    weft_volume *read = save_and_open(made, "sphere.vdb");
    const struct weft_volume_info *a = weft_volume_get_info(made), *b = weft_volume_get_info(read);
    assert_string_equal(b->grid_class, "level set");
    assert_string_equal(b->type, "float");
    assert_int_equal(a->active_voxels, b->active_voxels);
    assert_memory_equal(a->active_min, b->active_min, sizeof a->active_min);
    assert_memory_equal(a->active_max, b->active_max, sizeof a->active_max);
    for (int i = 0; i < 12; i++)
        assert_true(fabs(b->index_to_world[i / 4][i % 4] - transform[i / 4][i % 4]) <= 1e-9);
    struct whole whole = load_whole(read);
    for (int n = 0; n < 50000; n++) {
        int at[3], seed = n * 7919;
        for (int i = 0; i < 3; i++, seed /= 101)
            at[i] = seed % 101 - 50;
        double d = sqrt((double)(at[0] * at[0] + at[1] * at[1] + at[2] * at[2])) - 40;
        float expected = (float)(d < -3 ? -3 : d > 3 ? 3 : d);
        float got =
            brick_voxel(whole.store, at[0] + centre[0], at[1] + centre[1], at[2] + centre[2]);
        assert_true(got == expected);
    }
    free_whole(&whole);
    weft_volume_destroy(&read);
    weft_volume_destroy(&made);
}

static void test_tiles(void **state)
{
    (void)state;
    const struct weft_volume_tile tiles[] = {
        {{8, 16, 24}, 8, 1}, {{-128, 0, 128}, 128, 2}, {{4096, -4096, 8192}, 4096, 3}};
    struct weft_volume_bricks_params params = {
        .tile_count = WEFT_COUNT(tiles), .tiles = tiles, .background = 0.5f, .log = &test_log};
    weft_volume *made = NULL;
    assert_int_equal(weft_volume_create_bricks(&params, &made), WEFT_OK);
    weft_volume *read = save_and_open(made, "tiles.vdb");
    struct weft_brick_list a, b;
    assert_int_equal(weft_volume_find(made, &everywhere, &a), WEFT_OK);
    assert_int_equal(weft_volume_find(read, &everywhere, &b), WEFT_OK);
    assert_int_equal(a.tile_count, 3);
    assert_int_equal(b.tile_count, 3);
    assert_memory_equal(a.tiles, b.tiles, 3 * sizeof *a.tiles);
    assert_true(weft_volume_get_info(read)->background == 0.5f);
    weft_brick_list_clear(&a);
    weft_brick_list_clear(&b);
    weft_volume_destroy(&read);
    weft_volume_destroy(&made);
}

static void test_empty(void **state)
{
    (void)state;
    struct weft_volume_bricks_params params = {.background = 4, .log = &test_log};
    weft_volume *made = NULL;
    assert_int_equal(weft_volume_create_bricks(&params, &made), WEFT_OK);
    assert_true(weft_volume_get_info(made)->empty);
    weft_volume *read = save_and_open(made, "empty.vdb");
    assert_true(weft_volume_get_info(read)->empty);
    struct whole whole = load_whole(read);
    assert_int_equal(whole.list.brick_count + whole.list.tile_count, 0);
    free_whole(&whole);
    weft_volume_destroy(&read);
    weft_volume_destroy(&made);
}

// Against every brick and tile tested by itself.
static void test_find(void **state)
{
    (void)state;
    weft_volume *made = make_sphere(60, nowhere, NULL);
    weft_volume *read = save_and_open(made, "find.vdb");
    struct weft_brick_list all, some;
    assert_int_equal(weft_volume_find(read, &everywhere, &all), WEFT_OK);
    assert_true(all.brick_count > 500 && all.tile_count > 50);
    srand(1);
    for (int n = 0; n < 300; n++) {
        struct weft_region region = {.slab_count = n % 4};
        for (int i = 0; i < 3; i++) {
            region.min[i] = rand() % 160 - 80;
            region.max[i] = region.min[i] + rand() % 100 - 5;
            region.slab[i].lower = rand() % 80 - 60;
            region.slab[i].upper = region.slab[i].lower + rand() % 20;
            for (int c = 0; c < 3; c++)
                region.slab[i].normal[c] = (rand() % 200 - 100) / 73.0;
        }
        assert_int_equal(weft_volume_find(read, &region, &some), WEFT_OK);
        size_t bricks = 0, tiles = 0;
        for (size_t i = 0; i < all.brick_count; i++)
            if (weft_region_meets(&region, all.brick_origin[i], 8)) {
                assert_true(bricks < some.brick_count);
                assert_memory_equal(some.brick_origin[bricks++], all.brick_origin[i], 12);
            }
        for (size_t i = 0; i < all.tile_count; i++)
            if (weft_region_meets(&region, all.tiles[i].origin, all.tiles[i].size)) {
                assert_true(tiles < some.tile_count);
                assert_memory_equal(&some.tiles[tiles++], &all.tiles[i], sizeof *all.tiles);
            }
        assert_int_equal(bricks, some.brick_count);
        assert_int_equal(tiles, some.tile_count);
        weft_brick_list_clear(&some);
    }
    const int32_t missing[1][3] = {{0, 0, 0}};
    float values[512];
    assert_int_equal(weft_volume_read(read, 1, missing, values), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_volume_read(made, 1, missing, values), WEFT_ERR_ARGUMENT);
    weft_brick_list_clear(&all);
    weft_volume_destroy(&read);
    weft_volume_destroy(&made);
}

static int fixture_value(int i, int j, int k)
{
    bool inside = i >= 0 && i < 20 && j >= 0 && j < 12 && k >= 0 && k < 9;
    return inside ? (i * 7 + j * 3 + k) % 50 + 1 : 0;
}

static bool make_fixtures(void)
{
    char command[1024];
    snprintf(command, sizeof command, "%s/make_vdb_fixtures %s", WEFT_BINARY_DIR, test_folder);
    return access(WEFT_BINARY_DIR "/make_vdb_fixtures", X_OK) == 0 && system(command) == 0;
}

static void test_types(void **state)
{
    (void)state;
    static const char *const files[] = {"types.vdb", "zip.vdb", "none.vdb"};
    static const char *const grids[] = {"float", "double", "half", "int32", "bool", "twin[1]"};
    if (!make_fixtures())
        skip();
    for (size_t f = 0; f < WEFT_COUNT(files); f++)
        for (size_t g = 0; g < WEFT_COUNT(grids); g++) {
            weft_volume *volume = open_file(file_path(files[f]), grids[g]);
            const struct weft_volume_info *info = weft_volume_get_info(volume);
            assert_string_equal(info->type, g < 5 ? grids[g] : "float");
            assert_string_equal(info->name, grids[g]);
            assert_int_equal(info->active_voxels, 20 * 12 * 9);
            struct whole whole = load_whole(volume);
            for (int k = -1; k < 17; k++)
                for (int j = -1; j < 17; j++)
                    for (int i = -1; i < 25; i++) {
                        int expected = fixture_value(i, j, k);
                        if (g == 4)
                            expected = expected != 0;
                        assert_true(brick_voxel(whole.store, i, j, k) == (float)expected);
                    }
            free_whole(&whole);
            weft_volume_destroy(&volume);
        }
}

static void test_list(void **state)
{
    (void)state;
    static const struct {
        const char *name, *type;
        bool supported;
    } expected[] = {
        {"vec3s", "vec3s", true},   {"float", "float", true},   {"double", "double", true},
        {"half", "half", true},     {"int32", "int32", true},   {"bool", "bool", true},
        {"twin[0]", "float", true}, {"twin[1]", "float", true}, {"int64", "int64", false},
        {"vec3d", "vec3d", true},   {"vec3h", "vec3h", true},   {"vec3i", "vec3i", true}};
    if (!make_fixtures())
        skip();
    struct weft_volume_list list;
    struct weft_volume_open_params params = {.path = file_path("types.vdb"), .log = &test_log};
    assert_int_equal(weft_volume_list_load(&params, &list), WEFT_OK);
    assert_int_equal(list.count, WEFT_COUNT(expected));
    for (size_t i = 0; i < list.count; i++) {
        assert_string_equal(list.grids[i].name, expected[i].name);
        assert_string_equal(list.grids[i].type, expected[i].type);
        assert_int_equal(list.grids[i].supported, expected[i].supported);
        assert_int_equal(list.grids[i].components, strncmp(expected[i].type, "vec3", 4) ? 1 : 3);
        assert_int_equal(list.grids[i].active_voxels, 20 * 12 * 9);
        assert_int_equal(list.grids[i].active_max[0], 19);
    }
    bool cut = false;
    for (size_t i = 0; i < list.grids[7].metadata_count; i++) {
        const struct weft_metadata *entry = &list.grids[7].metadata[i];
        cut = cut || (!strcmp(entry->key, "note") && strlen(entry->value) == 191 &&
                      !strcmp(entry->value + 188, "..."));
    }
    assert_true(cut);
    weft_volume_list_clear(&list);
}

static void test_refused(void **state)
{
    (void)state;
    static const struct {
        const char *file, *grid, *message;
        enum weft_result result;
    } cases[] = {
        {"types.vdb", "absent", "'vec3s' (vec3s), 'float' (float), 'double' (double)",
         WEFT_ERR_ARGUMENT},
        {"types.vdb", "int64", "type int64", WEFT_ERR_UNSUPPORTED},
        {"frustum.vdb", NULL, "frustum", WEFT_ERR_UNSUPPORTED},
        {"far.vdb", NULL, "1073741824", WEFT_ERR_LIMIT},
        {"streamed.vdb", NULL, "streamed", WEFT_ERR_UNSUPPORTED},
        {"missing.vdb", NULL, "missing.vdb: No such file", WEFT_ERR_OPEN},
        {".", NULL, ". is a folder", WEFT_ERR_OPEN},
    };
    if (!make_fixtures())
        skip();
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_volume *volume = NULL;
        struct weft_volume_open_params params = {
            .path = file_path(cases[i].file), .grid = cases[i].grid, .log = &test_log};
        assert_int_equal(weft_volume_open(&params, &volume), cases[i].result);
        assert_null(volume);
        if (!strstr(last_error.message, cases[i].message))
            fail_msg("'%s' lacks '%s'", last_error.message, cases[i].message);
    }
}

static void test_bad_arguments(void **state)
{
    (void)state;
    float data[8] = {0};
    weft_volume *volume = NULL;
    const struct {
        struct weft_volume_params *params;
        enum weft_result result;
    } cases[] = {
        {weft_volume_params(.size = {2, 2, 0}, .data = data), WEFT_ERR_ARGUMENT},
        {weft_volume_params(.size = {2, 2, 2}), WEFT_ERR_ARGUMENT},
        {weft_volume_params(.size = {2, 2, 2}, .data = data, .index_to_world = {{1}, {1}, {1}}),
         WEFT_ERR_ARGUMENT},
        {weft_volume_params(.size = {2, 2, 2}, .data = data, .origin = {1 << 30, 0, 0}),
         WEFT_ERR_LIMIT},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        assert_int_equal(weft_volume_create(cases[i].params, &volume), cases[i].result);
    const int32_t twice[2][3] = {{8, 8, 8}, {8, 8, 8}};
    float values[1024] = {0};
    struct weft_volume_bricks_params bricks = {
        .brick_count = 2, .brick_origin = twice, .brick_values = values, .log = &test_log};
    assert_int_equal(weft_volume_create_bricks(&bricks, &volume), WEFT_ERR_ARGUMENT);
    const struct weft_volume_tile cover = {{0, 0, 0}, 128, 1};
    bricks.brick_count = 1;
    bricks.tile_count = 1;
    bricks.tiles = &cover;
    assert_int_equal(weft_volume_create_bricks(&bricks, &volume), WEFT_ERR_ARGUMENT);
    weft_volume_destroy(&volume);
}

static void test_no_clobber(void **state)
{
    (void)state;
    weft_volume *made = make_sphere(10, nowhere, NULL);
    struct weft_volume_save_params params = {
        .path = file_path("once.vdb"), .no_clobber = true, .log = &test_log};
    assert_int_equal(weft_volume_save(made, &params), WEFT_OK);
    assert_int_equal(weft_volume_save(made, &params), WEFT_ERR_WRITE);
    params.no_clobber = false;
    params.path = file_path("small.vdb");
    params.limits.output_bytes = 1000;
    assert_int_equal(weft_volume_save(made, &params), WEFT_ERR_LIMIT);
    assert_non_null(strstr(last_error.message, "1000 bytes"));
    assert_int_equal(access(file_path("small.vdb"), F_OK), -1);
    weft_volume_destroy(&made);
}

static void test_real(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        int size[3];
    } cases[] = {{WEFT_TEST_DATA "/smoke.vdb", {111, 222, 112}},
                 {WEFT_TEST_DATA "/mri.vdb", {201, 249, 210}}};
    size_t missing = 0;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        if (access(cases[i].path, R_OK)) {
            print_message("[  SKIPPED ] %s is not here\n", cases[i].path);
            missing++;
            continue;
        }
        weft_volume *volume = open_file(cases[i].path, NULL);
        const struct weft_volume_info *info = weft_volume_get_info(volume);
        assert_string_equal(info->type, "half");
        for (int c = 0; c < 3; c++)
            assert_int_equal(info->active_max[c] - info->active_min[c] + 1, cases[i].size[c]);
        struct whole whole = load_whole(volume);
        assert_int_equal(whole.list.brick_count, info->bricks);
        for (size_t v = 0; v < whole.list.brick_count * 512; v++)
            assert_true(isfinite(whole.values[v]));
        free_whole(&whole);
        weft_volume_destroy(&volume);
    }
    if (missing == WEFT_COUNT(cases))
        skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dense),      cmocka_unit_test(test_clamped_find),
        cmocka_unit_test(test_level_set),  cmocka_unit_test(test_tiles),
        cmocka_unit_test(test_empty),      cmocka_unit_test(test_find),
        cmocka_unit_test(test_types),      cmocka_unit_test(test_list),
        cmocka_unit_test(test_refused),    cmocka_unit_test(test_bad_arguments),
        cmocka_unit_test(test_no_clobber), cmocka_unit_test(test_real),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
