// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/division.h - the parts that the ranks of a command divide a picture into, frame after
// frame, and the cost map that --cost-map keeps for the next run. For each frame a verb does items
// of weft_division_regions() with weft_division_costs(), then weft_division_learn().
#ifndef WEFT_TOOLS_RANKS_DIVISION_H
#define WEFT_TOOLS_RANKS_DIVISION_H

#include "tools/ranks/options.h"

// Starts as {0}; the same on all ranks, but for the map, which is rank 0's.
struct rank_division {
    weft_division *division;
    weft_cost_map *map; // NULL: none is kept
    const char *path;   // borrowed from the request
};

// Divides a picture as is asked for (rank_options_regions), by the map where its file is there.
// Collective. Returns, on all ranks alike, what weft_division_create and weft_cost_map_load return,
// after an error line.
enum weft_result rank_division_create(const struct rank_request *request, const int size[2],
                                      int granularity, int least, struct rank_division *out);
void rank_division_clear(struct rank_division *division);

// Writes the map, where one is kept, once the outputs are. Collective. Returns, on all ranks alike,
// what weft_cost_map_save returns, after an error line.
enum weft_result rank_division_save(const struct rank_division *division);

#endif
