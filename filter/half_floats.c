// SPDX-License-Identifier: BSD-3-Clause
// Many floats as halves and back: F16C converts eight at once where the processor has it.
#include <math.h>

#include "filter/half.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

static void convert_plain(const float *values, size_t count, uint16_t *out,
                          struct weft_half_losses *losses)
{
    for (size_t i = 0; i < count; i++) {
        out[i] = weft_half_from_float(values[i]);
        const float stored = weft_half_to_float(out[i]);
        if (isfinite(stored))
            losses->rounding = fmax(losses->rounding, fabs((double)stored - (double)values[i]));
        else
            losses->overflows += isfinite(values[i]) != 0;
    }
}

#if defined(__x86_64__)
// Differences are exact: a half is 0, or within a factor of two of what it stands for. Those of
// infinities and NAN are no numbers, which a maximum passes over.
__attribute__((target("avx2,f16c"))) static void
convert_f16c(const float *values, size_t count, uint16_t *out, struct weft_half_losses *losses)
{
    enum { LANES = 8 };
    const __m256 size = _mm256_castsi256_ps(_mm256_set1_epi32(0x7fffffff));
    const __m256 infinite = _mm256_set1_ps(INFINITY);
    __m256 largest = _mm256_setzero_ps();
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        const __m256 value = _mm256_loadu_ps(values + i);
        const __m128i half = _mm256_cvtps_ph(value, _MM_FROUND_TO_NEAREST_INT);
        const __m256 stored = _mm256_cvtph_ps(half);
        const __m256 change = _mm256_and_ps(size, _mm256_sub_ps(stored, value));
        const __m256 lost = _mm256_cmp_ps(change, infinite, _CMP_EQ_OQ);
        _mm_storeu_si128((__m128i *)(out + i), half);
        losses->overflows += (uint64_t)__builtin_popcount((unsigned)_mm256_movemask_ps(lost));
        largest = _mm256_max_ps(_mm256_andnot_ps(lost, change), largest);
    }
    float lanes[LANES];
    _mm256_storeu_ps(lanes, largest);
    for (int l = 0; l < LANES; l++)
        losses->rounding = fmax(losses->rounding, (double)lanes[l]);
    convert_plain(values + i, count - i, out + i, losses);
}
#endif

void weft_half_from_floats(const float *values, size_t count, uint16_t *out,
                           struct weft_half_losses *losses)
{
#if defined(__x86_64__)
    // Not every compiler knows the name of F16C; what has AVX2 has it, too.
    if (__builtin_cpu_supports("avx2")) {
        convert_f16c(values, count, out, losses);
        return;
    }
#endif
    convert_plain(values, count, out, losses);
}

static void widen_plain(const uint16_t *halves, size_t count, float *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = weft_half_to_float(halves[i]);
}

#if defined(__x86_64__)
__attribute__((target("avx2,f16c"))) static void widen_f16c(const uint16_t *halves, size_t count,
                                                            float *out)
{
    enum { LANES = 8 };
    size_t i = 0;
    for (; i + LANES <= count; i += LANES)
        _mm256_storeu_ps(out + i, _mm256_cvtph_ps(_mm_loadu_si128((const __m128i *)(halves + i))));
    widen_plain(halves + i, count - i, out + i);
}
#endif

void weft_half_to_floats(const uint16_t *halves, size_t count, float *out)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) {
        widen_f16c(halves, count, out);
        return;
    }
#endif
    widen_plain(halves, count, out);
}
