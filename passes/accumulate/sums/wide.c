// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/wide.h"

// Enough bits that the last ones only say whether anything is left.
enum { QUOTIENT_BITS = 30 };

static int bit_length(weft_uwide value)
{
    const uint64_t high = (uint64_t)(value >> 64), low = (uint64_t)value;
    if (high)
        return 128 - __builtin_clzll(high);
    return low ? 64 - __builtin_clzll(low) : 0;
}

// Long division: QUOTIENT_BITS bits of a / b, and below them one that is set where a rest remains.
// A double holds them, and its rounding to a float is the only one, down to subnormal floats.
static float divide(weft_uwide a, weft_uwide b)
{
    const int shift = bit_length(a) - bit_length(b);
    if (shift > 0)
        b <<= shift; // below 2^127, as a is
    else
        a <<= -shift;
    uint64_t bits = 0;
    for (int i = 0; i <= QUOTIENT_BITS; i++) {
        bits <<= 1;
        if (a >= b) {
            a -= b;
            bits |= 1;
        }
        a <<= 1;
    }
    bits = bits << 1 | (a != 0);
    return (float)ldexp((double)bits, shift - QUOTIENT_BITS - 1);
}

float weft_wide_quotient(weft_wide numerator, weft_wide denominator)
{
    if (numerator == 0 || denominator == 0)
        return denominator == 0 ? (float)NAN : 0.0f;
    float near;
    if (weft_wide_is_near((double)numerator / (double)denominator, &near))
        return near;
    const float size = divide(weft_wide_magnitude(numerator), weft_wide_magnitude(denominator));
    return (numerator < 0) != (denominator < 0) ? -size : size;
}
