// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <string.h>

#include "filter/check.h"
#include "filter/statistics.h"

enum {
    BLOCK = 4096, // values looked at once more where one is not finite
    LANES = 4,    // of a vector
    PAIR = 2,     // doubles of a vector
    LINE = 256,   // differences at a time
};

typedef float floats __attribute__((vector_size(LANES * sizeof(float))));
typedef int32_t bits __attribute__((vector_size(LANES * sizeof(float))));

struct ends {
    floats low, high, zero; // zero: 0 as long as all are finite, else NAN
};

static inline floats choose(bits mask, floats a, floats b)
{
    return (floats)((mask & (bits)a) | (~mask & (bits)b));
}

static inline void take(struct ends *e, floats v)
{
    e->low = choose(v < e->low, v, e->low);
    e->high = choose(v > e->high, v, e->high);
    e->zero += v * 0.0f;
}

// Returns whether all values are finite; else the ends may be infinite.
static bool measure_finite(const float *values, size_t count, float *minimum, float *maximum)
{
    const floats none = {0};
    struct ends a = {none + INFINITY, none - INFINITY, none}, b = a;
    size_t i = 0;
    for (; i + 2 * LANES <= count; i += 2 * LANES) {
        floats v[2];
        memcpy(v, values + i, sizeof v);
        take(&a, v[0]);
        take(&b, v[1]);
    }
    for (; i < count; i++)
        take(&a, none + values[i]);
    a.low = choose(b.low < a.low, b.low, a.low);
    a.high = choose(b.high > a.high, b.high, a.high);
    a.zero += b.zero;
    bool finite = true;
    *minimum = a.low[0];
    *maximum = a.high[0];
    for (int l = 0; l < LANES; l++) {
        *minimum = a.low[l] < *minimum ? a.low[l] : *minimum;
        *maximum = a.high[l] > *maximum ? a.high[l] : *maximum;
        finite &= a.zero[l] == 0.0f;
    }
    return finite;
}

// Returns how many values are not finite.
static size_t measure_mixed(const float *values, size_t count, float *minimum, float *maximum)
{
    size_t not_finite = 0;
    *minimum = INFINITY;
    *maximum = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            not_finite++;
            continue;
        }
        *minimum = values[i] < *minimum ? values[i] : *minimum;
        *maximum = values[i] > *maximum ? values[i] : *maximum;
    }
    return not_finite;
}

void weft_statistics_add(struct weft_statistics *statistics, const float *values, size_t count)
{
    statistics->count += count;
    for (size_t from = 0; from < count; from += BLOCK) {
        const size_t size = count - from < BLOCK ? count - from : BLOCK;
        float minimum, maximum;
        if (!measure_finite(values + from, size, &minimum, &maximum))
            statistics->not_finite += measure_mixed(values + from, size, &minimum, &maximum);
        if (minimum > maximum) // nothing finite
            continue;
        statistics->minimum = fmin(statistics->minimum, (double)minimum);
        statistics->maximum = fmax(statistics->maximum, (double)maximum);
    }
}

void weft_statistics_join(struct weft_statistics *statistics, const struct weft_statistics *other)
{
    statistics->minimum = fmin(statistics->minimum, other->minimum);
    statistics->maximum = fmax(statistics->maximum, other->maximum);
    statistics->count += other->count;
    statistics->not_finite += other->not_finite;
    for (int n = 0; n < WEFT_STATISTICS_DIFFERENCES; n++)
        statistics->difference[n] = fmax(statistics->difference[n], other->difference[n]);
}

// Puts differences in the place of all numbers but the last; returns the larger of `largest` and
// the largest one.
static double difference_line(double *line, size_t count, double largest)
{
    for (size_t i = 0; i + 1 < count; i++) {
        line[i] = line[i + 1] - line[i];
        const double size = fabs(line[i]);
        largest = size > largest && size <= DBL_MAX ? size : largest;
    }
    return largest;
}

void weft_statistics_add_differences(struct weft_statistics *statistics, const float *values,
                                     size_t count, size_t stride)
{
    double line[LINE + WEFT_STATISTICS_DIFFERENCES];
    for (size_t from = 0; from < count; from += LINE) {
        size_t size = count - from < WEFT_COUNT(line) ? count - from : WEFT_COUNT(line);
        for (size_t i = 0; i < size; i++)
            line[i] = (double)values[(from + i) * stride];
        for (int n = 0; n < WEFT_STATISTICS_DIFFERENCES && size > 1; n++, size--)
            statistics->difference[n] = difference_line(line, size, statistics->difference[n]);
    }
}

// ---- planes -------------------------------------------------------------------------------------

typedef double doubles __attribute__((vector_size(PAIR * sizeof(double))));
typedef int64_t long_bits __attribute__((vector_size(PAIR * sizeof(double))));

static inline doubles widen(const float *values)
{
    return (doubles){(double)values[0], (double)values[1]};
}

// The n-th difference is the sum of these times neighbours.
static const double binomials[WEFT_STATISTICS_DIFFERENCES][WEFT_STATISTICS_DIFFERENCES + 1] = {
    {-1, 1}, {1, -2, 1}, {-1, 3, -3, 1}, {1, -4, 6, -4, 1}};

static inline double add_up(const double *factor, const float *const *line, int n, size_t at)
{
    double sum = 0.0;
    for (int k = 0; k <= n; k++)
        sum += factor[k] * (double)line[k][at];
    return fabs(sum);
}

static inline void take_difference(doubles *most, const double *factor, const float *const *line,
                                   int n, size_t at)
{
    const long_bits magnitude = (long_bits){INT64_MAX, INT64_MAX};
    doubles sum = factor[0] * widen(line[0] + at);
    for (int k = 1; k <= n; k++)
        sum += factor[k] * widen(line[k] + at);
    const doubles size = (doubles)((long_bits)sum & magnitude);
    const doubles finite = (doubles)((size <= DBL_MAX) & (long_bits)size); // else 0
    const long_bits takes = finite > *most;
    *most = (doubles)((takes & (long_bits)finite) | (~takes & (long_bits)*most));
}

// Over lines of which each is the next neighbour of the one before; or `largest`.
static inline __attribute__((always_inline)) double
lines_difference(const float *const *line, int n, size_t count, double largest)
{
    enum { AT_ONCE = 4 };
    const double *factor = binomials[n - 1];
    doubles most[AT_ONCE] = {{0}};
    size_t i = 0;
    for (; i + AT_ONCE * PAIR <= count; i += AT_ONCE * PAIR)
        for (size_t k = 0; k < AT_ONCE; k++)
            take_difference(&most[k], factor, line, n, i + k * PAIR);
    for (; i < count; i++) {
        const double size = add_up(factor, line, n, i);
        largest = size > largest && size <= DBL_MAX ? size : largest;
    }
    for (int k = 0; k < AT_ONCE; k++)
        largest = fmax(largest, fmax(most[k][0], most[k][1]));
    return largest;
}

static double any_difference(const float *const *line, int n, size_t count, double largest)
{
    return n == 3 ? lines_difference(line, 3, count, largest)
                  : lines_difference(line, n, count, largest);
}

double weft_statistics_plane_difference(const struct weft_statistics_plane *p, int n, size_t from,
                                        size_t to)
{
    double largest = 0.0;
    const size_t order = (size_t)n;
    if (n < 1 || n > WEFT_STATISTICS_DIFFERENCES)
        return 0.0;
    for (size_t y = from; y < to && y < p->height; y++) {
        const float *along[WEFT_STATISTICS_DIFFERENCES + 1], *down[WEFT_STATISTICS_DIFFERENCES + 1];
        for (size_t k = 0; k <= order; k++) {
            along[k] = p->values + y * p->stride + k;
            down[k] = p->values + (y + k) * p->stride;
        }
        if (p->width > order)
            largest = any_difference(along, n, p->width - order, largest);
        if (y + order < p->height)
            largest = any_difference(down, n, p->width, largest);
    }
    return largest;
}

double weft_statistics_magnitude(const struct weft_statistics *statistics)
{
    return fmax(0.0, fmax(-statistics->minimum, statistics->maximum));
}
