// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/sums.h"

#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/half.h"

// Halves and floats as their bits.
enum { HALF_UNIT_BITS = 24, CODE_FACTOR = 257 }; // 65535 = 257 * 255

// ---- kinds --------------------------------------------------------------------------------------

static bool is_wide(enum weft_sum_kind kind)
{
    return kind >= WEFT_SUM_WIDE;
}

static bool is_code(enum weft_sum_kind kind)
{
    return kind == WEFT_SUM_UNORM8 || kind == WEFT_SUM_UNORM16 || kind == WEFT_SUM_MIXED;
}

enum weft_sum_kind weft_sums_widened(enum weft_sum_kind kind)
{
    if (kind == WEFT_SUM_NONE)
        return kind;
    return is_code(kind) ? WEFT_SUM_MIXED : WEFT_SUM_WIDE;
}

enum weft_sum_kind weft_sums_kind_of(enum weft_plane_type type, bool narrow)
{
    static const enum weft_sum_kind kinds[] = {
        [WEFT_PLANE_FLOAT] = WEFT_SUM_WIDE,    [WEFT_PLANE_HALF] = WEFT_SUM_HALF,
        [WEFT_PLANE_UNORM8] = WEFT_SUM_UNORM8, [WEFT_PLANE_UNORM16] = WEFT_SUM_UNORM16,
        [WEFT_PLANE_UINT] = WEFT_SUM_UINT,
    };
    return narrow ? kinds[type] : weft_sums_widened(kinds[type]);
}

enum weft_sum_kind weft_sums_common_kind(enum weft_sum_kind a, enum weft_sum_kind b)
{
    const enum weft_sum_kind low = a < b ? a : b, high = a < b ? b : a;
    if (low == high || low == WEFT_SUM_NONE)
        return high;
    if (low == WEFT_SUM_UNORM8 && high == WEFT_SUM_UNORM16)
        return high;
    return is_code(low) || is_code(high) ? WEFT_SUM_MIXED : WEFT_SUM_WIDE;
}

size_t weft_sums_size(enum weft_sum_kind kind)
{
    static const size_t sizes[] = {0,
                                   sizeof(int32_t),
                                   sizeof(int64_t),
                                   sizeof(int64_t),
                                   sizeof(int64_t),
                                   sizeof(weft_wide),
                                   sizeof(weft_wide)};
    return sizes[kind];
}

double weft_sums_capacity(enum weft_sum_kind kind)
{
    if (!is_wide(kind)) // the sum of weights is what limits them
        return INFINITY;
    return kind == WEFT_SUM_MIXED ? 0x1p46 : 0x1p62;
}

// What a sum of kind `from` is multiplied by to be one of kind `to`; never 0.
static weft_wide factor_between(enum weft_sum_kind from, enum weft_sum_kind to)
{
    const weft_wide one = (weft_wide)1 << WEFT_SUM_UNIT_BITS;
    weft_wide factor = 1;
    if (from == to)
        return 1;
    if (from == WEFT_SUM_UNORM8)
        factor = CODE_FACTOR;
    else if (to == WEFT_SUM_MIXED && from != WEFT_SUM_UNORM16)
        factor = WEFT_SUM_LARGEST_CODE;
    if (is_wide(to) && !is_wide(from))
        factor *= from == WEFT_SUM_HALF ? one >> HALF_UNIT_BITS : one;
    return factor;
}

static weft_wide stored(const struct weft_plane_sums *sums, size_t at)
{
    switch (weft_sums_size(sums->kind)) {
    case sizeof(int32_t):
        return ((const int32_t *)sums->sum)[at];
    case sizeof(int64_t):
        return ((const int64_t *)sums->sum)[at];
    case sizeof(weft_wide):
        return ((const weft_wide *)sums->sum)[at];
    default:
        return 0;
    }
}

static void increase(const struct weft_plane_sums *sums, size_t at, weft_wide by)
{
    switch (weft_sums_size(sums->kind)) {
    case sizeof(int32_t):
        ((int32_t *)sums->sum)[at] += (int32_t)by;
        return;
    case sizeof(int64_t):
        ((int64_t *)sums->sum)[at] += (int64_t)by;
        return;
    default:
        ((weft_wide *)sums->sum)[at] += by;
        return;
    }
}

weft_wide weft_sums_get(const struct weft_plane_sums *sums, size_t at, enum weft_sum_kind kind)
{
    return stored(sums, at) * factor_between(sums->kind, kind);
}

static double size_of(weft_wide value)
{
    const weft_uwide size = weft_wide_magnitude(value);
    const double read = (double)(uint64_t)(size >> 64) * 0x1p64 + (double)(uint64_t)size;
    return value < 0 ? -read : read;
}

void weft_sums_read(const struct weft_plane_sums *sums, size_t first, size_t count, double *out)
{
    const size_t size = weft_sums_size(sums->kind);
    const void *sum = (const char *)sums->sum + first * size;
    if (size == sizeof(int32_t))
        for (size_t i = 0; i < count; i++)
            out[i] = ((const int32_t *)sum)[i];
    else if (size == sizeof(int64_t))
        for (size_t i = 0; i < count; i++)
            out[i] = (double)((const int64_t *)sum)[i];
    else
        for (size_t i = 0; i < count; i++)
            out[i] = size_of(((const weft_wide *)sum)[i]);
}

double weft_sums_widening(enum weft_sum_kind kind)
{
    return (double)factor_between(kind, weft_sums_widened(kind));
}

// Of one kind: what is done most is a loop without choices.
static void join_alike(const struct weft_plane_sums *sums, const struct weft_plane_sums *other,
                       size_t first, size_t end)
{
    const size_t size = weft_sums_size(sums->kind);
    if (size == sizeof(int32_t))
        for (size_t i = first; i < end; i++)
            ((int32_t *)sums->sum)[i] += ((const int32_t *)other->sum)[i];
    else if (size == sizeof(int64_t))
        for (size_t i = first; i < end; i++)
            ((int64_t *)sums->sum)[i] += ((const int64_t *)other->sum)[i];
    else if (size == sizeof(weft_wide))
        for (size_t i = first; i < end; i++)
            ((weft_wide *)sums->sum)[i] += ((const weft_wide *)other->sum)[i];
}

void weft_sums_join(const struct weft_plane_sums *sums, const struct weft_plane_sums *other,
                    size_t first, size_t end)
{
    if (sums->kind == other->kind) {
        join_alike(sums, other, first, end);
        return;
    }
    const weft_wide factor = factor_between(other->kind, sums->kind);
    for (size_t i = first; i < end && other->kind != WEFT_SUM_NONE; i++)
        increase(sums, i, stored(other, i) * factor);
}

bool weft_sums_raise(struct weft_plane_sums *sums, enum weft_sum_kind kind, size_t count)
{
    if (kind == sums->kind)
        return true;
    struct weft_plane_sums raised = {kind, calloc(count, weft_sums_size(kind))};
    if (!raised.sum)
        return false;
    weft_sums_join(&raised, sums, 0, count);
    weft_sums_clear(sums);
    *sums = raised;
    return true;
}

void weft_sums_clear(struct weft_plane_sums *sums)
{
    free(sums->sum);
    *sums = (struct weft_plane_sums){0};
}

// ---- narrow sums --------------------------------------------------------------------------------

// A half in units of 2^-24: below 2^11 times a power of two up to 2^29.
static inline int64_t half_times(uint16_t half, int32_t weight)
{
    const uint32_t exponent = half >> 10 & 31, normal = exponent != 0;
    const uint32_t mantissa = (half & 1023u) | normal << 10;
    const int64_t size = (int64_t)mantissa * weight * ((int64_t)1 << (exponent - normal));
    return half & 0x8000 ? -size : size;
}

#define EVERY for (size_t i = 0; i < count; i++)
#define LOOPS(set, attribute)                                                                      \
    attribute static void unorm8_##set(int32_t *restrict sum, const uint8_t *restrict value,       \
                                       size_t count, int32_t weight)                               \
    {                                                                                              \
        if (weight == 1)                                                                           \
            EVERY sum[i] += value[i];                                                              \
        else                                                                                       \
            EVERY sum[i] += value[i] * weight;                                                     \
    }                                                                                              \
    attribute static void bytes_##set(int64_t *restrict sum, const uint8_t *restrict value,        \
                                      size_t count, int32_t weight)                                \
    {                                                                                              \
        EVERY sum[i] += (int64_t)(value[i] * CODE_FACTOR) * weight;                                \
    }                                                                                              \
    attribute static void words_##set(int64_t *restrict sum, const uint16_t *restrict value,       \
                                      size_t count, int32_t weight)                                \
    {                                                                                              \
        if (weight == 1)                                                                           \
            EVERY sum[i] += value[i];                                                              \
        else                                                                                       \
            EVERY sum[i] += (int64_t)(int32_t)value[i] * weight;                                   \
    }                                                                                              \
    attribute static void integers_##set(int64_t *restrict sum, const uint32_t *restrict value,    \
                                         size_t count, int32_t weight)                             \
    {                                                                                              \
        EVERY sum[i] += (int64_t)value[i] * weight;                                                \
    }                                                                                              \
    attribute static void halves_##set(int64_t *restrict sum, const uint16_t *restrict value,      \
                                       size_t count, int32_t weight)                               \
    {                                                                                              \
        if (weight == 1)                                                                           \
            EVERY sum[i] += half_times(value[i], 1);                                               \
        else                                                                                       \
            EVERY sum[i] += half_times(value[i], weight);                                          \
    }

LOOPS(plain, )
#if defined(__x86_64__)
LOOPS(avx2, __attribute__((target("avx2"))))
#else
#define unorm8_avx2 unorm8_plain
#define bytes_avx2 bytes_plain
#define words_avx2 words_plain
#define integers_avx2 integers_plain
#define halves_avx2 halves_plain
#endif

static void add_narrow(const struct weft_plane_sums *sums, const struct weft_sums_addend *a,
                       int32_t weight, bool avx2)
{
    int64_t *sum = (int64_t *)sums->sum + (sums->kind == WEFT_SUM_UNORM8 ? 0 : a->at);
    if (sums->kind == WEFT_SUM_UNORM8)
        (avx2 ? unorm8_avx2 : unorm8_plain)((int32_t *)sums->sum + a->at, a->values, a->count,
                                            weight);
    else if (a->type == WEFT_PLANE_UNORM8)
        (avx2 ? bytes_avx2 : bytes_plain)(sum, a->values, a->count, weight);
    else if (a->type == WEFT_PLANE_UNORM16)
        (avx2 ? words_avx2 : words_plain)(sum, a->values, a->count, weight);
    else if (a->type == WEFT_PLANE_UINT)
        (avx2 ? integers_avx2 : integers_plain)(sum, a->values, a->count, weight);
    else
        (avx2 ? halves_avx2 : halves_plain)(sum, a->values, a->count, weight);
}

// ---- wide sums ----------------------------------------------------------------------------------

// A value as an integer times a power of two.
struct term {
    int64_t integer;
    int log2;
};

static inline struct term term_of(const void *values, enum weft_plane_type type, size_t i)
{
    switch (type) {
    case WEFT_PLANE_UNORM8:
        return (struct term){((const uint8_t *)values)[i] * CODE_FACTOR, 0};
    case WEFT_PLANE_UNORM16:
        return (struct term){((const uint16_t *)values)[i], 0};
    case WEFT_PLANE_UINT:
        return (struct term){((const uint32_t *)values)[i], 0};
    case WEFT_PLANE_HALF:
        return (struct term){half_times(((const uint16_t *)values)[i], 1), -HALF_UNIT_BITS};
    default:
        break;
    }
    uint32_t bits;
    memcpy(&bits, (const char *)values + i * sizeof bits, sizeof bits);
    const uint32_t exponent = bits >> 23 & 255, normal = exponent != 0;
    const int32_t size = (int32_t)((bits & 0x7fffffu) | normal << 23);
    return (struct term){bits >> 31 ? -size : size, (int)(exponent - normal) - 149};
}

// Weight times value, rounded to a unit: |fixed| <= 2^84 and |integer| < 2^41, and whoever adds has
// seen to it that the product fits. Type and factor are known when it is compiled.
static inline __attribute__((always_inline)) void
add_general(weft_wide *sum, const struct weft_sums_addend *a, weft_wide fixed,
            enum weft_plane_type type, int32_t factor)
{
    for (size_t i = 0; i < a->count; i++) {
        const struct term term = term_of(a->values, type, i);
        sum[i] += weft_wide_round(fixed * term.integer, -term.log2) * factor;
    }
}

// Products that a double holds: their integer parts in units of 2^-32, then what is left, of which
// only the latter is rounded, to even. So it is the rounding of add_general.
static inline __attribute__((always_inline)) void
add_doubles(weft_wide *sum, const struct weft_sums_addend *a, double weight, int32_t factor)
{
    const float *value = a->values;
    for (size_t i = 0; i < a->count; i++) {
        const double product = (double)value[i] * weight * 0x1p32;
        const int64_t high = llrint(product), low = llrint((product - (double)high) * 0x1p32);
        sum[i] += (high * ((weft_wide)1 << 32) + low) * factor;
    }
}

// Other weights are the sum of two that have 24 and 29 bits, so that doubles hold both products.
// What is left of these, each within a half, is rounded together, to nearest; ties, and what might
// be one, are left to the integers.
static inline __attribute__((always_inline)) void add_pairs(weft_wide *sum,
                                                            const struct weft_sums_addend *a,
                                                            weft_wide fixed, double weight,
                                                            int32_t factor)
{
    const float *value = a->values;
    const double first = (double)(float)weight, second = weight - first;
    for (size_t i = 0; i < a->count; i++) {
        const double product = (double)value[i] * first * 0x1p32;
        const double small = (double)value[i] * second * 0x1p64;
        const int64_t high = llrint(product);
        const double middle = (product - (double)high) * 0x1p32;
        const int64_t low = llrint(middle), lowest = llrint(small);
        const double rest = (middle - (double)low) + (small - (double)lowest);
        weft_wide term = high * ((weft_wide)1 << 32) + low + lowest + (rest > 0.5) - (rest < -0.5);
        if (fabs(rest) == 0.5) {
            const struct term t = term_of(value, WEFT_PLANE_FLOAT, i);
            term = weft_wide_round(fixed * t.integer, -t.log2);
        }
        sum[i] += term * factor;
    }
}

static inline __attribute__((always_inline)) void add_values(weft_wide *sum,
                                                             const struct weft_sums_addend *a,
                                                             const struct weft_weight *weight,
                                                             int32_t factor)
{
    const double counted = ldexp((double)weight->fixed, -WEFT_WEIGHT_BITS);
    if (a->type == WEFT_PLANE_HALF)
        add_general(sum, a, weight->fixed, WEFT_PLANE_HALF, factor);
    else if (a->type == WEFT_PLANE_UINT)
        add_general(sum, a, weight->fixed, WEFT_PLANE_UINT, factor);
    else if (!(a->largest * fabs(counted) < 0x1p20)) // for add_pairs' integers of 64 bits
        add_general(sum, a, weight->fixed, WEFT_PLANE_FLOAT, factor);
    else if ((double)(float)counted == counted)
        add_doubles(sum, a, counted, factor);
    else
        add_pairs(sum, a, weight->fixed, counted, factor);
}

static void add_wide(const struct weft_plane_sums *sums, const struct weft_sums_addend *a,
                     const struct weft_weight *weight)
{
    weft_wide *sum = (weft_wide *)sums->sum + a->at;
    if (a->type == WEFT_PLANE_UNORM8)
        add_general(sum, a, weight->fixed, WEFT_PLANE_UNORM8, 1);
    else if (a->type == WEFT_PLANE_UNORM16)
        add_general(sum, a, weight->fixed, WEFT_PLANE_UNORM16, 1);
    else if (sums->kind == WEFT_SUM_MIXED)
        add_values(sum, a, weight, WEFT_SUM_LARGEST_CODE);
    else
        add_values(sum, a, weight, 1);
}

void weft_sums_add(const struct weft_plane_sums *sums, const struct weft_sums_addend *addend,
                   const struct weft_weight *weight, enum weft_instruction_set instructions)
{
    if (is_wide(sums->kind))
        add_wide(sums, addend, weight);
    else
        add_narrow(sums, addend, weight->integer, instructions >= WEFT_INSTRUCTIONS_AVX2);
}
