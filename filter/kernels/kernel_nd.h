// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel_nd.h - a kernel's weights in one, two and three dimensions.
// The one place that says how a kernel in several dimensions comes from h: the product of the axes'
// weights, or for radial kernels (weft_kernel_make_radial) h of the distance, normalised or not.
// Arrays of weights have width^dims entries, [z][y][x], x fastest. Allocates nothing, thread-safe.
#ifndef WEFT_FILTER_KERNELS_KERNEL_ND_H
#define WEFT_FILTER_KERNELS_KERNEL_ND_H

#include "kernel.h"

WEFT_BEGIN_DECLS

enum {
    WEFT_KERNEL_MAX_WEIGHTS = WEFT_KERNEL_MAX_WIDTH * WEFT_KERNEL_MAX_WIDTH * WEFT_KERNEL_MAX_WIDTH
};

// Whether the weights in so many dimensions are other than the products of the axes' weights: for
// what relies on products.
WEFT_API bool weft_kernel_is_radial(const struct weft_kernel *kernel, int dims);

// All weights at a position in index coordinates (dims entries, 1 to 3), those outside a radial
// kernel's ball being 0. Writes the first tap (0 along unused axes) and returns the number of
// weights, 0 for other dims. Kernels whose weights add up to 0 there give infinities or NANs when
// normalised.
WEFT_API int weft_kernel_weights_nd(const struct weft_kernel *kernel, int dims,
                                    const double *position, double *weights, int64_t first[3]);

// The same from axes: `width` values for each of dims axes, the weights of that axis
// (weft_kernel_weights), or for weft_kernel_is_radial the taps' offsets along it.
WEFT_API int weft_kernel_combine(const struct weft_kernel *kernel, int dims,
                                 const double *const axis[3], double *weights);

// Least and largest sum of a radial kernel's weights over all positions in 2D or 3D, not
// normalised, from 9^dims positions of an eighth of a cell. Where they are on both sides of 0, as
// in 3D for many kernels with negative lobes (Catmull-Rom: -0.06 at the samples), or touch it, the
// kernel cannot be normalised.
struct weft_kernel_sums {
    double least, largest;
};
WEFT_API struct weft_kernel_sums weft_kernel_radial_sums(const struct weft_kernel *kernel,
                                                         int dims);

WEFT_END_DECLS
#endif
