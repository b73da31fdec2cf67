// SPDX-License-Identifier: BSD-3-Clause
// filter/analysis/reference.h - direct convolution in double: the truth that everything is measured
// against. Evaluates eq. 1 of Hadwiger, Hauser and Moeller (2003) as written, one weight per tap
// (filter/kernels/kernel_nd.h), compensated sums (Neumaier 1974), no tables, no separable
// shortcuts. For a prefiltered kernel (weft_kernel_make_prefiltered) it takes coefficients in the
// place of samples. Thread-safe where the caller's `fetch` is; nothing is allocated.
#ifndef WEFT_FILTER_ANALYSIS_REFERENCE_H
#define WEFT_FILTER_ANALYSIS_REFERENCE_H

#include "../kernels/kernel.h"

WEFT_BEGIN_DECLS

// The caller's samples: returns the sample at an index (0 along axes past dims), whatever it lies
// beyond. `priv` is what the caller handed over.
typedef double (*weft_reference_fetch)(void *priv, const int64_t index[3]);

// A reconstructed value, and what errors are relative to.
struct weft_reference_value {
    // sum w_i f_i over the taps whose weight is not exactly 0. What other taps hold does not count,
    // be it NaN or infinite.
    double value;
    double magnitude; // largest |f_i| among the width^dims taps; of those with weight 0, if finite
};

// Reconstructs at a position in index coordinates with the tensor-product kernel, or the radial
// one. dims is 1, 2 or 3, and position has dims entries. Calls fetch once for each of width^dims
// taps. Returns a value of NAN for other dims and for kernels that weft_kernel_check refuses.
WEFT_API struct weft_reference_value weft_reference_compute(const struct weft_kernel *kernel,
                                                            int dims, const double *position,
                                                            weft_reference_fetch fetch, void *priv);

// Reconstructs likewise with a kernel for each of dims axes, all of one width and none radial: with
// a derivative along one of them, say. Returns a value of NAN for other kernels and dims.
WEFT_API struct weft_reference_value weft_reference_compute_axes(const struct weft_kernel kernel[3],
                                                                 int dims, const double *position,
                                                                 weft_reference_fetch fetch,
                                                                 void *priv);

// Reconstructs likewise with the kernel stretched along each axis (weft_stretch_weights), scale[a]
// >= 1. `room` is for weft_stretch_width weights of every axis. Returns a value of NAN for other
// dims, and kernels or scales that have no such width.
WEFT_API struct weft_reference_value
weft_reference_compute_stretched(const struct weft_kernel *kernel, const double *scale, int dims,
                                 const double *position, double *room, weft_reference_fetch fetch,
                                 void *priv);

WEFT_END_DECLS
#endif
