// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/squares.h"

#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

enum { LIMBS = 3, HALF_UNIT_BITS = 24, CODE_FACTOR = 257 };
enum { DROPPED_BITS = 2 * WEFT_SUM_UNIT_BITS - WEFT_SQUARE_UNIT_BITS };

// ---- one sum ------------------------------------------------------------------------------------

size_t weft_squares_size(enum weft_sum_kind kind)
{
    static const size_t sizes[WEFT_SUM_KIND_COUNT] = {
        [WEFT_SUM_UNORM8] = sizeof(uint64_t),       [WEFT_SUM_UNORM16] = sizeof(uint64_t),
        [WEFT_SUM_UINT] = sizeof(weft_uwide),       [WEFT_SUM_HALF] = sizeof(weft_uwide),
        [WEFT_SUM_WIDE] = LIMBS * sizeof(uint64_t), [WEFT_SUM_MIXED] = LIMBS * sizeof(uint64_t)};
    return sizes[kind];
}

double weft_squares_capacity(enum weft_sum_kind kind)
{
    if (kind < WEFT_SUM_WIDE) // their number is what limits them
        return INFINITY;
    return kind == WEFT_SUM_MIXED ? 0x1p54 : 0x1p86;
}

static struct weft_wide256 stored(const struct weft_plane_squares *squares, size_t i)
{
    const size_t size = weft_squares_size(squares->kind);
    struct weft_wide256 out = {{0}};
    if (size > 0)
        memcpy(out.limb, (const char *)squares->sum + i * size, size);
    return out;
}

static void store(const struct weft_plane_squares *squares, size_t i, struct weft_wide256 value)
{
    const size_t size = weft_squares_size(squares->kind);
    memcpy((char *)squares->sum + i * size, value.limb, size);
}

static struct weft_wide256 shifted_left(struct weft_wide256 a, int bits)
{
    for (; bits > 0; bits -= 32)
        a = weft_wide256_times(a, UINT64_C(1) << (bits < 32 ? bits : 32));
    return a;
}

// To nearest, halves up; what is left has three limbs.
static struct weft_wide256 shifted_right(struct weft_wide256 a, int bits)
{
    a = weft_wide256_sum(a, (struct weft_wide256){{UINT64_C(1) << (bits - 1)}});
    for (int i = 0; i < 4; i++)
        a.limb[i] = a.limb[i] >> bits | (i < 3 ? a.limb[i + 1] << (64 - bits) : 0);
    return a;
}

// A sum of squares of kind `from` as one of kind `to`.
static struct weft_wide256 raised(struct weft_wide256 value, enum weft_sum_kind from,
                                  enum weft_sum_kind to)
{
    uint64_t factor = 1;
    if (from == to)
        return value;
    if (from == WEFT_SUM_UNORM8)
        factor = CODE_FACTOR;
    else if (to == WEFT_SUM_MIXED && from != WEFT_SUM_UNORM16)
        factor = WEFT_SUM_LARGEST_CODE;
    value = weft_wide256_times(value, factor * factor);
    if (to < WEFT_SUM_WIDE || from >= WEFT_SUM_WIDE)
        return value;
    return shifted_left(value, from == WEFT_SUM_HALF ? WEFT_SQUARE_UNIT_BITS - 2 * HALF_UNIT_BITS
                                                     : WEFT_SQUARE_UNIT_BITS);
}

// ---- all of them --------------------------------------------------------------------------------

void weft_squares_join(const struct weft_plane_squares *squares,
                       const struct weft_plane_squares *other, size_t count)
{
    for (size_t i = 0; i < count && other->kind != WEFT_SUM_NONE; i++)
        store(squares, i,
              weft_wide256_sum(stored(squares, i),
                               raised(stored(other, i), other->kind, squares->kind)));
}

bool weft_squares_raise(struct weft_plane_squares *squares, enum weft_sum_kind kind, size_t count)
{
    if (kind == squares->kind)
        return true;
    struct weft_plane_squares raised = {kind, calloc(count, weft_squares_size(kind))};
    if (!raised.sum)
        return false;
    weft_squares_join(&raised, squares, count);
    weft_squares_clear(squares);
    *squares = raised;
    return true;
}

void weft_squares_clear(struct weft_plane_squares *squares)
{
    free(squares->sum);
    *squares = (struct weft_plane_squares){0};
}

static void fold_bytes(uint64_t *square, int32_t *sum, const int32_t *term, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        sum[i] += term[i];
        square[i] += (uint64_t)((int64_t)term[i] * term[i]);
    }
}

static void fold_words(uint64_t *square, int64_t *sum, const int64_t *term, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        sum[i] += term[i];
        square[i] += (uint64_t)(term[i] * term[i]);
    }
}

static void fold_integers(weft_uwide *square, int64_t *sum, const int64_t *term, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        sum[i] += term[i];
        square[i] += (weft_uwide)((weft_wide)term[i] * term[i]);
    }
}

static void increase(uint64_t *limb, weft_uwide low, uint64_t high)
{
    const weft_uwide added = (weft_uwide)limb[0] + (uint64_t)low;
    const weft_uwide carried = (weft_uwide)limb[1] + (uint64_t)(low >> 64) + (added >> 64);
    limb[0] = (uint64_t)added;
    limb[1] = (uint64_t)carried;
    limb[2] += high + (uint64_t)(carried >> 64);
}

// The square of high * 2^64 + low with high < 2^20, that is of values below 2^20, in units of
// 2^-104: of its three parts only that of low * low has bits below these.
static inline void add_square(uint64_t *limb, uint64_t high, uint64_t low)
{
    const weft_uwide half = (weft_uwide)1 << (DROPPED_BITS - 1);
    const weft_uwide lows = ((weft_uwide)low * low + half) >> DROPPED_BITS;
    const weft_uwide mixed = (weft_uwide)high * low << (65 - DROPPED_BITS);
    const weft_uwide highs = (weft_uwide)(high * high) << (128 - DROPPED_BITS);
    const uint64_t beyond = high * high >> DROPPED_BITS;
    weft_uwide sum;
    const bool carry = __builtin_add_overflow(lows + mixed, highs, &sum);
    increase(limb, sum, beyond + carry);
}

static void fold_wide(uint64_t *square, weft_wide *sum, const weft_wide *term, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const weft_uwide size = weft_wide_magnitude(term[i]);
        uint64_t *limb = &square[i * LIMBS];
        sum[i] += term[i];
        if (size >> 84 == 0) {
            add_square(limb, (uint64_t)(size >> 64), (uint64_t)size);
            continue;
        }
        const struct weft_wide256 added =
            shifted_right(weft_wide256_product(size, size), DROPPED_BITS);
        increase(limb, (weft_uwide)added.limb[1] << 64 | added.limb[0], added.limb[2]);
    }
}

void weft_squares_fold(const struct weft_plane_squares *squares, const struct weft_plane_sums *sums,
                       size_t at, const void *terms, size_t count)
{
    void *square = (char *)squares->sum + at * weft_squares_size(squares->kind);
    void *sum = (char *)sums->sum + at * weft_sums_size(sums->kind);
    switch (squares->kind) {
    case WEFT_SUM_UNORM8:
        fold_bytes(square, sum, terms, count);
        return;
    case WEFT_SUM_UNORM16:
        fold_words(square, sum, terms, count);
        return;
    case WEFT_SUM_UINT:
    case WEFT_SUM_HALF:
        fold_integers(square, sum, terms, count);
        return;
    default:
        fold_wide(square, sum, terms, count);
        return;
    }
}

// ---- results ------------------------------------------------------------------------------------

// What a unit of a kind is worth, as a double.
static double unit_of(enum weft_sum_kind kind)
{
    switch (kind) {
    case WEFT_SUM_UNORM8:
        return 1.0 / 255.0;
    case WEFT_SUM_UNORM16:
        return 1.0 / WEFT_SUM_LARGEST_CODE;
    case WEFT_SUM_HALF:
        return ldexp(1.0, -HALF_UNIT_BITS);
    case WEFT_SUM_WIDE:
        return ldexp(1.0, -WEFT_SUM_UNIT_BITS);
    case WEFT_SUM_MIXED:
        return ldexp(1.0 / WEFT_SUM_LARGEST_CODE, -WEFT_SUM_UNIT_BITS);
    default:
        return 1.0;
    }
}

double weft_squares_spread(const struct weft_plane_squares *squares,
                           const struct weft_plane_sums *sums, size_t i, uint64_t n)
{
    const weft_uwide sum = weft_wide_magnitude(weft_sums_get(sums, i, sums->kind));
    const double unit = unit_of(squares->kind);
    struct weft_wide256 square = weft_wide256_times(stored(squares, i), n);
    if (squares->kind >= WEFT_SUM_WIDE)
        square = shifted_left(square, DROPPED_BITS);
    return weft_wide256_to_double(weft_wide256_excess(square, weft_wide256_product(sum, sum))) *
           unit * unit;
}
