// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/division.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

// Rounds of moving boundaries by a map: each knows a region's load better than the one before.
enum { ROUNDS = 4 };

struct weft_division {
    weft_ranks *ranks;
    struct weft_division_params params;
    weft_regions *regions;
    int rank;
    double *seconds; // of the regions as they were last measured or estimated, the same on all
    bool known;      // that they are of the regions as they are
};

static bool takes_costs(enum weft_schedule schedule)
{
    return schedule == WEFT_SCHEDULE_PULL || schedule == WEFT_SCHEDULE_AUTO;
}

// Gives all ranks the seconds that rank 0 has.
static enum weft_result share(weft_division *d)
{
    const size_t bytes = (size_t)weft_regions_count(d->regions) * sizeof *d->seconds;
    void *data = d->seconds;
    size_t size = bytes;
    const enum weft_result res = weft_ranks_share(d->ranks, &data, &size);
    if (res != WEFT_OK || d->rank == 0)
        return res;
    memcpy(d->seconds, data, size < bytes ? size : bytes);
    free(data);
    return WEFT_OK;
}

// Whether all is well with all.
static enum weft_result agree(weft_division *d, enum weft_result res)
{
    char line[1] = "";
    return weft_ranks_agree(d->ranks, res, line, sizeof line, NULL);
}

static enum weft_result estimate(weft_division *d)
{
    for (int64_t i = 0; d->rank == 0 && i < weft_regions_count(d->regions); i++) {
        const struct weft_rectangle region = weft_regions_get(d->regions, i);
        d->seconds[i] = weft_cost_map_estimate(d->params.map, &region);
    }
    return share(d);
}

// What is known before the first frame. Only rank 0 knows whether there is a map.
static enum weft_result begin(weft_division *d)
{
    bool has_map = d->params.map != NULL;
    void *data = &has_map;
    size_t size = sizeof has_map;
    enum weft_result res = weft_ranks_share(d->ranks, &data, &size);
    if (res != WEFT_OK)
        return res;
    if (d->rank != 0) {
        has_map = *(bool *)data;
        free(data);
    }
    const bool moves = d->params.schedule == WEFT_SCHEDULE_DYNAMIC;
    for (int round = 0; has_map && moves && round < ROUNDS && res == WEFT_OK; round++) {
        res = estimate(d);
        if (res == WEFT_OK)
            res = agree(d, weft_regions_balance(d->regions, d->seconds, 0.0));
    }
    if (has_map && takes_costs(d->params.schedule) && res == WEFT_OK) {
        res = estimate(d);
        d->known = true;
    }
    return res;
}

enum weft_result weft_division_create(weft_ranks *ranks, const struct weft_division_params *params,
                                      weft_division **out)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    const struct weft_log *log = params->regions.log;
    enum weft_result res = WEFT_ERR_MEMORY;
    *out = NULL;
    weft_division *d = calloc(1, sizeof *d);
    if (!d) {
        weft_error(log, "not enough memory to divide a picture");
    } else {
        *d = (weft_division){.ranks = ranks, .params = *params, .rank = info.rank};
        if (!d->params.regions.ranks)
            d->params.regions.ranks = info.size;
        res = WEFT_ERR_ARGUMENT;
        weft_require_enum(log, params->schedule, WEFT_SCHEDULE_COUNT - 1);
        weft_require(log, params->keep >= 0.0 && params->keep < 1.0);
        res = weft_regions_create(&d->params.regions, &d->regions);
    }
    if (res == WEFT_OK) {
        const size_t count = (size_t)weft_regions_count(d->regions);
        d->seconds = calloc(count, sizeof *d->seconds);
        if (!d->seconds) {
            weft_error(log, "not enough memory for the costs of %zu regions", count);
            res = WEFT_ERR_MEMORY;
        }
    }
fail:;
    char line[1] = "";
    res = weft_ranks_agree(ranks, res, line, sizeof line, NULL);
    if (res == WEFT_OK)
        res = begin(d);
    if (res == WEFT_OK)
        *out = d;
    else
        weft_division_destroy(&d);
    return res;
}

void weft_division_destroy(weft_division **division)
{
    if (*division) {
        weft_regions_destroy(&(*division)->regions);
        free((*division)->seconds);
        free(*division);
    }
    *division = NULL;
}

const weft_regions *weft_division_regions(const weft_division *division)
{
    return division->regions;
}

const double *weft_division_costs(const weft_division *division)
{
    return division->known ? division->seconds : NULL;
}

static void keep_seconds(weft_division *d, const double *seconds)
{
    // A clock that stands still is no reason to refuse a cost.
    static const double least = 1e-12;
    for (int64_t i = 0; i < weft_regions_count(d->regions); i++) {
        const struct weft_rectangle region = weft_regions_get(d->regions, i);
        if (d->params.map)
            weft_cost_map_add(d->params.map, &region, seconds[i]);
        d->seconds[i] = fmax(seconds[i], least);
    }
}

enum weft_result weft_division_learn(weft_division *d, const struct weft_items_report *report)
{
    if (d->rank == 0)
        keep_seconds(d, report->item_seconds);
    const bool moves = report->schedule == WEFT_SCHEDULE_DYNAMIC;
    if (!moves && report->schedule != WEFT_SCHEDULE_PULL)
        return WEFT_OK;
    const enum weft_result res = share(d);
    if (res != WEFT_OK)
        return res;
    d->known = !moves;
    return moves ? agree(d, weft_regions_balance(d->regions, d->seconds, d->params.keep)) : res;
}
