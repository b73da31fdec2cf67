// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/codes.h - arithmetic of signed codes of 16 bits, -32767 to 32767 (not
// installed). Products are made in single precision, become the nearest code, halves the even one,
// or with `truncate` the next one toward zero, and those that are beyond all codes the last one;
// then so do sums. NAN is a product below all codes. Pure functions; thread-safe.
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_CODES_H
#define WEFT_PASSES_ACCUMULATE_SUMS_CODES_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

enum { WEFT_CODE_LARGEST = 32767 };

// a = a + v scale
void weft_codes_add(const float *values, float scale, bool truncate, int16_t *codes, size_t count);
// a = a factor
void weft_codes_multiply(float factor, bool truncate, int16_t *codes, size_t count);
// a = a + x
void weft_codes_shift(float x, bool truncate, int16_t *codes, size_t count);

WEFT_END_DECLS
#endif
