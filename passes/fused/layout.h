// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/layout.h - a tile's voxels as the slice shader reads them (not installed).
#ifndef WEFT_PASSES_FUSED_LAYOUT_H
#define WEFT_PASSES_FUSED_LAYOUT_H

#include "passes/fused/plan.h"

// How a cell's pixels are made, from the dearest.
enum weft_cell_class { WEFT_CELL_FULL, WEFT_CELL_SMOOTH, WEFT_CELL_CONSTANT };
enum { WEFT_CELL_CLASSES = 3 };

// Scratch and results of one tile after the other, sized for the largest.
struct weft_slice_layout {
    const struct weft_slice_plan *plan;
    struct weft_block_layout block_layout; // the tile's
    float *box, *block;                    // voxels of one cell in reach, and as they are laid out
    float *constants;                      // a value for each cell that has only that one
    int32_t *entries;                      // by cell: >= 0 where its block starts, else ~constant
    uint8_t *classes;                      // by cell, enum weft_cell_class
    size_t constant_count;                 // of this tile
    uint64_t cells_constant, cells_smooth; // found in the voxels, over all tiles
    bool any_unfit; // of this tile's voxels, laid out as 0 (passes/fused/exact.h)
};

// Scratch for the plan's largest tile. Returns WEFT_ERR_MEMORY.
enum weft_result weft_slice_layout_create(const struct weft_slice_plan *plan,
                                          struct weft_slice_layout *out);
void weft_slice_layout_destroy(struct weft_slice_layout *layout); // {0} is fine

// Writes the tile's source texels, constants, entries and classes.
void weft_slice_layout_write(struct weft_slice_layout *layout,
                             const struct weft_slice_tile_plan *tile, const weft_brick_store *store,
                             char *source);

#endif
