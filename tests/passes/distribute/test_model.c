// SPDX-License-Identifier: BSD-3-Clause
// The model of schedules: what can be computed by hand, the bounds of list scheduling, and what it
// says of the paper's case. WEFT_RANKS=full prints its table.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/passes/distribute/model.h"
#include "tests/passes/distribute/polygons.h"
#include "tests/support/common.h"

static const enum weft_schedule schedules[] = {WEFT_SCHEDULE_STATIC, WEFT_SCHEDULE_DYNAMIC,
                                               WEFT_SCHEDULE_PULL};

// A row of regions of one pixel with these costs, the same in all frames.
struct list {
    const double *seconds;
};

static double list_cost(const void *priv, int frame, const struct weft_rectangle *region)
{
    (void)frame;
    return ((const struct list *)priv)->seconds[region->x];
}

static struct model list_model(const struct list *list, int count, int processors,
                               enum weft_schedule schedule)
{
    return (struct model){
        .processors = processors,
        .frames = 1,
        .schedule = schedule,
        .params = {.width = count, .height = 1, .region_width = 1, .region_height = 1},
        .cost = list_cost,
        .priv = list};
}

static double run(const struct model *model, struct model_result *out)
{
    assert_true(model_run(model, out));
    const double seconds = out->load.seconds;
    weft_load_clear(&out->load);
    return seconds;
}

static void small_works_take_what_they_take_by_hand(void **state)
{
    (void)state;
    static const double seconds[] = {3.0, 3.0, 2.0, 2.0, 2.0}, rising[] = {1.0, 2.0, 3.0, 4.0};
    const struct list list = {seconds}, up = {rising};
    struct model_result r;
    struct model m = list_model(&list, 5, 1, WEFT_SCHEDULE_STATIC);
    assert_near(run(&m, &r), 12.0, 1e-12, "one processor");
    assert_near(r.idle_share, 0.0, 1e-12, "idle");
    m.processors = 2; // 3 2 2 and 3 2
    assert_near(run(&m, &r), 7.0, 1e-12, "static");
    assert_near(r.idle_share, 1.0 - 12.0 / 14.0, 1e-12, "idle");
    assert_near(r.imbalance, 7.0 / 6.0, 1e-12, "imbalance");
    assert_near(r.bound, 6.0 + 0.5 * 3.0, 1e-12, "bound");
    // The dearest first are 4/3 - 1/(3 P) of the best, 6, here (Graham 1969).
    m.schedule = WEFT_SCHEDULE_PULL;
    assert_near(run(&m, &r), (4.0 / 3.0 - 1.0 / 6.0) * 6.0, 1e-12, "pull");
    // In their order 1 3 and 2 4 are 6; the dearest first, as the second frame has them, 4 1 and
    // 3 2, are 5. As one work of two frames: 1 3 1 2 4 and 2 4 3.
    m = list_model(&up, 4, 2, WEFT_SCHEDULE_PULL);
    assert_near(run(&m, &r), 6.0, 1e-12, "pull, in order");
    m.frames = 2;
    assert_near(run(&m, &r), 11.0, 1e-12, "pull, then by cost");
    m.one_work = true;
    assert_near(run(&m, &r), 11.0, 1e-12, "pull, without a barrier");
    m.schedule = WEFT_SCHEDULE_STATIC; // 1 3 1 3 and 2 4 2 4
    assert_near(run(&m, &r), 12.0, 1e-12, "static, without a barrier");
}

static void messages_take_what_they_take_by_hand(void **state)
{
    (void)state;
    static const double seconds[] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    const struct list list = {seconds};
    struct model_result r;
    struct model m = list_model(&list, 4, 2, WEFT_SCHEDULE_STATIC);
    m.machine = (struct model_machine){.take = 0.1, .latency = 0.01};
    // Rank 0: 1, .1, 1, .1, then what came at 1.01 (taken at 1.1, before its second item: .1) and
    // 2.01 (taken at 2.3): 2.4, and the word that it is over.
    assert_near(run(&m, &r), 2.41, 1e-12, "static");
    assert_near(r.idle_share, 1.0 - 4.0 / (2.0 * 2.41), 1e-12, "idle");
    m.schedule = WEFT_SCHEDULE_PULL;
    // Rank 1 asks at 0, begins at .02, ends at 1.02; asks again, ends at 2.04. Rank 0 has taken its
    // own at 1.1 and what came at 1.03 at 1.2, ends at 2.2 and 2.3, takes what came at 2.05 until
    // 2.4.
    assert_near(run(&m, &r), 2.41, 1e-12, "pull");
    // From its second item on rank 1 asks ahead: of eight it does four, from .02, 1.04, 2.04 and
    // 3.04 on; rank 0 four and what came meanwhile.
    static const double more[] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    const struct list eight = {more};
    struct model ahead = list_model(&eight, 8, 2, WEFT_SCHEDULE_PULL);
    ahead.machine = (struct model_machine){.latency = 0.01};
    assert_near(run(&ahead, &r), 4.0 + 4 * 0.02 + 0.02, 1e-12, "asked when free");
    ahead.machine.ahead = 2.0;
    assert_near(run(&ahead, &r), 4.0 + 2 * 0.02 + 0.02, 1e-12, "asked ahead");
    m.machine.frame = 0.5, m.machine.start = 7.0, m.frames = 3;
    run(&m, &r);
    assert_near(r.completion, 7.0 + 3 * (2.41 + 0.5), 1e-12, "completion");
    // Room for one result: of 3 ranks with 2 items each rank 1 and 2 wait until rank 0, after its
    // first item, takes the first ones.
    static const double uneven[] = {4.0, 1.0, 1.0, 4.0, 1.0, 1.0, 4.0, 1.0, 1.0};
    const struct list waits = {uneven};
    m = list_model(&waits, 9, 3, WEFT_SCHEDULE_STATIC);
    m.machine.room = 1;
    // Rank 1's second one, ready at 2, goes at 4, its third, ready at 5, at 8.
    assert_near(run(&m, &r), 12.0, 1e-12, "room for one");
    m.machine.take = 1.0; // rank 0: 4 1, 1 1, 4 1, 1 1, 4 1, 1 1
    assert_near(run(&m, &r), 21.0, 1e-12, "room for one, and taking");
}

// Any costs: at least the mean and the dearest item, with pull at most the bound of list
// scheduling; static is its busiest rank.
static void pull_is_within_the_bounds_of_list_scheduling(void **state)
{
    (void)state;
    uint64_t seed = 9;
    int ran = 0;
    for (int i = 0; i < 100; i++) {
        double seconds[300], most = 0.0;
        const int count = 1 + (int)(299.0 * polygons_random(&seed));
        const int processors = 1 + (int)(63.0 * polygons_random(&seed));
        for (int k = 0; k < count; k++)
            seconds[k] = exp(4.0 * polygons_random(&seed));
        const struct list list = {seconds};
        for (int one = 0; one < 2; one++) {
            struct model_result r;
            struct model m = list_model(&list, count, processors, WEFT_SCHEDULE_PULL);
            m.frames = 2, m.one_work = one;
            m.machine.ahead = i % 2 ? 20.0 : 0.0; // of messages that take no time
            const double pulled = run(&m, &r);
            // An item that was asked for ahead may wait for one that takes as long.
            const double more = i % 2 ? m.frames * r.largest : 0.0;
            assert_true(pulled >= r.lower * (1 - 1e-12) &&
                        pulled <= (r.bound + more) * (1 + 1e-12));
            assert_near(r.idle_share, 1.0 - r.work / (processors * pulled), 1e-12, "idle");
            ran++;
        }
        struct model_result r;
        struct model m = list_model(&list, count, processors, WEFT_SCHEDULE_STATIC);
        for (int k = 0; k < processors; k++) {
            double busy = 0.0;
            for (int at = k; at < count; at += processors)
                busy += seconds[at];
            most = fmax(most, busy);
        }
        assert_near(run(&m, &r), most, 1e-9, "static");
    }
    assert_int_equal(ran, 200);
}

static void measured_costs_are_divided_by_area(void **state)
{
    (void)state;
    double seconds[2][6] = {{1, 2, 3, 4, 5, 6}, {10, 10, 10, 10, 10, 10}};
    const struct model_grid grid = {90, 20, 3, 2, 2, 0.5, seconds[0]};
    const struct weft_rectangle all = {0, 0, 90, 20}, cell = {30, 10, 30, 10},
                                half = {15, 0, 30, 10};
    assert_near(model_grid_cost(&grid, 0, &all), 0.5 + 21.0 - 3.0, 1e-12, "all");
    assert_near(model_grid_cost(&grid, 0, &cell), 5.0, 1e-12, "a cell");
    assert_near(model_grid_cost(&grid, 0, &half), 0.5 + 0.5 * (0.5 + 1.5), 1e-12, "two halves");
    assert_near(model_grid_cost(&grid, 1, &cell), 10.0, 1e-12, "the next frame");
}

// ---- the paper's case ---------------------------------------------------------------------------

static struct model picture(const struct polygons *polygons, int processors,
                            enum weft_schedule schedule, int granularity, int frames)
{
    return (struct model){.processors = processors,
                          .frames = frames,
                          .schedule = schedule,
                          .params = {.width = 512, .height = 512, .granularity = granularity},
                          .keep = 0.5,
                          .cost = polygons_cost,
                          .priv = polygons};
}

static bool is_full(void)
{
    const char *value = getenv("WEFT_RANKS");
    return value && strcmp(value, "full") == 0;
}

static void print(const char *what, const struct model *m, const struct model_result *r)
{
    if (is_full())
        print_message("%-28s %4d processors, %5lld regions, %-7s: idle %5.1f %%, imbalance %.2f, "
                      "bound %.2f of the mean\n",
                      what, m->processors, (long long)r->items, weft_schedule_names[m->schedule],
                      100.0 * r->idle_share, r->imbalance, r->bound * m->processors / r->work);
}

// 4,000 polygons of 50 pixels, 64 regions, 8 processors. Of random ones a processor has 500, which
// deviate by 4 %: static processors are idle for some 7 %, not for the paper's 35.8 %. Of four
// clusters they are idle for that. By load, or pulled, it is at most 10 %, but for the first frames
// of dynamic schedules; the paper's 25.5 % are of one step, without knowing what boundaries did.
static void the_papers_case(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int clusters;
        double spread;
        double static_least, static_most, dynamic_most, pull_most;
    } scenes[] = {
        {"random", 0, 0.0, 0.04, 0.11, 0.05, 0.05},
        {"8 clusters of 120 pixels", 8, 120.0, 0.20, 0.30, 0.10, 0.05},
        {"4 clusters of 60 pixels", 4, 60.0, 0.33, 0.39, 0.12, 0.05},
    };
    for (size_t s = 0; s < WEFT_COUNT(scenes); s++) {
        struct polygons p = polygons_make(4000, 512, scenes[s].clusters, scenes[s].spread, 1997);
        double idle[3];
        for (int k = 0; k < 3; k++) {
            struct model_result r;
            const struct model m = picture(&p, 8, schedules[k], 8, is_full() ? 50 : 12);
            run(&m, &r);
            print(scenes[s].name, &m, &r);
            idle[k] = r.idle_share;
        }
        if (!(idle[0] >= scenes[s].static_least && idle[0] <= scenes[s].static_most &&
              idle[1] <= scenes[s].dynamic_most && idle[2] <= scenes[s].pull_most))
            fail_msg("%s: idle %.3f, %.3f, %.3f", scenes[s].name, idle[0], idle[1], idle[2]);
        free(p.polygon_list);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_works_take_what_they_take_by_hand),
        cmocka_unit_test(messages_take_what_they_take_by_hand),
        cmocka_unit_test(pull_is_within_the_bounds_of_list_scheduling),
        cmocka_unit_test(measured_costs_are_divided_by_area),
        cmocka_unit_test(the_papers_case),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
