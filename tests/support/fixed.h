// SPDX-License-Identifier: BSD-3-Clause
// tests/support/fixed.h - unorm arithmetic as graphics hardware does it, by its definition: what
// tests compare integer results with. b bits (1 to WEFT_FIXED_MAX_BITS) hold 0 to 2^b - 1, which is
// 1.0 (Hadwiger, Hauser and Moeller, WSCG 2003, section 2; equation numbers are theirs). Signs are
// kept.
#ifndef WEFT_TESTS_SUPPORT_FIXED_H
#define WEFT_TESTS_SUPPORT_FIXED_H

#include <math.h>

#include "filter/fixed.h"

// Eq. 2 and 3: the integer that stands for x, and the number that an integer stands for.
static inline int64_t fixed_quantise(double x, int bits, enum weft_fixed_rounding rounding)
{
    const double scaled = x * (double)weft_fixed_one(bits);
    return (int64_t)(rounding == WEFT_FIXED_ROUND ? round(scaled) : trunc(scaled));
}

static inline double fixed_value(int64_t x, int bits)
{
    return (double)x / (double)weft_fixed_one(bits);
}

// Eq. 6: x y / (2^b - 1), |x|, |y| < 2^31.
static inline int64_t fixed_multiply(int64_t x, int64_t y, int bits,
                                     enum weft_fixed_rounding rounding)
{
    const int64_t one = weft_fixed_one(bits), product = x * y;
    // one is odd, so no product is half way.
    const int64_t half = rounding == WEFT_FIXED_ROUND ? one / 2 : 0;
    return (product + (product < 0 ? -half : half)) / one;
}

// What a render target stores.
static inline int64_t fixed_clamp(int64_t x, int bits)
{
    const int64_t one = weft_fixed_one(bits);
    return x < 0 ? 0 : x > one ? one : x;
}

#endif
