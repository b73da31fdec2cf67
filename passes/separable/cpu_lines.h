// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/cpu_lines.h - the loops of the CPU engine (not installed). Included by
// cpu_body.h once for each precision, with
//   NUMBER     what sums are made in
//   LANES      how many of them a vector holds: 2, 4, 8 or 16
//   NAME(x)    x, with what makes it one of its kind
// Vectors are those of GCC and Clang; whether products and sums are rounded once or twice is up to
// the file's flags, the same for every pixel: each is a lane of a whole vector.

#define BROAD __attribute__((vector_size(LANES * sizeof(NUMBER))))
#define NARROW __attribute__((vector_size(LANES * sizeof(float))))
typedef NUMBER NAME(vector) BROAD;
typedef float NAME(floats) NARROW;

static inline NAME(vector) NAME(load)(const NUMBER *from)
{
    NAME(vector) v;
    memcpy(&v, from, sizeof v);
    return v;
}

// Of a line of floats, or of numbers.
static inline NAME(vector) NAME(load_at)(const void *line, bool floats, int x)
{
    NAME(floats) v;
    if (!floats)
        return NAME(load)((const NUMBER *)line + x);
    memcpy(&v, (const float *)line + x, sizeof v);
    return __builtin_convertvector(v, NAME(vector));
}

// The first `count` lanes, and zeros.
static inline NAME(vector) NAME(load_part)(const void *line, bool floats, int x, int count)
{
    NAME(vector) v = {0};
    for (int l = 0; l < count; l++)
        v[l] = floats ? (NUMBER)((const float *)line)[x + l] : ((const NUMBER *)line)[x + l];
    return v;
}

static inline void NAME(store)(NUMBER *to, NAME(vector) v)
{
    memcpy(to, &v, sizeof v);
}

// ---- interleaving -------------------------------------------------------------------------------

#if LANES == 2
#define LOW(a, b) __builtin_shufflevector(a, b, 0, 2)
#define HIGH(a, b) __builtin_shufflevector(a, b, 1, 3)
#elif LANES == 4
#define LOW(a, b) __builtin_shufflevector(a, b, 0, 4, 1, 5)
#define HIGH(a, b) __builtin_shufflevector(a, b, 2, 6, 3, 7)
#elif LANES == 8
#define LOW(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11)
#define HIGH(a, b) __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15)
#else
#define LOW(a, b)                                                                                  \
    __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23)
#define HIGH(a, b)                                                                                 \
    __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31)
#endif

// Rows become columns: the halves are riffled once for every bit of the number of a lane.
static inline void NAME(transpose)(NAME(vector) v[LANES])
{
#pragma GCC unroll 4
    for (int step = 1; step < LANES; step *= 2) {
        NAME(vector) old[LANES];
        memcpy(old, v, sizeof old);
#pragma GCC unroll 8
        for (int i = 0; i < LANES / 2; i++) {
            v[2 * i] = LOW(old[i], old[i + LANES / 2]);
            v[2 * i + 1] = HIGH(old[i], old[i + LANES / 2]);
        }
    }
}

static inline __attribute__((always_inline)) void
NAME(gather_span)(const void *const *lines, bool floats, const struct weft_separable_span *span,
                  NUMBER factor, NUMBER *to)
{
    for (int i = 0; i < span->count; i += LANES, to += LANES * LANES) {
        const int left = span->count - i < LANES ? span->count - i : LANES, x = span->sample + i;
        NAME(vector) v[LANES];
#pragma GCC unroll 16
        for (int l = 0; l < LANES; l++)
            v[l] = factor * (left == LANES ? NAME(load_at)(lines[l], floats, x)
                                           : NAME(load_part)(lines[l], floats, x, left));
        NAME(transpose)(v);
        memcpy(to, v, (size_t)left * sizeof *v);
    }
}

static void NAME(gather)(const void *const *lines, bool floats,
                         const struct weft_separable_span *span, double factor, void *out)
{
    NUMBER *to = (NUMBER *)out + (size_t)span->at * LANES;
    if (floats)
        NAME(gather_span)(lines, true, span, (NUMBER)factor, to);
    else
        NAME(gather_span)(lines, false, span, (NUMBER)factor, to);
}

// ---- across: each column has its own weights ----------------------------------------------------

static inline __attribute__((always_inline)) void
NAME(across_taps)(const struct weft_separable_across *a, int taps, bool skips_zeros)
{
    const NUMBER *weights = a->weights;
    for (int column = 0; column < a->columns; column += LANES) {
        NAME(vector) v[LANES];
#pragma GCC unroll 16
        for (int l = 0; l < LANES; l++, weights += taps) {
            const NUMBER *from = (const NUMBER *)a->lines + (size_t)a->first[column + l] * LANES;
            NAME(vector) sum = {0};
            if (!skips_zeros || weights[0] != 0)
                sum = weights[0] * NAME(load)(from);
            for (int t = 1; t < taps; t++)
                if (!skips_zeros || weights[t] != 0)
                    sum += weights[t] * NAME(load)(from + t * LANES);
            v[l] = sum;
        }
        NAME(transpose)(v);
        NUMBER *to = (NUMBER *)a->out + column;
#pragma GCC unroll 16
        for (int l = 0; l < LANES; l++)
            NAME(store)(to + (size_t)l * a->pitch, v[l]);
    }
}

static void NAME(across)(const struct weft_separable_across *a)
{
    if (a->skips_zeros)
        NAME(across_taps)(a, a->taps, true);
    else if (a->taps == 2)
        NAME(across_taps)(a, 2, false);
    else if (a->taps == 4)
        NAME(across_taps)(a, 4, false);
    else if (a->taps == 6)
        NAME(across_taps)(a, 6, false);
    else
        NAME(across_taps)(a, a->taps, false);
}

// ---- along: all columns of a row share their weights --------------------------------------------

// Whole vectors side by side, so many that their sums do not wait for each other.
static inline __attribute__((always_inline)) void NAME(along_at)(const void *const *lines,
                                                                 bool floats, const NUMBER *weights,
                                                                 int taps, int at_once, int x,
                                                                 NUMBER *to)
{
    enum { MOST = 8 };
    NAME(vector) v[MOST];
#pragma GCC unroll 8
    for (int i = 0; i < at_once; i++)
        v[i] = (NAME(vector)){0};
    for (int t = 0; t < taps; t++) {
        const NUMBER weight = weights[t];
        const void *line = lines[t];
#pragma GCC unroll 8
        for (int i = 0; i < at_once; i++)
            v[i] += weight * NAME(load_at)(line, floats, x + i * LANES);
    }
#pragma GCC unroll 8
    for (int i = 0; i < at_once; i++)
        NAME(store)(to + x + i * LANES, v[i]);
}

// Fewer columns than a vector has lanes.
static inline __attribute__((always_inline)) void NAME(along_few)(const void *const *lines,
                                                                  bool floats,
                                                                  const NUMBER *weights, int taps,
                                                                  int count, NUMBER *to)
{
    NAME(vector) v = {0};
    for (int t = 0; t < taps; t++)
        v += weights[t] * NAME(load_part)(lines[t], floats, 0, count);
    memcpy(to, &v, (size_t)count * sizeof *to);
}

// The last vector may overlap the one before: it makes the same of those columns.
static inline __attribute__((always_inline)) void NAME(along_taps)(const void *const *lines,
                                                                   bool floats,
                                                                   const NUMBER *weights, int taps,
                                                                   int count, NUMBER *to)
{
    int x = 0;
    if (count < LANES) {
        NAME(along_few)(lines, floats, weights, taps, count, to);
        return;
    }
    for (; x + 8 * LANES <= count; x += 8 * LANES)
        NAME(along_at)(lines, floats, weights, taps, 8, x, to);
    for (; x + 2 * LANES <= count; x += 2 * LANES)
        NAME(along_at)(lines, floats, weights, taps, 2, x, to);
    if (x + LANES <= count)
        NAME(along_at)(lines, floats, weights, taps, 1, x, to);
    if (count % LANES != 0)
        NAME(along_at)(lines, floats, weights, taps, 1, count - LANES, to);
}

static void NAME(along)(const void *const *lines, bool floats, const void *weights, int taps,
                        int count, void *out)
{
    if (floats && taps == 4)
        NAME(along_taps)(lines, true, weights, 4, count, out);
    else if (floats)
        NAME(along_taps)(lines, true, weights, taps, count, out);
    else if (taps == 4)
        NAME(along_taps)(lines, false, weights, 4, count, out);
    else if (taps == 6)
        NAME(along_taps)(lines, false, weights, 6, count, out);
    else
        NAME(along_taps)(lines, false, weights, taps, count, out);
}

static void NAME(narrow)(const void *numbers, int count, float *out)
{
    const NUMBER *from = numbers;
    for (int i = 0; i < count; i++)
        out[i] = (float)from[i];
}

// ---- pixels -------------------------------------------------------------------------------------

typedef __typeof__((NAME(floats)){0} < (NAME(floats)){0}) NAME(mask);

// Of those lanes of two that a mask chooses.
static inline NAME(floats) NAME(choose)(NAME(mask) mask, NAME(floats) a, NAME(floats) b)
{
    return (NAME(floats))((mask & (NAME(mask))a) | (~mask & (NAME(mask))b));
}

static bool NAME(measure)(const float *pixels, int count, float *minimum, float *maximum)
{
    NAME(floats) low = {0}, high = {0}, zero = {0};
    low += INFINITY;
    high -= INFINITY;
    for (int x = 0; x < count; x += LANES) {
        // Lanes past the last pixel have the first one.
        NAME(floats) v = {0};
        if (count - x >= LANES)
            memcpy(&v, pixels + x, sizeof v);
        else
            for (int l = 0; l < LANES; l++)
                v[l] = pixels[x + l < count ? x + l : 0];
        low = NAME(choose)(v < low, v, low);
        high = NAME(choose)(v > high, v, high);
        zero += v * 0.0f; // 0 of finite numbers, else NAN
    }
    *minimum = low[0];
    *maximum = high[0];
    bool finite = true;
    for (int l = 0; l < LANES; l++) {
        *minimum = low[l] < *minimum ? low[l] : *minimum;
        *maximum = high[l] > *maximum ? high[l] : *maximum;
        finite &= zero[l] == 0.0f;
    }
    return finite;
}

static const struct weft_separable_lines NAME(lines) = {
    .lanes = LANES,
    .bytes = sizeof(NUMBER),
    .gather = NAME(gather),
    .across = NAME(across),
    .along = NAME(along),
    .narrow = NAME(narrow),
    .measure = NAME(measure),
};

#undef BROAD
#undef NARROW
#undef LOW
#undef HIGH
#undef NUMBER
#undef LANES
#undef NAME
