// SPDX-License-Identifier: BSD-3-Clause
// The plans of `weft resample`: separable, or passes as they are asked for, or the cheapest passes
// within --max-error by what weft calibrate measured.
#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// ---- passes within a budget ---------------------------------------------------------------------

static bool is_given(const struct resample_job *job, enum pass_option o)
{
    return job->option[RESAMPLE_PASSES + o].given;
}

// The least bound that passes which need not be planned could have, to the range; INFINITY: none.
static double least_bound(const struct weft_resample_choice *choice)
{
    double least = INFINITY;
    for (size_t i = 0; i < choice->count; i++)
        least = fmin(least, choice->candidates[i].bound); // NAN of what is refused
    return least;
}

// Says what the best would be.
static enum weft_result refuse(struct resample_job *job, const struct weft_profile *profile,
                               const struct weft_resample_choice *choice)
{
    const char *wanted = job->option[RESAMPLE_MAX_ERROR].text;
    const double least = least_bound(choice);
    job->over_budget = true;
    if (choice->best >= 0) {
        const struct weft_candidate *c = &choice->candidates[choice->best];
        report_error("no passes of profile %s are within --max-error %s, %.3g of the range: the "
                     "best bound found is %.3g of it (%s, %d samples, %d bits)",
                     profile->name, wanted, choice->max_error, c->bound,
                     weft_technique_names[c->method.technique], c->method.samples, c->method.bits);
    } else if (isfinite(least)) {
        report_error("no passes of profile %s are within --max-error %s, %.3g of the range: no "
                     "bound could be below %.3g of it",
                     profile->name, wanted, choice->max_error, least);
    } else {
        report_error("profile %s has no passes for this kernel, within --max-error %s or not",
                     profile->name, wanted);
    }
    return WEFT_ERR_ARGUMENT;
}

// For the groups of so many channels.
static enum weft_result choose(struct resample_job *job, int channels,
                               const weft_resample_source **sources, double *max_error)
{
    struct weft_resample_choice *choice = &job->choices[channels > 1];
    struct weft_resample_choose_params params = {
        .passes = *weft_pass_plan_params(),
        .any_technique = !is_given(job, PASS_TECHNIQUE),
        .any_samples = !is_given(job, PASS_RESOLUTION),
        .any_bits = !is_given(job, PASS_BITS),
        .sources = sources,
        .max_error = max_error,
        .width = job->result.width,
        .height = job->result.height,
        .model = &job->engine.model,
        .log = report_log(),
    };
    for (size_t g = 0; g < job->group_count; g++) {
        if (job->group[g].count != channels)
            continue;
        sources[params.source_count] = job->group[g].source;
        max_error[params.source_count++] = job->group[g].max_error;
    }
    if (params.source_count == 0)
        return WEFT_OK;
    if (job->context) // what is emulated is not on any machine
        engine_load_costs(&job->engine, job->context);
    enum weft_result res = pass_plan_params(&job->option[RESAMPLE_PASSES], PASS_DEFAULT_PROFILE,
                                            &job->kernel, 2, channels, &params.passes);
    if (res == WEFT_OK)
        res = weft_resample_choose(&params, choice);
    if (res != WEFT_OK)
        return res;
    if (choice->chosen < 0)
        return refuse(job, &params.passes.profile, choice);
    *(channels > 1 ? &job->together : &job->single) = choice->plan;
    choice->plan = NULL;
    return WEFT_OK;
}

static enum weft_result choose_passes(struct resample_job *job)
{
    const weft_resample_source **sources = calloc(job->group_count, sizeof *sources);
    double *max_error = calloc(job->group_count, sizeof *max_error);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (sources && max_error)
        res = choose(job, 1, sources, max_error);
    else
        report_error("out of memory for %zu channels", job->group_count);
    if (res == WEFT_OK)
        res = choose(job, RESAMPLE_MAX_TOGETHER, sources, max_error);
    free(sources);
    free(max_error);
    return res;
}

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result plan_passes(struct resample_job *job)
{
    enum weft_result res = WEFT_OK;
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++) {
        weft_pass_plan **plan = job->group[g].count > 1 ? &job->together : &job->single;
        if (!*plan)
            res = pass_plan_create(&job->option[RESAMPLE_PASSES], PASS_DEFAULT_PROFILE,
                                   &job->kernel, 2, job->group[g].count, plan);
    }
    return res;
}

static enum weft_result set_passes(struct resample_job *job)
{
    if (!job->option[RESAMPLE_MAX_ERROR].given)
        return plan_passes(job);
    const enum weft_result res = resample_create_context(job); // whose costs count
    return res == WEFT_OK ? choose_passes(job) : res;
}

static enum weft_result plan_group(struct resample_job *job, struct resample_group *group)
{
    const int which = group->count > 1;
    const weft_pass_plan *const passes[2] = {job->single, job->together};
    enum weft_result res = WEFT_OK;
    if (!job->plan[which]) {
        struct weft_resample_params params = resample_plan_params(job);
        params.passes = passes[which];
        res = weft_resample_plan_create(&params, &job->plan[which]);
    }
    group->plan = job->plan[which];
    return res;
}

enum weft_result resample_plan(struct resample_job *job)
{
    const double start = report_now_seconds();
    enum weft_result res = job->separable ? resample_plan_separable(job) : set_passes(job);
    for (size_t g = 0; !job->separable && res == WEFT_OK && g < job->group_count; g++)
        res = plan_group(job, &job->group[g]);
    job->plan_seconds = report_now_seconds() - start;
    return res;
}
