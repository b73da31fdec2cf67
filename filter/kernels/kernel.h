// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/kernel.h - the kernel catalogue.
// A kernel h is a 1D reconstruction filter with support [-r, r), used as a tensor product in 2D and
// 3D, or there radially: filter/kernels/kernel_nd.h has the weights of both. The reconstruction of
// samples f[i] is g(x) = sum_i f[i] h(x - i) (Hadwiger, Hauser, Moeller, WSCG 2003, eq. 1).
// Everything here is in double and allocates nothing. Thread-safety: all functions may be called
// from any thread; two threads may use one kernel while none changes it.
#ifndef WEFT_FILTER_KERNELS_KERNEL_H
#define WEFT_FILTER_KERNELS_KERNEL_H

#include "../base.h"

WEFT_BEGIN_DECLS

// Parameters of a record, and taps along an axis, at most.
enum { WEFT_KERNEL_PARAMS = 2, WEFT_KERNEL_MAX_WIDTH = 16 };

// What a record says of one of its parameters.
struct weft_kernel_param {
    const char *name; // "B"; NULL: the record has no more parameters
    double initial;   // value when not given
    double min, max;  // inclusive range
};

struct weft_kernel;

// One record of the catalogue: constant data and two short functions. A user's own kernel is such a
// record too: fill one, keep it as long as kernels refer to it, and hand it to weft_kernel_create.
// Its functions must be pure: several threads call them at once. Members that depend on the
// parameters (continuity, orders, interpolating, unit_sum) say what holds for all of them, and
// `refine` may raise them.
struct weft_kernel_info {
    const char *name;                                    // "catmull-rom"
    const char *description;                             // one line
    const char *citation;                                // authors, year
    struct weft_kernel_param params[WEFT_KERNEL_PARAMS]; // all zero: it has none
    double radius; // half-width r, up to WEFT_KERNEL_MAX_WIDTH / 2; 0: the first parameter is r
    // h(x), zero outside [-r, r); where h jumps, the limit from the right.
    double (*weight)(const struct weft_kernel *kernel, double x);
    // h'(x), zero outside; where h' jumps, the limit from the right. NULL where there is none.
    double (*derivative)(const struct weft_kernel *kernel, double x);
    // Called by weft_kernel_create to set the members of struct weft_kernel that are sharper for
    // these parameters; NULL: they are as here.
    void (*refine)(struct weft_kernel *kernel);
    const void *data; // for the functions above; NULL if they need none
    // A record that reconstructs a derivative of the signal ("d-catmull-rom", "dd-catmull-rom") is
    // that derivative of the kernel `primitive`, with jumps but without impulses where that jumps.
    const struct weft_kernel_info *primitive; // NULL for ordinary records
    int derivation;                           // 0: reconstructs f itself; 1: f'; 2: f''
    // Degree of the polynomials that the weights are of the fraction (weft_kernel_first_tap), one
    // per tap; -1: they are not polynomials.
    int degree;
    int continuity; // h has so many continuous derivatives: 0: h is continuous; -1: h jumps
    // Order of approximation by eq. 1: the error falls as (sample distance)^order; 0: not at all.
    int order;
    // The order after the samples are prefiltered so that the result interpolates
    // (weft_kernel_make_prefiltered) or is the best in the space of the kernel's shifts (Strang and
    // Fix 1971); 0: there is none, or the record reconstructs a derivative.
    int order_prefiltered;
    bool interpolating; // h(0) = 1 and h(k) = 0 at other integers
    bool unit_sum;      // sum_k h(x - k) = 1 for every x
    bool moves; // takes one sample as it is, and is never stretched (filter/kernels/stretch.h)
};

// A record with its parameters set. A plain value that owns nothing, copied freely, made by
// weft_kernel_create and its kin. A kernel that is all zero stands for the default where a params
// struct says so.
struct weft_kernel {
    const struct weft_kernel_info *info; // of the catalogue, or borrowed from the user
    double param[WEFT_KERNEL_PARAMS];    // values, in the order of the record; 0 past those
    double support;                      // half-width r
    int width;                           // taps at any position: ceil(2 r)
    // What the record's members of these names are for these parameters.
    int continuity, order, order_prefiltered;
    bool interpolating, unit_sum;
    bool normalised; // weights are divided by sum_k h(x - k): weft_kernel_normalise
    bool radial;     // weights in 2D and 3D are h(|d|): weft_kernel_make_radial
    // Coefficients are to take the place of the samples: weft_kernel_make_prefiltered. `order` is
    // then that of the two together; `interpolating` stays what h itself is.
    bool prefiltered;
};

// The catalogue: a NULL-ended list. Look-up, command help, tests and plots all walk it.
WEFT_API extern const struct weft_kernel_info *const weft_kernel_list[];

// Finds a record of the catalogue by its name; capitals and small letters are alike, and so are
// '-', '_' and ' '. Returns NULL if there is none, or for a NULL name.
WEFT_API const struct weft_kernel_info *weft_kernel_find(const char *name);

// A name that other programs have for a kernel.
struct weft_kernel_alias {
    const char *name;     // "catrom"; other programs' capitals do not matter
    const char *kernel;   // "catmull-rom", as weft_kernel_parse reads it
    bool taken;           // true: the name stands for that kernel. false: for one of several, or for
                          // one that weft has not; weft_kernel_parse refuses it
    const char *sentence; // why it does; or which kernels may be meant, and who means which
};

// The aliases, up to one without a name. Names with a number behind them that is a radius
// ("lanczos3") are not among them, and are understood, too.
WEFT_API extern const struct weft_kernel_alias weft_kernel_aliases[];

// Writes what weft_kernel_parse takes a kernel's text for that has a taken alias in it, or a radius
// without its colon: "d-catmull-rom" for "d-catrom", "lanczos:3+unit" for "Lanczos3+unit". Cut to
// size and NUL-terminated when size > 0. Returns what the name means there, as an alias's sentence
// has it; NULL, and writes "", for any other text.
WEFT_API const char *weft_kernel_translate(const char *text, char *out, size_t size);

// Makes a kernel of a record: sets its parameters (param NULL: all initial; a NAN: that one
// initial) and derives support, width and the rest. The record is borrowed as long as kernels of it
// are used. On failure *out is all zero. Returns WEFT_ERR_ARGUMENT (a parameter out of its range:
// the log has both; or a user's own record that is wrong).
//
// What a user's record claims for these parameters is checked by some thousand evaluations of its
// functions, and the log names the member and the numbers: "kernel mine: .unit_sum is claimed, but
// the weights at fraction 0.25 sum to 0.93". That is: parameters' ranges; weights that are 0
// outside the radius and finite within; unit_sum, interpolating, moves; that tap by tap weights are
// polynomials of the degree (-1 where they are none: 0, what a record left out says, is that of a
// box); jumps of h, and of the derivative, that `continuity` denies (not beyond the first);
// order and order_prefiltered by sums over the taps; derivative and primitive by their integrals.
// Claims may be off by 1e-6 of the largest weight, as single precision is, slopes by a hundredth of
// the largest. Whether h is even nobody claims; it is looked at where it matters.
WEFT_API enum weft_result weft_kernel_create(const struct weft_log *log,
                                             const struct weft_kernel_info *info,
                                             const double *param, struct weft_kernel *out);

// Checks that a kernel is one, as every call does first that takes a kernel and has a log. Kernels
// that were filled by hand, or whose records were, may fail. Returns WEFT_ERR_ARGUMENT; the log
// names the member that is missing, out of its range or, by the weights at some positions, not true
// (unit_sum, interpolating). Functions without a log return NAN and write no weights for kernels
// whose info, support or width is wrong.
WEFT_API enum weft_result weft_kernel_check(const struct weft_log *log,
                                            const struct weft_kernel *kernel);

// Makes the weights at every position add up to one, in place: h(x) becomes h(x) / sum_k h(x - k).
// A kernel whose weights do already stays as it is. The sum must not vanish anywhere, which is not
// checked: weights are infinite or NAN where it does. Returns WEFT_ERR_ARGUMENT, the kernel being
// as before, for records that reconstruct a derivative, whose weights add up to 0.
WEFT_API enum weft_result weft_kernel_normalise(const struct weft_log *log,
                                                struct weft_kernel *kernel);

// Makes the weight at offset d in 2D and 3D h(|d|), 0 from |d| = r on, in place of the product of
// three h; of kernels that are not even, the half h(x >= 0) counts. Nothing changes in 1D. Radial
// weights practically never add up to one, not even on average, so `unit_sum` and the orders are
// lost, as far as 2D and 3D go: call weft_kernel_normalise after this, not before, to divide by the
// sum of all width^dims weights, which brings constants back but no more. `interpolating` stays
// where r <= sqrt(2). Not all can be normalised: weft_kernel_radial_sums.
// Returns WEFT_ERR_ARGUMENT for records that reconstruct a derivative, and prefiltered kernels.
WEFT_API enum weft_result weft_kernel_make_radial(const struct weft_log *log,
                                                  struct weft_kernel *kernel);

// Marks a kernel whose samples are to be replaced by coefficients, so that the reconstruction
// passes through the samples (filter/kernels/prefilter.h): B-splines of degree 2 and more, o-Moms,
// and their derivatives, which are then those of the interpolating spline. Support, width and
// weights stay those of h, here and wherever samples are handed over directly
// (weft_reference_compute, weft_multipass_run, kernel tiles): these take coefficients. Slices and
// `weft resample` filter what they read; filter/analysis/analysis.h and weft_error_e1 speak of
// samples. Returns WEFT_ERR_ARGUMENT for other records and for radial kernels.
WEFT_API enum weft_result weft_kernel_make_prefiltered(const struct weft_log *log,
                                                       struct weft_kernel *kernel);

// Makes the kernel of weights h'(x), with the same parameters and width: by the record of the
// catalogue that is the derivative of the kernel's ("d-lanczos:2" for "lanczos:2", "dd-lanczos:2"
// for that). It is prefiltered where the kernel is. `out` may be `kernel`; it is all zero on
// failure. Returns WEFT_ERR_ARGUMENT where there is no such record (nearest; third derivatives, and
// second ones of some; records that are not the catalogue's) and for normalised kernels, whose
// derivative is not the record's, or WEFT_ERR_UNSUPPORTED for radial ones.
WEFT_API enum weft_result weft_kernel_derive(const struct weft_log *log,
                                             const struct weft_kernel *kernel,
                                             struct weft_kernel *out);

// Reads "NAME", "NAME:p" or "NAME:p,q" as users write it ("cubic:0,0.5"), with "+radial" behind it
// for weft_kernel_make_radial, "+unit" for weft_kernel_normalise ("lanczos:3+unit") or both, in
// either order; up to 255 bytes, whatever the locale. An "i" right behind NAME ("bspline3i") is for
// weft_kernel_make_prefiltered. Trailing parameters may be left out. Capitals do not matter, and
// names that other programs have are understood (weft_kernel_translate). An unknown name is logged
// with what it may have meant, or with the list of names; "cubic:-0.5", which is B = -0.5 and looks
// like a = -0.5, with a question.
// Returns WEFT_ERR_ARGUMENT.
WEFT_API enum weft_result weft_kernel_parse(const struct weft_log *log, const char *text,
                                            struct weft_kernel *out);

// Writes the text that weft_kernel_parse reads back as the same kernel, cut to size and
// NUL-terminated when size > 0. Returns what snprintf returns: the length of the whole text.
WEFT_API int weft_kernel_format(const struct weft_kernel *kernel, char *text, size_t size);

// The functions below know one axis: for radial kernels, too, they return what holds in 1D.

// Returns the weight of a sample at distance x from the position (position less sample), h(x),
// divided by the sum of weights where the kernel is normalised.
WEFT_API double weft_kernel_weight(const struct weft_kernel *kernel, double x);
// Returns the slope of that weight; NAN where the record has no derivative.
WEFT_API double weft_kernel_derivative(const struct weft_kernel *kernel, double x);

// Returns the first tap, the lowest index of a sample that meets at position x. Even widths:
// floor(x) - width/2 + 1. Odd widths: floor(x + 1/2) - (width - 1)/2. *fraction (in [0, 1)) is the
// distance past that floor, the argument of the kernel's tiles: tap j has weight h(fraction + c -
// j), c = weft_kernel_offset(). Positions are clamped to +-2^62; a NAN counts as 0.
WEFT_API int64_t weft_kernel_first_tap(const struct weft_kernel *kernel, double x,
                                       double *fraction);

// Returns c = x - (first tap) - fraction, the same for every x: width / 2.0 - 1.
WEFT_API double weft_kernel_offset(const struct weft_kernel *kernel);

// Writes the `width` (<= WEFT_KERNEL_MAX_WIDTH) weights of the taps at position x, in order of
// increasing tap, each h(x - tap). Returns the first tap.
WEFT_API int64_t weft_kernel_weights(const struct weft_kernel *kernel, double x, double *weights);

WEFT_END_DECLS
#endif
