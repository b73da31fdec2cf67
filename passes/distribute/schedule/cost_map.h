// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/schedule/cost_map.h - what a picture cost, place by place, kept for the next
// run of it: a grid of cells with the seconds that were spent in each.
#ifndef WEFT_PASSES_DISTRIBUTE_SCHEDULE_COST_MAP_H
#define WEFT_PASSES_DISTRIBUTE_SCHEDULE_COST_MAP_H

#include "schedule.h"

WEFT_BEGIN_DECLS

enum { WEFT_COST_MAP_CELLS = 64 }; // along a side, at most: a cell has at least a pixel

// Thread-safety: one thread at a time.
typedef struct weft_cost_map weft_cost_map;

// Of a picture of this size; nothing is known. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_cost_map_create(int32_t width, int32_t height, weft_cost_map **out);
WEFT_API void weft_cost_map_destroy(weft_cost_map **map); // accepts &NULL, leaves NULL behind

// Adds the seconds that a region took, spread evenly over its pixels. What is known of a cell is
// the mean of what was added to it, a cell that a region covers in part counting so much. A region
// that is not of the picture, and seconds that are not >= 0, are left out.
WEFT_API void weft_cost_map_add(weft_cost_map *map, const struct weft_rectangle *region,
                                double seconds);
// The seconds that a region would take, by its cells: > 0, also where nothing is known, which
// counts as the mean of what is. Of a region that is not of the picture 0.
WEFT_API double weft_cost_map_estimate(const weft_cost_map *map,
                                       const struct weft_rectangle *region);

// Reads and writes it: a text of sizes and of the nanoseconds of each cell, which appears whole or
// not at all. A map of another size of picture, of the same seconds in all, is made this one's. It
// counts like one frame. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_OPEN, WEFT_ERR_FORMAT (the log has the
// line and the numbers; larger than WEFT_COST_MAP_BYTES), WEFT_ERR_WRITE or WEFT_ERR_MEMORY.
enum { WEFT_COST_MAP_BYTES = 1 << 20 };
WEFT_API enum weft_result weft_cost_map_load(const struct weft_log *log, const char *path,
                                             int32_t width, int32_t height, weft_cost_map **out);
WEFT_API enum weft_result weft_cost_map_save(const struct weft_log *log, const weft_cost_map *map,
                                             const char *path);

WEFT_END_DECLS
#endif
