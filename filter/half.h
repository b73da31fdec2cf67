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

WEFT_END_DECLS
#endif
