// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/blend/emulate.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "filter/half.h"

// To an integer, halves to even; for 0 to 2^22.
static inline float rounded(float value)
{
    return (value + 0x1p23f) - 0x1p23f;
}

void weft_blend_fetch(enum weft_plane_type type, float *values, size_t count)
{
    const bool codes = type == WEFT_PLANE_UNORM8 || type == WEFT_PLANE_UNORM16;
    const float largest = type == WEFT_PLANE_UNORM8 ? 255.0f : 65535.0f, unit = 1.0f / largest;
    for (size_t i = 0; i < count && codes; i++)
        values[i] = rounded(values[i] * largest) * unit;
}

// ---- codes --------------------------------------------------------------------------------------

// To the nearest code, halves to even; what is NAN becomes 0.
static inline uint32_t code_of(float value, float largest)
{
    value = value > 0.0f ? value : 0.0f;
    value = value < 1.0f ? value : 1.0f;
    return (uint32_t)rounded(value * largest);
}

static inline uint32_t product(uint32_t a, uint32_t b, int bits)
{
    const uint32_t ab = a * b;
    return (ab + (ab >> bits) + (1u << (bits - 1))) >> bits;
}

static inline void blend_codes(int bits, const struct weft_blend_step *step, const float *values,
                               size_t count, uint16_t *target)
{
    const uint32_t largest = (1u << bits) - 1, constant = code_of(step->constant, (float)largest);
    const uint32_t rest = step->operation == WEFT_BLEND_MIX ? largest - constant : largest;
    const uint32_t share = step->operation == WEFT_BLEND_SUM ? largest : constant;
    for (size_t i = 0; i < count; i++) {
        const uint32_t sum = product(code_of(values[i], (float)largest), share, bits) +
                             product(target[i], rest, bits); // the whole of it is exact
        target[i] = (uint16_t)(sum < largest ? sum : largest);
    }
}

// ---- floats -------------------------------------------------------------------------------------

static inline float flushed(float value)
{
    return fabsf(value) < FLT_MIN ? 0.0f * value : value;
}

void weft_blend_weigh(float weight, float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        values[i] = flushed(flushed(values[i]) * weight);
}

// Bits of a float that a half lacks are cut off; below its normal range multiples of 2^-24 stay.
static inline float truncated_to_half(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    bits &= 0xffffe000u;
    float normal;
    memcpy(&normal, &bits, sizeof normal);
    const float size = fabsf(value);
    const float small =
        copysignf((float)(int32_t)(size < 0x1p-14f ? size * 0x1p24f : 0.0f) * 0x1p-24f, value);
    const float large = copysignf(isinf(value) ? INFINITY : WEFT_HALF_MAX, value);
    return size < 0x1p-14f ? small : size > WEFT_HALF_MAX ? large : normal;
}

static inline void blend_floats(bool halves, const struct weft_blend_step *step,
                                const float *values, size_t count, float *target)
{
    const float share = step->operation == WEFT_BLEND_SUM ? 1.0f : step->constant;
    const float rest = step->operation == WEFT_BLEND_MIX ? 1.0f - share : 1.0f;
    for (size_t i = 0; i < count; i++) {
        const float sum = flushed(flushed(flushed(values[i]) * share) + flushed(target[i] * rest));
        target[i] = halves ? truncated_to_half(sum) : sum;
    }
}

void weft_blend_emulate(int bits, const struct weft_blend_step *step, const float *values,
                        size_t count, void *target)
{
    if (bits == 8)
        blend_codes(8, step, values, count, target);
    else if (bits == 16)
        blend_codes(16, step, values, count, target);
    else
        blend_floats(bits != 32, step, values, count, target);
}
