// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/kernel_nd.h"
#include "passes/convolve_job.h"

// The kernel's weights along each axis: the derivative's along one, where the plan says so.
struct axis_kernels {
    struct weft_kernel kernel[3];
    bool sums_are_one;
};

static void make_axis_kernels(const struct weft_convolve_job *job, struct axis_kernels *out)
{
    const struct weft_convolve_work *w = job->work;
    for (int a = 0; a < 3; a++)
        out->kernel[a] = w->kernel;
    out->sums_are_one = w->derivative == 0 && (w->kernel.unit_sum || w->kernel.normalised);
    if (w->derivative)
        weft_kernel_derive(NULL, &w->kernel, &out->kernel[w->derivative - 1]);
}

static double add_up(const double *weights, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++)
        sum += weights[i];
    return sum;
}

// Of the exact weights at a pixel, what constants are multiplied by.
static double weight_sum(const struct weft_convolve_job *job, const struct axis_kernels *axes,
                         const double at[3])
{
    double weights[WEFT_KERNEL_MAX_WEIGHTS], product = 1.0;
    int64_t first[3];
    if (axes->sums_are_one)
        return 1.0;
    if (weft_kernel_is_radial(&job->work->kernel, job->passes->dims))
        return add_up(weights, weft_kernel_weights_nd(&job->work->kernel, job->passes->dims, at,
                                                      weights, first));
    for (int a = 0; a < job->passes->dims; a++) {
        weft_kernel_weights(&axes->kernel[a], at[a], weights);
        product *= add_up(weights, axes->kernel[a].width);
    }
    // Derivatives' weights cancel but for rounding, which a large `low` would show.
    return fabs(product) < 1e-12 ? 0.0 : product;
}

static uint8_t marks_in_reach(const struct weft_convolve_job *job, const double at[3])
{
    const struct weft_samples *s = job->samples;
    size_t from[3] = {0}, to[3] = {0};
    for (int a = 0; a < job->passes->dims; a++) {
        double fraction;
        const int64_t first = weft_job_first_tap(job, a, at[a], &fraction);
        const int64_t last = first + job->work->kernel.width - 1;
        from[a] = (size_t)(first > 0 ? first : 0);
        to[a] = (size_t)(last < s->size[a] ? last : s->size[a] - 1);
    }
    uint8_t marks = 0;
    for (size_t z = from[2]; z <= to[2]; z++)
        for (size_t y = from[1]; y <= to[1]; y++)
            for (size_t x = from[0]; x <= to[0]; x++)
                marks |= job->not_finite[(z * (size_t)s->size[1] + y) * (size_t)s->size[0] + x];
    return marks;
}

static double result_at(const struct weft_convolve_job *job, const void *result, size_t i)
{
    const double bias = job->passes->result_bias, scale = job->passes->result_scale;
    if (job->floats)
        return ((double)((const float *)result)[i] - bias) / scale;
    const double code =
        job->one <= 0xff ? ((const uint8_t *)result)[i] : ((const uint16_t *)result)[i];
    return (code / job->one - bias) / scale;
}

void weft_convolve_job_finish(const struct weft_convolve_job *job, const void *result,
                              float *const pixels[4], struct weft_convolve_report *report)
{
    const int width = job->grid->width, channels = job->work->channels;
    struct axis_kernels axes;
    make_axis_kernels(job, &axes);
    for (size_t i = 0; i < job->pixels; i++) {
        double at[3];
        weft_convolve_position(job->grid, (int)(i % (size_t)width), (int)(i / (size_t)width), at);
        const double base = job->low == 0.0 ? 0.0 : job->low * weight_sum(job, &axes, at);
        const uint8_t marks = job->not_finite ? marks_in_reach(job, at) : 0;
        for (int c = 0; c < channels; c++) {
            const double r = result_at(job, result, i * (size_t)channels + (size_t)c);
            pixels[c][i] = marks >> c & 1 ? NAN : (float)(base + job->width * r);
        }
        report->not_finite += marks != 0;
    }
    report->low = job->low;
    report->high = job->high;
    report->clamped = job->clamped;
    report->source_bytes = job->source.bytes;
    report->tile_bytes = job->tiles.bytes;
    report->position_bytes = job->pixels * sizeof *job->entries;
}
