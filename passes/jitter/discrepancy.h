// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/discrepancy.h - how well a set of samples sees straight edges: its half-plane
// discrepancy, the largest error that the average over the samples, all of one weight, has of a
// pixel (or lens) with one edge of contrast 1.
//
// D = max over all edges of |share of the samples inside - share of the area inside|. The least D
// that n points can have falls as n^(-3/4) (Alexander 1990, Matousek 1995), so that "within 1/n"
// cannot be kept by many: of the sets here `grid` of up to 4 points, j2 and msaa of 2 keep it.
#ifndef WEFT_PASSES_JITTER_DISCREPANCY_H
#define WEFT_PASSES_JITTER_DISCREPANCY_H

#include "jitter.h"

WEFT_BEGIN_DECLS

// Points that are looked at, at most: the time grows as n^2 log n, from 0.2 s for 1,024 points and
// 4 s for 4,096, the memory as n, 16 bytes a point.
enum { WEFT_DISCREPANCY_MAX = 1 << 14 };

// What to look at.
struct weft_discrepancy_params {
    const double (*points)[2];    // count positions (required)
    int count;                    // 1 to WEFT_DISCREPANCY_MAX (required)
    enum weft_jitter_shape shape; // that they are to fill (default: the square)
    double size;                  // side of the square, diameter of the disc (default 1)
    const struct weft_log *log;   // borrowed until the call returns; may be NULL
};
#define WEFT_DISCREPANCY_DEFAULTS
#define weft_discrepancy_params(...)                                                               \
    (&(struct weft_discrepancy_params){WEFT_DISCREPANCY_DEFAULTS __VA_ARGS__})

// D, and an edge that has it.
struct weft_discrepancy {
    double value; // D, 0 to 1; never too small but for rounding, too large by 1e-11 at most
    // The edge covers the points with x cos(angle) + y sin(angle) <= distance, in the points' unit.
    // Samples on it count as inside where share > area, else as outside.
    double angle, distance;
    double share; // of the samples that are inside
    double area;  // of the shape that is inside: weft_edge_square, weft_edge_disc
};

// Computes the discrepancy exactly, but for rounding, by the edges that can be the worst:
// discrepancy.c derives them. Points may lie outside the shape, as those of centred sets do.
// On failure *out is all NAN. Returns WEFT_ERR_ARGUMENT (points that are missing or not finite, a
// count, a shape, a size that is not in [2^-100, 2^100]) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_discrepancy_compute(const struct weft_discrepancy_params *params,
                                                   struct weft_discrepancy *out);

WEFT_END_DECLS
#endif
