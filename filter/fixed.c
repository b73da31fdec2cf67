// SPDX-License-Identifier: BSD-3-Clause
#include "filter/fixed.h"

#include <math.h>

const char *const weft_fixed_rounding_names[] = {"nearest", "truncated", NULL};

int64_t weft_fixed_quantise(double x, int bits, enum weft_fixed_rounding rounding)
{
    if (!(fabs(x) < 0x1p32))
        return 0;
    const double scaled = x * (double)weft_fixed_one(bits);
    return (int64_t)(rounding == WEFT_FIXED_ROUND ? round(scaled) : trunc(scaled));
}

double weft_fixed_value(int64_t x, int bits)
{
    const int64_t one = weft_fixed_one(bits);
    return one ? (double)x / (double)one : (double)NAN;
}

int64_t weft_fixed_multiply(int64_t x, int64_t y, int bits, enum weft_fixed_rounding rounding)
{
    const int64_t one = weft_fixed_one(bits), limit = INT64_C(1) << 31;
    if (one == 0 || x <= -limit || x >= limit || y <= -limit || y >= limit)
        return 0;
    const int64_t product = x * y;
    // one is odd, so no product is half way.
    const int64_t half = rounding == WEFT_FIXED_ROUND ? one / 2 : 0;
    return (product + (product < 0 ? -half : half)) / one;
}

int64_t weft_fixed_clamp(int64_t x, int bits)
{
    const int64_t one = weft_fixed_one(bits);
    return x < 0 ? 0 : x > one ? one : x;
}

double weft_fixed_quantise_error(int bits, enum weft_fixed_rounding rounding)
{
    const double one = (double)weft_fixed_one(bits);
    return one > 0.0 ? (rounding == WEFT_FIXED_ROUND ? 0.5 : 1.0) / one : (double)NAN;
}

double weft_fixed_multiply_error(int bits, enum weft_fixed_rounding rounding)
{
    const double one = (double)weft_fixed_one(bits);
    return one > 0.0 ? (rounding == WEFT_FIXED_ROUND ? 0.5 : 1.0) * (one - 1.0) / (one * one)
                     : (double)NAN;
}
