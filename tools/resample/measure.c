// SPDX-License-Identifier: BSD-3-Clause
// What the samples of `weft resample` are: the range of each group, and how they change.
#include <math.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

enum { DIFFERENCES = 4 };

static size_t source_size(const struct resample_job *job, int axis)
{
    return (size_t)((axis ? job->image.height : job->image.width) + 2 * job->pad);
}

const float *resample_source_plane(const struct resample_job *job, size_t channel)
{
    return job->coefficients ? job->coefficients[channel]
                             : job->image.channels[job->source[channel]].plane;
}

double resample_largest_sample(const struct resample_group *group)
{
    return fmax(fabs(group->sample_low), fabs(group->sample_high));
}

// The image's own, whatever is read in their place.
static const float *samples_of(const struct resample_job *job, size_t channel)
{
    return job->image.channels[job->source[channel]].plane;
}

static void set_sample_range(const struct resample_job *job, struct resample_group *g)
{
    const size_t count = (size_t)job->image.width * (size_t)job->image.height;
    g->sample_low = INFINITY;
    g->sample_high = -INFINITY;
    for (int c = 0; c < g->count; c++) {
        const float *samples = samples_of(job, g->channel[c]);
        for (size_t i = 0; i < count; i++) {
            if (!isfinite(samples[i]))
                continue;
            g->sample_low = fmin(g->sample_low, samples[i]);
            g->sample_high = fmax(g->sample_high, samples[i]);
        }
    }
    if (g->sample_low > g->sample_high) // nothing finite
        g->sample_low = g->sample_high = 0.0;
}

static void set_range(const struct resample_job *job, struct resample_group *g)
{
    const struct option_value *range = &job->option[RESAMPLE_PLAN + RESAMPLE_PLAN_SOURCE_RANGE];
    const size_t count = source_size(job, 0) * source_size(job, 1);
    g->low = range->given ? range->number[0] : INFINITY;
    g->high = range->given ? range->number[1] : -INFINITY;
    for (int c = 0; c < g->count; c++) {
        const float *samples = resample_source_plane(job, g->channel[c]);
        for (size_t i = 0; i < count; i++) {
            if (!isfinite(samples[i]) ||
                (range->given && (samples[i] < g->low || samples[i] > g->high))) {
                g->clamped++;
            } else if (!range->given) {
                g->low = fmin(g->low, samples[i]);
                g->high = fmax(g->high, samples[i]);
            }
        }
    }
    if (g->low > g->high) // nothing finite
        g->low = g->high = 0.0;
}

// Largest |difference| of some order along rows (stride 1) or columns; not finite ones count not.
static double largest_difference(const float *samples, size_t lines, size_t line_stride,
                                 size_t count, size_t stride, int order)
{
    static const double binomials[DIFFERENCES + 1][DIFFERENCES + 1] = {
        {1}, {1, -1}, {1, -2, 1}, {1, -3, 3, -1}, {1, -4, 6, -4, 1}};
    double largest = 0.0;
    for (size_t line = 0; line < lines; line++) {
        for (size_t i = 0; i + (size_t)order < count; i++) {
            double sum = 0.0;
            for (int k = 0; k <= order; k++)
                sum += binomials[order][k] *
                       (double)samples[line * line_stride + (i + (size_t)k) * stride];
            if (isfinite(sum))
                largest = fmax(largest, fabs(sum));
        }
    }
    return largest;
}

// The leading term, for a signal whose derivatives are as large as its samples' differences.
static double leading_e1(const struct resample_job *job, const struct resample_group *g)
{
    const size_t width = (size_t)job->image.width, height = (size_t)job->image.height;
    const int order = job->kernel.order;
    double largest = 0.0;
    if (order < 1 || order > DIFFERENCES)
        return NAN;
    for (int c = 0; c < g->count; c++) {
        const float *samples = samples_of(job, g->channel[c]);
        largest = fmax(largest, largest_difference(samples, height, width, width, 1, order));
        largest = fmax(largest, largest_difference(samples, width, 1, height, width, order));
    }
    return weft_error_e1(&job->kernel, 2, largest);
}

static bool range_given(const struct resample_job *job)
{
    return job->option[RESAMPLE_PLAN + RESAMPLE_PLAN_SOURCE_RANGE].given;
}

static void warn_of_clamping(const struct resample_job *job, const struct resample_group *group)
{
    char name[256];
    if (!range_given(job) || !group->clamped)
        return;
    resample_group_name(job, group, name, sizeof name);
    report_warning("%s: %llu samples are outside --source-range %g,%g, or not finite: the "
                       "error is bounded only where they are not",
                       name, (unsigned long long)group->clamped, group->low, group->high);
}

enum weft_result resample_measure(struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++) {
        struct resample_group *group = &job->group[g];
        set_sample_range(job, group);
        if (group->exact)
            resample_exact_range(job, group);
        else
            set_range(job, group);
        warn_of_clamping(job, group);
        group->e1 = leading_e1(job, group);
        group->max_error = range_given(job)
                               ? budget_error(&job->budget, group->low, group->high)
                               : budget_error(&job->budget, group->sample_low, group->sample_high);
    }
    return WEFT_OK;
}
