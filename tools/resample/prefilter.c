// SPDX-License-Identifier: BSD-3-Clause
// Coefficients of an image's channels, for kernels that interpolate by a prefilter.
#include <math.h>
#include <stdlib.h>

#include "tools/common/kernels.h"
#include "tools/common/report.h"
#include "tools/resample/job.h"

static int clamp(int x, int size)
{
    return x < 0 ? 0 : x >= size ? size - 1 : x;
}

struct plane {
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
                        struct plane *p)
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
                         struct plane *p)
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

// Beyond the border the nearest pixel's value holds, and its coefficients settle within the pad.
static float *filter_plane(const struct weft_prefilter *prefilter, int pad,
                           const struct weft_image *image, const float *plane)
{
    struct plane p = {.width = image->width + 2 * pad, .height = image->height + 2 * pad};
    const size_t row = (size_t)p.width, count = row * (size_t)p.height;
    float *out = malloc(count * sizeof *out);
    p.values = malloc(count * sizeof *p.values);
    bool done = out && p.values;
    for (int y = 0; done && y < p.height; y++) {
        const float *from = plane + (size_t)clamp(y - pad, image->height) * (size_t)image->width;
        for (int x = 0; x < p.width; x++)
            out[(size_t)y * row + (size_t)x] = from[clamp(x - pad, image->width)];
    }
    done = done && filter_lines(prefilter, pad, out, &p);
    if (!done) {
        report_error("out of memory: %zu bytes for the coefficients of %d x %d pixels",
                     count * (sizeof *out + sizeof *p.values), image->width, image->height);
        free(out);
        out = NULL;
    }
    free(p.values);
    free(p.sums);
    return out;
}

// Coefficients are several times the samples: those of the largest floats leave their range.
static enum weft_result check_range(const struct resample_job *job, size_t channel)
{
    const struct weft_image *image = &job->image;
    const struct weft_image_channel *source = &image->channels[job->source[channel]];
    const int width = image->width + 2 * job->pad, height = image->height + 2 * job->pad;
    const float *coefficient = job->coefficients[channel];
    char kernel[KERNELS_TEXT];
    for (int y = 0; y < height; y++) {
        const float *row =
            source->plane + (size_t)clamp(y - job->pad, image->height) * (size_t)image->width;
        for (int x = 0; x < width; x++, coefficient++) {
            const float sample = row[clamp(x - job->pad, image->width)];
            if (!isinf(*coefficient) || !isfinite(sample))
                continue;
            weft_kernel_format(&job->kernel, kernel, sizeof kernel);
            report_error(
                "channel %s: the coefficients of %s leave the range of floats, at a sample "
                "of %.9g: mark what is no data by NaN, or take a kernel without prefilter",
                source->name, kernel, (double)sample);
            return WEFT_ERR_LIMIT;
        }
    }
    return WEFT_OK;
}

enum weft_result resample_prefilter(struct resample_job *job)
{
    struct weft_prefilter prefilter;
    if (!job->kernel.prefiltered)
        return WEFT_OK;
    const double start = report_now_seconds();
    enum weft_result res = weft_prefilter_compute(report_log(), &job->kernel, &prefilter);
    if (res != WEFT_OK)
        return res;
    job->pad = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    job->coefficients = calloc(job->result.channel_count, sizeof *job->coefficients);
    if (!job->coefficients) {
        report_error("out of memory for %zu channels", job->result.channel_count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < job->result.channel_count; i++) {
        job->coefficients[i] = filter_plane(&prefilter, job->pad, &job->image,
                                            job->image.channels[job->source[i]].plane);
        if (!job->coefficients[i])
            return WEFT_ERR_MEMORY;
        res = check_range(job, i);
        if (res != WEFT_OK)
            return res;
    }
    job->report.prepare_seconds += report_now_seconds() - start;
    return WEFT_OK;
}

void resample_prefilter_clear(struct resample_job *job)
{
    for (size_t i = 0; job->coefficients && i < job->result.channel_count; i++)
        free(job->coefficients[i]);
    free(job->coefficients);
    job->coefficients = NULL;
}
