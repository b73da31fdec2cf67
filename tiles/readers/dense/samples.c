// SPDX-License-Identifier: BSD-3-Clause
// Samples of all types as floats.
#include <float.h>
#include <math.h>
#include <string.h>

#include "tiles/readers/dense/dense.h"

// A sample in full: integers of 64 bits have as many.
typedef long double number;

static uint64_t load(const struct weft_dense *dense, const unsigned char *from, size_t size)
{
    uint64_t bits = 0;
    unsigned char bytes[8];
    for (size_t i = 0; i < size; i++)
        bytes[i] = from[dense->swapped ? size - 1 - i : i];
    memcpy(&bits, bytes, size);
    return bits;
}

static number sample(const struct weft_dense *dense, const unsigned char *from)
{
    const uint64_t bits = load(dense, from, weft_sample_sizes[dense->type]);
    const uint32_t low = (uint32_t)bits;
    float single;
    double wide;
    switch (dense->type) {
    case WEFT_SAMPLE_UINT8:
    case WEFT_SAMPLE_UINT16:
    case WEFT_SAMPLE_UINT32:
    case WEFT_SAMPLE_UINT64:
        return (number)bits;
    case WEFT_SAMPLE_INT8:
        return (int8_t)low;
    case WEFT_SAMPLE_INT16:
        return (int16_t)low;
    case WEFT_SAMPLE_INT32:
        return (int32_t)low;
    case WEFT_SAMPLE_INT64:
        return (number)(int64_t)bits;
    case WEFT_SAMPLE_FLOAT:
        memcpy(&single, &low, sizeof single);
        return single;
    default:
        memcpy(&wide, &bits, sizeof wide);
        return wide;
    }
}

static bool is_scaled(const struct weft_dense *dense)
{
    return dense->slope != 1.0 || dense->intercept != 0.0;
}

// Scaled in double, as the format's own library does it.
static number value(const struct weft_dense *dense, const unsigned char *from)
{
    const number plain = sample(dense, from);
    return is_scaled(dense) ? dense->slope * (double)plain + dense->intercept : plain;
}

// The same for the most usual samples, without a detour.
#define CONVERT(TYPE)                                                                              \
    for (size_t i = 0; i < count; i++, from += stride) {                                           \
        TYPE one;                                                                                  \
        memcpy(&one, from, sizeof one);                                                            \
        out[i] = (float)one;                                                                       \
    }                                                                                              \
    return true

static bool convert_plain(const struct weft_dense *dense, const unsigned char *from, int64_t stride,
                          size_t count, float *out)
{
    if (dense->swapped || is_scaled(dense) || dense->rest)
        return false;
    switch (dense->type) {
    case WEFT_SAMPLE_UINT8:
        CONVERT(uint8_t);
    case WEFT_SAMPLE_INT16:
        CONVERT(int16_t);
    case WEFT_SAMPLE_UINT16:
        CONVERT(uint16_t);
    case WEFT_SAMPLE_FLOAT:
        CONVERT(float);
    case WEFT_SAMPLE_DOUBLE:
        CONVERT(double);
    default:
        return false;
    }
}

void weft_dense_convert(const struct weft_dense *dense, const unsigned char *from, int64_t stride,
                        size_t count, float *out)
{
    if (convert_plain(dense, from, stride, count, out))
        return;
    for (size_t i = 0; i < count; i++, from += stride) {
        const number whole = value(dense, from);
        const float rounded = (float)whole;
        const number lack = whole - (number)rounded;
        out[i] = !dense->rest ? rounded : isfinite(lack) ? (float)lack : 0.0f;
    }
}

void weft_dense_count_values(const struct weft_dense *dense, const unsigned char *from,
                             int64_t stride, size_t count, struct weft_volume_info *info)
{
    const bool integers = dense->type < WEFT_SAMPLE_FLOAT && !is_scaled(dense);
    for (size_t i = 0; i < count; i++, from += stride) {
        const number whole = value(dense, from);
        const double lack = (double)fabsl(whole - (number)(float)whole);
        if (integers && lack > 0.0) {
            info->values_rounded++;
            info->largest_rounding = lack > info->largest_rounding ? lack : info->largest_rounding;
        }
        if (!integers) {
            info->values_infinite += isfinite(whole) && isinf((float)whole);
            info->values_tiny += whole != 0 && fabsl(whole) < FLT_MIN;
        }
    }
}
