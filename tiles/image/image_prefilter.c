// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image_prefilter.h"

#include <math.h>
#include <stdlib.h>

#include "filter/check.h"

static float sample_at(const struct weft_image_plane *plane, int x, int y)
{
    const int64_t column = weft_boundary_index(plane->boundary, x, plane->width);
    const int64_t row = weft_boundary_index(plane->boundary, y, plane->height);
    return column < 0 || row < 0 ? plane->border : plane->samples[row * plane->stride + column];
}

struct lines {
    int width, height; // the image's and the pads
    double *values, *sums;
};

// Adds a missing sample's weights in coefficients along a line.
static void spread(const double *taps, int overlap, double share, double *line, int at, int count,
                   ptrdiff_t stride)
{
    const int from = at < overlap ? 0 : at - overlap;
    const int to = at + overlap < count ? at + overlap : count - 1;
    for (int k = from; k <= to; k++)
        line[k * stride] += share * fabs(taps[k < at ? at - k : k - at]);
}

// How much coefficients depend on the missing samples.
static bool sum_missing(const struct weft_prefilter *prefilter, int overlap, const float *samples,
                        struct lines *p)
{
    const size_t row = (size_t)p->width, count = row * (size_t)p->height;
    double taps[WEFT_PREFILTER_MAX_OVERLAP + 1];
    double *rows = calloc(count, sizeof *rows);
    p->sums = calloc(count, sizeof *p->sums);
    weft_prefilter_taps(prefilter, overlap, taps);
    for (size_t i = 0; rows && p->sums && i < count; i++)
        if (!isfinite(samples[i]))
            spread(taps, overlap, 1.0, rows + i / row * row, (int)(i % row), p->width, 1);
    for (size_t i = 0; rows && p->sums && i < count; i++)
        if (rows[i] > 0.0)
            spread(taps, overlap, rows[i], p->sums + i % row, (int)(i / row), p->height, p->width);
    free(rows);
    return rows && p->sums;
}

static bool filter_lines(const struct weft_prefilter *prefilter, int overlap, float *samples,
                         struct lines *p)
{
    const size_t row = (size_t)p->width, count = row * (size_t)p->height;
    bool missing = false;
    for (size_t i = 0; i < count; i++) {
        p->values[i] = isfinite(samples[i]) ? (double)samples[i] : 0.0;
        missing = missing || !isfinite(samples[i]);
    }
    if (missing && !sum_missing(prefilter, overlap, samples, p))
        return false;
    for (int y = 0; y < p->height; y++)
        weft_prefilter_line(prefilter, p->values + (size_t)y * row, row, 1, NAN, NAN);
    for (int x = 0; x < p->width; x++)
        weft_prefilter_line(prefilter, p->values + x, (size_t)p->height, p->width, NAN, NAN);
    for (size_t i = 0; i < count; i++)
        if (isfinite(samples[i]))
            samples[i] = missing && p->sums[i] > WEFT_PREFILTER_MISSING ? NAN : (float)p->values[i];
    return true;
}

// Beyond the border coefficients settle within the pad.
static bool fill(const struct weft_prefilter *prefilter, const struct weft_image_plane *plane,
                 int pad, struct lines *p, float *out)
{
    const size_t row = (size_t)p->width;
    p->values = malloc(row * (size_t)p->height * sizeof *p->values);
    for (int y = 0; p->values && y < p->height; y++) {
        for (int x = 0; x < p->width; x++)
            out[(size_t)y * row + (size_t)x] = sample_at(plane, x - pad, y - pad);
    }
    const bool done = p->values && filter_lines(prefilter, pad, out, p);
    free(p->values);
    free(p->sums);
    return done;
}

// Coefficients are several times the samples.
static enum weft_result check_range(const struct weft_log *log, const struct weft_kernel *kernel,
                                    const struct weft_image_plane *plane, int pad,
                                    const float *coefficient)
{
    char name[256];
    for (int y = 0; y < plane->height + 2 * pad; y++) {
        for (int x = 0; x < plane->width + 2 * pad; x++, coefficient++) {
            const float sample = sample_at(plane, x - pad, y - pad);
            if (!isinf(*coefficient) || !isfinite(sample))
                continue;
            weft_kernel_format(kernel, name, sizeof name);
            weft_error(
                log,
                "the coefficients of %s leave the range of floats, at a sample of %.9g: mark "
                "what is no data by NaN, or take a kernel without prefilter",
                name, (double)sample);
            return WEFT_ERR_LIMIT;
        }
    }
    return WEFT_OK;
}

enum weft_result weft_image_prefilter(const struct weft_log *log, const struct weft_kernel *kernel,
                                      const struct weft_image_plane *plane, int pad, float **out)
{
    struct weft_prefilter prefilter;
    struct lines p = {.width = plane->width + 2 * pad, .height = plane->height + 2 * pad};
    const size_t count = (size_t)p.width * (size_t)p.height;
    *out = NULL;
    enum weft_result res = weft_prefilter_compute(log, kernel, &prefilter);
    if (res != WEFT_OK)
        return res;
    float *coefficients = malloc(count * sizeof *coefficients);
    res =
        coefficients && fill(&prefilter, plane, pad, &p, coefficients) ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res != WEFT_OK)
        weft_error(log, "out of memory: %zu bytes for the coefficients of %d x %d pixels",
                   count * (sizeof *coefficients + sizeof *p.values), plane->width, plane->height);
    if (res == WEFT_OK)
        res = check_range(log, kernel, plane, pad, coefficients);
    if (res == WEFT_OK)
        *out = coefficients;
    else
        free(coefficients);
    return res;
}
