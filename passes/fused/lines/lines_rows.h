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

// One pixel's sums over the taps along the second and third axis, for the LANES taps along a row
// from `first` on.
INLINE ROW(row) ROW(pixel)(const float *first, const REAL *y, const REAL *z, int width, bool summed,
                           size_t pitch_y, size_t pitch_z)
{
    ROW(row) sum = {0};
    // One register for the address: taps are then constants away from it.
    __asm__("" : "+r"(first));
    for (int j = 0; j < width; j++) {
        const float *at = first + (size_t)j * pitch_y;
        ROW(row) row = ROW(load)(at);
        if (!summed) {
            row *= ROW(splat)(z[0]);
            for (int k = 1; k < width; k++)
                row = FMA(LANES, ROW(load)(at + (size_t)k * pitch_z), ROW(splat)(z[k * WIDE]), row);
        }
        if (j)
            sum = FMA(LANES, row, ROW(splat)(y[j * WIDE]), sum);
        else
            sum = row * ROW(splat)(y[0]);
    }
    return sum;
}

// Of two neighbours whose taps are the same samples each is loaded once, to both halves of a
// vector: slices that are magnified have mostly such. The operations are those of one pixel.
#if LANES == 4 && REAL_IS_FLOAT && defined(__AVX2__)
typedef float NAME(both) __attribute__((vector_size(32)));

INLINE NAME(both) NAME(twice)(const float *from)
{
    return _mm256_broadcast_ps((const __m128 *)from);
}

// The weights of both pixels, each in four lanes.
INLINE NAME(both) NAME(halves)(const float weights[2])
{
    double two;
    memcpy(&two, weights, sizeof two);
    return _mm256_permutevar_ps(_mm256_castpd_ps(_mm256_set1_pd(two)),
                                _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
}

INLINE void NAME(at_once)(const float *first, const REAL *y, const REAL *z, int width, bool summed,
                          size_t pitch_y, size_t pitch_z, ROW(row) rows[2])
{
    NAME(both) sum = {0};
    __asm__("" : "+r"(first));
    for (int j = 0; j < width; j++) {
        const float *at = first + (size_t)j * pitch_y;
        NAME(both) row = NAME(twice)(at);
        if (!summed) {
            row *= NAME(halves)(z);
            for (int k = 1; k < width; k++)
                row =
                    FMA(8, NAME(twice)(at + (size_t)k * pitch_z), NAME(halves)(z + k * WIDE), row);
        }
        if (j)
            sum = FMA(8, row, NAME(halves)(y + j * WIDE), sum);
        else
            sum = row * NAME(halves)(y);
    }
    rows[0] = __builtin_shufflevector(sum, sum, 0, 1, 2, 3);
    rows[1] = __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
}
#endif

// Lanes 4 q to 4 q + 3, or both.
INLINE NAME(group) ROW(part)(ROW(row) row, int q)
{
#define PICK __builtin_shufflevector
#if LANES <= 4
    (void)q;
    return row;
#elif LANES == 8
    return q ? PICK(row, row, 4, 5, 6, 7) : PICK(row, row, 0, 1, 2, 3);
#else
    switch (q) {
    case 0:
        return PICK(row, row, 0, 1, 2, 3);
    case 1:
        return PICK(row, row, 4, 5, 6, 7);
    case 2:
        return PICK(row, row, 8, 9, 10, 11);
    default:
        return PICK(row, row, 12, 13, 14, 15);
    }
#endif
#undef PICK
}

// Pixels GROUP at a time: what their lanes hold is turned into vectors across the pixels, one for
// each of the `taps` along the row, and added up by the weights x[tap * WIDE].
INLINE NAME(group)
    ROW(add_up)(const ROW(row) rows[GROUP], const REAL *x, int taps, bool first, NAME(group) sum)
{
    for (int q = 0; q * GROUP < taps; q++) {
        NAME(group) turned[GROUP], weight;
        for (int i = 0; i < GROUP; i++)
            turned[i] = ROW(part)(rows[i], q);
        NAME(turn)(turned);
        for (int k = 0; k < GROUP && q * GROUP + k < taps; k++) {
            memcpy(&weight, x + (q * GROUP + k) * WIDE, sizeof weight);
            if (first && q + k == 0)
                sum = turned[k] * weight;
            else
                sum = FMA(GROUP, turned[k], weight, sum);
        }
    }
    return sum;
}

INLINE void ROW(pair)(const float *const *start, const uint32_t *at, int c, const REAL *y,
                      const REAL *z, int width, bool summed, size_t pitch_y, size_t pitch_z,
                      ROW(row) rows[2])
{
    const float *first = start[0] + at[0] + c, *second = start[1] + at[1] + c;
#if LANES == 4 && REAL_IS_FLOAT && defined(__AVX2__)
    if (first == second) {
        NAME(at_once)(first, y, z, width, summed, pitch_y, pitch_z, rows);
        return;
    }
#endif
    rows[0] = ROW(pixel)(first, y, z, width, summed, pitch_y, pitch_z);
    rows[1] = ROW(pixel)(second, y + 1, z + 1, width, summed, pitch_y, pitch_z);
}

INLINE void ROW(line)(const struct weft_line *line, int width, bool summed, size_t pitch_y,
                      size_t pitch_z)
{
    struct NAME(weights) w;
    float values[CHUNK];
    for (int from = 0; from < line->count; from += CHUNK) {
        const int count = line->count - from < CHUNK ? line->count - from : CHUNK;
        NAME(weigh_any)(line, from, count, &w);
        for (int i = 0; i < count; i += GROUP) {
            const int group = i / WIDE * WIDE * width + i % WIDE;
            NAME(group) sum = {0};
            for (int c = 0; c < width; c += LANES) {
                ROW(row) rows[GROUP];
                for (int p = 0; p < GROUP; p += 2)
                    ROW(pair)
                (line->start + from + i + p, w.at + i + p, c, w.y + group + p, w.z + group + p,
                 width, summed, pitch_y, pitch_z, rows + p);
                sum = ROW(add_up)(rows, w.x + group + c * WIDE,
                                  width - c < LANES ? width - c : LANES, c == 0, sum);
            }
            NAME(put)(sum, values + i);
        }
        if (line->kernel->clamp_to)
            clamp_pixels(line, from, count, w.at, values);
        memcpy(line->out + from, values, (size_t)count * sizeof *values);
    }
}

#undef ROW
