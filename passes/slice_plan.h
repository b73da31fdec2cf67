// SPDX-License-Identifier: BSD-3-Clause
// passes/slice_plan.h - what a plan holds, for those who run and verify it (not installed).
#ifndef WEFT_PASSES_SLICE_PLAN_H
#define WEFT_PASSES_SLICE_PLAN_H

#include "passes/slice_grid.h"
#include "tiles/interleave.h"
#include "tiles/polynomial_tiles.h"

// What one cell of a tile needs.
struct weft_slice_cell {
    uint8_t low[3], high[3]; // as in struct weft_slice_run_of_pixels, over the tile
    bool constant;           // every voxel in reach is `value`
    float value;
};

// Resident data of one rectangle. Source buffer: `head_texels` of constants (and room, so that no
// block's entry is negative), then a block for each other cell, in the cells' order.
struct weft_slice_tile_plan {
    struct weft_cell_map map;      // numbers the cells
    struct weft_slice_cell *cells; // by number
    struct weft_cell_map bricks;   // to read; keys in units of 8 voxels
    struct weft_block_layout layout;
    size_t constant_count, head_texels, source_texels;
};

struct weft_slice_plan {
    struct weft_slice_plan_info info;
    struct weft_slice_grid grid;
    struct weft_polynomial_tiles kernel_tiles;
    struct weft_brick_list topology; // of everything near the slice
    weft_volume *coefficients; // prefiltered kernels: what is read in place of the volume, or NULL
    struct weft_slice_tile *tiles; // info.tile_count
    struct weft_slice_tile_plan *tile_plans;
    size_t tile_capacity;
    char *text;
    const struct weft_log *log;
};

// What a slice's taps read: the volume, or the plan's coefficients of it.
weft_volume *weft_slice_voxels(const struct weft_slice_plan *plan, weft_volume *volume);

// The part of a clamped volume's box that a region reaches once clamped, without slabs.
void weft_slice_clamp_region(const struct weft_volume_info *volume, struct weft_region *region);

// A store over `topology`'s tiles, and its bricks where values (of the listed bricks, in that
// order) are given; clamped where the volume is.
enum weft_result weft_slice_store_create(const struct weft_log *log,
                                         const struct weft_volume_info *info,
                                         const struct weft_brick_list *topology,
                                         const struct weft_cell_map *bricks, const float *values,
                                         weft_brick_store **out);

// The voxels that a cell's taps reach, inclusive.
void weft_slice_cell_box(const struct weft_slice_plan *plan, struct weft_cell_key key,
                         const struct weft_slice_cell *cell, int32_t min[3], int32_t max[3]);

// Origins of a map's bricks, and their voxels. values: bricks->count * 512 floats.
enum weft_result weft_slice_read_bricks(const struct weft_slice_plan *plan, weft_volume *volume,
                                        const struct weft_cell_map *bricks, float *values);

#endif
