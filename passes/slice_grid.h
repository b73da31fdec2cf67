// SPDX-License-Identifier: BSD-3-Clause
// passes/slice_grid.h - where a slice's pixels lie, as the GPU computes it (not installed).
// Pixels are grouped in blocks of 256 x 256 on a fixed grid over the whole output. A block's first
// position is formed in double and rounded to 32 fraction bits; within the block positions advance by
// integer additions. So they do not depend on tiles or threads, and are off by at most
// 2^-33 (1 + 2 * 255) voxels along each axis.
#ifndef WEFT_PASSES_SLICE_GRID_H
#define WEFT_PASSES_SLICE_GRID_H

#include "passes/slice.h"
#include "tiles/cell_map.h"

enum { WEFT_GRID_BLOCK = 256, WEFT_GRID_FRACTION_BITS = 32 };

struct weft_slice_grid {
    struct weft_slice_geometry index; // in index space
    int32_t base[3];                  // local origin: multiples of 8, in index space
    double tap_shift;    // added to a position before floor: 0 or 1/2, by the kernel's width
    int tap_offset;      // floor(position + tap_shift) - first tap
    int64_t du[3], dv[3]; // per pixel, 32 fraction bits
};

// Checks and converts a request. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_LIMIT.
enum weft_result weft_slice_grid_create(const struct weft_log *log,
                                        const struct weft_slice_params *params,
                                        const struct weft_volume_info *info,
                                        struct weft_slice_grid *out);

// Fixed-point position + tap_shift - base of the first pixel of block (bx, by).
void weft_slice_grid_block(const struct weft_slice_grid *grid, int bx, int by, int64_t position[3]);

// The exact position of a pixel in index coordinates.
void weft_slice_grid_position(const struct weft_slice_grid *grid, int x, int y,
                              double position[3]);

// Box and slabs that hold every tap of every pixel.
void weft_slice_grid_region(const struct weft_slice_grid *grid, int taps, struct weft_region *out);

// Neighbouring pixels of a row whose first taps (by floor(position + tap_shift)) share a cell.
struct weft_slice_run_of_pixels {
    int x, y, count;
    struct weft_cell_key cell; // in units of 8 voxels
    uint8_t low[3], high[3];   // of floor(position + tap_shift) within the cell, 0 to 7
};
typedef bool (*weft_slice_run_visitor)(void *priv, const struct weft_slice_run_of_pixels *run);

// Visits a rectangle of pixels row by row, with the GPU's own positions. false if a visit was.
bool weft_slice_grid_walk(const struct weft_slice_grid *grid, int x, int y, int width, int height,
                          weft_slice_run_visitor visit, void *priv);

#endif
