// SPDX-License-Identifier: BSD-3-Clause
// filter/half.h - half floats (IEEE 754 binary16) as their bits (not installed).
#ifndef WEFT_FILTER_HALF_H
#define WEFT_FILTER_HALF_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// The largest finite half. Values from 65520 on, half a step above it, round to infinity.
#define WEFT_HALF_MAX 65504.0f

// Rounds to nearest, ties to even, denormals included. NaN stays NaN, with its sign, and is quiet.
uint16_t weft_half_from_float(float value);

// Exact: every half is a float.
float weft_half_to_float(uint16_t half);

// `count` of them, with the processor's own conversion where it has one: the same bits, but that
// NAN is quiet.
void weft_half_to_floats(const uint16_t *halves, size_t count, float *out);

// What values lose as halves. Starts as {0}; grows by whatever is added.
struct weft_half_losses {
    uint64_t overflows; // finite values that no half holds: they become infinite
    double rounding;    // largest |half - value| of those that stay finite
};

// Rounds `count` values as weft_half_from_float does, and adds what they lose. With the processor's
// own conversion where it has one: the same bits.
void weft_half_from_floats(const float *values, size_t count, uint16_t *out,
                           struct weft_half_losses *losses);

WEFT_END_DECLS
#endif
