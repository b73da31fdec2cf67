// SPDX-License-Identifier: BSD-3-Clause
// What the samples of `weft resample` are: the range of each group, and how they change.
#include <math.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

static size_t source_size(const struct resample_job *job)
{
    return (size_t)(job->image.width + 2 * job->pad) * (size_t)(job->image.height + 2 * job->pad);
}

const float *resample_source_plane(const struct resample_job *job, size_t channel)
{
    return job->coefficients ? job->coefficients[channel]
                             : job->image.channels[job->source[channel]].plane;
}

// The image's borders hold beyond them: no samples are out of reach.
static struct weft_bound bound_of(const struct weft_bound_terms *terms,
                                  const struct resample_group *group, double result)
{
    const struct weft_bound_values values = {.low = group->low,
                                             .high = group->high,
                                             .sample_low = group->sample_low,
                                             .sample_high = group->sample_high,
                                             .result = result};
    return weft_bound_compute(terms, &values);
}

struct weft_bound resample_bound_of(const struct weft_pass_plan_info *plan,
                                    const struct resample_group *group, double result)
{
    return bound_of(&plan->bound, group, result);
}

struct weft_bound resample_bound(const struct resample_job *job, const struct resample_group *group,
                                 double result)
{
    if (group->exact)
        return (struct weft_bound){.total = 0.0};
    if (group->plan)
        return resample_bound_of(weft_pass_plan_get_info(group->plan), group, result);
    const struct weft_bound_terms terms = weft_separable_bound_terms(
        &job->kernel, fmax(fabs(group->low), fabs(group->high)), WEFT_VOLUME_PREFILTER_ERROR);
    return bound_of(&terms, group, result);
}

// The image's own, whatever is read in their place.
static const float *samples_of(const struct resample_job *job, size_t channel)
{
    return job->image.channels[job->source[channel]].plane;
}

// 0 to 0 where nothing is finite.
static void range_of(const struct weft_statistics *s, double *low, double *high)
{
    *low = isnan(s->minimum) ? 0.0 : s->minimum;
    *high = isnan(s->maximum) ? 0.0 : s->maximum;
}

static void set_sample_range(const struct resample_job *job, struct resample_group *g)
{
    const size_t count = (size_t)job->image.width * (size_t)job->image.height;
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    for (int c = 0; c < g->count; c++)
        weft_statistics_add(&s, samples_of(job, g->channel[c]), count);
    range_of(&s, &g->sample_low, &g->sample_high);
}

static uint64_t count_outside(const float *samples, size_t count, double low, double high)
{
    uint64_t outside = 0;
    for (size_t i = 0; i < count; i++)
        outside += !(samples[i] >= low && samples[i] <= high);
    return outside;
}

static void set_range(const struct resample_job *job, struct resample_group *g)
{
    const struct option_value *range = &job->option[RESAMPLE_PLAN + RESAMPLE_PLAN_SOURCE_RANGE];
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    for (int c = 0; c < g->count; c++) {
        const float *samples = resample_source_plane(job, g->channel[c]);
        if (range->given)
            g->clamped +=
                count_outside(samples, source_size(job), range->number[0], range->number[1]);
        else
            weft_statistics_add(&s, samples, source_size(job));
    }
    range_of(&s, &g->low, &g->high);
    if (range->given) {
        g->low = range->number[0];
        g->high = range->number[1];
    } else {
        g->clamped = s.not_finite;
    }
}

// The leading term, for a signal whose derivatives are as large as its samples' differences.
static double leading_e1(const struct resample_job *job, const struct resample_group *g)
{
    const size_t width = (size_t)job->image.width, height = (size_t)job->image.height;
    const int order = job->kernel.order;
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    if (order < 1 || order > WEFT_STATISTICS_DIFFERENCES)
        return NAN;
    for (int c = 0; c < g->count; c++) {
        const float *samples = samples_of(job, g->channel[c]);
        for (size_t y = 0; y < height; y++)
            weft_statistics_add_differences(&s, samples + y * width, width, 1);
        for (size_t x = 0; x < width; x++)
            weft_statistics_add_differences(&s, samples + x, height, width);
    }
    return weft_error_e1(&job->kernel, 2, s.difference[order - 1]);
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
