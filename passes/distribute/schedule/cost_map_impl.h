// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/schedule/cost_map_impl.h - the cells of a cost map (not installed).
#ifndef WEFT_PASSES_DISTRIBUTE_SCHEDULE_COST_MAP_IMPL_H
#define WEFT_PASSES_DISTRIBUTE_SCHEDULE_COST_MAP_IMPL_H

#include "passes/distribute/schedule/cost_map.h"

// Cell (c, r) has the picture's part from c / columns to (c + 1) / columns of its width, and
// likewise of its height: boundaries may lie within pixels.
struct weft_cost_map {
    int32_t width, height, columns, rows;
    double *seconds; // [rows][columns] added
    double *times;   // how often a cell was covered
};

// Seconds of all that is between, in pixels: added, or what is known of it.
void weft_cost_map_spread(weft_cost_map *map, const double x[2], const double y[2], double seconds);
double weft_cost_map_sum(const weft_cost_map *map, const double x[2], const double y[2]);

#endif
