// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/lines/lines_body.h - lines of pixels in one precision: included twice by the file of
// a set of instructions, which defines
//   REAL, REAL_IS_FLOAT  float or double
//   WIDE                 pixels whose weights are made at once: lanes of a vector of REALs
//   NARROW, MIDDLE, BROAD  lanes of vectors along a row, of up to 4, 8 and 16 taps
//   FMA(lanes, a, b, c)  a * b + c
// and undefines them after. (Not installed.)
// GCC's and clang's vectors: https://gcc.gnu.org/onlinedocs/gcc/Vector-Extensions.html
#define JOIN_(a, b) a##_##b
#define JOIN(a, b) JOIN_(a, b)
#define NAME(name) JOIN(name, REAL)
#define INLINE static inline __attribute__((always_inline))

#ifndef WEFT_PASSES_FUSED_LINES_LINES_BODY_H
#define WEFT_PASSES_FUSED_LINES_LINES_BODY_H

#include <math.h>
#include <string.h>
#if defined(__SSE2__)
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

// Of CHUNK pixels. Weights along rows are [pixel][stride], those along the other axes
// [group of WIDE pixels][tap][pixel].
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
INLINE void NAME(across)(const struct weft_line_kernel *kernel, int width, int degree, NAME(wide) t,
                         REAL *out)
{
    const REAL *c = kernel->coefficients;
    const int stride = kernel->stride;
    for (int i = 0; i < width; i++) {
        NAME(wide) sum = NAME(splat)(c[degree * stride + i]);
        for (int p = degree - 1; p >= 0; p--)
            sum = FMA(WIDE, sum, t, NAME(splat)(c[p * stride + i]));
        memcpy(out + i * WIDE, &sum, sizeof sum);
    }
}

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

// Weights of one pixel along an axis, in vectors along the taps: out[stride].
INLINE void NAME(along)(const struct weft_line_kernel *kernel, int stride, int degree, int segment,
                        REAL t, REAL *out)
{
    typedef JOIN(NAME(row), NARROW) row;
    const REAL *c = (const REAL *)kernel->coefficients +
                    (size_t)segment * (size_t)(degree + 1) * (size_t)stride;
    for (int i = 0; i < stride; i += NARROW) {
        row sum, power;
        memcpy(&sum, c + degree * stride + i, sizeof sum);
        for (int p = degree - 1; p >= 0; p--) {
            memcpy(&power, c + p * stride + i, sizeof power);
            sum = FMA(NARROW, sum, t - (row){0}, power);
        }
        memcpy(out + i, &sum, sizeof sum);
    }
}

// The same of WIDE pixels along all axes where segments differ from pixel to pixel.
static void NAME(by_segment)(const struct weft_line_kernel *kernel, const NAME(wide) t[3], REAL *x,
                             REAL *y, REAL *z)
{
    for (int a = 0; a < 3; a++) {
        const NAME(wide) scaled = t[a] * NAME(splat)((REAL)kernel->segments);
        for (int i = 0; i < WIDE; i++) {
            REAL own[MOST] = {0}, *out = a ? own : x + i * kernel->stride;
            int segment = (int)scaled[i];
            if (segment > kernel->segments - 1)
                segment = kernel->segments - 1;
            NAME(along)
            (kernel, kernel->stride, kernel->degree, segment, scaled[i] - (REAL)segment, out);
            for (int k = 0; a && k < kernel->width; k++)
                (a == 1 ? y : z)[k * WIDE + i] = own[k];
        }
    }
}

// Places and weights of `count` pixels of a line, and of those past it that fill a vector.
INLINE void NAME(weigh)(const struct weft_line *line, int from, int count, int width, int degree,
                        int stride, bool whole, struct NAME(weights) * out)
{
    const struct weft_line_kernel *kernel = line->kernel;
    NAME(words) number, position[3], low[3];
    for (int i = 0; i < WIDE; i++)
        number[i] = (uint32_t)(from + i);
    for (int a = 0; a < 3; a++) {
        position[a] = number * line->step[a] + line->position[a];
        low[a] = number * line->low_step[a] + line->low[a];
    }
    for (int i = 0; i < count; i += WIDE) {
        NAME(wide) t[3];
        NAME(words) at = {0};
        REAL *x = out->x + i * stride, *y = out->y + i * width, *z = out->z + i * width;
        const uint32_t pitch[3] = {1, kernel->pitch_y, kernel->summed ? 0 : kernel->pitch_z};
        for (int a = 0; a < 3; a++) {
            const NAME(words) word = position[a] + (low[a] >> (uint32_t)line->low_bits);
            position[a] += (uint32_t)WIDE * line->step[a];
            low[a] += (uint32_t)WIDE * line->low_step[a];
            at += (word >> WEFT_LINE_FRACTION) * pitch[a];
            t[a] = NAME(fraction)(word);
        }
        memcpy(out->at + i, &at, sizeof at);
        if (!whole) {
            NAME(by_segment)(kernel, t, x, y, z);
            continue;
        }
        NAME(across)(kernel, width, degree, t[1], y);
        NAME(across)(kernel, width, degree, t[2], z);
        for (int p = 0; p < WIDE; p++)
            NAME(along)(kernel, stride, degree, 0, t[0][p], x + p * stride);
    }
}

// Piecewise cubics of four taps are the common case.
static void NAME(weigh_any)(const struct weft_line *line, int from, int count,
                            struct NAME(weights) * out)
{
    const struct weft_line_kernel *kernel = line->kernel;
    if (kernel->segments > 1)
        NAME(weigh)(line, from, count, kernel->width, kernel->degree, kernel->stride, false, out);
    else if (kernel->width == 4 && kernel->degree == 3)
        NAME(weigh)(line, from, count, 4, 3, 4, true, out);
    else
        NAME(weigh)(line, from, count, kernel->width, kernel->degree, kernel->stride, true, out);
}

// ---- lines --------------------------------------------------------------------------------------

#define LINE(name, width, lanes, stride, summed, pitch_y, pitch_z)                                 \
    static void NAME(name)(const struct weft_line *line)                                           \
    {                                                                                              \
        JOIN(NAME(line), lanes)(line, width, stride, summed, pitch_y, pitch_z);                    \
    }
// Blocks of a kernel's own: 8 cells and the taps past the last one.
#define FIXED(name, width, lanes, stride)                                                          \
    LINE(name##_flat, width, lanes, stride, true, width + 7, 0)                                    \
    LINE(name, width, lanes, stride, false, width + 7, (width + 7) * (width + 7))
// Of any width and pitch.
#define ANY(name, lanes, stride)                                                                   \
    LINE(name##_flat, line->kernel->width, lanes, stride, true, line->kernel->pitch_y, 0)          \
    LINE(name, line->kernel->width, lanes, stride, false, line->kernel->pitch_y,                   \
         line->kernel->pitch_z)

FIXED(two, 2, NARROW, 4)
FIXED(four, 4, NARROW, 4)
FIXED(six, 6, MIDDLE, 8)
FIXED(eight, 8, MIDDLE, 8)
ANY(up_to_four, NARROW, 4)
ANY(up_to_eight, MIDDLE, 8)
ANY(up_to_sixteen, BROAD, 16)

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
#undef JOIN_
#undef JOIN
#undef NAME
#undef INLINE
