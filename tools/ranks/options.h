// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/options.h - how the work of a verb is divided among ranks: the options that all verbs
// share which do.
#ifndef WEFT_TOOLS_RANKS_OPTIONS_H
#define WEFT_TOOLS_RANKS_OPTIONS_H

#include "tools/draw/plot.h"
#include "tools/options/options.h"
#include "weft.h"

enum rank_option {
    RANK_SCHEDULE,
    RANK_REGION,
    RANK_GRANULARITY,
    RANK_TIMEOUT,
    RANK_MIXED,
    RANK_COST_MAP,
    RANK_CHART,
    RANK_OPTION_COUNT
};

// A verb's table has them in this order from `first` on.
// clang-format off
#define RANK_OPTIONS(first)                                                                        \
    [(first) + RANK_SCHEDULE] = {.name = "schedule", 0, OPTION_CHOICE, NULL,                       \
        "of several ranks (mpirun): who does what: in turn, in turn with boundaries that follow "  \
        "the load, or whoever is free (default auto)",                                             \
        weft_schedule_names, .group = OPTION_RESOURCES},                                           \
    [(first) + RANK_REGION] = {.name = "region", 0, OPTION_TEXT, "N|WxH|rows:N|frame",             \
        "the parts that a picture is divided into, in pixels; rows: of whole rows; frame: "        \
        "pictures are not divided (default: by --granularity)", .group = OPTION_GEOMETRY},         \
    [(first) + RANK_GRANULARITY] = {.name = "granularity", 0, OPTION_NUMBER, "G",                  \
        "parts of a picture for each rank (default: the verb's)",                                  \
        .group = OPTION_RESOURCES},                                                                \
    [(first) + RANK_TIMEOUT] = {.name = "rank-timeout", 0, OPTION_NUMBER, "SECONDS",               \
        "without a sign of life after which a rank is given up, and the job is ended (default 6)", \
        .group = OPTION_RESOURCES},                                                                \
    [(first) + RANK_MIXED] = {.name = "mixed", 0, OPTION_FLAG, NULL,                               \
        "let ranks have different renderers, instructions or versions: bytes may then depend on "  \
        "who did what", .group = OPTION_METHOD},                                                   \
    [(first) + RANK_COST_MAP] = {.name = "cost-map", 0, OPTION_TEXT, "FILE",                       \
        "what places of the picture cost: read, where it is there, to divide it, and written",     \
        .group = OPTION_FILES, .names = OPTION_NAMES_FILE},                                        \
    [(first) + RANK_CHART] = {.name = "load-chart", 0, OPTION_OUTPUT, PLOT_VALUE,                  \
        "plot how busy each rank was", plot_endings, .group = OPTION_PICTURES}
// clang-format on

// What they say. Zero where an option was not given.
struct rank_request {
    bool given; // any of them
    enum weft_schedule schedule;
    int32_t region[2]; // 0, N: N whole rows; -1, -1: pictures are not divided; 0, 0: by
                       // granularity
    int granularity;   // 0: not given
    bool mixed;
    const char *cost_map, *chart; // NULL: none
};
// Reads them, sets the time-out of ranks_get(), and on rank 0 checks that what they name can be
// written. Texts are borrowed. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_WRITE or another result (no
// gnuplot for the chart) after an error line.
enum weft_result rank_options_read(const struct option_value *first, struct rank_request *out);

// How a picture is divided for the ranks there are. `granularity`: the verb's, where none is asked
// for; least: pixels that a side has at least (what filters reach), where no region's size is asked
// for. Regions larger than the picture are the picture.
struct weft_regions_params rank_options_regions(const struct rank_request *request,
                                                const int size[2], int granularity, int least);

#endif
