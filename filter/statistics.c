// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>

#include "filter/check.h"
#include "filter/statistics.h"

enum {
    BLOCK = 4096, // values looked at once more where one is not finite
    LANES = 16,   // of what a compiler makes vectors
    LINE = 256,   // differences at a time
};

// Returns whether all values are finite; else the ends may be infinite.
static bool measure_finite(const float *values, size_t count, float *minimum, float *maximum)
{
    float low[LANES], high[LANES], zero[LANES] = {0};
    for (int l = 0; l < LANES; l++) {
        low[l] = INFINITY;
        high[l] = -INFINITY;
    }
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        for (int l = 0; l < LANES; l++) {
            const float x = values[i + (size_t)l];
            low[l] = x < low[l] ? x : low[l];
            high[l] = x > high[l] ? x : high[l];
            zero[l] += x * 0.0f; // 0 of finite numbers, else NAN
        }
    }
    for (; i < count; i++) {
        low[0] = values[i] < low[0] ? values[i] : low[0];
        high[0] = values[i] > high[0] ? values[i] : high[0];
        zero[0] += values[i] * 0.0f;
    }
    bool finite = true;
    for (int l = 0; l < LANES; l++) {
        low[0] = low[l] < low[0] ? low[l] : low[0];
        high[0] = high[l] > high[0] ? high[l] : high[0];
        finite &= zero[l] == 0.0f;
    }
    *minimum = low[0];
    *maximum = high[0];
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

double weft_statistics_magnitude(const struct weft_statistics *statistics)
{
    return fmax(0.0, fmax(-statistics->minimum, statistics->maximum));
}
