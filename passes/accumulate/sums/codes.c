// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/codes.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

// Adding this rounds |x| < 2^22 to an integer, halves to even; taking it away leaves the integer.
#define TO_INTEGER 0x1.8p23f

static inline int32_t code_of(float x, bool truncate)
{
    const float most = WEFT_CODE_LARGEST;
    x = x > -most ? x : -most; // NAN, too
    x = x < most ? x : most;
    return (int32_t)(truncate ? x : (x + TO_INTEGER) - TO_INTEGER);
}

static inline int16_t in_range(int32_t code)
{
    code = code > -WEFT_CODE_LARGEST ? code : -WEFT_CODE_LARGEST;
    return (int16_t)(code < WEFT_CODE_LARGEST ? code : WEFT_CODE_LARGEST);
}

// How many values are done many at a time, to the same bits; the rest follow one by one.
#if defined(__SSE2__)
enum { LANES = 8 };

static inline __m128i load(const int16_t *codes)
{
    return _mm_loadu_si128((const __m128i *)codes);
}

static inline void store(int16_t *codes, __m128i values)
{
    _mm_storeu_si128((__m128i *)codes, _mm_max_epi16(values, _mm_set1_epi16(-WEFT_CODE_LARGEST)));
}

// What is too low, or NAN, becomes the lowest integer, and that the lowest code.
static inline __m128i codes_of(__m128 low, __m128 high, bool truncate)
{
    const __m128 most = _mm_set1_ps(WEFT_CODE_LARGEST);
    low = _mm_min_ps(most, low); // NAN stays
    high = _mm_min_ps(most, high);
    const __m128i codes = truncate ? _mm_packs_epi32(_mm_cvttps_epi32(low), _mm_cvttps_epi32(high))
                                   : _mm_packs_epi32(_mm_cvtps_epi32(low), _mm_cvtps_epi32(high));
    return _mm_max_epi16(codes, _mm_set1_epi16(-WEFT_CODE_LARGEST));
}

static inline size_t add_many(const float *values, float scale, bool truncate, int16_t *codes,
                              size_t count)
{
    const __m128 s = _mm_set1_ps(scale);
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        const __m128i change = codes_of(_mm_mul_ps(_mm_loadu_ps(values + i), s),
                                        _mm_mul_ps(_mm_loadu_ps(values + i + 4), s), truncate);
        store(codes + i, _mm_adds_epi16(load(codes + i), change));
    }
    return i;
}

static inline size_t multiply_many(float factor, bool truncate, int16_t *codes, size_t count)
{
    const __m128 f = _mm_set1_ps(factor);
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        const __m128i old = load(codes + i);
        const __m128i low = _mm_srai_epi32(_mm_unpacklo_epi16(old, old), 16);
        const __m128i high = _mm_srai_epi32(_mm_unpackhi_epi16(old, old), 16);
        store(codes + i, codes_of(_mm_mul_ps(_mm_cvtepi32_ps(low), f),
                                  _mm_mul_ps(_mm_cvtepi32_ps(high), f), truncate));
    }
    return i;
}
#else
static inline size_t add_many(const float *values, float scale, bool truncate, int16_t *codes,
                              size_t count)
{
    (void)values, (void)scale, (void)truncate, (void)codes, (void)count;
    return 0;
}

static inline size_t multiply_many(float factor, bool truncate, int16_t *codes, size_t count)
{
    (void)factor, (void)truncate, (void)codes, (void)count;
    return 0;
}
#endif

void weft_codes_add(const float *values, float scale, bool truncate, int16_t *codes, size_t count)
{
    size_t i = truncate ? add_many(values, scale, true, codes, count)
                        : add_many(values, scale, false, codes, count);
    for (; i < count; i++)
        codes[i] = in_range(codes[i] + code_of(values[i] * scale, truncate));
}

void weft_codes_multiply(float factor, bool truncate, int16_t *codes, size_t count)
{
    size_t i = truncate ? multiply_many(factor, true, codes, count)
                        : multiply_many(factor, false, codes, count);
    for (; i < count; i++)
        codes[i] = in_range(code_of((float)codes[i] * factor, truncate));
}

void weft_codes_shift(float x, bool truncate, int16_t *codes, size_t count)
{
    const int32_t change = code_of(x, truncate);
    for (size_t i = 0; i < count; i++)
        codes[i] = in_range(codes[i] + change);
}
