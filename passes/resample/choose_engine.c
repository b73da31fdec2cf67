// SPDX-License-Identifier: BSD-3-Clause
// What runs a separable plan: every engine in every sums is planned, which is cheap.
#include <math.h>
#include <stdlib.h>

#include "passes/choose/search.h"
#include "passes/resample/choose.h"
#include "passes/resample/resample_impl.h"

static const struct weft_method methods[] = {
    {.algorithm = WEFT_ALGORITHM_SEPARABLE},
    {.algorithm = WEFT_ALGORITHM_SEPARABLE, .engine = WEFT_ENGINE_CPU},
    {.algorithm = WEFT_ALGORITHM_SEPARABLE, .engine = WEFT_ENGINE_CPU, .sums = WEFT_SUMS_DOUBLE},
};

struct chooser {
    const struct weft_resample_engine_params *params;
    const struct weft_cost_model *model;
    struct weft_quiet_log quiet;
};

static enum weft_result create(const struct chooser *c, const struct weft_method *method,
                               const struct weft_log *log, weft_resample_plan **out)
{
    struct weft_resample_params params = c->params->plan;
    params.engine = method->engine;
    params.sums = method->sums;
    params.log = log;
    return weft_resample_plan_create(&params, out);
}

// The largest part of a source's budget that the bound takes; 0 without budgets.
static double find_part(const struct weft_resample_engine_params *p, const weft_resample_plan *plan)
{
    double part = 0.0;
    for (size_t i = 0; p->max_error && i < p->source_count; i++) {
        const double bound = weft_resample_bound(plan, &p->sources[i]->info.statistics, 0.0).total;
        if (bound > 0.0)
            part = fmax(part, bound / p->max_error[i]);
    }
    return part;
}

static int most_taps(const weft_resample_plan *plan)
{
    const struct weft_separable_info *info = weft_separable_plan_get_info(plan->separable);
    return info->taps[0] > info->taps[1] ? info->taps[0] : info->taps[1];
}

static void set_figures(const struct chooser *c, const weft_resample_plan *plan,
                        struct weft_candidate *candidate)
{
    const struct weft_resample_info *info = &plan->info;
    const double sources = c->params->source_count ? (double)c->params->source_count : 1.0;
    const struct weft_work work = {
        .algorithm = WEFT_ALGORITHM_SEPARABLE,
        .engine = candidate->method.engine,
        .sums = candidate->method.sums,
        .threads = c->params->threads,
        .pixels = (double)info->width * info->height,
        .of.separable =
            weft_separable_work_of(most_taps(plan), info->size[0] + 2.0 * info->overlap,
                                   info->size[1] + 2.0 * info->overlap, info->width, info->height),
    };
    candidate->state = WEFT_CANDIDATE_DEARER;
    candidate->seconds = sources * weft_cost_of(c->model, &work);
    candidate->bound = find_part(c->params, plan);
}

// Whether there may be this method.
static bool is_wanted(const struct weft_resample_engine_params *p, const struct weft_method *method)
{
    return (!p->engines || p->engines & 1u << method->engine) &&
           (p->max_error || method->sums == WEFT_SUMS_FLOAT);
}

static enum weft_result consider(struct chooser *c, const struct weft_method *method,
                                 struct weft_resample_choice *out)
{
    weft_resample_plan *plan = NULL;
    struct weft_candidate *candidate = &out->candidates[out->count];
    *candidate =
        (struct weft_candidate){.method = *method, .state = WEFT_CANDIDATE_REFUSED, .bound = NAN};
    weft_method_format(method, candidate->name, sizeof candidate->name);
    const enum weft_result res = create(c, method, &c->quiet.log, &plan);
    if (res == WEFT_OK)
        set_figures(c, plan, candidate);
    weft_resample_plan_destroy(&plan);
    out->count += res == WEFT_OK;
    if (res != WEFT_OK && c->quiet.failure[0])
        weft_error(c->params->log, "%s", c->quiet.failure);
    return res;
}

// ---- the search ---------------------------------------------------------------------------------

// The figures are there, and planning was no trouble.
static enum weft_result plan(void *priv, struct weft_candidate *candidate, void **out)
{
    const struct chooser *c = priv;
    weft_resample_plan *made = NULL;
    const enum weft_result res = create(c, &candidate->method, c->params->plan.log, &made);
    *out = made;
    return res;
}

static void destroy(void *made)
{
    weft_resample_plan *plan = made;
    weft_resample_plan_destroy(&plan);
}

static enum weft_result search(struct chooser *c, struct weft_resample_choice *out)
{
    const struct weft_search search = {.candidates = out->candidates,
                                       .count = out->count,
                                       .max_error = out->max_error,
                                       .quiet = &c->quiet,
                                       .priv = c,
                                       .plan = plan,
                                       .destroy = destroy};
    struct weft_search_result result;
    const enum weft_result res = weft_search_run(&search, &result);
    out->chosen = result.chosen;
    out->best = result.best;
    out->separable = result.plan;
    out->planned = result.planned;
    return res;
}

static enum weft_result check(const struct weft_resample_engine_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, !p->plan.passes);
    weft_require(p->log, p->engines < 1u << (WEFT_ENGINE_CPU + 1));
    weft_require(p->log, p->threads >= 0);
    weft_require(p->log, !p->max_error || (p->sources && p->source_count >= 1));
    for (size_t i = 0; p->max_error && i < p->source_count; i++) {
        weft_require(p->log, p->sources[i]);
        weft_require(p->log, p->max_error[i] >= 0.0);
    }
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_resample_choose_engine(const struct weft_resample_engine_params *params,
                                             struct weft_resample_choice *out)
{
    struct chooser c = {.params = params,
                        .model = params->model ? params->model : &weft_cost_default};
    *out = (struct weft_resample_choice){.chosen = -1, .best = -1, .max_error = 1.0};
    weft_quiet_log_init(&c.quiet, params->log);
    enum weft_result res = check(params);
    if (res == WEFT_OK && !(out->candidates = calloc(WEFT_COUNT(methods), sizeof *out->candidates)))
        res = WEFT_ERR_MEMORY;
    for (size_t i = 0; res == WEFT_OK && i < WEFT_COUNT(methods); i++)
        if (is_wanted(params, &methods[i]))
            res = consider(&c, &methods[i], out);
    if (res == WEFT_OK)
        res = search(&c, out);
    if (res != WEFT_OK)
        weft_resample_choice_clear(out);
    return res;
}
