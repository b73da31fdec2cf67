// SPDX-License-Identifier: BSD-3-Clause
// filter/fixed.h - unorm arithmetic as graphics hardware does it: b bits hold 0 to 2^b - 1, which
// is 1.0 (Hadwiger, Hauser and Moeller, WSCG 2003, section 2).
#ifndef WEFT_FILTER_FIXED_H
#define WEFT_FILTER_FIXED_H

#include "base.h"

WEFT_BEGIN_DECLS

enum { WEFT_FIXED_MAX_BITS = 24 }; // where a double still multiplies exactly

// How a result that lies between two integers becomes one of them. Default: to the nearest.
enum weft_fixed_rounding {
    WEFT_FIXED_ROUND,    // to the nearest, halves away from zero
    WEFT_FIXED_TRUNCATE, // towards zero
};
// NULL-ended, in the order of the enum: "nearest", "truncated".
WEFT_API extern const char *const weft_fixed_rounding_names[];

// Returns the integer that stands for 1.0: 2^bits - 1; 0 for bits that are not 1 to
// WEFT_FIXED_MAX_BITS. Pure and thread-safe.
static inline int64_t weft_fixed_one(int bits)
{
    return bits >= 1 && bits <= WEFT_FIXED_MAX_BITS ? (INT64_C(1) << bits) - 1 : 0;
}

WEFT_END_DECLS
#endif
