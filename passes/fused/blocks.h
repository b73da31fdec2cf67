// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/blocks.h - where engines find the voxels of a tile's cells, and what those are (not
// installed).
#ifndef WEFT_PASSES_FUSED_BLOCKS_H
#define WEFT_PASSES_FUSED_BLOCKS_H

#include <math.h>

#include "passes/fused/plan.h"

// How a cell's pixels are made, from the dearest.
enum weft_cell_class { WEFT_CELL_FULL, WEFT_CELL_SMOOTH, WEFT_CELL_CONSTANT };
enum { WEFT_CELL_CLASSES = 3 };

// The cells of one tile after the other, by number.
struct weft_slice_blocks {
    struct weft_block_layout layout; // of all blocks
    int lead; // samples along each axis from where a block begins to where taps do, of a pixel at
              // the cell's start; the axes are the block's
    const void *texels; // in memory; NULL: in GL
    int32_t *entries;   // >= 0: the texel that the cell's block begins with; else ~constant
    uint8_t *classes;   // enum weft_cell_class
    float *constants;   // a value for each cell that has only that one
    size_t constant_count, smooth_count;   // cells of these classes
    bool any_unfit;                        // some voxels are, and are 0 here (passes/fused/exact.h)
    uint64_t cells_constant, cells_smooth; // found in the voxels, over all tiles
};

// Room for the plan's largest tile. Returns WEFT_ERR_MEMORY.
enum weft_result weft_slice_blocks_create(const struct weft_slice_plan *plan,
                                          struct weft_slice_blocks *out);
void weft_slice_blocks_destroy(struct weft_slice_blocks *blocks); // {0} is fine

// Sets a cell's class and entry: one value, or a block.
void weft_slice_blocks_set_constant(struct weft_slice_blocks *blocks, size_t cell, float value);
void weft_slice_blocks_set(struct weft_slice_blocks *blocks, size_t cell, size_t texel,
                           enum weft_cell_class class);

// What an output is where all voxels have this value and weights add up to one: the value itself,
// and derivatives of it, which are exactly 0 where it is finite.
static inline float weft_slice_constant(const struct weft_derivative *derivative, float value)
{
    const int *along = derivative->along;
    if (along[0] + along[1] + along[2] == 0)
        return value;
    return isfinite(value) ? 0.0f : NAN;
}

// ---- what samples are ---------------------------------------------------------------------------

// A box of samples in memory: [z][y][x], x fastest.
struct weft_sample_box {
    const float *at;
    int size[3], pitch[3]; // samples along each axis, and floats between them
};
struct weft_sample_box weft_sample_box_of(const float *at, const int size[3], const int span[3]);

// Least and greatest of the samples; without meaning where one is NaN.
struct weft_sample_range {
    float low, high;
    bool finite;
};
struct weft_sample_range weft_sample_box_range(const struct weft_sample_box *samples);

// Largest |f_k-1 - 2 f_k + f_k+1| along an axis; +INFINITY where a sample is not finite.
float weft_sample_box_second_difference(const struct weft_sample_box *samples, int axis);

// Whether none of these is unfit.
bool weft_sample_range_fit(const struct weft_slice_plan *plan,
                           const struct weft_sample_range *range);

// Whether one value does for all samples within the plan's smooth_error, and which.
bool weft_sample_range_constant(const struct weft_slice_plan *plan,
                                const struct weft_sample_range *range, float *value);

// Whether linear interpolation does; second differences by axis of the block.
bool weft_sample_range_smooth(const struct weft_slice_plan *plan,
                              const struct weft_sample_range *range, const float second[3]);

#endif
