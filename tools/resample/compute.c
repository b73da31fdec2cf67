// SPDX-License-Identifier: BSD-3-Clause
// Runs the plans of `weft resample`, group by group.
#include <math.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// Progress over all groups.
struct steps {
    const char *what;
    double step, steps;
};

static bool report_step(void *priv, double fraction)
{
    const struct steps *s = priv;
    const struct weft_progress *outer = report_progress(s->what);
    return outer->report(outer->priv, (s->step + fraction) / s->steps);
}

enum weft_result resample_compile_group(struct resample_job *job,
                                        const struct resample_group *group,
                                        weft_resample_compiled **out)
{
    weft_resample_compiled **compiled = &job->compiled[group->plan != job->plan[0]];
    enum weft_result res = WEFT_OK;
    if (!*compiled) {
        res = weft_resample_compile(
            group->plan,
            weft_resample_compile_params(.context = job->context, .cpu = job->engine.cpu),
            compiled);
        if (res == WEFT_OK)
            job->work.prepare_seconds += weft_resample_compiled_get_info(*compiled)->seconds;
    }
    *out = *compiled;
    return res;
}

static enum weft_result run_group(struct resample_job *job, struct resample_group *group,
                                  struct steps *steps)
{
    const struct weft_progress progress = {report_step, steps};
    struct weft_resample_run_params params = {
        .source = group->source, .progress = &progress, .log = report_log()};
    struct weft_resample_report report;
    weft_resample_compiled *compiled;
    enum weft_result res = resample_compile_group(job, group, &compiled);
    for (int c = 0; c < group->count; c++)
        params.plane[c] = job->result.channels[group->channel[c]].plane;
    if (res == WEFT_OK)
        res = weft_resample_run(compiled, &params, &report);
    if (res != WEFT_OK)
        return res;
    weft_resample_work_add(&job->work, &report.work);
    group->minimum = report.pixels.minimum;
    group->maximum = report.pixels.maximum;
    group->not_finite = report.pixels.not_finite;
    group->bound = resample_group_bound(group, weft_statistics_magnitude(&report.pixels));
    return WEFT_OK;
}

static enum weft_result verify_group(struct resample_job *job, struct resample_group *group,
                                     struct steps *steps)
{
    const struct weft_progress progress = {report_step, steps};
    struct error_image_part part;
    struct weft_resample_verify_params params = {
        .source = group->source,
        .how = resample_verify_how(job, group, &progress, &part),
        .log = report_log()};
    for (int c = 0; c < group->count; c++)
        params.plane[c] = job->result.channels[group->channel[c]].plane;
    return weft_resample_verify(group->plan, &params, &group->error);
}

static enum weft_result move_group(struct resample_job *job, struct resample_group *group)
{
    const struct weft_resample_integers source =
        resample_integers(job, group, 0, job->image.height);
    const struct weft_image_channel *to = &job->result.channels[group->channel[0]];
    const struct weft_resample_integers result = {
        .width = job->result.width, .height = job->result.height, .plane = to->integers};
    uint32_t range[2];
    const enum weft_result res = weft_resample_move(group->plan, &source, NULL, to->integers, 0);
    if (res != WEFT_OK)
        return res;
    for (size_t i = 0; i < (size_t)job->result.width * (size_t)job->result.height; i++)
        to->plane[i] = (float)to->integers[i];
    weft_resample_integer_range(&result, range);
    group->minimum = range[0];
    group->maximum = range[1];
    struct error_image_part part;
    const struct weft_verify_params how = resample_verify_how(job, group, NULL, &part);
    return job->option[RESAMPLE_VERIFY].given
               ? weft_resample_move_verify(group->plan, &source, NULL, to->integers, 0, &how,
                                           &group->error)
               : WEFT_OK;
}

typedef enum weft_result (*group_work)(struct resample_job *job, struct resample_group *group,
                                       struct steps *steps);

static enum weft_result each_filtered(struct resample_job *job, const char *what, group_work work)
{
    struct steps steps = {.what = what, .steps = (double)job->group_count};
    enum weft_result res = WEFT_OK;
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++, steps.step++)
        if (!job->group[g].exact)
            res = work(job, &job->group[g], &steps);
    return res;
}

enum weft_result resample_compute(struct resample_job *job)
{
    enum weft_result res = resample_create_errors(job);
    if (res == WEFT_OK)
        res = each_filtered(job, "resampling", run_group);
    const double start = report_now_seconds();
    if (res == WEFT_OK && job->option[RESAMPLE_VERIFY].given)
        res = each_filtered(job, "verifying", verify_group);
    job->verify_seconds = report_now_seconds() - start;
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        if (job->group[g].exact)
            res = move_group(job, &job->group[g]);
    return res;
}
