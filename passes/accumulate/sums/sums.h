// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/sums.h - sums of weight * value as integers, one for every pixel of a
// channel (not installed). Sums are the same whatever the order of frames: what is rounded is each
// product by itself, and that only in sums of 128 bits and below their unit.
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_SUMS_H
#define WEFT_PASSES_ACCUMULATE_SUMS_SUMS_H

#include "passes/accumulate/sums/weights.h"
#include "passes/cpu/cpu.h"
#include "tiles/image/plane.h"

WEFT_BEGIN_DECLS

// What sums are counted in. Narrow ones have integer weights, wide ones any; the latter are the
// last two.
enum weft_sum_kind {
    WEFT_SUM_NONE,    // no frame yet
    WEFT_SUM_UNORM8,  // int32_t, units of 1 / 255
    WEFT_SUM_UNORM16, // int64_t, units of 1 / 65535
    WEFT_SUM_UINT,    // int64_t, units of 1
    WEFT_SUM_HALF,    // int64_t, units of 2^-24, the least half
    WEFT_SUM_WIDE,    // weft_wide, units of 2^-64
    WEFT_SUM_MIXED,   // weft_wide, units of 2^-64 / 65535, in which codes are integers, too
    WEFT_SUM_KIND_COUNT
};
enum { WEFT_SUM_UNIT_BITS = 64, WEFT_SUM_LARGEST_CODE = 65535 };

// Of one channel. Starts as {0}.
struct weft_plane_sums {
    enum weft_sum_kind kind;
    void *sum; // of every pixel; NULL for none
};

// The kind that values of a type are added up in.
enum weft_sum_kind weft_sums_kind_of(enum weft_plane_type type, bool narrow);
// The wide kind that takes sums of a kind exactly.
enum weft_sum_kind weft_sums_widened(enum weft_sum_kind kind);
// The least kind that takes the sums of both exactly.
enum weft_sum_kind weft_sums_common_kind(enum weft_sum_kind a, enum weft_sum_kind b);
size_t weft_sums_size(enum weft_sum_kind kind); // of one sum in bytes
// What |sums| of a kind stay below, in values: they may then be added up.
double weft_sums_capacity(enum weft_sum_kind kind);

// Brings `count` sums to a kind, exactly. False: no memory; the sums are then as they were.
bool weft_sums_raise(struct weft_plane_sums *sums, enum weft_sum_kind kind, size_t count);
void weft_sums_clear(struct weft_plane_sums *sums);

// Adds weight * value for `count` values that lie one after another, from sum `at` on. The sums'
// kind is at least that of the values, which are finite; `largest` of all |values|.
struct weft_sums_addend {
    const void *values;
    enum weft_plane_type type;
    size_t at, count;
    double largest;
};
void weft_sums_add(const struct weft_plane_sums *sums, const struct weft_sums_addend *addend,
                   const struct weft_weight *weight, enum weft_instruction_set instructions);

// Sum `at` as one of another kind, at least the sums' own.
weft_wide weft_sums_get(const struct weft_plane_sums *sums, size_t at, enum weft_sum_kind kind);
// Sums `first` and those behind as doubles, within 2^-51 of them, in their own units; and what sums
// of a wide kind have more of these in a value.
void weft_sums_read(const struct weft_plane_sums *sums, size_t first, size_t count, double *out);
double weft_sums_widening(enum weft_sum_kind kind);
// Adds other sums, of a kind that is not above.
void weft_sums_join(const struct weft_plane_sums *sums, const struct weft_plane_sums *other,
                    size_t first, size_t end);

WEFT_END_DECLS
#endif
