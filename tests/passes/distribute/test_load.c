// SPDX-License-Identifier: BSD-3-Clause
// Loads of ranks and their figures.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "passes/distribute/schedule/load.h"
#include "tests/support/common.h"

// The paper's: T = .53 s with .19 s idle is 35.8 %, and its dynamic T = .47 s with .12 s 25.5 %.
// imbalance = max / mean = 1 / (1 - idle share) where the busiest one is never idle.
static void figures_are_the_papers(void **state)
{
    (void)state;
    static const double cases[][4] = {{.53, .19, .358, 1.56}, {.47, .12, .255, 1.34}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_load load;
        struct weft_load_figures figures;
        assert_int_equal(weft_load_create(8, &load), WEFT_OK);
        load.seconds = cases[i][0];
        load.rank[0].busy = load.seconds;
        for (int r = 1; r < 8; r++)
            load.rank[r].busy = load.seconds - cases[i][1] * 8.0 / 7.0;
        weft_load_compute(&load, &figures);
        assert_near(figures.idle_share, cases[i][2], 5e-4, "idle share");
        assert_near(figures.imbalance, cases[i][3], 5e-3, "imbalance");
        assert_near(figures.mean_busy, cases[i][0] - cases[i][1], 1e-12, "mean");
        assert_near(figures.largest_busy, cases[i][0], 0.0, "largest");
        weft_load_clear(&load);
        assert_null(load.rank);
    }
}

static void loads_of_works_add_up(void **state)
{
    (void)state;
    struct weft_load sum, one;
    assert_int_equal(weft_load_create(3, &sum), WEFT_OK);
    assert_int_equal(weft_load_create(3, &one), WEFT_OK);
    one.seconds = 2.0;
    for (int r = 0; r < 3; r++) {
        one.rank[r] = (struct weft_rank_load){
            .busy = r * .5, .taking = r ? 0.0 : .25, .items = r + 1, .bytes = 100u * (unsigned)r};
        snprintf(one.rank[r].host, sizeof one.rank[r].host, "node%d", r);
    }
    weft_load_add(&sum, &one);
    weft_load_add(&sum, &one);
    assert_near(sum.seconds, 4.0, 0.0, "seconds");
    for (int r = 0; r < 3; r++) {
        assert_near(sum.rank[r].busy, r, 0.0, "busy");
        assert_near(sum.rank[r].taking, r ? 0.0 : .5, 0.0, "taking");
        assert_int_equal(sum.rank[r].items, 2 * (r + 1));
        assert_int_equal(sum.rank[r].bytes, 200 * r);
        assert_string_equal(sum.rank[r].host, one.rank[r].host);
    }
    struct weft_load_figures figures;
    weft_load_compute(&sum, &figures);
    assert_near(figures.idle_share, 1.0 - 3.0 / (3.0 * 4.0), 0.0, "idle share");
    assert_near(figures.imbalance, 2.0, 0.0, "imbalance");
    weft_load_clear(&sum);
    weft_load_clear(&one);
}

static void nothing_done_is_no_idle_time(void **state)
{
    (void)state;
    struct weft_load load = {.ranks = -1};
    struct weft_load_figures figures;
    assert_int_equal(weft_load_create(0, &load), WEFT_ERR_ARGUMENT);
    assert_int_equal(load.ranks, 0);
    weft_load_compute(&load, &figures);
    assert_near(figures.idle_share, 0.0, 0.0, "idle share");
    assert_near(figures.imbalance, 1.0, 0.0, "imbalance");
    weft_load_clear(&load);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_are_the_papers),
        cmocka_unit_test(loads_of_works_add_up),
        cmocka_unit_test(nothing_done_is_no_idle_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
