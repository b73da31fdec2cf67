// SPDX-License-Identifier: BSD-3-Clause
// Parts of a verb's pictures, and the cost map that --cost-map reads and writes.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "tests/support/files.h"
#include "tests/tools/ranks/told.h"
#include "tools/ranks/division.h"
#include "tools/ranks/ranks.h"

static const int picture[2] = {80, 40};

// One frame of the schedule; *costs: what was known before of the first region; 0: nothing.
static enum weft_result run_frame(const struct rank_request *request, double *costs)
{
    struct rank_division d;
    enum weft_result res = rank_division_create(request, picture, 2, 1, &d);
    if (res != WEFT_OK) {
        assert_null(d.division);
        assert_null(d.map);
        return res;
    }
    double seconds[2] = {0.25, 0.75};
    const struct weft_items_report report = {.item_seconds = seconds,
                                             .schedule = request->schedule};
    assert_int_equal(weft_regions_count(weft_division_regions(d.division)), 2);
    *costs = weft_division_costs(d.division) ? weft_division_costs(d.division)[0] : 0.0;
    res = weft_division_learn(d.division, &report);
    if (res == WEFT_OK)
        res = rank_division_save(&d);
    rank_division_clear(&d);
    return res;
}

static enum weft_result runs(void *priv, weft_ranks *ranks)
{
    char told[2048];
    double costs;
    (void)priv;
    ranks_set(ranks);
    struct rank_request request = {.schedule = WEFT_SCHEDULE_PULL};
    assert_int_equal(run_frame(&request, &costs), WEFT_OK); // without a map
    assert_true(costs == 0.0);
    assert_int_equal(test_count_entries(test_folder), 2);
    request.cost_map = test_path("map");
    for (int run = 0; run < 2; run++) {
        assert_int_equal(run_frame(&request, &costs), WEFT_OK);
        assert_int_equal(test_count_entries(test_folder), 3);
        // An empty map takes all places for alike; the second run has the first one's.
        assert_true(run == 0 ? costs > 0.0 : costs > 0.249 && costs < 0.251);
    }
    test_write_file(request.cost_map, "weft-cost-map 1\npicture x\n", 26);
    const struct told file = told_begin();
    assert_int_equal(run_frame(&request, &costs), WEFT_ERR_FORMAT);
    told_end(file, told, sizeof told);
    assert_non_null(strstr(told, "map:2: picture: number 1 is \"x\""));
    assert_string_equal(strchr(told, '\n'), "\n"); // one line
    ranks_set(NULL);
    return WEFT_OK;
}

static void maps_are_read_and_written(void **state)
{
    (void)state;
    assert_int_equal(weft_distribute_over(NULL, weft_distribute_params(), runs, NULL), WEFT_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(maps_are_read_and_written, test_enter_folder,
                                        test_leave_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
