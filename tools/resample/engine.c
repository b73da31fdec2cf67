// SPDX-License-Identifier: BSD-3-Clause
// What runs a resampling: OpenGL or the CPU engine, as it is asked for, or the fastest within
// --max-error.
#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/ranks/ranks.h"
#include "tools/resample/job.h"

// ---- options and contexts -----------------------------------------------------------------------

// Whatever says how a plan's passes are to be asks for a plan.
const char *resample_passes_option(const struct resample_job *job)
{
    const struct option_value *o = job->option;
    if (o[RESAMPLE_TOGETHER].given)
        return "--together";
    if (o[RESAMPLE_PASSES + PASS_PROFILE].given)
        return "--profile";
    for (int i = 0; i < PASS_OPTION_COUNT; i++)
        if (o[RESAMPLE_PASSES + i].given)
            return "an option of passes";
    return weft_kernel_is_radial(&job->kernel, 2) ? "a radial kernel" : NULL;
}

enum weft_result resample_read_engine(struct resample_job *job)
{
    const struct option_value *o = job->option;
    const struct option_value *engine = &o[RESAMPLE_ENGINE];
    if (job->engine_is_read)
        return WEFT_OK;
    if (o[RESAMPLE_EMULATE].given) {
        for (int i = 0; i < ENGINE_OPTION_COUNT; i++) {
            if (!engine[i].given)
                continue;
            report_error("--emulate runs passes on the CPU: --engine, --context, --threads and "
                         "--sums make no sense with it");
            return WEFT_ERR_ARGUMENT;
        }
    }
    if (o[RESAMPLE_MAX_ERROR].given && engine[ENGINE_SUMS].given) {
        report_error("--max-error chooses what --sums says");
        return WEFT_ERR_ARGUMENT;
    }
    job->engine_is_read = true;
    const enum weft_result res =
        engine_options_read(engine, resample_passes_option(job), &job->engine);
    if (res == WEFT_OK && !engine[ENGINE_THREADS].given && ranks_threads())
        job->engine.cpu.threads = ranks_threads();
    return res;
}

static bool needs_gl(const struct resample_job *job)
{
    bool any = false;
    for (size_t g = 0; g < job->group_count; g++)
        any = any || !job->group[g].exact;
    if (job->warp.is)
        return job->engine.engine == WEFT_ENGINE_GL;
    if (job->separable && job->plan[0]) // as it is planned
        return any && weft_resample_plan_get_info(job->plan[0])->engine == WEFT_ENGINE_GL;
    return any && !job->option[RESAMPLE_EMULATE].given;
}

enum weft_result resample_create_context(struct resample_job *job)
{
    const double start = report_now_seconds();
    if (job->context || !needs_gl(job))
        return WEFT_OK;
    enum weft_result res = engine_create_context(&job->engine, &job->context);
    job->context_seconds = report_now_seconds() - start;
    if (res != WEFT_OK || job->context)
        return res;
    weft_resample_plan_destroy(&job->plan[0]);
    weft_resample_choice_clear(&job->choices[0]);
    return resample_plan_separable(job);
}

// ---- separable plans ----------------------------------------------------------------------------

struct weft_resample_params resample_plan_params(const struct resample_job *job)
{
    return *weft_resample_params(.kernel = job->kernel,
                                 .size = {job->image.width, job->image.height},
                                 .width = job->result.width, .height = job->result.height,
                                 .map = {job->map[0], job->map[1]}, .boundary = job->boundary,
                                 .unstretched = resample_is_unstretched(job),
                                 .clamp = job->option[RESAMPLE_CLAMP].given,
                                 .engine = job->engine.engine, .sums = job->engine.sums,
                                 .log = report_log());
}

// Says what the best would be.
static enum weft_result refuse(struct resample_job *job)
{
    const struct weft_resample_choice *choice = &job->choices[0];
    const struct weft_candidate *best = &choice->candidates[choice->best];
    job->over_budget = true;
    for (size_t g = 0; g < job->group_count; g++) {
        const struct resample_group *group = &job->group[g];
        const double bound = resample_group_bound(group, 0.0).total;
        char name[256];
        if (bound <= group->max_error)
            continue;
        resample_group_name(job, group, name, sizeof name);
        report_error(
            "%s: no method is within --max-error %s, which is %.3g: the best one's bound is "
            "%.3g (%s)",
            name, job->option[RESAMPLE_MAX_ERROR].text, group->max_error, bound, best->name);
        break;
    }
    return WEFT_ERR_ARGUMENT;
}

// Integers that are moved count in no budget.
static enum weft_result choose(struct resample_job *job)
{
    const weft_resample_source **sources = calloc(job->group_count, sizeof *sources);
    double *max_error = calloc(job->group_count, sizeof *max_error);
    struct weft_resample_engine_params params = {.plan = resample_plan_params(job),
                                                 .sources = sources,
                                                 .engines =
                                                     engine_candidates(&job->engine, job->context),
                                                 .threads = job->engine.cpu.threads,
                                                 .model = &job->engine.model,
                                                 .log = report_log()};
    enum weft_result res = sources && max_error ? WEFT_OK : WEFT_ERR_MEMORY;
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++) {
        if (!job->group[g].source || job->group[g].exact)
            continue;
        sources[params.source_count] = job->group[g].source;
        max_error[params.source_count++] = job->group[g].max_error;
    }
    if (job->option[RESAMPLE_MAX_ERROR].given && params.source_count)
        params.max_error = max_error;
    if (res == WEFT_OK)
        res = weft_resample_choose_engine(&params, &job->choices[0]);
    if (res == WEFT_OK && job->choices[0].chosen < 0 &&
        engine_has_more_candidates(&job->engine, &params.engines)) {
        weft_resample_choice_clear(&job->choices[0]);
        res = weft_resample_choose_engine(&params, &job->choices[0]);
    }
    free(sources);
    free(max_error);
    return res;
}

// The best one's, by which the error line tells how far the budget is.
static enum weft_result plan_best(struct resample_job *job)
{
    const struct weft_resample_choice *choice = &job->choices[0];
    struct weft_resample_params params = resample_plan_params(job);
    params.engine = choice->candidates[choice->best].method.engine;
    params.sums = choice->candidates[choice->best].method.sums;
    return weft_resample_plan_create(&params, &job->plan[0]);
}

static enum weft_result choose_or_plan(struct resample_job *job)
{
    const struct weft_resample_params params = resample_plan_params(job);
    const bool budget = job->option[RESAMPLE_MAX_ERROR].given;
    if (budget || job->engine.automatic)
        engine_load_costs(&job->engine, job->context);
    if (!budget && !(job->engine.automatic && job->engine.calibrated))
        return weft_resample_plan_create(&params, &job->plan[0]);
    const enum weft_result res = choose(job);
    job->plan[0] = job->choices[0].separable;
    job->choices[0].separable = NULL;
    return res == WEFT_OK && !job->plan[0] ? plan_best(job) : res;
}

enum weft_result resample_plan_separable(struct resample_job *job)
{
    const enum weft_result res = choose_or_plan(job);
    for (size_t g = 0; g < job->group_count; g++)
        job->group[g].plan = job->plan[0];
    return res == WEFT_OK && job->choices[0].count && job->choices[0].chosen < 0 ? refuse(job)
                                                                                 : res;
}
