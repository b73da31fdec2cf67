// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/reach.h - how far sums may reach, kept as integers (not installed): each
// frame's part is rounded up to units by itself, so that what is kept is the same whatever the
// order of frames, and parts can be joined to the same bytes. Pure functions.
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_REACH_H
#define WEFT_PASSES_ACCUMULATE_SUMS_REACH_H

#include "passes/accumulate/sums/wide.h"

WEFT_BEGIN_DECLS

// Units of 2^-64 of sums, which stay below 2^62 values, and of 2^-24 of sums of squares: below 2^86
// in wide kinds, and 2^96 for all the integers that narrow ones take.
enum { WEFT_REACH_BITS = 64, WEFT_REACH_SQUARES_BITS = 24 };

// What was checked against the capacities of kinds.
static inline weft_uwide weft_reach_make(double values)
{
    return (weft_uwide)ceil(ldexp(values, WEFT_REACH_BITS));
}

static inline double weft_reach_read(weft_uwide reach)
{
    return ldexp((double)reach, -WEFT_REACH_BITS);
}

static inline weft_uwide weft_reach_make_squares(double squares)
{
    return (weft_uwide)ceil(ldexp(squares, WEFT_REACH_SQUARES_BITS));
}

static inline double weft_reach_read_squares(weft_uwide reach)
{
    return ldexp((double)reach, -WEFT_REACH_SQUARES_BITS);
}

// Whether it can be that of sums, for what was read.
static inline bool weft_reach_can_be(weft_uwide reach)
{
    return reach >> 127 == 0;
}

WEFT_END_DECLS
#endif
