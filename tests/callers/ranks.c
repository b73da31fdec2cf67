// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static void schedules(void)
{
    struct weft_regions_params good = {.width = 20, .height = 10, .log = &logger};
    weft_regions *regions = NULL;
#define CALL (weft_regions_destroy(&regions), weft_regions_create(&p, &regions))
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, -1, CALL);
    ANY_INT(good, width, CALL);
    ANY_INT(good, height, CALL);
    ANY_INT(good, region_width, CALL);
    ANY_INT(good, region_height, CALL);
    ANY_INT(good, ranks, CALL);
    ANY_INT(good, granularity, CALL);
    ANY_INT(good, least, CALL);
#undef CALL
    weft_regions_destroy(&regions);
    TRUE(weft_regions_create(&good, &regions) == WEFT_OK);
    TRUE(weft_regions_get(regions, -1).width < 0);
    TRUE(weft_regions_get(regions, weft_regions_count(regions)).width < 0);
    double seconds[8] = {1.0};
    TRUE(weft_regions_count(regions) == 8);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const enum weft_result res = weft_regions_balance(regions, seconds, numbers[n]);
        TRUE((res == WEFT_OK) == (numbers[n] >= 0.0 && numbers[n] < 1.0));
        seconds[7] = numbers[n];
        TRUE(weft_regions_balance(regions, seconds, 0.0) ==
             (numbers[n] >= 0.0 && !isinf(numbers[n]) ? WEFT_OK : WEFT_ERR_ARGUMENT));
        seconds[7] = 0.0;
    }
    weft_regions_destroy(&regions);
    weft_regions_destroy(&regions);
    struct weft_load load, fewer = {0};
    TRUE(weft_load_create(0, &load) == WEFT_ERR_ARGUMENT && !load.rank);
    TRUE(weft_load_create(2, &load) == WEFT_OK);
    struct weft_load_figures figures;
    weft_load_add(&load, &fewer);
    weft_load_add(&fewer, &load);
    weft_load_compute(&fewer, &figures);
    TRUE(figures.idle_share == 0.0 && figures.imbalance == 1.0);
    load.rank[0].busy = NAN, load.seconds = -1.0;
    weft_load_compute(&load, &figures);
    weft_load_clear(&load);
    weft_load_clear(&load);
}

static enum weft_result idle_item(void *priv, int64_t item, void **data, size_t *size)
{
    (void)priv, (void)item, (void)data, (void)size;
    return WEFT_OK;
}

static enum weft_result idle_take(void *priv, int64_t item, const void *data, size_t size)
{
    (void)priv, (void)item, (void)data, (void)size;
    return WEFT_OK;
}

static enum weft_result ask_ranks(void *priv, weft_ranks *ranks)
{
    (void)priv;
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    TRUE(info.rank == 0 && info.size == 1 && info.threads > 0 && info.host[0]);
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        if (!(numbers[i] >= 0.5 && isfinite(numbers[i])))
            REFUSED(weft_ranks_set_timeout(ranks, numbers[i]));
    void *data = NULL;
    size_t size = 0;
    struct weft_ranks_part part;
    SURVIVED(weft_ranks_share(ranks, &data, &size));
    SURVIVED(weft_ranks_gather(ranks, NULL, 0, &part));
    weft_ranks_free_parts(1, &part);
    weft_ranks_free_parts(1, &part);
    char line[1] = "";
    TRUE(weft_ranks_agree(ranks, WEFT_ERR_GL, line, sizeof line, NULL) == WEFT_ERR_GL);
    SURVIVED(weft_ranks_compare(ranks, "", ""));

    struct weft_items_report report = {0};
    const double costs[2] = {1.0, 0.0};
    struct weft_items good = {.count = 2, .run = idle_item, .take = idle_take};
    TRUE(weft_ranks_do_items(ranks, &good, &report) == WEFT_OK && report.failed_rank == -1);
    weft_items_report_clear(&report);
    weft_items_report_clear(&report);
    weft_items_report_clear(NULL);
    BAD_ENUM(good, schedule, weft_ranks_do_items(ranks, &p, &report));
    struct weft_items bad = good;
    bad.count = -1;
    REFUSED(weft_ranks_do_items(ranks, &bad, &report));
    bad = good, bad.cost = costs;
    REFUSED(weft_ranks_do_items(ranks, &bad, &report));
    bad = good, bad.run = NULL;
    REFUSED(weft_ranks_do_items(ranks, &bad, &report));
    return WEFT_ERR_FORMAT;
}

static void several_ranks(void)
{
    const struct weft_distribute_params *params = weft_distribute_params(.log = &logger);
    TRUE(weft_distribute_over(NULL, params, ask_ranks, NULL) == WEFT_ERR_FORMAT);
    REFUSED(weft_distribute_over(NULL, params, NULL, NULL));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        if (numbers[i] != 0.0 && !(numbers[i] >= 0.5 && isfinite(numbers[i])))
            REFUSED(weft_distribute_over(
                NULL, weft_distribute_params(.timeout = numbers[i], .log = &logger), ask_ranks,
                NULL));
}

static void cost_maps(void)
{
    weft_cost_map *map = NULL;
    for (size_t n = 0; n < WEFT_COUNT(ints); n++) {
        TRUE((weft_cost_map_create(ints[n], 1, &map) == WEFT_OK) == (ints[n] > 0));
        weft_cost_map_destroy(&map);
        TRUE((weft_cost_map_create(1, ints[n], &map) == WEFT_OK) == (ints[n] > 0));
        weft_cost_map_destroy(&map);
        TRUE(weft_cost_map_load(&logger, "/nonexistent", ints[n], 1, &map) != WEFT_OK &&
             callers_lines > 0);
        callers_lines = 0;
    }
    REFUSED(weft_cost_map_load(&logger, NULL, 1, 1, &map));
    TRUE(!map && weft_cost_map_create(100, 100, &map) == WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        for (size_t k = 0; k < WEFT_COUNT(ints); k++) {
            const struct weft_rectangle across = {ints[i], 0, ints[k], 1};
            const struct weft_rectangle down = {0, ints[i], 1, ints[k]};
            weft_cost_map_add(map, &across, 1.0);
            weft_cost_map_add(map, &down, 1.0);
            TRUE(weft_cost_map_estimate(map, &across) >= 0.0);
            TRUE(weft_cost_map_estimate(map, &down) >= 0.0);
        }
    const struct weft_rectangle all = {0, 0, 100, 100};
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        weft_cost_map_add(map, &all, numbers[n]);
    TRUE(weft_cost_map_estimate(map, &all) > 0.0);
    REFUSED(weft_cost_map_save(&logger, map, NULL));
    REFUSED(weft_cost_map_save(&logger, map, "/nonexistent/map"));
    weft_cost_map_destroy(&map);
    weft_cost_map_destroy(&map);
}

static enum weft_result divide_badly(void *priv, weft_ranks *ranks)
{
    (void)priv;
    weft_division *division = NULL;
    struct weft_division_params good = {.regions = {.width = 20, .height = 10, .log = &logger}};
#define CALL (weft_division_destroy(&division), weft_division_create(ranks, &p, &division))
    BAD_ENUM(good, schedule, CALL);
    ANY_NUMBER(good, keep, CALL);
    ANY_INT(good, regions.width, CALL);
    ANY_INT(good, regions.least, CALL);
#undef CALL
    weft_division_destroy(&division);
    good.schedule = WEFT_SCHEDULE_DYNAMIC;
    TRUE(weft_division_create(ranks, &good, &division) == WEFT_OK);
    TRUE(weft_regions_count(weft_division_regions(division)) == 8);
    TRUE(!weft_division_costs(division));
    double seconds[8] = {NAN, INFINITY, -1.0};
    struct weft_items_report report = {.item_seconds = seconds, .schedule = WEFT_SCHEDULE_DYNAMIC};
    TRUE(weft_division_learn(division, &report) == WEFT_ERR_ARGUMENT);
    weft_division_destroy(&division);
    weft_division_destroy(&division);
    return WEFT_OK;
}

static void divisions(void)
{
    TRUE(weft_distribute_over(NULL, weft_distribute_params(.log = &logger), divide_badly, NULL) ==
         WEFT_OK);
}

const struct caller_case callers_ranks[] = {
    {schedules,
     {F(regions_create), F(regions_destroy), F(regions_count), F(regions_get), F(regions_balance),
      F(load_create), F(load_clear), F(load_add), F(load_compute)}},
    {several_ranks,
     {F(distribute_over), F(ranks_get_info), F(ranks_set_timeout), F(ranks_share), F(ranks_gather),
      F(ranks_free_parts), F(ranks_agree), F(ranks_compare), F(ranks_do_items),
      F(items_report_clear)}},
    {cost_maps,
     {F(cost_map_create), F(cost_map_destroy), F(cost_map_add), F(cost_map_estimate),
      F(cost_map_load), F(cost_map_save)}},
    {divisions,
     {F(division_create), F(division_destroy), F(division_regions), F(division_costs),
      F(division_learn)}},
    {0},
};
