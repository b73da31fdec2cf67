// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>

#include "filter/kernels/kernel_nd.h"
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

static bool any_mark(const struct weft_multipass_job *job, const double at[3])
{
    const struct weft_samples *s = job->samples;
    size_t from[3] = {0}, to[3] = {0};
    for (int a = 0; a < job->compiled->passes->dims; a++) {
        double fraction;
        const int64_t first = weft_job_first_tap(job, a, at[a], &fraction);
        const int64_t last = first + job->compiled->work.kernel.width - 1;
        from[a] = (size_t)(first > 0 ? first : 0);
        to[a] = (size_t)(last < s->size[a] ? last : s->size[a] - 1);
    }
    for (size_t z = from[2]; z <= to[2]; z++)
        for (size_t y = from[1]; y <= to[1]; y++)
            for (size_t x = from[0]; x <= to[0]; x++)
                if (job->not_finite[(z * (size_t)s->size[1] + y) * (size_t)s->size[0] + x])
                    return true;
    return false;
}

// Channels in which a tap that counts, whose exact weight is not 0, is not finite.
static uint8_t marks_at(const struct weft_multipass_job *job, const double at[3])
{
    const struct weft_multipass *m = job->compiled;
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    if (!job->not_finite || !any_mark(job, at))
        return 0;
    const int width = m->work.kernel.width, rows = m->passes->dims > 1 ? width : 1;
    const int count = weft_multipass_weights(&m->work, &m->axes, at, weights, first);
    uint8_t marks = 0;
    for (int i = 0; i < count; i++) {
        const int64_t index[3] = {first[0] + i % width, first[1] + i / width % rows,
                                  first[2] + i / width / rows};
        if (weights[i] != 0.0)
            marks |= job->not_finite[weft_multipass_sample(job->samples, index)];
    }
    return marks;
}

// Errors may bring a value past the range of floats, where it stays only if the exact one is there.
static float held(const struct weft_multipass_job *job, const double at[3], int channel,
                  double value)
{
    if (!(fabs(value) > FLT_MAX))
        return (float)value;
    const double exact =
        weft_multipass_refer(&job->compiled->work, &job->compiled->axes, job->samples, channel, at);
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

void weft_multipass_job_finish(const struct weft_multipass_job *job, const void *result,
                               struct weft_multipass_report *report)
{
    const struct weft_multipass_run_params *p = job->params;
    const int width = job->grid->width, channels = job->compiled->work.channels;
    const int64_t stride = p->stride ? p->stride : width;
    for (size_t i = 0; i < job->pixels; i++) {
        const int x = (int)(i % (size_t)width), y = (int)(i / (size_t)width);
        double at[3];
        weft_multipass_position(job->grid, x, y, at);
        const double base = job->low == 0.0 ? 0.0 : job->low * weight_sum(job, at);
        const uint8_t marks = marks_at(job, at);
        for (int c = 0; c < channels; c++) {
            const double r = result_at(job, result, i * (size_t)channels + (size_t)c);
            p->pixels[c][y * stride + x] =
                marks >> c & 1 ? NAN : held(job, at, c, base + job->width * r);
        }
        report->not_finite += marks != 0;
    }
    report->low = job->low;
    report->high = job->high;
    report->clamped = job->clamped;
}
