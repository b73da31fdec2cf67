// SPDX-License-Identifier: BSD-3-Clause
// Coefficients of an image's channels, for kernels that interpolate by a prefilter.
#include <math.h>
#include <stdlib.h>

#include "report.h"
#include "resample_job.h"

static int clamp(int x, int size)
{
    return x < 0 ? 0 : x >= size ? size - 1 : x;
}

// Beyond the border the nearest pixel's value holds, and its coefficients settle within the pad.
static float *filter_plane(const struct weft_prefilter *prefilter, int pad,
                           const struct weft_image *image, const float *plane)
{
    const int width = image->width + 2 * pad, height = image->height + 2 * pad;
    const size_t row = (size_t)width, count = row * (size_t)height;
    float *out = malloc(count * sizeof *out);
    double *values = malloc(count * sizeof *values);
    if (!out || !values) {
        report_error("out of memory: %zu bytes for the coefficients of %d x %d pixels",
                     count * (sizeof *out + sizeof *values), image->width, image->height);
        free(out);
        free(values);
        return NULL;
    }
    for (int y = 0; y < height; y++) {
        const float *from = plane + (size_t)clamp(y - pad, image->height) * (size_t)image->width;
        for (int x = 0; x < width; x++) {
            const size_t at = (size_t)y * row + (size_t)x;
            out[at] = from[clamp(x - pad, image->width)];
            values[at] = isfinite(out[at]) ? (double)out[at] : 0.0;
        }
        weft_prefilter_line(prefilter, values + (size_t)y * row, row, 1, NAN, NAN);
    }
    for (int x = 0; x < width; x++)
        weft_prefilter_line(prefilter, values + x, (size_t)height, width, NAN, NAN);
    for (size_t i = 0; i < count; i++)
        out[i] = isfinite(out[i]) ? (float)values[i] : out[i];
    free(values);
    return out;
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
