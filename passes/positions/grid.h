// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/grid.h - where a slice's pixels lie, as the GPU computes it (not installed).
// Positions are multiples of 2^-29 voxels, half-way rounded up: what is whole, or half-way between
// two voxels, in exact arithmetic is so here.
// Pixels are grouped in blocks of 256 x 256 on a fixed grid over the whole output. A block's first
// position is formed in double and rounded to a fixed-point number of b = 40 fraction bits; within
// the block positions advance by integer additions, which every GPU does exactly, and the bits past
// the 29th are cut off, half a unit having been added before. So positions do not depend on tiles
// or threads. Sums are off by at most 2^-(b+1) (1 + 2 * 255) = 2^-32 voxels along each axis, less
// than the half unit from a whole number to where rounding would leave it, and positions by 2^-30
// more.
#ifndef WEFT_PASSES_POSITIONS_GRID_H
#define WEFT_PASSES_POSITIONS_GRID_H

#include "filter/rectangle.h"
#include "passes/positions/geometry.h"
#include "tiles/volume/cell_map.h"

enum { WEFT_GRID_BLOCK = 256 };

// A shader keeps positions modulo 8 voxels: one word with 3 whole and 29 fraction bits, and while
// it adds up steps one with the fraction bits beyond.
enum { WEFT_GRID_WORD_FRACTION_BITS = 29 };

struct weft_slice_grid {
    struct weft_slice_geometry index; // in index space
    double tap_shift;     // added to a position before floor: 0 or 1/2, by the kernel's width
    int tap_offset;       // floor(position + tap_shift) - first tap
    int fraction_bits;    // 40; 31 where a step is over 2048 voxels
    int64_t du[3], dv[3]; // steps to the next pixel, fixed point
};

// The first pixel of a block: index coordinate + tap_shift + 2^-30 = base + position /
// 2^fraction_bits.
struct weft_slice_block {
    int32_t base[3]; // multiples of 8
    int64_t position[3];
};

// The inverse of an affine map, by cofactors; false if it has none in double.
bool weft_affine_invert(const double m[3][4], double out[3][4]);

// Checks a cut and converts it, for a kernel of `taps` taps along each axis. Returns
// WEFT_ERR_ARGUMENT (size, edges), WEFT_ERR_FORMAT (a transform that leaves no cut) or
// WEFT_ERR_LIMIT (index range).
enum weft_result weft_slice_grid_create(const struct weft_log *log,
                                        const struct weft_slice_geometry *geometry,
                                        enum weft_space space, int taps,
                                        const struct weft_volume_info *info,
                                        struct weft_slice_grid *out);

void weft_slice_grid_block(const struct weft_slice_grid *grid, int bx, int by,
                           struct weft_slice_block *out);

// A pixel as engines have it: along each axis its coordinate + tap_shift as a whole number and a
// fraction in [0, 1). `block` is the one that it lies in.
void weft_slice_grid_pixel(const struct weft_slice_grid *grid, const struct weft_slice_block *block,
                           int x, int y, int32_t whole[3], double fraction[3]);

// The position of a pixel in index coordinates, formed in double, `moved` (NULL: not) and rounded
// as above.
void weft_slice_grid_position(const struct weft_slice_grid *grid, int x, int y,
                              const double moved[3], double position[3]);
// How far, before rounding, that may be from where engines have it.
double weft_slice_grid_margin(const struct weft_slice_grid *grid, const double position[3]);

// Box and slabs that hold every tap of every pixel.
void weft_slice_grid_region(const struct weft_slice_grid *grid, int taps, struct weft_region *out);

// Neighbouring pixels of a row whose first taps (by floor(position + tap_shift)) share a cell.
struct weft_span {
    int x, y, count;
    struct weft_cell_key cell; // in units of 8 voxels
    uint8_t low[3], high[3];   // of floor(position + tap_shift) within the cell, 0 to 7
};
typedef bool (*weft_span_visitor)(void *priv, const struct weft_span *run);

// Visits a rectangle of pixels row by row, with the GPU's own positions. false if a visit was.
bool weft_slice_grid_walk(const struct weft_slice_grid *grid, int x, int y, int width, int height,
                          weft_span_visitor visit, void *priv);

// Warns of a cut that sees the background alone: whether it passes the active voxels or only its
// pixels do, where they lie, the nearest plane across the same axis that meets them, and whether the
// same numbers, which are of `space`, would meet them in the other one.
void weft_slice_miss_report(const struct weft_log *log, const struct weft_slice_grid *grid,
                            const struct weft_slice_geometry *geometry, enum weft_space space,
                            int taps, const struct weft_volume_info *volume);

#endif
