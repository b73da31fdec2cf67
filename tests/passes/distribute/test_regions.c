// SPDX-License-Identifier: BSD-3-Clause
// Regions cover every pixel of a picture once, whatever sizes are asked for.
#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "passes/distribute/schedule/schedule.h"
#include "tests/passes/distribute/cover.h"
#include "tests/support/common.h"

static weft_regions *make(const struct weft_regions_params *params)
{
    weft_regions *regions = NULL;
    struct weft_regions_params p = *params;
    p.log = &log_to_stderr;
    assert_int_equal(weft_regions_create(&p, &regions), WEFT_OK);
    return regions;
}

static void names_are_those_of_the_enum(void **state)
{
    (void)state;
    static const char *const expected[] = {"auto", "static", "dynamic", "pull"};
    for (int i = 0; i < WEFT_SCHEDULE_COUNT; i++)
        assert_string_equal(weft_schedule_names[i], expected[i]);
    assert_null(weft_schedule_names[WEFT_SCHEDULE_COUNT]);
}

static void every_pixel_is_covered_once(void **state)
{
    (void)state;
    static const int32_t sides[] = {1, 2, 3, 7, 64, 65, 100, 509, 512};
    static const int32_t sizes[] = {0, 1, 7, 64, INT32_MAX};
    int ran = 0;
    for (size_t w = 0; w < WEFT_COUNT(sides); w++)
        for (size_t h = 0; h < WEFT_COUNT(sides); h++)
            for (size_t x = 0; x < WEFT_COUNT(sizes); x++)
                for (size_t y = 0; y < WEFT_COUNT(sizes); y++) {
                    weft_regions *regions =
                        make(weft_regions_params(.width = sides[w], .height = sides[h],
                                                 .region_width = sizes[x],
                                                 .region_height = sizes[y], .ranks = 1 + ran % 9));
                    assert_covers(regions, sides[w], sides[h], 1);
                    weft_regions_destroy(&regions);
                    ran++;
                }
    assert_int_equal(ran, 9 * 9 * 5 * 5);
}

static void a_size_that_is_asked_for_is_taken(void **state)
{
    (void)state;
    static const struct {
        struct weft_regions_params params;
        int64_t count, index;
        struct weft_rectangle region;
    } cases[] = {
        {{.width = 512, .height = 512, .region_width = 64, .region_height = 64},
         64,
         9,
         {64, 64, 64, 64}},
        {{.width = 512, .height = 512, .region_width = 7, .region_height = 7, .least = 9},
         74 * 74,
         74 * 74 - 1,
         {511, 511, 1, 1}},
        {{.width = 100, .height = 30, .region_height = 8}, 4, 3, {0, 24, 100, 6}},
        {{.width = 100, .height = 30, .region_width = 8}, 13, 12, {96, 0, 4, 30}},
        {{.width = 100, .height = 30, .region_width = 1000, .region_height = 1000},
         1,
         0,
         {0, 0, 100, 30}},
        {{.width = INT32_MAX,
          .height = INT32_MAX,
          .region_width = 1 << 21,
          .region_height = 1 << 21},
         1 << 20,
         (1 << 20) - 1,
         {1023 << 21, 1023 << 21, INT32_MAX - (1023 << 21), INT32_MAX - (1023 << 21)}},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_regions *regions = make(&cases[i].params);
        const struct weft_rectangle got = weft_regions_get(regions, cases[i].index);
        assert_int_equal(weft_regions_count(regions), cases[i].count);
        assert_memory_equal(&got, &cases[i].region, sizeof got);
        assert_int_equal(weft_regions_get(regions, -1).width, -1);
        assert_int_equal(weft_regions_get(regions, cases[i].count).height, -1);
        weft_regions_destroy(&regions);
        assert_null(regions);
    }
}

// The paper's 64 regions of 64 x 64 for 8 processors; others by hand.
static void by_granularity_regions_are_near_to_squares(void **state)
{
    (void)state;
    static const struct {
        struct weft_regions_params params;
        int64_t columns, rows;
    } cases[] = {
        {{.width = 512, .height = 512, .ranks = 8}, 8, 8},
        {{.width = 512, .height = 512, .ranks = 8, .granularity = 2}, 4, 4},
        {{.width = 512, .height = 512, .ranks = 7}, 8, 7},
        {{.width = 512, .height = 512}, 3, 3},
        {{.width = 1024, .height = 256, .ranks = 2}, 8, 2},
        {{.width = 64, .height = 1, .ranks = 3}, 24, 1},
        {{.width = 1, .height = 5, .ranks = 3}, 1, 5},
        {{.width = 512, .height = 512, .ranks = 1024, .least = 9}, 56, 56},
        {{.width = 512, .height = 512, .ranks = 1024}, 91, 91},
        {{.width = 20, .height = 20, .ranks = 1024, .least = 40}, 1, 1},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_regions_params *p = &cases[i].params;
        weft_regions *regions = make(p);
        const int64_t count = weft_regions_count(regions);
        int64_t columns = 0;
        while (columns < count && weft_regions_get(regions, columns).y == 0)
            columns++;
        if (columns != cases[i].columns || count != columns * cases[i].rows)
            fail_msg("%d x %d, %d ranks: %lld columns, %lld regions", p->width, p->height, p->ranks,
                     (long long)columns, (long long)count);
        assert_covers(regions, p->width, p->height, p->least < 20 ? p->least : 20);
        weft_regions_destroy(&regions);
    }
}

static void what_is_out_of_range_is_refused_with_the_numbers(void **state)
{
    (void)state;
    static const struct {
        struct weft_regions_params params;
        enum weft_result result;
        const char *text;
    } cases[] = {
        {{.width = 0, .height = 5}, WEFT_ERR_ARGUMENT, "width > 0"},
        {{.width = 5, .height = -1}, WEFT_ERR_ARGUMENT, "height > 0"},
        {{.width = 5, .height = 5, .region_width = -1}, WEFT_ERR_ARGUMENT, "region_width >= 0"},
        {{.width = 5, .height = 5, .ranks = -1}, WEFT_ERR_ARGUMENT, "ranks > 0"},
        {{.width = 5, .height = 5, .granularity = -1}, WEFT_ERR_ARGUMENT, "granularity > 0"},
        {{.width = 5, .height = 5, .least = INT_MIN}, WEFT_ERR_ARGUMENT, "least > 0"},
        {{.width = 2049, .height = 2048, .region_width = 1, .region_height = 1},
         WEFT_ERR_LIMIT,
         "2049 x 2048 regions of a picture of 2049 x 2048: there may be 4194304"},
        {{.width = INT_MAX, .height = INT_MAX, .ranks = INT_MAX, .granularity = INT_MAX},
         WEFT_ERR_LIMIT,
         "there may be 4194304"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_regions_params p = cases[i].params;
        p.log = &log;
        weft_regions *regions = (weft_regions *)&p;
        assert_int_equal(weft_regions_create(&p, &regions), cases[i].result);
        assert_null(regions);
        assert_int_equal(message.count, 1);
        if (!strstr(message.text, cases[i].text))
            fail_msg("\"%s\" instead of \"%s\"", message.text, cases[i].text);
    }
    weft_regions *most = make(
        weft_regions_params(.width = 2048, .height = 2048, .region_width = 1, .region_height = 1));
    assert_int_equal(weft_regions_count(most), WEFT_REGIONS_MAX);
    weft_regions_destroy(&most);
    weft_regions_destroy(&most);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_those_of_the_enum),
        cmocka_unit_test(every_pixel_is_covered_once),
        cmocka_unit_test(a_size_that_is_asked_for_is_taken),
        cmocka_unit_test(by_granularity_regions_are_near_to_squares),
        cmocka_unit_test(what_is_out_of_range_is_refused_with_the_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
