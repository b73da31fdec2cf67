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

// Of CHUNK pixels: weights along each axis, [vector of WIDE pixels][tap][pixel].
struct NAME(weights) {
    _Alignas(64) REAL x[CHUNK * MOST];
    REAL y[CHUNK * MOST], z[CHUNK * MOST];
    uint32_t at[CHUNK]; // the first tap's sample, past `start`
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

// Weights of one pixel along an axis, in vectors along the taps: out[kernel->stride].
INLINE void NAME(along)(const struct weft_line_kernel *kernel, int segment, REAL t, REAL *out)
{
    typedef JOIN(NAME(row), NARROW) row;
    const int stride = kernel->stride, degree = kernel->degree;
    const REAL *c = (const REAL *)kernel->coefficients +
                    (size_t)segment * (size_t)(degree + 1) * (size_t)stride;
    for (int i = 0; i < kernel->width; i += NARROW) {
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
static void NAME(by_segment)(const struct weft_line_kernel *kernel, NAME(wide) t, REAL *out)
{
    const NAME(wide) scaled = t * NAME(splat)((REAL)kernel->segments);
    for (int i = 0; i < WIDE; i++) {
        REAL own[MOST] = {0};
        int segment = (int)scaled[i];
        if (segment > kernel->segments - 1)
            segment = kernel->segments - 1;
        NAME(along)(kernel, segment, scaled[i] - (REAL)segment, own);
        for (int k = 0; k < kernel->width; k++)
            out[k * WIDE + i] = own[k];
    }
}

// Places and weights of `count` pixels of a line, and of those past it that fill a vector.
INLINE void NAME(weigh)(const struct weft_line *line, int from, int count, int width, int degree,
                        bool whole, struct NAME(weights) * out)
{
    const struct weft_line_kernel *kernel = line->kernel;
    NAME(words) number, position[3], low[3];
    NAME(words) step[3], low_step[3];
    REAL *const weights[3] = {out->x, out->y, out->z};
    const REAL *const coefficients = kernel->coefficients;
    const uint32_t pitch[3] = {1, kernel->pitch_y, kernel->summed ? 0 : kernel->pitch_z};
    const uint32_t low_bits = (uint32_t)line->low_bits;
    for (int i = 0; i < WIDE; i++)
        number[i] = (uint32_t)(from + i);
    for (int a = 0; a < 3; a++) {
        position[a] = number * line->step[a] + line->position[a];
        low[a] = number * line->low_step[a] + line->low[a];
        step[a] = (NAME(words)){0} + WIDE * line->step[a];
        low_step[a] = (NAME(words)){0} + WIDE * line->low_step[a];
    }
    for (int i = 0; i < count; i += WIDE) {
        NAME(words) at = {0};
        for (int a = 0; a < 3; a++) {
            const NAME(words) word = position[a] + (low[a] >> low_bits);
            position[a] += step[a];
            low[a] += low_step[a];
            at += (word >> WEFT_LINE_FRACTION) * pitch[a];
            if (whole)
                NAME(across)
            (coefficients, width, degree, NAME(fraction)(word), weights[a] + i * width);
            else NAME(by_segment)(kernel, NAME(fraction)(word), weights[a] + i * width);
        }
        memcpy(out->at + i, &at, sizeof at);
    }
}

// Piecewise cubics of four taps are the common case.
static void NAME(weigh_any)(const struct weft_line *line, int from, int count,
                            struct NAME(weights) * out)
{
    const struct weft_line_kernel *kernel = line->kernel;
    if (kernel->segments > 1)
        NAME(weigh)(line, from, count, kernel->width, kernel->degree, false, out);
    else if (kernel->width == 4 && kernel->degree == 3)
        NAME(weigh)(line, from, count, 4, 3, true, out);
    else
        NAME(weigh)(line, from, count, kernel->width, kernel->degree, true, out);
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

static weft_line_fn NAME(find)(const struct weft_line_kernel *k)
{
    const uint32_t own = (uint32_t)k->width + 7;
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
