// SPDX-License-Identifier: BSD-3-Clause
// filter/analysis/error.h - the error of a reconstruction by its sources, for samples in [0, 1]
// (Hadwiger, Hauser and Moeller, WSCG 2003; equation numbers are theirs): E1 is the kernel's own,
// E2 that of its sampled and quantised tiles; both are absolute. E3, that of arithmetic, is a
// plan's (passes/plan/plan.h).
#ifndef WEFT_FILTER_ANALYSIS_ERROR_H
#define WEFT_FILTER_ANALYSIS_ERROR_H

#include "../fixed.h"
#include "../kernels/prefilter.h"

WEFT_BEGIN_DECLS

// How a texel is taken from a tile: the nearest one, or linearly between two along each axis.
// Default: nearest.
enum weft_error_lookup { WEFT_ERROR_NEAREST, WEFT_ERROR_LINEAR };
// NULL-ended, in the order of the enum: "nearest", "linear".
WEFT_API extern const char *const weft_error_lookup_names[];

// What is computed: eq. 4, or what the paper's own table was made by. Default: eq. 4.
enum weft_error_convention {
    // Eq. 4 by its plain definition: all width^dims weights; a tile per tap with M samples per axis
    // at (k + 0.5) / M; the product over the axes is quantised, sign kept; the lookup takes the
    // nearest texel or interpolates linearly between texels in exact arithmetic, clamped at the
    // edges of the tile.
    WEFT_ERROR_EQ4,
    // This reproduces 53 of the 60 cells of the paper's table 1 to 0.01 %: only the taps on one
    // side of the origin per axis count ((width / 2)^dims); the half kernel [0, r] lies in one row
    // of r M texels, texel k holding h(r k / (r M - 1)), but looked up as if texel k were centred
    // at (k + 0.5) / M, interpolating across tiles; weights are quantised by adding 0.5 and
    // truncating towards zero, negative ones too, and once more after interpolation. It needs a
    // whole half-width.
    WEFT_ERROR_WSCG2003,
};
// NULL-ended, in the order of the enum: "eq4", "wscg2003".
WEFT_API extern const char *const weft_error_convention_names[];

// Which tiles' error is computed, and where. Borrowed until the call returns.
struct weft_error_kernel_params {
    struct weft_kernel kernel;             // required
    int dims;                              // 1 to 3 (default 2)
    int samples;                           // M, texels per unit and axis, up to 65536 (default 64)
    int bits;                              // of the texels, up to WEFT_FIXED_MAX_BITS (default 8)
    enum weft_fixed_rounding rounding;     // of the texels (default: to the nearest)
    enum weft_error_lookup lookup;         // default nearest
    enum weft_error_convention convention; // default eq. 4
    // Resampling locations per axis, at fractions (i + 0.5) / L (weft_kernel_first_tap), up to 4096
    // (default 1024, in 3D 256). Mirrored, permuted and otherwise equal ones are computed once.
    int locations;
    int threads;                          // up to 256 (default: as many as there are processors)
    const struct weft_log *log;           // may be NULL
    const struct weft_progress *progress; // may be NULL
};
#define WEFT_ERROR_KERNEL_DEFAULTS
#define weft_error_kernel_params(...)                                                              \
    (&(struct weft_error_kernel_params){WEFT_ERROR_KERNEL_DEFAULTS __VA_ARGS__})

// Statistics over all L^dims locations i of eps_i = sum_j |eps_h,j| over the taps j that meet
// there.
struct weft_error_kernel {
    double maximum; // eps_h, eq. 4: E2 <= eps_h max |f|. Eq. 15 has the error of one weight times
                    // the number of passes in its place
    double position[3]; // fractions of a location that has it
    double mean, rms;
    double median, percentile_90, percentile_99; // to 1 part in 8000
    // Of the signed sum_j eps_h,j: what a constant signal of 1.0 turns into, less that.
    double signed_min, signed_max, signed_mean;
    double single; // largest error of one weight
    double scale;  // what tables multiply by: 2^b - 1, or 2^b for WEFT_ERROR_WSCG2003
};

// Computes the error of a kernel's tiles. The result does not
// depend on the number of threads. Returns WEFT_ERR_ARGUMENT (a range), WEFT_ERR_UNSUPPORTED
// (convention and kernel; radial kernels in 2D and 3D, whose exact weights weft_kernel_tiles_exact
// has), WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
WEFT_API enum weft_result weft_error_kernel_compute(const struct weft_error_kernel_params *params,
                                                    struct weft_error_kernel *out);

// Returns the leading term of E1, the error of the kernel itself, for a signal whose derivative of
// the kernel's order stays below `derivative_bound` along each axis, at sample distance 1
// (weft_analysis_order). Of prefiltered kernels it is the interpolating spline's, not the blur of
// the plain one. NAN for radial kernels in 2D and 3D.
WEFT_API double weft_error_e1(const struct weft_kernel *kernel, int dims, double derivative_bound);

// What coefficients in the place of samples add to a result's error, whatever weighs them: at most
// coefficient * max |coefficient| + sample * max |sample|, both in reach. Three things count.
// Coefficients are rounded to single precision. Their filter is cut off past an overlap of
// weft_prefilter_overlap's `cut` along an axis, which the kernel sums up along that axis, while
// along the others the cardinal spline's gain counts, not that of the filter. And missing samples
// count as filter/kernels/prefilter.h says.
struct weft_prefilter_error {
    double coefficient, sample;
    // The part of `sample` that is cut off. Samples farther than the overlap from all taps may be
    // larger than those in reach: they add beyond * max |sample| of theirs. Those past the overlap
    // of another cut add that cut / `cut` times as much.
    double beyond;
    double gain; // largest |result| / largest |sample|
};
// Computes it for `dims` of 1 to 3 (else NAN) and a `cut` above 0, at most 2^-24. All zero for
// kernels that are not prefiltered.
WEFT_API struct weft_prefilter_error weft_prefilter_error(const struct weft_kernel *kernel,
                                                          int dims, double cut);
// The same with a kernel for each of dims axes, derivatives of one kernel: all 0 where one of them
// is not prefiltered.
WEFT_API struct weft_prefilter_error weft_prefilter_error_axes(const struct weft_kernel kernel[],
                                                               int dims, double cut);
// The same from what weft_prefilter_error finds in one dimension along each of dims axes, which
// takes milliseconds, for a call that has it from before. NAN for other dims.
WEFT_API struct weft_prefilter_error
weft_prefilter_error_join(const struct weft_prefilter_error along[], int dims);

WEFT_END_DECLS
#endif
