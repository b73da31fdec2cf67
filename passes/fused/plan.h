// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/plan.h - what a plan holds, for those who run and verify it (not installed).
#ifndef WEFT_PASSES_FUSED_PLAN_H
#define WEFT_PASSES_FUSED_PLAN_H

#include "passes/positions/grid.h"
#include "tiles/volume/block_layout.h"
#include "tiles/kernel/polynomial_tiles.h"

// What one cell of a tile needs.
struct weft_slice_cell {
    uint8_t low[3], high[3]; // as in struct weft_span, over the tile
    bool constant;           // every voxel in reach is `value`
    float value;
};

// Resident data of one rectangle. Source buffer: `head_texels` of room, so that no block's entry is
// negative, then a block for each cell that is not constant, in the cells' order.
struct weft_slice_tile_plan {
    struct weft_cell_map map;      // numbers the cells
    struct weft_slice_cell *cells; // by number
    struct weft_cell_map bricks;   // to read; keys in units of 8 voxels
    struct weft_block_layout layout;
    size_t head_texels, source_texels;
};

// How the volume's axes become those of blocks.
struct weft_slice_axes {
    int order[3];    // rows, columns and depth of a block run along these
    bool summed;     // voxels are summed along order[2] before they are laid out
    bool separable;  // rows and columns of the slice run along order[0] and order[1], and it is
                     // done one axis after the other
    int taps[3];     // that a pixel needs, by axis of the block: the kernel's width, 1 where summed
    int first, kept; // of the kernel's taps along a summed axis: from the first to the last one
                     // whose weight is not 0
    double weight[WEFT_KERNEL_MAX_WIDTH]; // of the kept ones
    int64_t plane;                        // index of the first kept one along order[2]
};

// What a cell's samples have to stay within for a cheaper piece. With n axes to convolve along:
// half their range times gain^n for one value; for linear interpolation, the sum over the axes
// i = 1..n of `curvature` gain^(n - i) times the largest second difference along axis i.
struct weft_slice_smooth {
    double error;     // 0: no cheaper pieces
    double gain;      // largest sum of |weight|
    double curvature; // 0: not by linear interpolation
};

struct weft_slice_plan {
    struct weft_slice_plan_info info;
    struct weft_slice_grid grid;
    struct weft_slice_axes axes;
    struct weft_slice_smooth smooth;
    struct weft_source_range range; // of stored samples
    float largest_fit;              // see passes/fused/exact.h
    bool clamp_to_samples;
    struct weft_polynomial_tiles kernel_tiles;
    struct weft_brick_list topology; // of everything near the slice
    weft_volume *coefficients; // prefiltered kernels: what is read in place of the volume, or NULL
    struct weft_slice_tile *tiles; // info.tile_count
    struct weft_slice_tile_plan *tile_plans;
    size_t tile_capacity;
    uint64_t separable_bytes; // what the passes of one axis after the other may take
    char *text;
    const struct weft_log *log;
};

// What a slice's taps read: the volume, or the plan's coefficients of it.
weft_volume *weft_slice_voxels(const struct weft_slice_plan *plan, weft_volume *volume);

// The part of a clamped volume's box that a region reaches once clamped, without slabs.
void weft_slice_clamp_region(const struct weft_volume_info *volume, struct weft_region *region);
// The axes' part of a plan, from its kernel and grid.
void weft_slice_axes_set(struct weft_slice_plan *plan, bool may_sum);
// Makes it separable where the slice can be and it pays.
void weft_slice_separable_set(struct weft_slice_plan *plan);
// The bounds' part, from its axes, range, tiles and kernel; smooth_error as in the params. Of the
// volume only what its numbers lose as floats.
void weft_slice_bound_set(struct weft_slice_plan *plan, double smooth_error,
                          const struct weft_volume_info *volume);

// What positions rounded to fixed point add to a result's error, in units of the largest |value
// read|.
double weft_slice_position_bound(const struct weft_slice_plan *plan);

// Whether a source of this format can hold a range of voxels.
bool weft_slice_source_holds(enum weft_source_format source, double low, double high);

// The largest sum of |h'| over the taps of a position; 0 where the kernel has no derivative.
double weft_slice_largest_slope(const struct weft_kernel *kernel);

// A store over `topology`'s tiles, and its bricks where values (of the listed bricks, in that
// order) are given; clamped where the volume is.
enum weft_result weft_slice_store_create(const struct weft_log *log,
                                         const struct weft_volume_info *info,
                                         const struct weft_brick_list *topology,
                                         const struct weft_cell_map *bricks, const float *values,
                                         weft_brick_store **out);

// The voxels that a cell's taps reach, inclusive; and of these the ones that the plan needs, which
// are fewer along a summed axis.
void weft_slice_cell_reach(const struct weft_slice_plan *plan, struct weft_cell_key key,
                           const struct weft_slice_cell *cell, int32_t min[3], int32_t max[3]);
void weft_slice_cell_box(const struct weft_slice_plan *plan, struct weft_cell_key key,
                         const struct weft_slice_cell *cell, int32_t min[3], int32_t max[3]);

// Voxels beyond the reach of a prefiltered kernel, by how far away: shell i lies beyond overlap[i]
// (0: that of WEFT_VOLUME_PREFILTER_ERROR), at which the inverse filter is cut off to
// WEFT_SLICE_SHELL_FALL^i times as much; the last one ends at 2^-80.
enum { WEFT_SLICE_SHELLS = 13 };
#define WEFT_SLICE_SHELL_FALL 0x1p-4
struct weft_slice_shells {
    int overlap[WEFT_SLICE_SHELLS + 1];
    double largest[WEFT_SLICE_SHELLS]; // |voxel|
    double at_taps;                    // likewise, of what the taps themselves lie on
};
// weft_slice_statistics_compute, and the shells that its `beyond` is the sum of; all 0 for other
// kernels.
enum weft_result weft_slice_statistics_shells(const struct weft_slice_plan *plan,
                                              weft_volume *volume,
                                              const struct weft_progress *progress,
                                              struct weft_slice_statistics *out,
                                              struct weft_slice_shells *shells);

// Origins of a map's bricks, and their voxels. values: bricks->count * 512 floats.
enum weft_result weft_slice_read_bricks(const struct weft_slice_plan *plan, weft_volume *volume,
                                        const struct weft_cell_map *bricks, float *values);

// Of a separable plan: the voxels in reach of a tile, inclusive; and all of its tiles.
void weft_slice_separable_box(const struct weft_slice_plan *plan,
                              const struct weft_slice_tile *tile, int32_t min[3], int32_t max[3]);
enum weft_result weft_slice_separable_run(weft_context *context, const struct weft_slice_plan *plan,
                                          weft_volume *volume, float *pixels,
                                          const struct weft_progress *progress,
                                          struct weft_slice_report *report);

// What of a plan does not depend on where the voxels lie: kernel, grid, axes, savings and bounds,
// without tiles. Returns as weft_slice_plan_create.
enum weft_result weft_slice_request_create(weft_volume *volume,
                                           const struct weft_slice_params *params,
                                           struct weft_slice_plan **out);

// The box of the active voxels' cells (half a voxel around them) in the given space.
void weft_slice_active_box(const struct weft_volume_info *volume, enum weft_space space,
                           double low[3], double high[3]);
// Warns of a slice that sees the background alone: whether it passes the active voxels or only its
// pixels do, where they lie, and whether the same numbers would meet them in index space.
void weft_slice_miss_report(const struct weft_log *log, const struct weft_slice_plan *plan,
                            const struct weft_slice_params *params,
                            const struct weft_volume_info *volume);

// Fills text and info.text. Returns WEFT_ERR_MEMORY.
enum weft_result weft_slice_text_print(struct weft_slice_plan *plan,
                                       const struct weft_volume_info *volume);

#endif
