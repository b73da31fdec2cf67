// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/axes.h - axes along which a cut needs no convolution of its own (not installed).
// Where all pixels of a cut have one coordinate along an axis, voxels can be summed along it once,
// and the rest is 2D; where moreover rows and columns run along the other two, pixels can be
// made along one after the other. Which axes those are depends on kernel and grid alone.
#ifndef WEFT_PASSES_POSITIONS_AXES_H
#define WEFT_PASSES_POSITIONS_AXES_H

#include "passes/positions/grid.h"

// How the volume's axes become those of blocks.
struct weft_slice_axes {
    int order[3];    // rows, columns and depth of a block run along these
    bool summed;     // voxels are summed along order[2] before they are laid out
    bool separable;  // rows and columns of the cut run along order[0] and order[1], and it is
                     // done one axis after the other
    int taps[3];     // that a pixel needs, by axis of the block: the kernel's width, 1 where summed
    int first, kept; // of the kernel's taps along a summed axis: from the first to the last one
                     // whose weight is not 0
    double weight[WEFT_KERNEL_MAX_WIDTH]; // of the kept ones
    int64_t plane;                        // index of the first kept one along order[2]
};

// Finds the axis that voxels can be summed along, where they may be.
void weft_slice_axes_set(const struct weft_kernel *kernel, const struct weft_slice_grid *grid,
                         bool may_sum, struct weft_slice_axes *out);
// Makes the axes separable where the cut can be and it pays.
void weft_slice_axes_separate(const struct weft_kernel *kernel, const struct weft_slice_grid *grid,
                              struct weft_slice_axes *axes);

// Narrows the box of voxels that taps reach, inclusive, to what is needed of it: fewer along a
// summed axis.
void weft_slice_axes_narrow(const struct weft_slice_axes *axes, int32_t min[3], int32_t max[3]);

// The coordinate of pixel number i along axis 0 or 1 of a separable cut's plane, as shaders of
// oblique cuts have it.
double weft_slice_axes_coordinate(const struct weft_slice_axes *axes,
                                  const struct weft_slice_grid *grid, int axis, int i);

// The voxels in reach of a rectangle of a separable cut, inclusive.
void weft_slice_axes_box(const struct weft_slice_axes *axes, const struct weft_kernel *kernel,
                         const struct weft_slice_grid *grid, const struct weft_rectangle *rectangle,
                         int32_t min[3], int32_t max[3]);

// Sums a box of voxels, [z][y][x], `span` apart, along the axis where every pixel has the same
// coordinate: out[y * stride + x], with x and y along order[0] and order[1].
void weft_slice_sum_planes(const struct weft_slice_axes *axes, const float *box, const int size[3],
                           const int span[3], float *out, int stride);

#endif
