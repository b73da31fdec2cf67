// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>
#include <string.h>

#include "filter/kernels/kernel_nd.h"
#include "filter/threads.h"
#include "passes/cpu/cpu.h"
#include "passes/multipass/job.h"

static double add_up(const double *weights, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++)
        sum += weights[i];
    return sum;
}

// Of the exact weights at a pixel, what constants are multiplied by.
static double weight_sum(const struct weft_multipass_job *job, const double at[3])
{
    const struct weft_multipass *m = job->compiled;
    double weights[WEFT_KERNEL_MAX_WEIGHTS], product = 1.0;
    int64_t first[3];
    if (m->axes.sums_are_one)
        return 1.0;
    if (weft_kernel_is_radial(&m->work.kernel, m->passes->dims))
        return add_up(weights,
                      weft_kernel_weights_nd(&m->work.kernel, m->passes->dims, at, weights, first));
    for (int a = 0; a < m->passes->dims; a++) {
        weft_kernel_weights(&m->axes.kernel[a], at[a], weights);
        product *= add_up(weights, m->axes.kernel[a].width);
    }
    // Derivatives' weights cancel but for rounding, which a large `low` would show.
    return fabs(product) < 1e-12 ? 0.0 : product;
}

// The box as samples of their own.
static struct weft_samples samples_of(const struct weft_sample_box *box)
{
    struct weft_samples samples = {.size = {box->size[0], box->size[1], box->size[2]}};
    memcpy(samples.plane, box->plane, sizeof samples.plane);
    return samples;
}

static uint8_t marks_of(const struct weft_multipass_job *job, const struct weft_sample_box *box,
                        size_t i)
{
    uint8_t marks = 0;
    for (int c = 0; c < job->compiled->work.channels; c++)
        marks |= (uint8_t)(!isfinite(box->plane[c][i]) << c);
    return marks;
}

static bool any_mark(const struct weft_multipass_job *job, const struct weft_sample_box *box,
                     const double at[3])
{
    size_t from[3] = {0}, to[3] = {0};
    for (int a = 0; a < job->compiled->passes->dims; a++) {
        double fraction;
        const int64_t first = weft_job_first_tap(job, box, a, at[a], &fraction);
        const int64_t last = first + job->compiled->work.kernel.width - 1;
        from[a] = (size_t)(first > 0 ? first : 0);
        to[a] = (size_t)(last < box->size[a] ? last : box->size[a] - 1);
    }
    for (size_t z = from[2]; z <= to[2]; z++)
        for (size_t y = from[1]; y <= to[1]; y++)
            for (size_t x = from[0]; x <= to[0]; x++)
                if (marks_of(job, box, (z * (size_t)box->size[1] + y) * (size_t)box->size[0] + x))
                    return true;
    return false;
}

// Channels in which a tap that counts, whose exact weight is not 0, is not finite.
static uint8_t marks_at(const struct weft_multipass_job *job, const struct weft_sample_box *box,
                        const double at[3])
{
    const struct weft_multipass *m = job->compiled;
    const struct weft_samples samples = samples_of(box);
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    if (!any_mark(job, box, at))
        return 0;
    const int width = m->work.kernel.width, rows = m->passes->dims > 1 ? width : 1;
    const int count = weft_multipass_weights(&m->work, &m->axes, at, weights, first);
    uint8_t marks = 0;
    for (int i = 0; i < count; i++) {
        const int64_t index[3] = {first[0] + i % width, first[1] + i / width % rows,
                                  first[2] + i / width / rows};
        if (weights[i] != 0.0)
            marks |= marks_of(job, box, weft_multipass_sample(&samples, index));
    }
    return marks;
}

// Errors may bring a value past the range of floats, where it stays only if the exact one is there.
static float held(const struct weft_multipass_job *job, int x, int y, int channel, double value)
{
    if (!(fabs(value) > FLT_MAX))
        return (float)value;
    const size_t pixel = (size_t)y * (size_t)job->grid->width + (size_t)x;
    const struct weft_sample_box *box = &job->boxes.box[weft_job_box(job, pixel)];
    const struct weft_samples samples = samples_of(box);
    double at[3];
    weft_job_position(job, box, x, y, at);
    const double exact =
        weft_multipass_refer(&job->compiled->work, &job->compiled->axes, &samples, channel, at);
    return fabs(exact) <= FLT_MAX ? (float)copysign(FLT_MAX, value) : (float)value;
}

static double result_at(const struct weft_multipass_job *job, const void *result, size_t i)
{
    const struct weft_multipass *m = job->compiled;
    const double bias = m->passes->result_bias, scale = m->passes->result_scale;
    if (m->floats)
        return ((double)((const float *)result)[i] - bias) / scale;
    const double code =
        m->one <= 0xff ? ((const uint8_t *)result)[i] : ((const uint16_t *)result)[i];
    return (code / m->one - bias) / scale;
}

struct finisher {
    const struct weft_multipass_job *job;
    const void *result;
    bool needs_sums;      // of the exact weights
    uint64_t *not_finite; // pixels, of each thread
};

static void finish_pixel(const struct finisher *f, int thread, int x, int y)
{
    const struct weft_multipass_job *job = f->job;
    const struct weft_multipass_run_params *p = job->params;
    const int channels = job->compiled->work.channels;
    const int64_t stride = p->stride ? p->stride : job->grid->width;
    const size_t i = (size_t)y * (size_t)job->grid->width + (size_t)x;
    double base = job->low == 0.0 ? 0.0 : job->low;
    uint8_t marks = 0;
    if (f->needs_sums || job->not_finite) {
        const struct weft_sample_box *box = &job->boxes.box[weft_job_box(job, i)];
        double at[3];
        weft_job_position(job, box, x, y, at);
        if (f->needs_sums)
            base *= weight_sum(job, at);
        if (job->not_finite)
            marks = marks_at(job, box, at);
    }
    for (int c = 0; c < channels; c++) {
        const double r = result_at(job, f->result, i * (size_t)channels + (size_t)c);
        p->pixels[c][y * stride + x] =
            marks >> c & 1 ? NAN : held(job, x, y, c, base + job->width * r);
    }
    f->not_finite[thread] += marks != 0;
}

enum { PART_ROWS = 16 };

static bool finish_rows(void *priv, int thread, size_t part)
{
    const struct finisher *f = priv;
    const struct weft_pixel_grid *g = f->job->grid;
    for (int y = (int)part * PART_ROWS; y < ((int)part + 1) * PART_ROWS && y < g->height; y++)
        for (int x = 0; x < g->width; x++)
            finish_pixel(f, thread, x, y);
    return true;
}

void weft_multipass_job_finish(const struct weft_multipass_job *job, const void *result,
                               struct weft_multipass_report *report)
{
    const size_t parts = (size_t)((job->grid->height + PART_ROWS - 1) / PART_ROWS);
    uint64_t counts[WEFT_CPU_MAX_THREADS] = {0};
    const struct finisher f = {
        .job = job,
        .result = result,
        .needs_sums = job->low != 0.0 && !job->compiled->axes.sums_are_one,
        .not_finite = counts,
    };
    weft_threads_run(job->compiled->threads, parts, finish_rows, (void *)(uintptr_t)&f);
    for (int t = 0; t < job->compiled->threads; t++)
        report->not_finite += counts[t];
    report->low = job->low;
    report->high = job->high;
    report->clamped = job->clamped;
}
