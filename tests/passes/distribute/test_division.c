// SPDX-License-Identifier: BSD-3-Clause
// A picture that is divided frame after frame: what is learnt moves boundaries, or orders items.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "passes/distribute/division.h"
#include "tests/passes/distribute/cover.h"
#include "tests/passes/distribute/threads_transport.h"
#include "tests/support/common.h"

enum { SIDE = 256 };

// What a region takes in this test: its pixels, those of the right quarter 20 times.
static double cost_of(const struct weft_rectangle *r)
{
    const int32_t dear = r->x + r->width - (r->x > SIDE * 3 / 4 ? r->x : SIDE * 3 / 4);
    return 1e-6 * r->height * (r->width + 19.0 * (dear > 0 ? dear : 0));
}

// A report as weft_ranks_do_items makes it: on other ranks only what they did themselves.
static struct weft_items_report work(const weft_division *division, enum weft_schedule schedule,
                                     int rank)
{
    const weft_regions *regions = weft_division_regions(division);
    const int64_t count = weft_regions_count(regions);
    struct weft_items_report report = {.schedule = schedule, .failed_rank = -1};
    report.item_seconds = calloc((size_t)count, sizeof *report.item_seconds);
    assert_non_null(report.item_seconds);
    for (int64_t i = 0; rank == 0 && i < count; i++) {
        const struct weft_rectangle r = weft_regions_get(regions, i);
        report.item_seconds[i] = cost_of(&r);
    }
    return report;
}

static double imbalance(const weft_regions *regions)
{
    double sum = 0.0, most = 0.0;
    for (int64_t i = 0; i < weft_regions_count(regions); i++) {
        const struct weft_rectangle r = weft_regions_get(regions, i);
        sum += cost_of(&r);
        most = larger(most, cost_of(&r));
    }
    return most * (double)weft_regions_count(regions) / sum;
}

static int rank_of(const weft_ranks *ranks)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    return info.rank;
}

static void learn(weft_ranks *ranks, weft_division *division, enum weft_schedule schedule)
{
    struct weft_items_report report = work(division, schedule, rank_of(ranks));
    assert_int_equal(weft_division_learn(division, &report), WEFT_OK);
    weft_items_report_clear(&report);
}

static enum weft_result frames(void *priv, weft_ranks *ranks)
{
    (void)priv;
    const struct weft_regions_params regions = {
        .width = SIDE, .height = SIDE, .ranks = 8, .log = &log_to_stderr};
    for (int s = 0; s < WEFT_SCHEDULE_COUNT; s++) {
        const enum weft_schedule schedule = (enum weft_schedule)s;
        weft_division *division = NULL;
        assert_int_equal(
            weft_division_create(
                ranks, weft_division_params(.regions = regions, .schedule = schedule), &division),
            WEFT_OK);
        const struct weft_rectangle first = weft_regions_get(weft_division_regions(division), 0);
        assert_null(weft_division_costs(division));
        for (int frame = 0; frame < 8; frame++) {
            learn(ranks, division, schedule == WEFT_SCHEDULE_AUTO ? WEFT_SCHEDULE_PULL : schedule);
            assert_covers(weft_division_regions(division), SIDE, SIDE, 1);
        }
        const struct weft_rectangle last = weft_regions_get(weft_division_regions(division), 0);
        const double *costs = weft_division_costs(division);
        if (schedule == WEFT_SCHEDULE_DYNAMIC) {
            assert_true(imbalance(weft_division_regions(division)) < 1.1);
        } else {
            assert_memory_equal(&first, &last, sizeof first);
        }
        if (schedule == WEFT_SCHEDULE_PULL || schedule == WEFT_SCHEDULE_AUTO) {
            assert_non_null(costs);
            assert_near(costs[0], cost_of(&first), 0.0, "cost");
        } else {
            assert_null(costs);
        }
        weft_division_destroy(&division);
    }
    return WEFT_OK;
}

// What a run learnt, the next one begins with.
static enum weft_result maps(void *priv, weft_ranks *ranks)
{
    (void)priv;
    const struct weft_regions_params regions = {.width = SIDE, .height = SIDE, .ranks = 8};
    weft_cost_map *map = NULL;
    if (rank_of(ranks) == 0)
        assert_int_equal(weft_cost_map_create(SIDE, SIDE, &map), WEFT_OK);
    for (int run = 0; run < 3; run++) {
        static const enum weft_schedule schedules[] = {WEFT_SCHEDULE_STATIC, WEFT_SCHEDULE_DYNAMIC,
                                                       WEFT_SCHEDULE_PULL};
        weft_division *division = NULL;
        assert_int_equal(weft_division_create(ranks,
                                              weft_division_params(.regions = regions, .map = map,
                                                                   .schedule = schedules[run]),
                                              &division),
                         WEFT_OK);
        const double *costs = weft_division_costs(division);
        const struct weft_rectangle first = weft_regions_get(weft_division_regions(division), 0);
        if (schedules[run] == WEFT_SCHEDULE_DYNAMIC)
            assert_true(imbalance(weft_division_regions(division)) < 1.1);
        else
            assert_true(imbalance(weft_division_regions(division)) > 3.0);
        if (schedules[run] == WEFT_SCHEDULE_PULL) {
            assert_non_null(costs);
            assert_near(costs[0], cost_of(&first), 1e-2 * costs[0], "cost");
        } else {
            assert_null(costs);
        }
        learn(ranks, division, schedules[run]);
        weft_division_destroy(&division);
    }
    weft_cost_map_destroy(&map);
    return WEFT_OK;
}

static enum weft_result refusals(void *priv, weft_ranks *ranks)
{
    (void)priv;
    static const struct weft_division_params bad[] = {
        {.regions = {.width = 0, .height = 5}},
        {.regions = {.width = 5, .height = 5}, .keep = 1.0},
        {.regions = {.width = 5, .height = 5}, .keep = (double)NAN},
        {.regions = {.width = 5, .height = 5}, .schedule = WEFT_SCHEDULE_COUNT},
        {.regions = {.width = 5, .height = 5}, .schedule = (enum weft_schedule) - 1},
    };
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_division_params p = bad[i];
        p.regions.log = &log;
        weft_division *division = (weft_division *)&p;
        assert_int_equal(weft_division_create(ranks, &p, &division), WEFT_ERR_ARGUMENT);
        assert_null(division);
        assert_int_equal(message.count, 1);
    }
    return WEFT_OK;
}

// ---- several ranks ------------------------------------------------------------------------------

// What a rank saw: nothing is asserted in its thread.
struct seen {
    enum weft_schedule schedule;
    bool refused; // this rank asks for what cannot be
    struct weft_rectangle region[8][64];
    double cost[8][64];
};

static enum weft_result watch(void *priv, weft_ranks *ranks)
{
    struct seen *seen = priv;
    const int rank = rank_of(ranks);
    weft_cost_map *map = NULL;
    weft_division *division = NULL;
    enum weft_result res = rank == 0 ? weft_cost_map_create(SIDE, SIDE, &map) : WEFT_OK;
    if (res == WEFT_OK)
        res = weft_division_create(
            ranks,
            weft_division_params(.regions = {.width = SIDE,
                                             .height = seen->refused ? 0 : SIDE,
                                             .ranks = 8},
                                 .map = map, .schedule = seen->schedule),
            &division);
    for (int frame = 0; frame < 8 && res == WEFT_OK; frame++) {
        struct weft_items_report report = work(division, seen->schedule, rank);
        const double *costs = weft_division_costs(division);
        for (int i = 0; i < 64; i++) {
            seen->region[frame][i] = weft_regions_get(weft_division_regions(division), i);
            seen->cost[frame][i] = costs ? costs[i] : -1.0;
        }
        res = weft_division_learn(division, &report);
        weft_items_report_clear(&report);
    }
    weft_division_destroy(&division);
    weft_cost_map_destroy(&map);
    return res;
}

static struct threads_outcome watch_all(int ranks, enum weft_schedule schedule, int refused,
                                        struct seen *seen)
{
    struct threads_params params = {.ranks = ranks,
                                    .seed = 3,
                                    .delay = 2e-4,
                                    .body = watch,
                                    .failing_rank = -1,
                                    .stopping_rank = -1};
    struct threads_outcome out;
    for (int r = 0; r < ranks; r++) {
        memset(&seen[r], 0, sizeof seen[r]);
        seen[r].schedule = schedule;
        seen[r].refused = r == refused;
        params.priv[r] = &seen[r];
    }
    threads_run(&params, &out);
    return out;
}

static void all_ranks_have_the_same(void **state)
{
    (void)state;
    static struct seen seen[3];
    for (int s = WEFT_SCHEDULE_STATIC; s < WEFT_SCHEDULE_COUNT; s++) {
        const struct threads_outcome out = watch_all(3, (enum weft_schedule)s, -1, seen);
        for (int r = 0; r < 3; r++) {
            assert_int_equal(out.result[r], WEFT_OK);
            assert_memory_equal(seen[r].region, seen[0].region, sizeof seen[0].region);
            assert_memory_equal(seen[r].cost, seen[0].cost, sizeof seen[0].cost);
        }
        const bool moved = memcmp(seen[0].region[0], seen[0].region[7], sizeof seen[0].region[0]);
        assert_int_equal(moved, s == WEFT_SCHEDULE_DYNAMIC);
        assert_int_equal(seen[2].cost[7][63] > 0.0, s == WEFT_SCHEDULE_PULL);
        assert_int_equal(out.left, 0);
    }
    // One that asks for what cannot be ends it for all.
    const struct threads_outcome out = watch_all(3, WEFT_SCHEDULE_DYNAMIC, 2, seen);
    for (int r = 0; r < 3; r++)
        assert_int_equal(out.result[r], WEFT_ERR_ARGUMENT);
}

static void run(weft_body body)
{
    assert_int_equal(
        weft_distribute_over(NULL, weft_distribute_params(.log = &log_to_stderr), body, NULL),
        WEFT_OK);
}

static void frames_teach_the_next_one(void **state)
{
    (void)state;
    run(frames);
}

static void maps_teach_the_next_run(void **state)
{
    (void)state;
    run(maps);
}

static void what_is_out_of_range_is_refused(void **state)
{
    (void)state;
    run(refusals);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_teach_the_next_one),
        cmocka_unit_test(maps_teach_the_next_run),
        cmocka_unit_test(what_is_out_of_range_is_refused),
        cmocka_unit_test(all_ranks_have_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
