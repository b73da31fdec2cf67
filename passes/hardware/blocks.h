// SPDX-License-Identifier: BSD-3-Clause
// passes/hardware/blocks.h - a tile's voxels as texels: a block a cell, plane by plane of blocks
// (not installed). No GL.
#ifndef WEFT_PASSES_HARDWARE_BLOCKS_H
#define WEFT_PASSES_HARDWARE_BLOCKS_H

#include "passes/hardware/plan.h"

// Scratch and results of one tile after the other, sized for the largest.
struct weft_hardware_blocks {
    const struct weft_hardware_plan *plan;
    int32_t *entries; // by cell: its block's number along each axis, 10 bits each
    char *plane;      // texels of one plane of blocks
    size_t plane_bytes;
    float *box; // voxels of one block, and as texels
    char *block;
    size_t count;      // blocks so far
    bool any_constant; // there is a block of one value,
    float constant;    // this one,
    int32_t at;        // here
    uint64_t cells_constant;
    bool any_unfit; // of the tile's voxels, laid out as 0 (passes/fused/exact.h)
};

// Returns WEFT_ERR_MEMORY.
enum weft_result weft_hardware_blocks_create(const struct weft_hardware_plan *plan,
                                             struct weft_hardware_blocks *out);
void weft_hardware_blocks_destroy(struct weft_hardware_blocks *blocks); // {0} is fine

// Begins a tile: forgets the one before.
void weft_hardware_blocks_begin(struct weft_hardware_blocks *blocks);

// Lays out cells of a tile from number *cell on until a plane of blocks is full or there are no
// more, and moves *cell on. Cells of one constant share a block with the last such cell.
void weft_hardware_blocks_fill(struct weft_hardware_blocks *blocks,
                               const struct weft_hardware_tile *tile, const weft_brick_store *store,
                               size_t *cell);

#endif
