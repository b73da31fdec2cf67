// SPDX-License-Identifier: BSD-3-Clause
// What the samples of `weft resample` are: a source for each group, and what it measures.
#include <math.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

static const struct option_value *range_of(const struct resample_job *job)
{
    return &job->option[RESAMPLE_PASSES + PASS_SOURCE_RANGE];
}

// ---- sources ------------------------------------------------------------------------------------

static struct weft_rectangle rows_of(const struct resample_job *job, int first, int rows)
{
    return (struct weft_rectangle){0, first, job->image.width, rows};
}

struct weft_resample_integers resample_integers(const struct resample_job *job,
                                                const struct resample_group *group, int first,
                                                int rows)
{
    const struct weft_image_channel *channel = &job->image.channels[job->source[group->channel[0]]];
    return (struct weft_resample_integers){.width = job->image.width,
                                           .height = job->image.height,
                                           .window = rows_of(job, first, rows),
                                           .plane = channel->integers +
                                                    (size_t)first * (size_t)job->image.width};
}

struct weft_resample_source_params resample_source_params(const struct resample_job *job,
                                                          const struct resample_group *group,
                                                          int first, int rows)
{
    const struct option_value *range = range_of(job);
    struct weft_resample_source_params params =
        *weft_resample_source_params(.kernel = job->kernel, .width = job->image.width,
                                     .height = job->image.height, .channels = group->count,
                                     .window = rows_of(job, first, rows), .boundary = job->boundary,
                                     .border = job->border,
                                     .threads = job->divided.is ? job->engine.cpu.threads : 0,
                                     .log = report_log());
    for (int c = 0; c < group->count; c++)
        params.plane[c] = job->image.channels[job->source[group->channel[c]]].plane +
                          (size_t)first * (size_t)job->image.width;
    if (range->given) {
        params.low = range->number[0];
        params.high = range->number[1];
    }
    return params;
}

bool resample_tells_e1(const struct resample_job *job)
{
    return job->option[RESAMPLE_JSON].given || job->option[RESAMPLE_VERIFY].given ||
           job->option[RESAMPLE_EXPLAIN].given;
}

// A float would hide the last bits of the ends.
static void set_exact_range(const struct resample_job *job, struct resample_group *group)
{
    const struct weft_resample_integers integers =
        resample_integers(job, group, 0, job->image.height);
    uint32_t range[2];
    weft_resample_integer_range(&integers, range);
    group->statistics.low = group->statistics.sample_low = range[0];
    group->statistics.high = group->statistics.sample_high = range[1];
}

static enum weft_result create_source(struct resample_job *job, struct resample_group *group)
{
    const struct weft_resample_source_params params =
        resample_source_params(job, group, 0, job->image.height);
    const enum weft_result res = weft_resample_source_create(&params, &group->source);
    if (res != WEFT_OK)
        return res;
    const struct weft_resample_source_info *info = weft_resample_source_get_info(group->source);
    group->statistics = info->statistics;
    group->e1 = resample_tells_e1(job) ? weft_resample_e1(group->source) : (double)NAN;
    job->work.prepare_seconds += info->prefilter_seconds;
    if (group->exact)
        set_exact_range(job, group);
    return WEFT_OK;
}

static void warn_of_clamping(const struct resample_job *job, const struct resample_group *group)
{
    const struct weft_resample_statistics *s = &group->statistics;
    char name[256];
    if (!range_of(job)->given || !s->clamped)
        return;
    resample_group_name(job, group, name, sizeof name);
    report_warning("%s: %llu samples are outside --source-range %g,%g, or not finite: the "
                   "error is bounded only where they are not",
                   name, (unsigned long long)s->clamped, s->low, s->high);
}

void resample_set_budget(struct resample_job *job, struct resample_group *group)
{
    const struct weft_resample_statistics *s = &group->statistics;
    warn_of_clamping(job, group);
    group->max_error = range_of(job)->given
                           ? budget_error(&job->budget, s->low, s->high)
                           : budget_error(&job->budget, s->sample_low, s->sample_high);
}

enum weft_result resample_measure(struct resample_job *job)
{
    for (size_t g = 0; g < job->group_count; g++)
        for (int c = 0; c < job->group[g].count; c++)
            job->group[g].rounded[c] = resample_count_rounded(
                job, job->source[job->group[g].channel[c]], 0, job->image.height);
    resample_warn_of_rounding(job);
    for (size_t g = 0; g < job->group_count; g++) {
        struct resample_group *group = &job->group[g];
        const enum weft_result res = create_source(job, group);
        if (res != WEFT_OK)
            return res;
        resample_set_budget(job, group);
    }
    return WEFT_OK;
}

// ---- bounds -------------------------------------------------------------------------------------

struct weft_bound resample_group_bound(const struct resample_group *group, double result)
{
    if (group->exact)
        return (struct weft_bound){.total = 0.0};
    return group->warp ? weft_warp_bound(group->warp, &group->statistics, result)
                       : weft_resample_bound(group->plan, &group->statistics, result);
}

// ---- errors -------------------------------------------------------------------------------------

enum weft_result resample_create_errors(struct resample_job *job)
{
    return job->option[RESAMPLE_ERROR_IMAGE].given
               ? error_image_create(job->result.width, job->result.height,
                                    (int)job->result.channel_count, &job->errors)
               : WEFT_OK;
}

struct weft_verify_params resample_verify_how(struct resample_job *job,
                                              const struct resample_group *group,
                                              const struct weft_progress *progress,
                                              struct error_image_part *part)
{
    *part = (struct error_image_part){.image = &job->errors, .channel = group->channel};
    return (struct weft_verify_params){.max_seconds = INFINITY,
                                       .progress = progress,
                                       .tell = job->errors.plane ? error_image_tell : NULL,
                                       .tell_priv = part};
}
