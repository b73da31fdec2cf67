// SPDX-License-Identifier: BSD-3-Clause
// Grids of every kind in VDB files that OpenVDB wrote: what the list tells, and what is read.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "filter/check.h"
#include "passes/slice/slice.h"
#include "tests/support/vdb_files.h"

enum { FIXTURE_VOXELS = 20 * 12 * 9 };

static int fixture_value(int i, int j, int k)
{
    return (i * 7 + j * 3 + k) % 50 + 1;
}

static int make_fixtures(void **state)
{
    char command[1024];
    if (make_folder(state))
        return -1;
    snprintf(command, sizeof command, "%s/make_vdb_fixtures %s", WEFT_BINARY_DIR, test_folder);
    return system(command) == 0 ? 0 : -1;
}

static enum weft_result open_grid(const char *file, const char *grid, weft_volume **out)
{
    const struct weft_volume_open_params params = {
        .path = file_path(file), .grid = grid, .log = &test_log};
    *last_error.message = 0;
    return weft_volume_open(&params, out);
}

static weft_volume *open_existing(const char *file, const char *grid)
{
    weft_volume *volume = NULL;
    if (open_grid(file, grid, &volume) != WEFT_OK)
        fail_msg("%s", last_error.message);
    return volume;
}

static struct weft_volume_list list_file(const char *file)
{
    struct weft_volume_list list;
    const struct weft_volume_open_params params = {.path = file_path(file), .log = &test_log};
    if (weft_volume_list_load(&params, &list) != WEFT_OK)
        fail_msg("%s", last_error.message);
    return list;
}

static const struct weft_volume_info *find_grid(const struct weft_volume_list *list,
                                                const char *name)
{
    for (size_t i = 0; i < list->count; i++)
        if (!strcmp(list->grids[i].name, name))
            return &list->grids[i];
    fail_msg("no grid %s", name);
    return NULL;
}

// The rows of the affine fixture's matrix are the images of i, j, k and the origin.
static const double affine[3][4] = {{0, -0.25, 0, 10}, {0.5, 0, 0, 20}, {0, 0.125, 2, 30}};

static void test_list(void **state)
{
    (void)state;
    static const struct {
        const char *name, *type;
        enum weft_result result;
        bool affine;
    } expected[] = {
        {"vector", "vec3s", WEFT_OK, true},
        {"int64", "int64", WEFT_ERR_UNSUPPORTED, true},
        {"mask", "mask", WEFT_ERR_UNSUPPORTED, false},
        {"points", "ptdataidx32", WEFT_ERR_UNSUPPORTED, true},
        {"tiny voxels", "float", WEFT_OK, false},
        {"owner", "float", WEFT_OK, false},
        {"instance", "float", WEFT_OK, true},
        {"tiles", "float", WEFT_OK, false},
        {"empty", "float", WEFT_OK, false},
        {"narrow double", "half", WEFT_OK, false},
        {"[0]", "float", WEFT_OK, false},
        {"[1]", "int32", WEFT_OK, false},
    };
    struct weft_volume_list list = list_file("kinds.vdb");
    assert_int_equal(list.count, WEFT_COUNT(expected));
    for (size_t i = 0; i < list.count; i++) {
        const struct weft_volume_info *info = &list.grids[i];
        assert_string_equal(info->name, expected[i].name);
        assert_string_equal(info->type, expected[i].type);
        assert_int_equal(info->result, expected[i].result);
        assert_int_equal(info->supported, expected[i].result == WEFT_OK);
        assert_int_equal(*info->problem != 0, expected[i].result != WEFT_OK);
        if (expected[i].affine)
            assert_memory_equal(info->index_to_world, affine, sizeof affine);
        double step = info->index_to_world[0][0];
        assert_true(expected[i].affine || step == (i == 4 ? 0.123456789 : 1.0));
    }
    assert_non_null(strstr(list.grids[1].problem, "int64"));
    assert_string_equal(list.grids[0].grid_class, "staggered");
    assert_false(find_grid(&list, "instance")->counted); // instances come without statistics
    assert_true(find_grid(&list, "empty")->counted && find_grid(&list, "empty")->empty);
    weft_volume_list_clear(&list);
    list = list_file("frustum.vdb");
    assert_int_equal(list.grids[0].result, WEFT_ERR_UNSUPPORTED);
    assert_non_null(strstr(list.grids[0].problem, "frustum"));
    assert_true(isnan(list.grids[0].index_to_world[0][0]));
    weft_volume_list_clear(&list);
}

// The fixtures' values, and `more`.
static void assert_voxels_and(weft_volume *volume, int more)
{
    struct weft_brick_list list;
    assert_int_equal(weft_volume_find(volume, &everywhere, &list), WEFT_OK);
    float *values = malloc((list.brick_count + 1) * 2048);
    assert_non_null(values);
    assert_int_equal(
        weft_volume_read(volume, list.brick_count, (const int32_t(*)[3])list.brick_origin, values),
        WEFT_OK);
    size_t seen = 0;
    for (size_t b = 0; b < list.brick_count; b++)
        for (int v = 0; v < 512; v++) {
            int i = list.brick_origin[b][0] + (v & 7), j = list.brick_origin[b][1] + (v >> 3 & 7),
                k = list.brick_origin[b][2] + (v >> 6);
            bool inside = i < 20 && j < 12 && k < 9;
            assert_true(values[b * 512 + (size_t)v] ==
                        (float)(inside ? fixture_value(i, j, k) + more : 0));
            seen += inside;
        }
    assert_int_equal(seen, FIXTURE_VOXELS);
    free(values);
    weft_brick_list_clear(&list);
}

static void assert_voxels(weft_volume *volume)
{
    assert_voxels_and(volume, 0);
}

static enum weft_result open_component(const char *file, const char *grid, int component,
                                       weft_volume **out)
{
    return weft_volume_open(weft_volume_open_params(.path = file_path(file), .grid = grid,
                                                    .component = component, .log = &test_log),
                            out);
}

// A component is a volume of its own; a staggered one's samples lie on their faces.
static void test_vectors(void **state)
{
    (void)state;
    static const char *const grids[] = {"vec3s", "vec3d", "vec3h", "vec3i"};
    weft_volume *volume = NULL;
    for (int g = 0; g < (int)WEFT_COUNT(grids) * 3; g++) {
        assert_int_equal(open_component("types.vdb", grids[g / 3], g % 3, &volume), WEFT_OK);
        const struct weft_volume_info *info = weft_volume_get_info(volume);
        assert_int_equal(info->components, 3);
        assert_int_equal(info->component, g % 3);
        assert_string_equal(info->type, grids[g / 3]);
        assert_voxels_and(volume, g % 3 * 100);
        weft_volume_destroy(&volume);
    }
    for (int c = 0; c < 3; c++) {
        assert_int_equal(open_component("kinds.vdb", "vector", c, &volume), WEFT_OK);
        const struct weft_volume_info *info = weft_volume_get_info(volume);
        assert_string_equal(info->grid_class, "staggered");
        for (int r = 0; r < 3; r++) {
            assert_memory_equal(info->index_to_world[r], affine[r], sizeof(double[3]));
            assert_true(info->index_to_world[r][3] == affine[r][3] - 0.5 * affine[r][c]);
        }
        weft_volume_destroy(&volume);
    }
    assert_int_equal(open_component("types.vdb", "vec3s", 3, &volume), WEFT_ERR_ARGUMENT);
    assert_int_equal(open_component("types.vdb", "vec3s", -1, &volume), WEFT_ERR_ARGUMENT);
    assert_int_equal(open_component("types.vdb", "float", 1, &volume), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last_error.message, "no component 1: a grid of float has 1"));
    assert_null(volume);
}

static void test_read(void **state)
{
    (void)state;
    static const char *const whole[] = {"tiny voxels", "owner", "instance", "narrow double",
                                        "[0]",         "[1]",   ""};
    for (size_t i = 0; i < WEFT_COUNT(whole); i++) {
        weft_volume *volume = open_existing("kinds.vdb", whole[i]);
        assert_int_equal(weft_volume_get_info(volume)->active_voxels, FIXTURE_VOXELS);
        assert_voxels(volume);
        if (i == 2)
            assert_memory_equal(weft_volume_get_info(volume)->index_to_world, affine,
                                sizeof affine);
        weft_volume_destroy(&volume);
    }
    weft_volume *volume = open_existing("kinds.vdb", "tiles");
    struct weft_brick_list list;
    assert_int_equal(weft_volume_find(volume, &everywhere, &list), WEFT_OK);
    assert_int_equal(list.brick_count, 0);
    assert_int_equal(list.tile_count, 2);
    assert_true(list.tiles[0].size == 128 && list.tiles[0].value == 8);
    assert_true(list.tiles[1].size == 8 && list.tiles[1].value == 7);
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
    volume = open_existing("kinds.vdb", "empty");
    assert_true(weft_volume_get_info(volume)->empty);
    assert_true(weft_volume_get_info(volume)->background == 5);
    weft_volume_destroy(&volume);
}

// Every listed name opens the grid that it is listed for, and is fit to be printed; so do the names
// as they are in the file.
static void test_names(void **state)
{
    (void)state;
    struct weft_volume_list list = list_file("names.vdb");
    assert_int_equal(list.count, 5);
    for (size_t i = 0; i < list.count; i++) {
        const struct weft_volume_info *info = &list.grids[i];
        char clean[256];
        snprintf(clean, sizeof clean, "%s", info->name);
        assert_string_equal(weft_text_clean(clean, false), info->name);
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(info->name, list.grids[j].name);
        weft_volume *volume = open_existing("names.vdb", info->name);
        assert_string_equal(weft_volume_get_info(volume)->name, info->name);
        assert_int_equal(weft_volume_get_info(volume)->active_voxels, info->active_voxels);
        weft_volume_destroy(&volume);
    }
    assert_int_equal(strlen(list.grids[0].name), 255);
    assert_string_equal(list.grids[0].name + 252, "...");
    assert_string_equal(list.grids[1].name + 249, "...[1]");
    assert_int_equal(list.grids[0].active_voxels, FIXTURE_VOXELS);
    assert_int_equal(list.grids[1].active_voxels, 1);
    assert_string_equal(list.grids[2].name, "?]0;owned??[31m??2Jweft: error: ??");
    for (size_t m = 0; m < list.grids[2].metadata_count; m++) {
        const struct weft_metadata *entry = &list.grids[2].metadata[m];
        assert_null(strpbrk(entry->key, "\x1b\n\xff"));
        assert_null(strpbrk(entry->value, "\x1b\xff"));
    }
    weft_volume_list_clear(&list);

    char *name = malloc(70001);
    assert_non_null(name);
    memset(name, 'm', 70000);
    name[70000] = 0;
    weft_volume *volume = open_existing("names.vdb", name);
    assert_string_equal(weft_volume_get_info(volume)->type, "bool");
    weft_volume_destroy(&volume);
    name[69999] = 'n';
    assert_int_equal(open_grid("names.vdb", name, &volume), WEFT_ERR_ARGUMENT);
    name[301] = 0;
    memset(name, 'n', 300);
    name[300] = '2';
    volume = open_existing("names.vdb", name);
    assert_int_equal(weft_volume_get_info(volume)->active_voxels, 1);
    weft_volume_destroy(&volume);
    free(name);
}

// 2^24 + n is a float for even n; -2147483647 is off by one. Largest float 3.4028235e38, smallest
// normal one 2^-126.
static void test_values(void **state)
{
    (void)state;
    static const struct {
        const char *grid;
        uint64_t rounded, infinite, tiny;
        double rounding;
    } cases[] = {
        {"integers", 257, 0, 0, 1},
        {"huge", 0, 201, 0, 0}, // and the background
        {"tiny", 0, 0, 100, 0},
        {"all", 0, 512, 0, 0},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_volume *volume = open_existing("values.vdb", cases[i].grid);
        const struct weft_volume_info *info = weft_volume_get_info(volume);
        assert_int_equal(info->values_rounded, cases[i].rounded);
        assert_int_equal(info->values_infinite, cases[i].infinite);
        assert_int_equal(info->values_tiny, cases[i].tiny);
        assert_true(info->largest_rounding == cases[i].rounding);
        weft_volume_destroy(&volume);
    }
}

// A volume and its rest are the stored values.
static void test_rest(void **state)
{
    (void)state;
    weft_volume *part[2] = {open_existing("values.vdb", "integers")};
    const struct weft_volume_open_params params = {
        .path = file_path("values.vdb"), .grid = "integers", .rest = true, .log = &test_log};
    assert_int_equal(weft_volume_open(&params, &part[1]), WEFT_OK);
    float values[2][512];
    const int32_t origin[1][3] = {{0, 0, 0}};
    for (int p = 0; p < 2; p++)
        assert_int_equal(weft_volume_read(part[p], 1, origin, values[p]), WEFT_OK);
    for (int n = 0; n < 512; n++)
        assert_true((double)values[0][n] + (double)values[1][n] == 0x1000000 + n);
    assert_true(weft_volume_get_info(part[1])->background == 0);
    weft_volume_destroy(&part[0]);
    weft_volume_destroy(&part[1]);
}

static struct weft_slice_plan_info plan_info(const char *file, const char *grid, const char *kernel)
{
    weft_volume *volume = open_existing(file, grid);
    struct weft_slice_params params = {
        .space = WEFT_SPACE_INDEX,
        .geometry = {
            .origin = {0, 0, 2.5}, .u = {7, 0, 0.5}, .v = {0, 7, 0.5}, .width = 4, .height = 4}};
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_kernel_parse(NULL, kernel, &params.kernel), WEFT_OK);
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    struct weft_slice_plan_info info = *weft_slice_plan_get_info(plan);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    return info;
}

// Bounds are of what is stored: integers are off by up to 1, doubles by half a unit of a float, and
// Catmull-Rom makes that up to 1.25^3 as much.
static void test_bounds(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        double gain;
    } cases[] = {{"nearest", 1.0}, {"linear", 1.0}, {"catmull-rom", 1.25 * 1.25 * 1.25}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const double gain = cases[i].gain;
        struct weft_slice_plan_info info = plan_info("values.vdb", "integers", cases[i].kernel);
        assert_true(fabs(info.output[0].bound.absolute_rounding - gain) < 1e-6);
        assert_true(info.output[0].error_absolute >= info.output[0].bound.absolute_rounding);
        const double exact = info.output[0].error_bound;
        info = plan_info("values.vdb", "tiny", cases[i].kernel);
        assert_true(info.output[0].bound.absolute_rounding == 0.0);
        assert_true(fabs((info.output[0].error_bound - exact) * 0x1p24 - gain) < 1e-3);
        assert_true(info.output[0].bound.relative + info.output[0].bound.sample_rounding ==
                    info.output[0].error_bound);
    }
}

// ---- damage -------------------------------------------------------------------------------------

// A copy in which bytes are replaced wherever they occur from the n-th occurrence on.
static void damage(const char *from, const char *to, const void *old, const void *new, size_t size,
                   int nth)
{
    size_t length;
    unsigned char *data = read_whole(file_path(from), &length);
    int count = 0;
    for (size_t at = 0; at + size <= length; at++)
        if (!memcmp(data + at, old, size) && ++count >= nth)
            memcpy(data + at, new, size);
    assert_true(count >= nth);
    write_whole(file_path(to), data, length);
    free(data);
}

static void test_one_damaged(void **state)
{
    (void)state;
    // A map that nobody knows, in one grid's header; a voxel size of 0.
    const double scale = 0.123456789, zero = 0;
    damage("kinds.vdb", "bad.vdb", "AffineMap", "FrailtMap", 9, 4);
    struct weft_volume_list list = list_file("bad.vdb");
    assert_int_equal(list.count, 12);
    const struct weft_volume_info *bad = find_grid(&list, "instance");
    assert_int_equal(bad->result, WEFT_ERR_FORMAT);
    assert_non_null(strstr(bad->problem, "FrailtMap"));
    assert_true(isnan(bad->index_to_world[0][0]));
    assert_int_equal(find_grid(&list, "tiles")->result, WEFT_OK);
    weft_volume_list_clear(&list);
    weft_volume *volume = NULL;
    assert_int_equal(open_grid("bad.vdb", "instance", &volume), WEFT_ERR_FORMAT);
    assert_non_null(strstr(last_error.message, "grid 'instance': "));
    volume = open_existing("bad.vdb", "owner");
    weft_volume_destroy(&volume);

    damage("kinds.vdb", "bad.vdb", &scale, &zero, 8, 1);
    list = list_file("bad.vdb");
    bad = find_grid(&list, "tiny voxels");
    assert_int_equal(bad->result, WEFT_ERR_FORMAT);
    assert_true(bad->index_to_world[0][0] == 0 && bad->index_to_world[0][3] == 0);
    assert_non_null(strstr(bad->problem, "singular"));
    weft_volume_list_clear(&list);
    assert_int_equal(open_grid("bad.vdb", "tiny voxels", &volume), WEFT_ERR_FORMAT);
}

// The grids before the cut are read; that in which it is, is named, and how many are behind it.
static void test_cut(void **state)
{
    (void)state;
    size_t length;
    unsigned char *data = read_whole(file_path("kinds.vdb"), &length);
    int seen = 0;
    for (int i = 1; i < 12; i++) {
        const size_t size = length * (size_t)i / 12;
        write_whole(file_path("cut.vdb"), data, size);
        struct weft_volume_list list = list_file("cut.vdb");
        const struct weft_volume_info *last = &list.grids[list.count - 1];
        assert_int_equal(last->result, WEFT_ERR_FORMAT);
        assert_non_null(strstr(last->problem, "cut short"));
        assert_true(list.count == 12 || strstr(last->problem, "more behind it"));
        for (size_t g = 0; g + 1 < list.count; g++) {
            weft_volume *volume = NULL;
            assert_int_equal(list.grids[g].supported,
                             open_grid("cut.vdb", list.grids[g].name, &volume) == WEFT_OK);
            seen += volume != NULL;
            weft_volume_destroy(&volume);
        }
        weft_volume_list_clear(&list);
    }
    assert_true(seen > 5);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_list),        cmocka_unit_test(test_vectors),
        cmocka_unit_test(test_read),        cmocka_unit_test(test_names),
        cmocka_unit_test(test_values),      cmocka_unit_test(test_rest),
        cmocka_unit_test(test_one_damaged), cmocka_unit_test(test_cut),
        cmocka_unit_test(test_bounds),
    };
    return cmocka_run_group_tests(tests, make_fixtures, remove_folder);
}
