// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/prefilter.h - coefficients in place of samples, so that splines interpolate.
// A B-spline of degree 2 or more does not pass through its samples: sum_i f[i] h(x - i) is blurred.
// With coefficients c for which sum_i c[i] h(k - i) = f[k] at every k it does, at the best order
// that the kernel has (struct weft_kernel, order_prefiltered). They come from f by the inverse of
// the filter h(k), whose impulse response is sum_p factor[p] pole[p]^|k|: all poles are real and
// negative, for the cubic one of sqrt(3) - 2 (Unser, Aldroubi and Eden, IEEE TSP 1993; Unser, IEEE
// Signal Processing Magazine 1999, box 2). The kernels are those that weft_kernel_make_prefiltered
// takes. All is in double, allocates nothing and is thread-safe. Functions that write taps or
// weights write none for a struct weft_prefilter that is not weft_prefilter_compute's, a kernel
// that weft_kernel_check refuses or an overlap out of its range.
// Samples that are not finite are missing. A coefficient depends on samples far away, and what is
// missing might have been anything. A coefficient is missing, too, where the inverse filter's
// |weights| of all missing samples together are more than WEFT_PREFILTER_MISSING, and at missing
// samples themselves; for others missing samples count as 0. A result is missing where one of its
// coefficients is. What is left is right whatever the missing samples were: it would change by at
// most WEFT_PREFILTER_MISSING sum |h| times the largest of them, which bounds of prefiltered
// kernels count. Images and volumes follow this rule. A missing sample takes its neighbours
// with it, about 13 on either side for cubics (the sum of distances along the axes); kernels
// without a prefilter lose no more than those whose taps meet it.
//
//   kernel    poles                            gain     overlap for errors of 2^-24, 2^-28, 2^-40
//   bspline2  -0.171573                        2            10, 11, 16
//   bspline3  -0.267949                        3            13, 15, 22
//   bspline4  -0.361341, -0.013725             4.8          18, 21, 29
//   bspline5  -0.430575, -0.043096             7.5          22, 25, 35
//   bspline6  -0.488295, -0.081679, -0.001414  11.803       27, 31, 42
//   bspline7  -0.535280, -0.122555, -0.009149  18.5294      31, 36, 49
//   omoms     -0.344131                        4.2          17, 19, 27
#ifndef WEFT_FILTER_KERNELS_PREFILTER_H
#define WEFT_FILTER_KERNELS_PREFILTER_H

#include "kernel.h"

WEFT_BEGIN_DECLS

// Poles of a filter, overlaps of any call, and weights of a position along an axis, at most.
enum {
    WEFT_PREFILTER_MAX_POLES = 3,
    WEFT_PREFILTER_MAX_OVERLAP = 96,
    WEFT_PREFILTER_MAX_WEIGHTS = WEFT_KERNEL_MAX_WIDTH + 2 * WEFT_PREFILTER_MAX_OVERLAP,
};

// What coefficients may depend on missing samples by; as small as single precision's rounding.
#define WEFT_PREFILTER_MISSING 0x1p-24

// A kernel's inverse filter. A plain value that owns nothing.
struct weft_prefilter {
    int poles;                               // of both arrays
    double pole[WEFT_PREFILTER_MAX_POLES];   // in (-1, 0), the largest in magnitude first
    double factor[WEFT_PREFILTER_MAX_POLES]; // of the impulse response, beside each pole
    // Largest |coefficient| / largest |sample| along an axis, for samples that alternate in sign:
    // what rounding the coefficients costs. To the power of 3 in 3D.
    double gain;
};

// Finds the inverse filter of a kernel, or of the kernel that it is the derivative of, whether the
// kernel is marked as prefiltered or not. Returns WEFT_ERR_ARGUMENT for kernels without a
// prefilter; *out is then all zero.
WEFT_API enum weft_result weft_prefilter_compute(const struct weft_log *log,
                                                 const struct weft_kernel *kernel,
                                                 struct weft_prefilter *out);

// Replaces `count` samples, `stride` doubles apart, by coefficients: one causal and one anticausal
// recursion per pole. Before the first sample the signal is `before` without end, behind the last
// one `after`; NAN: as the sample there. The result is exact for that infinite signal. Beyond the
// line the coefficients are not constant, but approach before and after as pole^distance: whoever
// needs them extends the line by weft_prefilter_overlap first. Samples that are not finite spread
// over the line: the caller puts 0 in their place, as above. Axes of images and volumes are
// filtered one after the other, in any order.
WEFT_API void weft_prefilter_line(const struct weft_prefilter *prefilter, double *values,
                                  size_t count, ptrdiff_t stride, double before, double after);

// Returns how many samples on either side a coefficient depends on: all farther ones together
// change it by no more than `error` (> 0) times the largest |sample|. At most
// WEFT_PREFILTER_MAX_OVERLAP, which is enough for 2^-80.
WEFT_API int weft_prefilter_overlap(const struct weft_prefilter *prefilter, double error);

// Writes the inverse filter, cut off past `overlap` (0 to WEFT_PREFILTER_MAX_OVERLAP) and scaled so
// that it adds up to one: taps[k] is for |k| = 0..overlap. Constants stay as they are.
WEFT_API void weft_prefilter_taps(const struct weft_prefilter *prefilter, int overlap,
                                  double *taps);

// Writes the weights of the samples themselves at position x, those of the cardinal spline (or of
// its derivative, as the kernel is): kernel->width + 2 overlap of them. They add up as the kernel's
// do; what lies farther is left out. Returns the index of the sample that the first one is for.
WEFT_API int64_t weft_prefilter_weights(const struct weft_prefilter *prefilter,
                                        const struct weft_kernel *kernel, int overlap, double x,
                                        double *weights);

// What samples are worth to a result, without coefficients: one axis of the truth that results are
// verified against. Samples lie from `low` to `high`; beyond them the nearest one holds, whose
// weights it then has, too.
struct weft_prefilter_axis {
    int64_t first;                             // the sample that index 0 below is for
    int count;                                 // samples; 0 where the request makes no sense
    double weight[WEFT_PREFILTER_MAX_WEIGHTS]; // of the cardinal spline
    double reach[WEFT_PREFILTER_MAX_WEIGHTS];  // largest |weight| in one of the coefficients
};
// Computes it for position x; low <= high.
WEFT_API void weft_prefilter_axis_set(const struct weft_prefilter *prefilter,
                                      const struct weft_kernel *kernel, int overlap, double x,
                                      int64_t low, int64_t high, struct weft_prefilter_axis *out);

// Returns whether a result is missing. `depends` and `reaches` are sums over missing samples, of
// products of |weight| and of `reach`; `whole` is the largest sum of the kernel's own |weights|, as
// a product. A result must be missing where its cardinal spline shows that it depends on them by
// more than the rule allows, and must not be where no coefficient in reach can. Between the two (at
// a sample the spline's weights of others vanish, those of coefficients do not) `finite` decides:
// whether the result to be verified is there.
WEFT_API bool weft_prefilter_is_missing(double depends, double reaches, double whole, bool finite);

WEFT_END_DECLS
#endif
