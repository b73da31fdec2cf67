// SPDX-License-Identifier: BSD-3-Clause
// filter/fixed.h - unorm arithmetic as graphics hardware does it: b bits hold 0 to 2^b - 1, which
// is 1.0 (Hadwiger, Hauser and Moeller, WSCG 2003, section 2; equation numbers are theirs). Weights
// may be negative here: magnitudes are treated as the paper treats values, signs are kept.
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

// All functions are pure and thread-safe. Bits are 1 to WEFT_FIXED_MAX_BITS; for others functions
// return 0 where they return integers, NAN where they return numbers.

// Returns the integer that stands for 1.0: 2^bits - 1.
static inline int64_t weft_fixed_one(int bits)
{
    return bits >= 1 && bits <= WEFT_FIXED_MAX_BITS ? (INT64_C(1) << bits) - 1 : 0;
}

// Eq. 2 and 3. The first returns the integer that stands for x, round(x (2^b - 1)) or its
// truncation; nothing is clamped; 0 where x is not finite or |x| is 2^32 or more. The second
// returns the number that an integer stands for, x / (2^b - 1).
WEFT_API int64_t weft_fixed_quantise(double x, int bits, enum weft_fixed_rounding rounding);
WEFT_API double weft_fixed_value(int64_t x, int bits);

// Eq. 6: returns the product of two integers that stand for numbers, x y / (2^b - 1), as an
// integer. |x| and |y| are below 2^31, else it returns 0. The product of values in range is in
// range.
WEFT_API int64_t weft_fixed_multiply(int64_t x, int64_t y, int bits,
                                     enum weft_fixed_rounding rounding);

// Returns what a render target stores: x clamped to [0, 2^b - 1].
WEFT_API int64_t weft_fixed_clamp(int64_t x, int bits);

// Returns the product of two bytes, rounded to nearest, without a division: what
// weft_fixed_multiply returns for 8 bits (Blinn, "Three wrongs make a right", 1995).
static inline uint8_t weft_fixed_multiply_bytes(uint8_t x, uint8_t y)
{
    const unsigned i = (unsigned)x * y + 128;
    return (uint8_t)((i + (i >> 8)) >> 8);
}

// Return the largest error of quantising one value (eps_q) and of one multiplication (eps_m, eq. 7
// and 8), in absolute terms where 1.0 is full range. Both are reached. For eight bits rounded,
// eps_m is 0.0019531; the paper's eq. 9 prints its bound 0.5 / 255 = 0.0019608 instead.
WEFT_API double weft_fixed_quantise_error(int bits, enum weft_fixed_rounding rounding);
WEFT_API double weft_fixed_multiply_error(int bits, enum weft_fixed_rounding rounding);

WEFT_END_DECLS
#endif
