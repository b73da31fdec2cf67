// SPDX-License-Identifier: BSD-3-Clause
// filter/analysis/reference.h - direct convolution in double: the truth that everything is measured
// against. Evaluates eq. 1 of Hadwiger, Hauser and Moeller (2003) as written, one weight per tap
// (filter/kernels/kernel_nd.h), compensated (Neumaier) sums, no tables, no separable shortcuts. For
// a prefiltered kernel (weft_kernel_make_prefiltered) samples are coefficients.
#ifndef WEFT_FILTER_ANALYSIS_REFERENCE_H
#define WEFT_FILTER_ANALYSIS_REFERENCE_H

#include "../kernels/kernel.h"

WEFT_BEGIN_DECLS

// The sample at an index (unused trailing dimensions are 0).
typedef double (*weft_reference_fetch)(void *priv, const int64_t index[3]);

struct weft_reference_value {
    // sum w_i f_i over the taps with a weight that is not exactly 0: what others hold does not
    // count, NaN and infinity neither.
    double value;
    double magnitude; // largest |f_i| among the width^dims taps; where the weight is 0, if finite
};

// Reconstructs at a position in index coordinates with the tensor-product kernel, or the radial
// one.
// dims is 1, 2 or 3 (else, and without a kernel, the value is NAN); position has dims entries.
// Thread-safe if fetch is.
WEFT_API struct weft_reference_value weft_reference_compute(const struct weft_kernel *kernel,
                                                            int dims, const double *position,
                                                            weft_reference_fetch fetch, void *priv);

// The same with a kernel for each axis, all of one width and none radial: a derivative along one of
// them, say. NAN for others.
WEFT_API struct weft_reference_value weft_reference_compute_axes(const struct weft_kernel kernel[3],
                                                                 int dims, const double *position,
                                                                 weft_reference_fetch fetch,
                                                                 void *priv);

WEFT_END_DECLS
#endif
