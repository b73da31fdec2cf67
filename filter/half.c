// SPDX-License-Identifier: BSD-3-Clause
#include "filter/half.h"

#include <string.h>

// A shift of `drop` bits, rounded to nearest, ties to even.
static uint32_t round_off(uint32_t bits, int drop)
{
    const uint32_t half = UINT32_C(1) << (drop - 1), rest = bits & (2 * half - 1);
    const uint32_t kept = bits >> drop;
    return kept + (rest > half || (rest == half && (kept & 1)));
}

uint16_t weft_half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint32_t sign = bits >> 16 & 0x8000, size = bits & 0x7fffffff;
    const int exponent = (int)(size >> 23) - 127;
    uint32_t half;
    if (size > 0x7f800000)
        half = 0x7e00 | (size >> 13 & 0x1ff);
    else if (exponent > 15)
        half = 0x7c00;
    else if (exponent >= -14) // a carry out of the fraction raises the exponent, up to infinity
        half = round_off(size - (UINT32_C(112) << 23), 13);
    else if (exponent >= -25) // denormal: units of 2^-24
        half = round_off((size & 0x7fffff) | 0x800000, -1 - exponent);
    else
        half = 0;
    return (uint16_t)(sign | half);
}

float weft_half_to_float(uint16_t half)
{
    const uint32_t sign = (uint32_t)(half & 0x8000) << 16, fraction = half & 0x3ff;
    const uint32_t exponent = half >> 10 & 31;
    uint32_t bits;
    float value;
    if (exponent == 0) {
        value = (float)fraction * 0x1p-24f;
        return sign ? -value : value;
    }
    bits = sign | (exponent == 31 ? 0x7f800000 : (exponent + 112) << 23) | fraction << 13;
    memcpy(&value, &bits, sizeof value);
    return value;
}
