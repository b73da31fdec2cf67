// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ranks/options.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/ranks/load_report.h"
#include "tools/ranks/ranks.h"

enum { MOST_PIXELS = 1 << 24, MOST_SECONDS = 86400 };

// A whole number of pixels that ends where *text is left; 0: there is none.
static int32_t read_pixels(const char **text)
{
    char *end;
    if (!isdigit((unsigned char)**text))
        return 0;
    errno = 0;
    const long value = strtol(*text, &end, 10);
    *text = end;
    return errno == 0 && value >= 1 && value <= MOST_PIXELS ? (int32_t)value : 0;
}

// N, WxH, rows:N or frame.
static bool parse_region(const char *text, int32_t region[2])
{
    static const char rows[] = "rows:";
    const bool whole_rows = strncmp(text, rows, sizeof rows - 1) == 0;
    if (strcmp(text, "frame") == 0) {
        region[0] = region[1] = -1;
        return true;
    }
    if (whole_rows)
        text += sizeof rows - 1;
    region[0] = region[1] = read_pixels(&text);
    if (region[0] && *text == 'x' && !whole_rows) {
        text++;
        region[1] = read_pixels(&text);
    }
    if (whole_rows)
        region[0] = 0;
    return region[1] && !*text;
}

static enum weft_result read_region(const struct option_value *o, struct rank_request *out)
{
    const char *text = o[RANK_REGION].text;
    if (!o[RANK_REGION].given)
        return WEFT_OK;
    if (!parse_region(text, out->region))
        report_error("--region %s: not N, WxH or rows:N with whole numbers of pixels from 1 to %d, "
                     "nor frame",
                     text, MOST_PIXELS);
    else if (o[RANK_GRANULARITY].given)
        report_error("--region %s and --granularity %s: a picture is divided by one of them", text,
                     o[RANK_GRANULARITY].text);
    else if (out->region[0] < 0 && out->schedule == WEFT_SCHEDULE_DYNAMIC)
        report_error("--region frame and --schedule dynamic: pictures that are not divided have no "
                     "boundaries that could follow the load; --schedule pull gives them to who is "
                     "free");
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_timeout(const struct option_value *value)
{
    double seconds = 0.0;
    enum weft_result res = options_read_number(value, "rank-timeout", 0.5, MOST_SECONDS,
                                               "not from 0.5 to 86400 seconds", &seconds);
    return res == WEFT_OK && value->given ? weft_ranks_set_timeout(ranks_get(), seconds) : res;
}

// Only where they will be written.
static enum weft_result check_outputs(const struct rank_request *request)
{
    const char *map = request->cost_map;
    if (map && (strcmp(map, "-") == 0 || paths_is_special(map))) {
        report_error("--cost-map %s: it is read and written, which takes a file", map);
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = WEFT_OK;
    if (map && ranks_tells())
        res = paths_check_output(map, false);
    if (res == WEFT_OK && request->chart && ranks_tells())
        res = load_report_check_plot(request->chart);
    return res;
}

enum weft_result rank_options_read(const struct option_value *first, struct rank_request *out)
{
    *out = (struct rank_request){
        .schedule = (enum weft_schedule)first[RANK_SCHEDULE].integer[0],
        .mixed = first[RANK_MIXED].given,
        .cost_map = first[RANK_COST_MAP].text,
        .chart = first[RANK_CHART].text,
    };
    for (int i = 0; i < RANK_OPTION_COUNT; i++)
        out->given = out->given || first[i].given;
    enum weft_result res = read_region(first, out);
    if (res == WEFT_OK)
        res = options_read_whole(&first[RANK_GRANULARITY], "granularity", 1, WEFT_REGIONS_MAX,
                                 &out->granularity);
    if (res == WEFT_OK)
        res = read_timeout(&first[RANK_TIMEOUT]);
    return res == WEFT_OK ? check_outputs(out) : res;
}

struct weft_regions_params rank_options_regions(const struct rank_request *request,
                                                const int size[2], int granularity, int least)
{
    struct weft_regions_params params =
        *weft_regions_params(.width = size[0], .height = size[1], .ranks = ranks_size(),
                             .least = least,
                             .granularity =
                                 request->granularity ? request->granularity : granularity,
                             .log = report_log());
    if (request->region[1]) {
        const bool whole = request->region[0] < 0;
        params.region_width = whole ? size[0] : request->region[0];
        params.region_height = whole ? size[1] : request->region[1];
    }
    return params;
}
