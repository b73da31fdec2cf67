// SPDX-License-Identifier: BSD-3-Clause
// filter/quantity.h - what is asked of a volume at a point: its value, and what its derivatives
// make. Engines reconstruct partial derivatives along the axes of index space; here these become
// derivatives in world space and what is computed of them. In double, pure, thread-safe, no
// allocation.
#ifndef WEFT_FILTER_QUANTITY_H
#define WEFT_FILTER_QUANTITY_H

#include "base.h"

WEFT_BEGIN_DECLS

// ---- derivatives --------------------------------------------------------------------------------

// A partial derivative: how often along x, y and z, 0 to 2 each, and 2 in all; {{0, 0, 0}} is the
// value.
struct weft_derivative {
    int along[3];
};

// Derivatives of different kinds: 1 value, 3 first and 6 second ones; and bytes of a text of one.
enum { WEFT_DERIVATIVES = 10, WEFT_DERIVATIVE_TEXT = 8 };

// Returns how often a derivative derives in all, 0 to 2; -1 of one that is none.
WEFT_API int weft_derivative_order(const struct weft_derivative *derivative);

// Writes "x", "xy", "zz", ..., or "none" for the value ("unknown" for what is no derivative), and
// returns `text`.
WEFT_API const char *weft_derivative_format(const struct weft_derivative *derivative,
                                            char text[WEFT_DERIVATIVE_TEXT]);

// Reads such a text; letters may stand in any order. Returns WEFT_ERR_ARGUMENT, with *out the
// value.
WEFT_API enum weft_result weft_derivative_parse(const struct weft_log *log, const char *text,
                                                struct weft_derivative *out);

// ---- quantities ---------------------------------------------------------------------------------

// Names are those of the command line. g is the gradient, H the Hessian, both in world space: per
// unit of length, and per its square. Curvatures are of the level surface through the point, by its
// normal n = -g / |g|, which points to where values fall, and are positive where a ball of high
// values has its surface: of a ball's of radius r, mean 1 / r, Gaussian 1 / r^2. (Kindlmann,
// Whitaker, Tasdizen, Moeller 2003, "Curvature-based transfer functions", section 4:
// G = P (-H / |g|) P with P = I - n n^T, of which the trace and the Frobenius norm are taken.)
enum weft_quantity {
    WEFT_QUANTITY_VALUE,                // "value": Y
    WEFT_QUANTITY_GRADIENT,             // "gradient": gradient.X, .Y, .Z
    WEFT_QUANTITY_GRADIENT_MAGNITUDE,   // "gradient-magnitude"
    WEFT_QUANTITY_NORMAL,               // "normal": normal.X, .Y, .Z; 0 where |g| is 0
    WEFT_QUANTITY_HESSIAN,              // "hessian": hessian.XX, .XY, .XZ, .YY, .YZ, .ZZ
    WEFT_QUANTITY_LAPLACIAN,            // "laplacian": the trace of H
    WEFT_QUANTITY_MEAN_CURVATURE,       // "mean-curvature": half the trace of G; 0 where |g| is 0
    WEFT_QUANTITY_GAUSSIAN_CURVATURE,   // "gaussian-curvature": the product of the next two
    WEFT_QUANTITY_PRINCIPAL_CURVATURES, // "principal-curvatures": principal-curvature.1 >= .2
    WEFT_QUANTITY_COUNT
};
// NULL-ended, in the order of the enum.
WEFT_API extern const char *const weft_quantity_names[];

// Channels of all quantities together.
enum { WEFT_QUANTITY_CHANNELS = 1 + 3 + 1 + 3 + 6 + 1 + 1 + 1 + 2 };

// A list of quantities, in the order asked for, and what it comes to. A plain value; made by
// weft_quantities_create or _parse.
struct weft_quantities {
    int count;
    enum weft_quantity quantity[WEFT_QUANTITY_COUNT];
    int channel_count;
    const char *channel[WEFT_QUANTITY_CHANNELS]; // names, in order; static storage
    // What is to be reconstructed for them, each once; under a transform that mixes axes, or any
    // that is not known yet, all of an order that is needed.
    int derivative_count;
    struct weft_derivative derivative[WEFT_DERIVATIVES];
};

// Makes a list. Returns WEFT_ERR_ARGUMENT (count below 1, an unknown quantity, one that is there
// twice); *out is then all zero.
WEFT_API enum weft_result weft_quantities_create(const struct weft_log *log,
                                                 const enum weft_quantity *quantity, int count,
                                                 struct weft_quantities *out);
// Reads "value,gradient,..." likewise. An unknown name is logged with all names.
WEFT_API enum weft_result weft_quantities_parse(const struct weft_log *log, const char *text,
                                                struct weft_quantities *out);

// Derivatives in index space become those in world space, for x_world = A x_index + b, where the
// rows of index_to_world are those of (A b): g = A^-T g', H = A^-T H' A^-1. Made once for many
// points.
struct weft_quantity_transform {
    double inverse[3][3]; // A^-1
};
// Returns WEFT_ERR_ARGUMENT for a transform that is not finite, or is singular as far as doubles
// tell: the determinant of its axes, each divided by its largest entry, is not above 1e-12; *out is
// then all zero. index_to_world NULL: the identity, for quantities in index space.
WEFT_API enum weft_result weft_quantity_transform_create(const struct weft_log *log,
                                                         const double (*index_to_world)[4],
                                                         struct weft_quantity_transform *out);

// Computes the channels of one point of its derivatives, those of the list in its order: of any
// size that floats have. NAN in, NAN out, in the channels that depend on it.
WEFT_API void weft_quantities_compute(const struct weft_quantities *list,
                                      const struct weft_quantity_transform *transform,
                                      const double *derivative, double *channel);

// How far each channel may be off where each derivative may by `error` (>= 0), for these very
// derivatives and whatever signs the errors have; INFINITY where there is no bound, as of a normal
// or curvature whose gradient may be 0. Roundings of the computation itself, in double, are not in
// it.
WEFT_API void weft_quantities_bound(const struct weft_quantities *list,
                                    const struct weft_quantity_transform *transform,
                                    const double *derivative, const double *error, double *bound);

// The same of many points: derivative[i] and channel[i] are planes of `count` floats, which do not
// overlap; computed in double and rounded to float once.
WEFT_API void weft_quantities_compute_planes(const struct weft_quantities *list,
                                             const struct weft_quantity_transform *transform,
                                             size_t count, const float *const *derivative,
                                             float *const *channel);

WEFT_END_DECLS
#endif
