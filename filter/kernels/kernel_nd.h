// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel_nd.h - a kernel's weights in one, two and three dimensions.
// The one place that says how a kernel in several dimensions comes from h: the product of the axes'
// weights, or for radial kernels (weft_kernel_make_radial) h of the distance, normalised or not.
// Arrays of weights have width^dims entries, [z][y][x], x fastest. Allocates nothing, thread-safe.
#ifndef WEFT_FILTER_KERNELS_KERNEL_ND_H
#define WEFT_FILTER_KERNELS_KERNEL_ND_H

#include "kernel.h"

WEFT_BEGIN_DECLS

// Room for all weights of any kernel in 3D: 32 KiB of doubles.
enum {
    WEFT_KERNEL_MAX_WEIGHTS = WEFT_KERNEL_MAX_WIDTH * WEFT_KERNEL_MAX_WIDTH * WEFT_KERNEL_MAX_WIDTH
};

// Returns whether the weights in `dims` dimensions differ from the products of the axes' weights:
// true for radial kernels in 2D and 3D. Code that relies on products asks this first.
WEFT_API bool weft_kernel_is_radial(const struct weft_kernel *kernel, int dims);

// Writes all weights at a position in index coordinates (dims entries, 1 to 3); those outside a
// radial kernel's ball are 0. Writes the first tap, 0 along unused axes. Where the weights of a
// normalised kernel add up to 0 they are infinite or NAN. Returns the number of weights, 0 (nothing
// is written to `weights`) for other dims and kernels that weft_kernel_check refuses.
WEFT_API int weft_kernel_weights_nd(const struct weft_kernel *kernel, int dims,
                                    const double *position, double *weights, int64_t first[3]);

// Writes the same weights from what is known of each axis: axis[i] has `width` values for each of
// dims axes, the weights of that axis (weft_kernel_weights), or, where weft_kernel_is_radial, the
// distances of position and tap along it. Returns the number of weights, 0 as above.
WEFT_API int weft_kernel_combine(const struct weft_kernel *kernel, int dims,
                                 const double *const axis[3], double *weights);

// Extremes of the sum of a radial kernel's weights, before it is normalised, over positions. Where
// 0 lies between them or is one of them, as in 3D for many kernels with negative lobes
// (Catmull-Rom: -0.06 at the samples), the kernel cannot be normalised.
struct weft_kernel_sums {
    double least, largest;
};
// Computes them for a kernel in 2D or 3D as if it were radial, from 9^dims positions 1/16 apart in
// [0, 1/2]^dims, which stand for all by symmetry. Returns NAN both for other dims.
WEFT_API struct weft_kernel_sums weft_kernel_radial_sums(const struct weft_kernel *kernel,
                                                         int dims);

WEFT_END_DECLS
#endif
