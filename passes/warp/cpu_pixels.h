// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/cpu_pixels.h - pixels of kernels of up to LANES taps (not installed). Included by
// cpu_lines.h, with NUMBER, LANES and SIZED(x), x with what makes it one of its kind.

typedef NUMBER SIZED(vector) __attribute__((vector_size(LANES * sizeof(NUMBER))));
typedef float SIZED(floats) __attribute__((vector_size(LANES * sizeof(float))));

static inline SIZED(vector) SIZED(numbers)(const NUMBER *from)
{
    SIZED(vector) v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline SIZED(vector) SIZED(load)(const float *from)
{
    SIZED(floats) v;
    memcpy(&v, from, sizeof v);
    return __builtin_convertvector(v, SIZED(vector));
}

// Halves are added up until one lane is left.
static inline NUMBER SIZED(add_up)(SIZED(vector) v)
{
    NUMBER n[LANES];
    memcpy(n, &v, sizeof n);
#pragma GCC unroll 4
    for (int half = LANES / 2; half >= 1; half /= 2)
#pragma GCC unroll 8
        for (int i = 0; i < half; i++)
            n[i] += n[i + half];
    return n[0];
}

// The weights of all taps at a fraction, by Horner's rule.
static inline __attribute__((always_inline)) SIZED(vector)
    SIZED(weights)(const struct weft_warp_taps *taps, double fraction)
{
    const NUMBER *c = taps->coefficients;
    NUMBER u = (NUMBER)fraction;
    if (taps->segments > 1) {
        const double scaled = fraction * taps->segments;
        const int segment = scaled < taps->segments ? (int)scaled : taps->segments - 1;
        c += (size_t)segment * (size_t)(taps->degree + 1) * LANES;
        u = (NUMBER)(scaled - segment);
    }
    SIZED(vector) sum = SIZED(numbers)(c + taps->degree * LANES);
    for (int p = taps->degree - 1; p >= 0; p--)
        sum = sum * u + SIZED(numbers)(c + p * LANES);
    return sum;
}

static inline __attribute__((always_inline)) void SIZED(pixels)(const struct weft_warp_line *line,
                                                                int width)
{
    const int64_t pitch = line->size[0];
    for (int i = 0; i < line->count; i++) {
        const int32_t x = line->row->first[0][i], y = line->row->first[1][i];
        if (!weft_warp_is_inside(x, y, LANES, width, line->size))
            continue;
        const SIZED(vector) wx = SIZED(weights)(line->taps, line->row->fraction[0][i]);
        const SIZED(vector) wy = SIZED(weights)(line->taps, line->row->fraction[1][i]);
        NUMBER along[LANES];
        memcpy(along, &wy, sizeof along);
        for (int c = 0; c < line->channels; c++) {
            const float *row = line->values[c] + y * pitch + x;
            SIZED(vector) sum = SIZED(load)(row) * along[0];
#pragma GCC unroll 8
            for (int j = 1; j < width; j++)
                sum += SIZED(load)(row + j * pitch) * along[j];
            line->out[c][i] = (float)SIZED(add_up)(sum * wx);
        }
    }
}
