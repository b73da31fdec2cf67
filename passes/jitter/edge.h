// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/edge.h - what a straight edge covers: the exact value of a pixel, of a round lens
// or of any separable pixel filter that half the plane lies under.
//
// An edge is a normal n and a distance d: it covers the points p with p . n <= d. The filter stands
// at the origin; lengths are in pixels (or diameters of the lens). Normals have any length that is
// finite and not 0: n is divided by it, d is not. Everything is pure, allocates nothing, and may be
// called from any thread.
#ifndef WEFT_PASSES_JITTER_EDGE_H
#define WEFT_PASSES_JITTER_EDGE_H

#include "../../filter/kernels/kernel.h"

WEFT_BEGIN_DECLS

// Returns the share of the square [-1/2, 1/2]^2 that the edge covers, 0 to 1. With a >= b >= 0 the
// magnitudes of the normal's coordinates: 1/2 + d / a for |d| <= (a - b) / 2; then, up to
// (a + b) / 2, one corner is missing: 1 - ((a + b) / 2 - d)^2 / (2 a b) for d > 0. Shares and what
// is missing to 1 are right to a few parts in 10^16 of the square, small shares of themselves too,
// as far as d allows. NAN for a normal that is none, or where d is NAN; d may be infinite.
WEFT_API double weft_edge_square(const double normal[2], double distance);

// Returns the share of the disc of diameter 1 about the origin that an edge at distance d covers,
// of any normal: 1/2 + (asin(u) + u sqrt(1 - u^2)) / pi, u = 2 d. NAN where d is NAN.
WEFT_API double weft_edge_disc(double distance);

// A value that was integrated numerically.
struct weft_edge_value {
    double value; // 0 to 1 but for kernels with negative lobes, which go past both
    // An estimate of the error, from the last refinement, with rounding: 1e-14 at most for kernels
    // of the catalogue; those with more corners than they have (tables) are less sure.
    double error;
};

// Computes the share of a pixel's weight that an edge covers when the pixel's filter is the product
// h(x / s) h(y / s) / (s^2 I^2), I the integral of h: with the edge's n = (c, s') and H the
// integral of h, that is the integral of h(x) H((d - c x) / s') dx, taken by Gauss and Legendre's
// rule between the corners of both factors, twice as finely until it stands still. Of a B-spline of
// degree k it is a sum of box filters' convolutions and exact but for rounding. `width` is that of
// the filter's support in pixels, 2 r s; 0: as the kernel stands, s = 1. Takes 0.02 to
// 0.7 ms.
// On failure *out is NAN. Returns WEFT_ERR_ARGUMENT (no kernel, a normal, a distance that is NAN, a
// width that is not in [2^-20, 2^20], an integral of h that is 0 or less: derivatives) or
// WEFT_ERR_UNSUPPORTED (radial kernels, which are no product, and prefiltered ones, whose support
// has no end).
WEFT_API enum weft_result weft_edge_kernel(const struct weft_log *log,
                                           const struct weft_kernel *kernel, double width,
                                           const double normal[2], double distance,
                                           struct weft_edge_value *out);

WEFT_END_DECLS
#endif
