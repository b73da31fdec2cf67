// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/division.h"

#include <unistd.h>

#include "tools/common/report.h"
#include "tools/ranks/ranks.h"

// The first run of a picture has none yet.
static enum weft_result load_map(const char *path, const int size[2], weft_cost_map **out)
{
    if (access(path, F_OK) == 0)
        return weft_cost_map_load(report_log(), path, size[0], size[1], out);
    const enum weft_result res = weft_cost_map_create(size[0], size[1], out);
    if (res == WEFT_ERR_MEMORY)
        report_error("out of memory for the cost map %s", path);
    return res;
}

enum weft_result rank_division_create(const struct rank_request *request, const int size[2],
                                      int granularity, int least, struct rank_division *out)
{
    *out = (struct rank_division){.path = request->cost_map};
    enum weft_result res = WEFT_OK;
    if (request->cost_map && ranks_tells())
        res = load_map(request->cost_map, size, &out->map);
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = ranks_agree(weft_division_create(
            ranks_get(),
            weft_division_params(.regions = rank_options_regions(request, size, granularity, least),
                                 .schedule = request->schedule, .map = out->map),
            &out->division));
    if (res != WEFT_OK)
        rank_division_clear(out);
    return res;
}

void rank_division_clear(struct rank_division *division)
{
    weft_division_destroy(&division->division);
    weft_cost_map_destroy(&division->map);
    *division = (struct rank_division){.path = NULL};
}

enum weft_result rank_division_save(const struct rank_division *division)
{
    enum weft_result res = WEFT_OK;
    if (division->map)
        res = weft_cost_map_save(report_log(), division->map, division->path);
    return ranks_agree(res);
}
