// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/lines/lines_body.h - lines of pixels in one precision: included twice by the file of
// a set of instructions, which defines
//   REAL, REAL_IS_FLOAT  float or double
//   WIDE                 pixels whose weights are made at once: lanes of a vector of REALs
//   NARROW, MIDDLE, BROAD  lanes of vectors along a row, of up to 4, 8 and 16 taps
//   FMA(lanes, a, b, c)  a * b + c
// and which are undefined at its end. (Not installed.)
// GCC's and clang's vectors: https://gcc.gnu.org/onlinedocs/gcc/Vector-Extensions.html
#define JOIN_(a, b) a##_##b
#define JOIN(a, b) JOIN_(a, b)
#define NAME(name) JOIN(name, REAL)
#define INLINE static inline __attribute__((always_inline))

#ifndef WEFT_PASSES_FUSED_LINES_LINES_BODY_H
#define WEFT_PASSES_FUSED_LINES_LINES_BODY_H

#include <math.h>
#include <string.h>
#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "passes/fused/lines/lines.h"

// Pixels whose weights are kept at once: they stay in the first cache.
enum { CHUNK = 64, MOST = WEFT_KERNEL_MAX_WIDTH };

// Pairs of orders along the second and third axis that derivatives of up to 1 and up to 2 in all
// have: 00, then 10 01, then 20 11 02. With those along the first axis they are sums, of which the
// ones that begin with each pair stand here.
enum { PAIRS = 6, SUMS = 10 };
static const int first_sum[PAIRS] = {0, 3, 5, 7, 8, 9};

// Which of these an output is.
static int sum_of(const struct weft_derivative *output)
{
    const int y = output->along[1], z = output->along[2], both = y + z;
    return first_sum[both * (both + 1) / 2 + z] + output->along[0];
}

// The highest order of a kernel's outputs, 1 at least.
static int order_of(const struct weft_line_kernel *kernel)
{
    int most = 1;
    for (int o = 0; o < kernel->output_count; o++) {
        const int *along = kernel->output[o].along;
        if (along[0] + along[1] + along[2] > 1)
            most = 2;
    }
    return most;
}

// The least and greatest of the samples next to a pixel: sums within them stay.
static void clamp_pixels(const struct weft_line *line, int from, int count, const uint32_t *at,
                         float *values)
{
    const struct weft_line_kernel *kernel = line->kernel;
    for (int i = 0; i < count; i++) {
        const float *first = line->start[from + i] + at[i];
        float least = INFINITY, most = -INFINITY;
        for (int z = kernel->clamp_from; z <= kernel->clamp_to; z++) {
            for (int y = kernel->clamp_from; y <= kernel->clamp_to; y++) {
                const float *row =
                    first + (size_t)z * kernel->pitch_z + (size_t)y * kernel->pitch_y;
                for (int x = kernel->clamp_from; x <= kernel->clamp_to; x++) {
                    least = row[x] < least ? row[x] : least;
                    most = row[x] > most ? row[x] : most;
                }
            }
        }
        values[i] = values[i] < least ? least : values[i] > most ? most : values[i];
    }
}

#endif

typedef REAL NAME(wide) __attribute__((vector_size(WIDE * sizeof(REAL))));
typedef uint32_t NAME(words) __attribute__((vector_size(WIDE * sizeof(uint32_t))));
typedef int32_t NAME(integers) __attribute__((vector_size(WIDE * sizeof(int32_t))));

// Pixels that are added up together.
#if WIDE < 4
#define GROUP 2
#else
#define GROUP 4
#endif
typedef REAL NAME(group) __attribute__((vector_size(GROUP * sizeof(REAL))));

// Of CHUNK pixels: weights of one order along each axis, [vector of WIDE pixels][tap][pixel].
struct NAME(weights) {
    _Alignas(64) REAL x[CHUNK * MOST];
    REAL y[CHUNK * MOST], z[CHUNK * MOST];
    uint32_t at[CHUNK]; // the first tap's sample, past `start`; those of order 0 have it
};

INLINE NAME(wide) NAME(splat)(REAL value)
{
    return value - (NAME(wide)){0};
}

// Fractions of WIDE pixels, as the shader has them: rounded to 24 bits for sums in single
// precision.
INLINE NAME(wide) NAME(fraction)(NAME(words) position)
{
#if REAL_IS_FLOAT
    const NAME(words) bits = (((position >> 4) & 0x1ffffffu) + 1u) >> 1;
    return __builtin_convertvector((NAME(integers))bits, NAME(wide)) * 0x1p-24f;
#else
    const NAME(words) bits = position & 0x1fffffffu;
    return __builtin_convertvector((NAME(integers))bits, NAME(wide)) * 0x1p-29;
#endif
}

// Weights of WIDE pixels along an axis, by Horner's rule: out[tap * WIDE].
INLINE void NAME(across)(const REAL *coefficients, int width, int degree, NAME(wide) t, REAL *out)
{
    const int power = width * WEFT_LINE_COPIES;
    for (int i = 0; i < width; i++) {
        const REAL *c = coefficients + i * WEFT_LINE_COPIES;
        NAME(wide) sum, next;
        memcpy(&sum, c + degree * power, sizeof sum);
        for (int p = degree - 1; p >= 0; p--) {
            memcpy(&next, c + p * power, sizeof next);
            sum = FMA(WIDE, sum, t, next);
        }
        memcpy(out + i * WIDE, &sum, sizeof sum);
    }
}

// Rows become columns.
INLINE void NAME(turn)(NAME(group) v[GROUP])
{
#define PICK __builtin_shufflevector
#if WIDE == 2
    const NAME(group) a = PICK(v[0], v[1], 0, 2), b = PICK(v[0], v[1], 1, 3);
    v[0] = a;
    v[1] = b;
#elif REAL_IS_FLOAT
    const NAME(group) a = PICK(v[0], v[1], 0, 4, 1, 5), b = PICK(v[0], v[1], 2, 6, 3, 7);
    const NAME(group) c = PICK(v[2], v[3], 0, 4, 1, 5), d = PICK(v[2], v[3], 2, 6, 3, 7);
    v[0] = PICK(a, c, 0, 1, 4, 5);
    v[1] = PICK(a, c, 2, 3, 6, 7);
    v[2] = PICK(b, d, 0, 1, 4, 5);
    v[3] = PICK(b, d, 2, 3, 6, 7);
#else // within the halves of a vector of doubles first
    const NAME(group) a = PICK(v[0], v[1], 0, 4, 2, 6), b = PICK(v[0], v[1], 1, 5, 3, 7);
    const NAME(group) c = PICK(v[2], v[3], 0, 4, 2, 6), d = PICK(v[2], v[3], 1, 5, 3, 7);
    v[0] = PICK(a, c, 0, 1, 4, 5);
    v[1] = PICK(b, d, 0, 1, 4, 5);
    v[2] = PICK(a, c, 2, 3, 6, 7);
    v[3] = PICK(b, d, 2, 3, 6, 7);
#endif
#undef PICK
}

INLINE void NAME(put)(NAME(group) sums, float *out)
{
#if REAL_IS_FLOAT
    memcpy(out, &sums, sizeof sums);
#else
    for (int i = 0; i < GROUP; i++)
        out[i] = (float)sums[i];
#endif
}

static void NAME(weigh_any)(const struct weft_line *line, int from, int count,
                            struct NAME(weights) * out);
static void NAME(weigh_orders)(const struct weft_line *line, int from, int count, int most,
                               struct NAME(weights) * out);

#define LANES NARROW
#include "passes/fused/lines/lines_rows.h"
#undef LANES
#if MIDDLE != NARROW
#define LANES MIDDLE
#include "passes/fused/lines/lines_rows.h"
#undef LANES
#endif
#if BROAD != MIDDLE
#define LANES BROAD
#include "passes/fused/lines/lines_rows.h"
#undef LANES
#endif

// Weights of one pixel along an axis, in vectors along the taps: out[weights->stride].
INLINE void NAME(along)(const struct weft_line_weights *weights, int width, int segment, REAL t,
                        REAL *out)
{
    typedef JOIN(NAME(row), NARROW) row;
    const int stride = weights->stride, degree = weights->degree;
    const REAL *c = (const REAL *)weights->coefficients +
                    (size_t)segment * (size_t)(degree + 1) * (size_t)stride;
    for (int i = 0; i < width; i += NARROW) {
        row sum, power;
        memcpy(&sum, c + degree * stride + i, sizeof sum);
        for (int p = degree - 1; p >= 0; p--) {
            memcpy(&power, c + p * stride + i, sizeof power);
            sum = FMA(NARROW, sum, t - (row){0}, power);
        }
        memcpy(out + i, &sum, sizeof sum);
    }
}

// The same of WIDE pixels where segments differ from pixel to pixel: out[tap * WIDE].
static void NAME(by_segment)(const struct weft_line_weights *weights, int width, NAME(wide) t,
                             REAL *out)
{
    const NAME(wide) scaled = t * NAME(splat)((REAL)weights->segments);
    for (int i = 0; i < WIDE; i++) {
        REAL own[MOST] = {0};
        int segment = (int)scaled[i];
        if (segment > weights->segments - 1)
            segment = weights->segments - 1;
        NAME(along)(weights, width, segment, scaled[i] - (REAL)segment, own);
        for (int k = 0; k < width; k++)
            out[k * WIDE + i] = own[k];
    }
}

// Weights of an order at WIDE pixels along an axis: out[tap * WIDE].
INLINE void NAME(set_weights)(const struct weft_line_weights *weights, int width, int degree,
                              bool whole, NAME(wide) t, REAL *out)
{
    if (whole)
        NAME(across)(weights->coefficients, width, degree, t, out);
    else
        NAME(by_segment)(weights, width, t, out);
}

// Words of positions of WIDE pixels, and what leads to those of the next ones.
struct NAME(steps) {
    NAME(words) position[3], low[3], step[3], low_step[3];
};

INLINE void NAME(begin)(const struct weft_line *line, int from, struct NAME(steps) * out)
{
    NAME(words) number;
    for (int i = 0; i < WIDE; i++)
        number[i] = (uint32_t)(from + i);
    for (int a = 0; a < 3; a++) {
        out->position[a] = number * line->step[a] + line->position[a];
        out->low[a] = number * line->low_step[a] + line->low[a];
        out->step[a] = (NAME(words)){0} + WIDE * line->step[a];
        out->low_step[a] = (NAME(words)){0} + WIDE * line->low_step[a];
    }
}

INLINE NAME(words) NAME(next)(struct NAME(steps) * steps, int a, uint32_t low_bits)
{
    const NAME(words) word = steps->position[a] + (steps->low[a] >> low_bits);
    steps->position[a] += steps->step[a];
    steps->low[a] += steps->low_step[a];
    return word;
}

// Places of `count` pixels of a line and weights of orders 0 to `most`, and of those past it that
// fill a vector. Order 0 is of this degree, or `whole` is false; others are of what they are.
INLINE void NAME(weigh)(const struct weft_line *line, int from, int count, int width, int degree,
                        bool whole, int most, bool listed, struct NAME(weights) * out)
{
    const struct weft_line_kernel *kernel = line->kernel;
    const uint32_t pitch[3] = {1, kernel->pitch_y, kernel->summed ? 0 : kernel->pitch_z};
    const uint32_t low_bits = (uint32_t)line->low_bits;
    struct NAME(steps) steps;
    if (!listed)
        NAME(begin)(line, from, &steps);
    for (int i = 0; i < count; i += WIDE) {
        NAME(words) at = {0};
        for (int a = 0; a < 3; a++) {
            NAME(words) word;
            if (listed)
                memcpy(&word, line->listed[a] + from + i, sizeof word);
            else
                word = NAME(next)(&steps, a, low_bits);
            at += (word >> WEFT_LINE_FRACTION) * pitch[a];
            const NAME(wide) t = NAME(fraction)(word);
            for (int n = 0; n <= most; n++) {
                const struct weft_line_weights *weights = &kernel->weights[n];
                REAL *own = a == 0 ? out[n].x : a == 1 ? out[n].y : out[n].z;
                NAME(set_weights)
                (weights, width, n ? weights->degree : degree, n ? weights->segments == 1 : whole,
                 t, own + i * width);
            }
        }
        memcpy(out->at + i, &at, sizeof at);
    }
}

// Piecewise cubics of four taps are the common case.
static void NAME(weigh_any)(const struct weft_line *line, int from, int count,
                            struct NAME(weights) * out)
{
    const int width = line->kernel->width;
    const struct weft_line_weights *w = &line->kernel->weights[0];
    if (line->listed[0])
        NAME(weigh)(line, from, count, width, w->degree, w->segments == 1, 0, true, out);
    else if (w->segments > 1)
        NAME(weigh)(line, from, count, width, w->degree, false, 0, false, out);
    else if (width == 4 && w->degree == 3)
        NAME(weigh)(line, from, count, 4, 3, true, 0, false, out);
    else
        NAME(weigh)(line, from, count, width, w->degree, true, 0, false, out);
}

// The same of orders up to `most`: out[order].
static void NAME(weigh_orders)(const struct weft_line *line, int from, int count, int most,
                               struct NAME(weights) * out)
{
    const int width = line->kernel->width;
    const struct weft_line_weights *w = &line->kernel->weights[0];
    const bool whole = w->segments == 1;
    if (line->listed[0] && width == 4)
        NAME(weigh)(line, from, count, 4, w->degree, whole, most, true, out);
    else if (line->listed[0])
        NAME(weigh)(line, from, count, width, w->degree, whole, most, true, out);
    else if (width == 4)
        NAME(weigh)(line, from, count, 4, w->degree, whole, most, false, out);
    else
        NAME(weigh)(line, from, count, width, w->degree, whole, most, false, out);
}

// ---- lines --------------------------------------------------------------------------------------

#define LINE(name, width, lanes, summed, pitch_y, pitch_z)                                         \
    static void NAME(name)(const struct weft_line *line)                                           \
    {                                                                                              \
        JOIN(NAME(line), lanes)(line, width, summed, pitch_y, pitch_z);                            \
    }
// Blocks of a kernel's own: 8 cells and the taps past the last one.
#define FIXED(name, width, lanes)                                                                  \
    LINE(name##_flat, width, lanes, true, width + 7, 0)                                            \
    LINE(name, width, lanes, false, width + 7, (width + 7) * (width + 7))
// Of any width and pitch.
#define ANY(name, lanes)                                                                           \
    LINE(name##_flat, line->kernel->width, lanes, true, line->kernel->pitch_y, 0)                  \
    LINE(name, line->kernel->width, lanes, false, line->kernel->pitch_y, line->kernel->pitch_z)

FIXED(two, 2, NARROW)
FIXED(four, 4, NARROW)
FIXED(six, 6, MIDDLE)
FIXED(eight, 8, MIDDLE)
ANY(up_to_four, NARROW)
ANY(up_to_eight, MIDDLE)
ANY(up_to_sixteen, BROAD)

// Of several outputs.
#define ORDERS(name, width, lanes, most, pitch_y, pitch_z)                                         \
    static void NAME(name)(const struct weft_line *line)                                           \
    {                                                                                              \
        JOIN(NAME(line_orders), lanes)(line, width, most, pitch_y, pitch_z);                       \
    }
#define BOTH(name, width, lanes, pitch_y, pitch_z)                                                 \
    ORDERS(name##_gradient, width, lanes, 1, pitch_y, pitch_z)                                     \
    ORDERS(name##_hessian, width, lanes, 2, pitch_y, pitch_z)
#define ANY_ORDERS(name, lanes)                                                                    \
    BOTH(name, line->kernel->width, lanes, line->kernel->pitch_y, line->kernel->pitch_z)

BOTH(four, 4, NARROW, 11, 121)
ANY_ORDERS(up_to_four, NARROW)
ANY_ORDERS(up_to_eight, MIDDLE)
ANY_ORDERS(up_to_sixteen, BROAD)

static weft_line_fn NAME(find_orders)(const struct weft_line_kernel *k)
{
    const bool first = order_of(k) == 1;
    if (k->width == 4 && k->pitch_y == 11 && k->pitch_z == 121)
        return first ? NAME(four_gradient) : NAME(four_hessian);
    if (k->width <= 4)
        return first ? NAME(up_to_four_gradient) : NAME(up_to_four_hessian);
    if (k->width <= 8)
        return first ? NAME(up_to_eight_gradient) : NAME(up_to_eight_hessian);
    return first ? NAME(up_to_sixteen_gradient) : NAME(up_to_sixteen_hessian);
}

static weft_line_fn NAME(find)(const struct weft_line_kernel *k)
{
    const uint32_t own = (uint32_t)k->width + 7;
    if (k->output_count)
        return NAME(find_orders)(k);
    if (k->pitch_y == own && (k->summed || k->pitch_z == own * own)) {
        switch (k->width) {
        case 2:
            return k->summed ? NAME(two_flat) : NAME(two);
        case 4:
            return k->summed ? NAME(four_flat) : NAME(four);
        case 6:
            return k->summed ? NAME(six_flat) : NAME(six);
        case 8:
            return k->summed ? NAME(eight_flat) : NAME(eight);
        }
    }
    if (k->width <= 4)
        return k->summed ? NAME(up_to_four_flat) : NAME(up_to_four);
    if (k->width <= 8)
        return k->summed ? NAME(up_to_eight_flat) : NAME(up_to_eight);
    return k->summed ? NAME(up_to_sixteen_flat) : NAME(up_to_sixteen);
}

#undef LINE
#undef FIXED
#undef ANY
#undef ORDERS
#undef BOTH
#undef ANY_ORDERS
#undef GROUP
#undef JOIN_
#undef JOIN
#undef NAME
#undef INLINE
#undef REAL
#undef REAL_IS_FLOAT
#undef WIDE
#undef NARROW
#undef MIDDLE
#undef BROAD
#undef FMA
