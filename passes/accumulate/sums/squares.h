// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/squares.h - sums of squares of integers, one for every pixel of a channel
// (not installed). What is squared is a sum of sums.h with weights of 1, of the same kind: a sum of
// squares is in units of the square of that sum's unit, and exact, but that wide ones are in units
// of 2^-104 (and 2^-104 / 65535^2), to which each square is rounded by itself. So these sums, too,
// are the same whatever their order.
//
// Why not Welford's running mean and variance: its result depends on the order of frames and cannot
// be joined to the same bytes. With exact sums nothing cancels, which is what it is for.
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_SQUARES_H
#define WEFT_PASSES_ACCUMULATE_SUMS_SQUARES_H

#include "passes/accumulate/sums/sums.h"

WEFT_BEGIN_DECLS

enum { WEFT_SQUARE_UNIT_BITS = 104 };

// Of one channel. Starts as {0}. The sums are uint64_t of codes, weft_uwide of halves and integers,
// and three limbs of 64 bits, the lowest first, of wide kinds.
struct weft_plane_squares {
    enum weft_sum_kind kind;
    void *sum; // of every pixel; NULL for none
};

size_t weft_squares_size(enum weft_sum_kind kind); // of one sum in bytes
// What sums of squares of a kind stay below, in values squared.
double weft_squares_capacity(enum weft_sum_kind kind);
// Brings `count` sums to a kind, exactly. False: no memory; the sums are then as they were.
bool weft_squares_raise(struct weft_plane_squares *squares, enum weft_sum_kind kind, size_t count);
void weft_squares_clear(struct weft_plane_squares *squares);

// Adds `count` terms, sums of the squares' kind, and their squares, to sums `at` and those behind.
void weft_squares_fold(const struct weft_plane_squares *squares, const struct weft_plane_sums *sums,
                       size_t at, const void *terms, size_t count);
// Adds other sums, of a kind that is not above.
void weft_squares_join(const struct weft_plane_squares *squares,
                       const struct weft_plane_squares *other, size_t count);

// The sum of (value - mean)^2 over n values, times n, of pixel i: n sum v^2 - (sum v)^2, exact but
// for the units of wide kinds, then a double. `sums` are of the same kind; n < 2^25.
double weft_squares_spread(const struct weft_plane_squares *squares,
                           const struct weft_plane_sums *sums, size_t i, uint64_t n);

WEFT_END_DECLS
#endif
