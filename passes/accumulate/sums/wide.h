// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/wide.h - integers of 128, 192 and 256 bits, as sums have them (not
// installed). Pure functions. What does not fit is the caller's fault, and wraps.
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_WIDE_H
#define WEFT_PASSES_ACCUMULATE_SUMS_WIDE_H

#include <math.h>

#include "filter/base.h"

WEFT_BEGIN_DECLS

__extension__ typedef __int128 weft_wide;
__extension__ typedef unsigned __int128 weft_uwide;

static inline weft_uwide weft_wide_magnitude(weft_wide value)
{
    return value < 0 ? -(weft_uwide)value : (weft_uwide)value;
}

// Shifts right, rounded to nearest, ties to even.
static inline weft_wide weft_wide_round(weft_wide value, int bits)
{
    if (bits <= 0)
        return value * ((weft_wide)1 << -bits);
    if (bits > 126)
        return 0;
    const weft_wide floor = value >> bits;
    const weft_uwide rest = (weft_uwide)value - ((weft_uwide)floor << bits);
    const weft_uwide half = (weft_uwide)1 << (bits - 1);
    return floor + (rest > half || (rest == half && (floor & 1)));
}

// The float nearest to numerator / denominator, ties to even; |denominator| < 2^126. NAN where both
// are 0, infinite where the denominator alone is.
float weft_wide_quotient(weft_wide numerator, weft_wide denominator);

// A guess at it that is within 2^-51: whether it is good enough to be sure of the nearest float,
// which it then is.
static inline bool weft_wide_is_near(double guess, float *out)
{
    *out = (float)(guess * (1.0 - 0x1p-50)) + 0.0f; // no negative zero
    return *out == (float)(guess * (1.0 + 0x1p-50));
}

// Limbs from the lowest up; never negative.
struct weft_wide256 {
    uint64_t limb[4];
};

static inline struct weft_wide256 weft_wide256_product(weft_uwide a, weft_uwide b)
{
    const uint64_t x[2] = {(uint64_t)a, (uint64_t)(a >> 64)},
                   y[2] = {(uint64_t)b, (uint64_t)(b >> 64)};
    struct weft_wide256 out = {{0}};
    for (int i = 0; i < 2; i++) {
        weft_uwide carry = 0;
        for (int j = 0; j < 2; j++) {
            carry += (weft_uwide)x[i] * y[j] + out.limb[i + j];
            out.limb[i + j] = (uint64_t)carry;
            carry >>= 64;
        }
        out.limb[i + 2] = (uint64_t)carry;
    }
    return out;
}

static inline struct weft_wide256 weft_wide256_times(struct weft_wide256 a, uint64_t factor)
{
    weft_uwide carry = 0;
    for (int i = 0; i < 4; i++) {
        carry += (weft_uwide)a.limb[i] * factor;
        a.limb[i] = (uint64_t)carry;
        carry >>= 64;
    }
    return a;
}

static inline struct weft_wide256 weft_wide256_sum(struct weft_wide256 a, struct weft_wide256 b)
{
    weft_uwide carry = 0;
    for (int i = 0; i < 4; i++) {
        carry += (weft_uwide)a.limb[i] + b.limb[i];
        a.limb[i] = (uint64_t)carry;
        carry >>= 64;
    }
    return a;
}

// a - b; 0 where b is larger.
static inline struct weft_wide256 weft_wide256_excess(struct weft_wide256 a, struct weft_wide256 b)
{
    bool borrow = false;
    for (int i = 0; i < 4; i++) {
        const weft_uwide taken = (weft_uwide)b.limb[i] + borrow;
        borrow = a.limb[i] < taken;
        a.limb[i] -= (uint64_t)taken;
    }
    return borrow ? (struct weft_wide256){{0}} : a;
}

// As a double, within 2^-51 of it.
static inline double weft_wide256_to_double(struct weft_wide256 a)
{
    double value = 0.0;
    for (int i = 0; i < 4; i++)
        value += ldexp((double)a.limb[i], 64 * i);
    return value;
}

WEFT_END_DECLS
#endif
