// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/footprint_impl.h - what engines ask a footprint (not installed).
#ifndef WEFT_PASSES_POSITIONS_FOOTPRINT_IMPL_H
#define WEFT_PASSES_POSITIONS_FOOTPRINT_IMPL_H

#include "passes/positions/footprint.h"
#include "passes/positions/grid.h"
#include "passes/positions/weights.h"
#include "tiles/volume/brick_store.h"

// Where in a cell the pixels of a rectangle have floor(position + tap_shift): from low to high, 0
// to 7.
struct weft_slice_cell {
    uint8_t low[3], high[3];
};

// The cells of a rectangle, numbered in the order in which its rows meet them.
struct weft_slice_cells {
    struct weft_rectangle rectangle;
    struct weft_cell_map map;
    struct weft_slice_cell *at; // by number
    size_t capacity;
    int holders;
};

// Voxels beyond the reach of a prefiltered kernel, by how far away: shell i lies beyond overlap[i]
// (0: that of WEFT_VOLUME_PREFILTER_ERROR), at which the inverse filter is cut off to
// WEFT_SLICE_SHELL_FALL^i times as much; the last one ends at 2^-80. All 0 for other kernels.
enum { WEFT_SLICE_SHELLS = 13 };
#define WEFT_SLICE_SHELL_FALL 0x1p-4
struct weft_slice_shells {
    int overlap[WEFT_SLICE_SHELLS + 1];
    double largest[WEFT_SLICE_SHELLS]; // |voxel|
    double at_taps;                    // likewise, of what the taps themselves lie on
};

struct weft_footprint {
    struct weft_footprint_info info;
    const struct weft_log *log;
    int holders;
    weft_volume *volume;
    // Prefiltered kernels: the volume's bricks, kept, and what is read in place of them; or NULL.
    weft_volume *samples, *coefficients;
    struct weft_slice_grid grid;
    struct weft_brick_list topology; // of everything near the cut
    weft_brick_store *places;        // of the topology, without voxels
    uint64_t memory_bytes;
    // Found so far.
    struct weft_slice_cells **cells;
    size_t cells_count, cells_capacity;
    // Read so far.
    weft_brick_store *store;
    float **blocks;
    size_t block_count, block_capacity;
    uint64_t store_bytes; // of voxels or coefficients, without the samples that are kept
    // Of the kernel, made so far: see passes/positions/weights.h.
    struct weft_slice_weights **weights;
    size_t weights_count;
    struct weft_slice_kernel kernel;
    // Computed so far.
    bool measured;
    struct weft_statistics voxels;
    struct weft_slice_statistics statistics;
    struct weft_slice_shells shells; // whose sum statistics.beyond is
};

// One more holder, who calls weft_footprint_destroy in the end.
weft_footprint *weft_footprint_hold(weft_footprint *footprint);

// Whether two kernels are one: parameters, normalised, radial and prefiltered included.
bool weft_kernel_same(const struct weft_kernel *a, const struct weft_kernel *b);

// What taps read: the volume, or the coefficients of it.
weft_volume *weft_footprint_voxels(const weft_footprint *footprint);

// Finds the cells of a rectangle, or takes them where somebody holds them. progress is asked once a
// row, with `fraction`. Returns WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
enum weft_result weft_footprint_cells(weft_footprint *footprint,
                                      const struct weft_rectangle *rectangle,
                                      const struct weft_progress *progress, double fraction,
                                      const struct weft_slice_cells **out);
// Gives them up. Accepts &NULL, leaves NULL behind.
void weft_footprint_release(weft_footprint *footprint, const struct weft_slice_cells **cells);

// The voxels that the taps of cell number i reach, inclusive.
void weft_footprint_cell_box(const weft_footprint *footprint, const struct weft_slice_cells *cells,
                             size_t i, int32_t min[3], int32_t max[3]);
// The same of all pixels of a rectangle, by the corners of its blocks: positions rise or fall
// along rows and columns.
void weft_footprint_box(const weft_footprint *footprint, const struct weft_rectangle *rectangle,
                        int32_t min[3], int32_t max[3]);

// Notes the bricks that hold a box of voxels, which is clamped where the volume is, and have voxels
// of their own. false: out of memory.
bool weft_footprint_note(const weft_footprint *footprint, const int32_t min[3],
                         const int32_t max[3], struct weft_cell_map *bricks);

// The one way that voxels are read: bricks that are not kept are, and kept as long as memory_bytes
// holds them, the other bricks that are kept and the caller's other_bytes; or else those kept are
// dropped before. *out answers for these bricks and the tiles, clamped where the volume is, until
// the next call. Coefficients are made of the volume's bricks, which are kept in what that leaves.
// Returns WEFT_ERR_MEMORY and what weft_volume_read returns.
enum weft_result weft_footprint_load(weft_footprint *footprint, const struct weft_cell_map *bricks,
                                     uint64_t other_bytes, const weft_brick_store **out);
// The same of the volume's own bricks where taps read coefficients of it, for prefiltered kernels:
// as weft_volume_read, and from what is kept of them.
enum weft_result weft_footprint_read_samples(weft_footprint *footprint, size_t count,
                                             const int32_t (*origin)[3], float *values);

// The statistics with their shells.
enum weft_result weft_footprint_measure(weft_footprint *footprint,
                                        const struct weft_progress *progress);

// The part of a clamped volume's box that a region reaches once clamped, without slabs.
void weft_footprint_clamp_region(const struct weft_volume_info *volume, struct weft_region *region);

// A store over a list's tiles, and its bricks without voxels: for where they are.
enum weft_result weft_footprint_places(const struct weft_log *log,
                                       const struct weft_volume_info *info,
                                       const struct weft_brick_list *topology,
                                       weft_brick_store **out);

#endif
