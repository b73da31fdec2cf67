// SPDX-License-Identifier: BSD-3-Clause
// Cost maps: what is added comes back, in any regions and sizes; files come back as they were; any
// other file is refused with one line that says where and what.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "passes/distribute/schedule/cost_map.h"
#include "tests/support/common.h"
#include "tests/support/files.h"

static weft_cost_map *make(int32_t width, int32_t height)
{
    weft_cost_map *map = NULL;
    assert_int_equal(weft_cost_map_create(width, height, &map), WEFT_OK);
    return map;
}

// Adds a frame of regions, `seconds` for each pixel.
static void add_frame(weft_cost_map *map, int32_t width, int32_t height, int32_t side,
                      double (*seconds)(int32_t x, int32_t y))
{
    weft_regions *regions = NULL;
    assert_int_equal(
        weft_regions_create(weft_regions_params(.width = width, .height = height,
                                                .region_width = side, .region_height = side),
                            &regions),
        WEFT_OK);
    for (int64_t i = 0; i < weft_regions_count(regions); i++) {
        const struct weft_rectangle r = weft_regions_get(regions, i);
        double sum = 0.0;
        for (int32_t y = r.y; y < r.y + r.height; y++)
            for (int32_t x = r.x; x < r.x + r.width; x++)
                sum += seconds(x, y);
        weft_cost_map_add(map, &r, sum);
    }
    weft_regions_destroy(&regions);
}

static double flat(int32_t x, int32_t y)
{
    (void)x, (void)y;
    return 1e-6;
}

static double halves(int32_t x, int32_t y)
{
    (void)y;
    return x < 64 ? 1e-6 : 4e-6;
}

static void estimates_are_what_was_added(void **state)
{
    (void)state;
    static const int32_t sides[] = {1, 7, 64, 200};
    for (size_t i = 0; i < WEFT_COUNT(sides); i++) {
        weft_cost_map *map = make(200, 150);
        for (int frame = 0; frame < 3; frame++)
            add_frame(map, 200, 150, sides[i], flat);
        const struct weft_rectangle all = {0, 0, 200, 150}, some = {3, 10, 121, 1},
                                    one = {199, 149, 1, 1};
        assert_near(weft_cost_map_estimate(map, &all), 30000e-6, 1e-12, "all");
        assert_near(weft_cost_map_estimate(map, &some), 121e-6, 1e-14, "some");
        assert_near(weft_cost_map_estimate(map, &one), 1e-6, 1e-16, "a pixel");
        weft_cost_map_destroy(&map);
        assert_null(map);
    }
    weft_cost_map *map = make(128, 128);
    add_frame(map, 128, 128, 32, halves);
    const struct weft_rectangle left = {0, 0, 64, 128}, across = {60, 5, 8, 2};
    assert_near(weft_cost_map_estimate(map, &left), 64 * 128e-6, 1e-12, "left");
    assert_near(weft_cost_map_estimate(map, &across), 8e-6 + 32e-6, 1e-14, "across");
    weft_cost_map_destroy(&map);
}

static void what_is_not_known_counts_as_the_mean(void **state)
{
    (void)state;
    weft_cost_map *map = make(100, 100);
    const struct weft_rectangle all = {0, 0, 100, 100}, part = {0, 0, 50, 100},
                                rest = {50, 0, 50, 100};
    assert_true(weft_cost_map_estimate(map, &rest) > 0.0);
    weft_cost_map_add(map, &part, 3.0);
    assert_near(weft_cost_map_estimate(map, &part), 3.0, 1e-12, "part");
    assert_near(weft_cost_map_estimate(map, &rest), 3.0, 1e-12, "rest");
    weft_cost_map_add(map, &rest, 0.0);
    weft_cost_map_add(map, &all, 3.0); // the mean of two frames, of either half
    assert_near(weft_cost_map_estimate(map, &part), 2.25, 1e-12, "part");
    assert_near(weft_cost_map_estimate(map, &rest), .75, 1e-12, "rest");
    static const struct weft_rectangle none[] = {{-1, 0, 5, 5},  {0, 0, 101, 5},
                                                 {99, 99, 2, 1}, {0, 0, 0, 5},
                                                 {0, 0, 5, -5},  {INT32_MAX, 0, INT32_MAX, 1}};
    for (size_t i = 0; i < WEFT_COUNT(none); i++) {
        weft_cost_map_add(map, &none[i], 1e9);
        assert_near(weft_cost_map_estimate(map, &none[i]), 0.0, 0.0, "none");
    }
    static const double bad[] = {-1.0, (double)NAN, (double)INFINITY};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        weft_cost_map_add(map, &all, bad[i]);
    assert_near(weft_cost_map_estimate(map, &all), 3.0, 1e-12, "all");
    weft_cost_map_destroy(&map);
    assert_int_equal(weft_cost_map_create(0, 1, &map), WEFT_ERR_ARGUMENT);
    assert_null(map);
    map = make(INT32_MAX, 1); // the largest, one row
    const struct weft_rectangle most = {0, 0, INT32_MAX, 1};
    weft_cost_map_add(map, &most, 5.0);
    assert_near(weft_cost_map_estimate(map, &most), 5.0, 1e-12, "most");
    weft_cost_map_destroy(&map);
}

static void files_come_back_in_any_size(void **state)
{
    (void)state;
    static const int32_t sizes[][2] = {{128, 128}, {64, 64}, {1000, 30}, {7, 5}, {1, 1}};
    const char *path = test_path("map");
    weft_cost_map *map = make(128, 128);
    add_frame(map, 128, 128, 1, halves);
    assert_int_equal(weft_cost_map_save(&test_log, map, path), WEFT_OK);
    weft_cost_map_destroy(&map);
    for (size_t i = 0; i < WEFT_COUNT(sizes); i++) {
        const int32_t w = sizes[i][0], h = sizes[i][1];
        weft_cost_map *loaded = NULL;
        assert_int_equal(weft_cost_map_load(&test_log, path, w, h, &loaded), WEFT_OK);
        const struct weft_rectangle all = {0, 0, w, h}, left = {0, 0, w > 1 ? w / 2 : 1, h};
        const double total = 128 * 64 * 5e-6;
        assert_near(weft_cost_map_estimate(loaded, &all), total, 1e-9, "all");
        if (w % 2 == 0)
            assert_near(weft_cost_map_estimate(loaded, &left), total / 5, 1e-9, "left");
        weft_cost_map_destroy(&loaded);
    }
    assert_int_equal(test_count_entries(test_folder), 3); // with . and ..
}

static void a_file_that_is_loaded_and_saved_is_the_same(void **state)
{
    (void)state;
    weft_cost_map *map = make(301, 97), *loaded = NULL;
    for (int32_t i = 0; i < 90; i++) {
        const struct weft_rectangle region = {3 * i, i, 5, 7};
        weft_cost_map_add(map, &region, 1e-3 * (i % 7 + 1));
    }
    char path[2][600];
    for (int i = 0; i < 2; i++)
        snprintf(path[i], sizeof path[i], "%s", test_path(i ? "b" : "a"));
    assert_int_equal(weft_cost_map_save(&test_log, map, path[0]), WEFT_OK);
    assert_int_equal(weft_cost_map_load(&test_log, path[0], 301, 97, &loaded), WEFT_OK);
    assert_int_equal(weft_cost_map_save(&test_log, loaded, path[1]), WEFT_OK);
    size_t size[2];
    char *bytes[2] = {test_read_file(path[0], &size[0]), test_read_file(path[1], &size[1])};
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]), free(bytes[1]);
    weft_cost_map_destroy(&map);
    weft_cost_map_destroy(&loaded);
}

// ---- files that are none ------------------------------------------------------------------------

static enum weft_result load_bytes(const void *bytes, size_t size)
{
    weft_cost_map *map = NULL;
    char path[600];
    snprintf(path, sizeof path, "%s", test_path("map"));
    remove(path); // a file that is written over goes to the disk at once
    test_write_file(path, bytes, size);
    test_forget();
    const enum weft_result res = weft_cost_map_load(&test_log, path, 100, 50, &map);
    assert_int_equal(map != NULL, res == WEFT_OK);
    if (map) {
        const struct weft_rectangle all = {0, 0, 100, 50};
        const double seconds = weft_cost_map_estimate(map, &all);
        assert_true(seconds > 0.0 && isfinite(seconds));
    }
    weft_cost_map_destroy(&map);
    return res;
}

static void bad_files_are_refused_in_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"", "map:1: \"weft-cost-map\" was expected, not \"\""},
        {"P6\n1 1\n", "map:1: \"weft-cost-map\" was expected, not \"P6\""},
        {"weft-cost-map 2\n", "map:1: weft-cost-map: number 1 is \"2\": 1 to 1 are possible"},
        {"weft-cost-map 1 1\n", "map:1: weft-cost-map: \"1\" stands behind 1 numbers"},
        {"weft-cost-map 1\npicture 2\n", "map:2: picture: number 2 is missing"},
        {"weft-cost-map 1\npicture 2 0\n",
         "map:2: picture: number 2 is \"0\": 1 to 2.14748e+09 are possible"},
        {"weft-cost-map 1\npicture 2 1.5\n", "map:2: picture: 1.5 is no whole number"},
        {"weft-cost-map 1\npicture 2 2\ncells 65 2\n",
         "map:3: cells: number 1 is \"65\": 1 to 64 are possible"},
        {"weft-cost-map 1\npicture 2 2\ncells 3 2\n",
         "map: 3 x 2 cells of a picture of 2 x 2 pixels"},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3\n", "map:5: cells: number 2 is missing"},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3 -4\n",
         "map:5: cells: number 2 is \"-4\": 0 to 1e+18 are possible"},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3 nan\n",
         "map:5: cells: number 2 is \"nan\""},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3 1e400\n",
         "map:5: cells: number 2 is \"1e400\""},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3 4x\n",
         "map:5: cells: number 2 is \"4x\""},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2 3\n",
         "map:4: cells: \"3\" stands behind 2 numbers"},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n", "map:5: cells: number 1 is missing"},
        {"weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3 4\n\n5",
         "\"5\" stands behind 2 lines of cells"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        assert_int_equal(load_bytes(cases[i].text, strlen(cases[i].text)), WEFT_ERR_FORMAT);
        if (test_errors != 1 || !strstr(test_message, cases[i].message))
            fail_msg("%d lines, \"%s\" instead of \"%s\"", test_errors, test_message,
                     cases[i].message);
    }
    assert_int_equal(load_bytes("weft-cost-map 1\n\0picture", 24), WEFT_ERR_FORMAT);
    assert_non_null(strstr(test_message, "byte 16 is 0"));
    char *large = malloc(WEFT_COST_MAP_BYTES + 1);
    memset(large, ' ', WEFT_COST_MAP_BYTES + 1);
    assert_int_equal(load_bytes(large, WEFT_COST_MAP_BYTES + 1), WEFT_ERR_FORMAT);
    assert_non_null(strstr(test_message, "has more than 1048576 bytes"));
    free(large);
    weft_cost_map *map = NULL;
    assert_int_equal(weft_cost_map_load(&test_log, "/dev/zero", 1, 1, &map), WEFT_ERR_FORMAT);
    assert_int_equal(weft_cost_map_load(&test_log, test_folder, 1, 1, &map), WEFT_ERR_OPEN);
    assert_int_equal(weft_cost_map_load(&test_log, "/nonexistent/map", 1, 1, &map), WEFT_ERR_OPEN);
    assert_non_null(strstr(test_message, "/nonexistent/map: No such file"));
    map = make(3, 3);
    assert_int_equal(weft_cost_map_save(&test_log, map, "/nonexistent/map"), WEFT_ERR_WRITE);
    weft_cost_map_destroy(&map);
    static const char *const good[] = {
        "weft-cost-map 1\npicture 2 2\ncells 2 2\n1 2\n3 4\n",
        "\xef\xbb\xbfweft-cost-map 1\r\npicture 2 2 \r\ncells 2 1\r\n1.5\t2e3\r\n\r\n",
        "weft-cost-map 1\npicture 2147483647 1\ncells 1 1\n1e18",
        "weft-cost-map 1\npicture 1 1\ncells 1 1\n0",
    };
    for (size_t i = 0; i < WEFT_COUNT(good); i++)
        if (load_bytes(good[i], strlen(good[i])) != WEFT_OK)
            fail_msg("%zu: %s", i, test_message);
}

static uint64_t random_bits(uint64_t *seed)
{
    *seed ^= *seed << 13, *seed ^= *seed >> 7, *seed ^= *seed << 17;
    return *seed;
}

// Bytes changed, taken out and doubled: what is taken is a map, what is not has one line.
static void mutated_files_are_maps_or_refused(void **state)
{
    (void)state;
    static const char text[] = "weft-cost-map 1\npicture 12 8\ncells 4 3\n"
                               "100 200 300 400\n1 2 3 4\n99999 0 7 123456789\n";
    static const char put[] = "0123456789 \n.-+eExn\t\r\x80\xff";
    uint64_t seed = 42;
    int taken = 0, refused = 0;
    for (int run = 0; run < 4000; run++) {
        char bytes[2 * sizeof text];
        size_t size = sizeof text - 1;
        memcpy(bytes, text, size);
        for (uint64_t n = 1 + random_bits(&seed) % 3; n > 0; n--) {
            const size_t at = random_bits(&seed) % size,
                         end = at + random_bits(&seed) % (size - at);
            switch (random_bits(&seed) % 4) {
            case 0:
                memmove(bytes + at, bytes + end, size - end), size -= end - at;
                break;
            case 1:
                size = size > 1 && at > 0 ? at : size;
                break;
            default:
                bytes[at] = put[random_bits(&seed) % sizeof put];
                break;
            }
            if (size < 2)
                break;
        }
        const enum weft_result res = load_bytes(bytes, size);
        assert_true(res == WEFT_OK || res == WEFT_ERR_FORMAT);
        assert_int_equal(test_errors, res == WEFT_OK ? 0 : 1);
        taken += res == WEFT_OK;
        refused += res != WEFT_OK;
    }
    assert_true(taken > 100 && refused > 1000);
}

#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, test_enter_folder, test_leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(estimates_are_what_was_added),
        cmocka_unit_test(what_is_not_known_counts_as_the_mean),
        IN_FOLDER(files_come_back_in_any_size),
        IN_FOLDER(a_file_that_is_loaded_and_saved_is_the_same),
        IN_FOLDER(bad_files_are_refused_in_one_line),
        IN_FOLDER(mutated_files_are_maps_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
