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
                for (int p = 0; p < GROUP; p++)
                    rows[p] =
                        ROW(pixel)(line->start[from + i + p] + w.at[i + p] + c, w.y + group + p,
                                   w.z + group + p, width, summed, pitch_y, pitch_z);
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

// ---- several outputs ----------------------------------------------------------------------------

// a * weight, or with it added to `into`.
INLINE ROW(row) ROW(add)(bool begins, ROW(row) into, ROW(row) a, REAL weight)
{
    if (begins)
        return a * ROW(splat)(weight);
    return FMA(LANES, a, ROW(splat)(weight), into);
}

// One pixel's sums as above for each pair of orders up to `most` in all, out[pair]. Weights of
// order n are w[n]'s, from `own` on.
INLINE void ROW(pixel_orders)(const float *first, const struct NAME(weights) * w, int own,
                              int width, int most, size_t pitch_y, size_t pitch_z,
                              ROW(row) out[PAIRS])
{
    ROW(row) sum[PAIRS] = {{0}};
    __asm__("" : "+r"(first));
    for (int j = 0; j < width; j++) {
        const float *at = first + (size_t)j * pitch_y;
        const int y = own + j * WIDE;
        ROW(row) row[WEFT_LINE_ORDERS];
        for (int k = 0; k < width; k++) {
            const ROW(row) samples = ROW(load)(at + (size_t)k * pitch_z);
            const int z = own + k * WIDE;
            row[0] = ROW(add)(k == 0, row[0], samples, w[0].z[z]);
            row[1] = ROW(add)(k == 0, row[1], samples, w[1].z[z]);
            if (most == 2)
                row[2] = ROW(add)(k == 0, row[2], samples, w[2].z[z]);
        }
        sum[0] = ROW(add)(j == 0, sum[0], row[0], w[0].y[y]);
        sum[1] = ROW(add)(j == 0, sum[1], row[0], w[1].y[y]);
        sum[2] = ROW(add)(j == 0, sum[2], row[1], w[0].y[y]);
        if (most == 2) {
            sum[3] = ROW(add)(j == 0, sum[3], row[0], w[2].y[y]);
            sum[4] = ROW(add)(j == 0, sum[4], row[1], w[1].y[y]);
            sum[5] = ROW(add)(j == 0, sum[5], row[2], w[0].y[y]);
        }
    }
    memcpy(out, sum, sizeof sum);
}

// Pixels GROUP at a time, one pair's: added up for each order along the row that it allows, as
// add_up does it; `spare` orders are left of `most`.
INLINE void ROW(add_orders)(const ROW(row) rows[GROUP], const struct NAME(weights) * w, int own,
                            int taps, int spare, bool first, NAME(group) sum[])
{
    for (int q = 0; q * GROUP < taps; q++) {
        NAME(group) turned[GROUP], weight;
        for (int i = 0; i < GROUP; i++)
            turned[i] = ROW(part)(rows[i], q);
        NAME(turn)(turned);
        for (int k = 0; k < GROUP && q * GROUP + k < taps; k++) {
            for (int n = 0; n <= spare; n++) {
                memcpy(&weight, w[n].x + own + (q * GROUP + k) * WIDE, sizeof weight);
                if (first && q + k == 0)
                    sum[n] = turned[k] * weight;
                else
                    sum[n] = FMA(GROUP, turned[k], weight, sum[n]);
            }
        }
    }
}

// The sums of GROUP pixels, whose samples begin at `start`.
INLINE void ROW(group_orders)(const float *const start[GROUP], const struct NAME(weights) * w,
                              int group, int width, int most, size_t pitch_y, size_t pitch_z,
                              NAME(group) sum[SUMS])
{
    for (int c = 0; c < width; c += LANES) {
        const int taps = width - c < LANES ? width - c : LANES;
        ROW(row) pixel[PAIRS], rows[PAIRS][GROUP];
        for (int p = 0; p < GROUP; p++) {
            ROW(pixel_orders)(start[p] + c, w, group + p, width, most, pitch_y, pitch_z, pixel);
            for (int i = 0; i < (most == 2 ? 6 : 3); i++)
                rows[i][p] = pixel[i];
        }
#define ADD(pair, spare)                                                                           \
    ROW(add_orders)(rows[pair], w, group + c * WIDE, taps, spare, c == 0, sum + first_sum[pair])
        ADD(0, most);
        ADD(1, most - 1);
        ADD(2, most - 1);
        if (most == 2) {
            ADD(3, 0);
            ADD(4, 0);
            ADD(5, 0);
        }
#undef ADD
    }
}

INLINE void ROW(line_orders)(const struct weft_line *line, int width, int most, size_t pitch_y,
                             size_t pitch_z)
{
    const struct weft_line_kernel *kernel = line->kernel;
    struct NAME(weights) w[WEFT_LINE_ORDERS];
    float values[WEFT_DERIVATIVES][CHUNK];
    int wanted[WEFT_DERIVATIVES];
    for (int o = 0; o < kernel->output_count; o++)
        wanted[o] = sum_of(&kernel->output[o]);
    for (int from = 0; from < line->count; from += CHUNK) {
        const int count = line->count - from < CHUNK ? line->count - from : CHUNK;
        NAME(weigh_orders)(line, from, count, most, w);
        for (int i = 0; i < count; i += GROUP) {
            const float *start[GROUP];
            NAME(group) sum[SUMS];
            for (int p = 0; p < GROUP; p++)
                start[p] = line->start[from + i + p] + w->at[i + p];
            ROW(group_orders)
            (start, w, i / WIDE * WIDE * width + i % WIDE, width, most, pitch_y, pitch_z, sum);
            for (int o = 0; o < kernel->output_count; o++)
                NAME(put)(sum[wanted[o]], values[o] + i);
        }
        for (int o = 0; o < kernel->output_count; o++)
            memcpy(line->out + (size_t)o * line->plane + from, values[o],
                   (size_t)count * sizeof *values[o]);
    }
}

#undef ROW
