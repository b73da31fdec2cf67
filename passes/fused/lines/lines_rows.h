// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/lines/lines_rows.h - pixels' sums in vectors of LANES samples along the rows of
// their blocks: a part of lines_body.h, once for every LANES. (Not installed.)
#define ROW(name) JOIN(NAME(name), LANES)

typedef REAL ROW(row) __attribute__((vector_size(LANES * sizeof(REAL))));
typedef float ROW(samples) __attribute__((vector_size(LANES * sizeof(float))));

INLINE ROW(row) ROW(load)(const float *from)
{
    ROW(samples) samples;
    memcpy(&samples, from, sizeof samples);
#if REAL_IS_FLOAT
    return samples;
#elif LANES == 2 && defined(__SSE2__) // which GCC does one by one
    return _mm_cvtps_pd(__builtin_shufflevector(samples, samples, 0, 1, 0, 1));
#else
    return __builtin_convertvector(samples, ROW(row));
#endif
}

INLINE ROW(row) ROW(splat)(REAL value)
{
    return value - (ROW(row)){0};
}

// One pixel's sum, in lanes.
INLINE ROW(row) ROW(pixel)(const float *first, const REAL *x, const REAL *y, const REAL *z,
                           int width, int stride, bool summed, size_t pitch_y, size_t pitch_z)
{
    ROW(row) sum = {0};
    // One register for the address: taps are then constants away from it.
    __asm__("" : "+r"(first));
    for (int c = 0; c < stride; c += LANES) {
        ROW(row) plane = {0}, weight;
        for (int j = 0; j < width; j++) {
            const float *at = first + (size_t)j * pitch_y + c;
            ROW(row) row = ROW(load)(at);
            if (!summed) {
                row *= ROW(splat)(z[0]);
                for (int k = 1; k < width; k++)
                    row = FMA(LANES, ROW(load)(at + (size_t)k * pitch_z), ROW(splat)(z[k * WIDE]),
                              row);
            }
            if (j)
                plane = FMA(LANES, row, ROW(splat)(y[j * WIDE]), plane);
            else
                plane = row * ROW(splat)(y[0]);
        }
        memcpy(&weight, x + c, sizeof weight);
        if (c)
            sum = FMA(LANES, plane, weight, sum);
        else
            sum = plane * weight;
    }
    return sum;
}

// The sums of the lanes of four pixels.
INLINE void ROW(add_up)(const ROW(row) s[4], float *out)
{
#define PICK __builtin_shufflevector
#if LANES == 2
    const ROW(row) a = PICK(s[0], s[1], 0, 2) + PICK(s[0], s[1], 1, 3);
    const ROW(row) b = PICK(s[2], s[3], 0, 2) + PICK(s[2], s[3], 1, 3);
    for (int i = 0; i < 2; i++) {
        out[i] = (float)a[i];
        out[i + 2] = (float)b[i];
    }
#else
    typedef REAL four __attribute__((vector_size(4 * sizeof(REAL))));
    typedef float floats __attribute__((vector_size(4 * sizeof(float))));
    four q[4];
    for (int i = 0; i < 4; i++) {
#if LANES == 4
        q[i] = s[i];
#elif LANES == 8
        q[i] = PICK(s[i], s[i], 0, 1, 2, 3) + PICK(s[i], s[i], 4, 5, 6, 7);
#else
        typedef REAL eight __attribute__((vector_size(8 * sizeof(REAL))));
        const eight half = PICK(s[i], s[i], 0, 1, 2, 3, 4, 5, 6, 7) +
                           PICK(s[i], s[i], 8, 9, 10, 11, 12, 13, 14, 15);
        q[i] = PICK(half, half, 0, 1, 2, 3) + PICK(half, half, 4, 5, 6, 7);
#endif
    }
    // Lanes 0 and 2, 1 and 3 of single precision, 0 and 1, 2 and 3 of double: cheap to pair.
#if REAL_IS_FLOAT
    const four a = PICK(q[0], q[1], 0, 4, 1, 5) + PICK(q[0], q[1], 2, 6, 3, 7);
    const four b = PICK(q[2], q[3], 0, 4, 1, 5) + PICK(q[2], q[3], 2, 6, 3, 7);
#else
    const four a = PICK(q[0], q[1], 0, 4, 2, 6) + PICK(q[0], q[1], 1, 5, 3, 7);
    const four b = PICK(q[2], q[3], 0, 4, 2, 6) + PICK(q[2], q[3], 1, 5, 3, 7);
#endif
    const four sums = PICK(a, b, 0, 1, 4, 5) + PICK(a, b, 2, 3, 6, 7);
    const floats rounded = __builtin_convertvector(sums, floats);
    memcpy(out, &rounded, sizeof rounded);
#endif
#undef PICK
}

static void NAME(weigh_any)(const struct weft_line *line, int from, int count,
                            struct NAME(weights) * out);

INLINE void ROW(line)(const struct weft_line *line, int width, int stride, bool summed,
                      size_t pitch_y, size_t pitch_z)
{
    struct NAME(weights) w;
    float values[CHUNK];
    for (int from = 0; from < line->count; from += CHUNK) {
        const int count = line->count - from < CHUNK ? line->count - from : CHUNK;
        NAME(weigh_any)(line, from, (count + 3) & ~3, &w); // pixels are added up in fours
        for (int i = 0; i < count; i += 4) {
            ROW(row) sum[4];
            for (int p = 0; p < 4; p++) {
                const int group = (i + p) / WIDE * WIDE * width + (i + p) % WIDE;
                sum[p] =
                    ROW(pixel)(line->start[from + i + p] + w.at[i + p], w.x + (i + p) * stride,
                               w.y + group, w.z + group, width, stride, summed, pitch_y, pitch_z);
            }
            ROW(add_up)(sum, values + i);
        }
        if (line->kernel->clamp_to)
            clamp_pixels(line, from, count, w.at, values);
        memcpy(line->out + from, values, (size_t)count * sizeof *values);
    }
}

#undef ROW
