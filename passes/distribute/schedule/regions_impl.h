// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/schedule/regions_impl.h - the boundaries of regions (not installed).
#ifndef WEFT_PASSES_DISTRIBUTE_SCHEDULE_REGIONS_IMPL_H
#define WEFT_PASSES_DISTRIBUTE_SCHEDULE_REGIONS_IMPL_H

#include "passes/distribute/schedule/schedule.h"

// Row r has pixels y[r] to y[r + 1] - 1; its region c has x[r * (columns + 1) + c] to the next.
struct weft_regions {
    int32_t width, height;
    int32_t rows, columns;
    int32_t least[2]; // along x and y, what a moved boundary leaves
    int32_t *x, *y;
    double *exact_x, *exact_y; // where the boundaries would be if pixels could be divided
};

// Allocates the four lists for its rows and columns, or returns false, with whatever could be had.
bool weft_regions_allocate(struct weft_regions *regions);
void weft_regions_release(struct weft_regions *regions); // frees them

#endif
