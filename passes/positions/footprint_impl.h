// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/footprint_impl.h - what engines ask a footprint (not installed).
#ifndef WEFT_PASSES_POSITIONS_FOOTPRINT_IMPL_H
#define WEFT_PASSES_POSITIONS_FOOTPRINT_IMPL_H

#include "passes/positions/footprint.h"
#include "passes/positions/grid.h"
#include "passes/positions/weights.h"
#include "tiles/volume/brick_reader.h"

// Where in a cell the pixels of a rectangle have floor(position + tap_shift): from low to high, 0
// to 7.
struct weft_slice_cell {
    uint8_t low[3], high[3];
};

// Neighbouring pixels of a row whose first taps share a cell, by its number.
struct weft_cell_span {
    uint32_t cell, count;
};

// The cells of a rectangle, numbered in the order in which its rows meet them.
struct weft_slice_cells {
    struct weft_rectangle rectangle;
    struct weft_cell_map map;
    struct weft_slice_cell *at; // by number
    size_t capacity;
    // Which pixels lie in which, row by row: where those of a row begin, and of one past the last.
    // NULL where spans are so short that they would take much more memory than pixels.
    struct weft_cell_span *spans;
    size_t *rows;
    size_t span_count, span_capacity;
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
    bool shared;           // these two are another's
    uint64_t samples_read; // of shared ones: bricks before
    struct weft_slice_grid grid;
    struct weft_brick_reader bricks; // of what taps read, everything near the cut
    uint64_t memory_bytes;
    // Found so far.
    struct weft_slice_cells **cells;
    size_t cells_count, cells_capacity;
    struct weft_kernel_facts *facts, *own_facts; // of the kernel, so far; own: NULL where shared
    // Computed so far.
    bool ranged;   // statistics' low, high, voxels and not_finite are known
    bool measured; // all of them are
    struct weft_statistics voxels;
    struct weft_slice_statistics statistics;
    struct weft_slice_shells shells; // whose sum statistics.beyond is
};

// What another keeps for footprints, borrowed for their lives: for prefiltered kernels the volumes
// of struct weft_footprint, else NULL; and what is known of kernels.
struct weft_footprint_shared {
    weft_volume *samples, *coefficients;
    struct weft_kernel_facts **kernels;
};
// As weft_footprint_create, but that nothing is looked for before weft_footprint_open. `shared`
// NULL: the footprint has its own.
enum weft_result weft_footprint_create_over(const struct weft_footprint_params *params,
                                            const struct weft_footprint_shared *shared,
                                            weft_footprint **out);

// Finds which bricks and tiles lie near the cut, once. Returns WEFT_ERR_MEMORY and what
// weft_volume_find returns.
enum weft_result weft_footprint_open(weft_footprint *footprint);

// One more holder, who calls weft_footprint_destroy in the end.
weft_footprint *weft_footprint_hold(weft_footprint *footprint);

// What taps read: the volume, or the coefficients of it.
weft_volume *weft_footprint_voxels(const weft_footprint *footprint);

// Finds the cells of a rectangle, or takes them where somebody holds them. progress is asked once a
// row, with `fraction`. Returns WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
enum weft_result weft_footprint_cells(weft_footprint *footprint,
                                      const struct weft_rectangle *rectangle,
                                      const struct weft_progress *progress, double fraction,
                                      const struct weft_slice_cells **out);
// Whether somebody has found them: then they are there at once.
bool weft_footprint_has_cells(const weft_footprint *footprint,
                              const struct weft_rectangle *rectangle);
// Visits spans of cells of the rectangle's rows from `row` to `end`, exclusive, row by row; rows
// and columns count from the rectangle's own. false if a visit was.
typedef bool (*weft_cell_visitor)(void *priv, int x, int y, const struct weft_cell_span *span);
bool weft_footprint_visit(const weft_footprint *footprint, const struct weft_slice_cells *cells,
                          int row, int end, weft_cell_visitor visit, void *priv);
// Gives them up. Accepts &NULL, leaves NULL behind.
void weft_footprint_release(weft_footprint *footprint, const struct weft_slice_cells **cells);

// The voxels that the taps of cell number i reach, inclusive.
void weft_footprint_cell_box(const weft_footprint *footprint, const struct weft_slice_cells *cells,
                             size_t i, int32_t min[3], int32_t max[3]);
// The same of all pixels of a rectangle, by the corners of its blocks: positions rise or fall
// along rows and columns.
void weft_footprint_box(const weft_footprint *footprint, const struct weft_rectangle *rectangle,
                        int32_t min[3], int32_t max[3]);

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
// What the voxels in reach are by themselves, statistics.low, high, voxels and not_finite, alone:
// no voxel around them is read. By `threads` threads, up to WEFT_CPU_MAX_THREADS; progress is asked
// from the caller's.
enum weft_result weft_footprint_measure_range(weft_footprint *footprint, int threads,
                                              const struct weft_progress *progress);

#endif
