// SPDX-License-Identifier: BSD-3-Clause
#include "passes/resample/choose.h"

#include <math.h>
#include <stdlib.h>

#include "filter/analysis/analysis.h"
#include "passes/choose/search.h"
#include "passes/resample/resample_impl.h"

enum { MIN_SAMPLES = 16, MAX_SAMPLES = 1024, SAMPLES_COUNT = 7, BITS_COUNT = 4 };
static const enum weft_technique techniques[] = {WEFT_TECHNIQUE_PLAIN, WEFT_TECHNIQUE_DOT4,
                                                 WEFT_TECHNIQUE_SPLIT_PRECISION,
                                                 WEFT_TECHNIQUE_HIERARCHICAL};
static const int unorm_bits[BITS_COUNT] = {8, 10, 12, 14};
enum { TECHNIQUE_COUNT = 4, MAX_CHOICES = TECHNIQUE_COUNT * SAMPLES_COUNT * BITS_COUNT };

struct chooser {
    const struct weft_resample_choose_params *params;
    const struct weft_cost_model *model;
    struct weft_pass_plan_params passes; // what all candidates have in common
    double slope;                        // largest sum of |h'|
    double rest;                         // of the last plan's bound, what is not E2
    struct weft_resample_choice *choice;
};

static double width_of(const struct weft_resample_statistics *of)
{
    return of->high - of->low;
}

static const struct weft_resample_statistics *statistics(const struct chooser *c, size_t i)
{
    return &c->params->sources[i]->info.statistics;
}

static struct weft_pass_plan_params params_of(const struct chooser *c,
                                              const struct weft_method *method)
{
    struct weft_pass_plan_params params = c->passes;
    params.technique = method->technique;
    params.samples = method->samples;
    params.bits = method->bits;
    return params;
}

// ---- figures ------------------------------------------------------------------------------------

// The largest part of a source's budget that a bound takes; values that are all the same are exact.
static double find_part(const struct chooser *c, const struct weft_bound_terms *terms)
{
    double part = 0.0;
    for (size_t i = 0; i < c->params->source_count; i++)
        if (width_of(statistics(c, i)) > 0.0)
            part = fmax(part, weft_resample_bound_of(terms, statistics(c, i), 0.0).total /
                                  c->params->max_error[i]);
    return part;
}

static void set_figures(const struct chooser *c, const struct weft_pass_work *plan,
                        const struct weft_bound_terms *terms, struct weft_candidate *candidate)
{
    const weft_resample_source *source = c->params->sources[0];
    const struct weft_work work = {
        .algorithm = WEFT_ALGORITHM_MULTIPASS,
        .pixels = (double)c->params->width * c->params->height,
        .of.passes = {.plan = *plan,
                      .samples = ((double)source->info.width + 2.0 * source->overlap) *
                                 ((double)source->info.height + 2.0 * source->overlap)},
    };
    candidate->seconds = (double)c->params->source_count * weft_cost_of(c->model, &work);
    candidate->bytes = (uint64_t)plan->tile_bytes;
    candidate->bound = find_part(c, terms) * c->choice->max_error;
}

// ---- candidates ---------------------------------------------------------------------------------

static void add(struct chooser *c, enum weft_technique technique, int samples, int bits)
{
    struct weft_candidate *candidate = &c->choice->candidates[c->choice->count];
    *candidate = (struct weft_candidate){
        .method = {.algorithm = WEFT_ALGORITHM_MULTIPASS,
                   .samples = samples,
                   .profile = c->passes.profile,
                   .technique = technique,
                   .bits = bits},
        .state = WEFT_CANDIDATE_DEARER,
        .estimated = true,
    };
    const struct weft_pass_plan_params params = params_of(c, &candidate->method);
    const struct weft_pass_work work = weft_pass_work_least(&params);
    const struct weft_bound_terms terms = weft_pass_bound_least(&params, c->slope);
    if (work.passes == 0.0) // what a profile cannot do is not among the choices
        return;
    set_figures(c, &work, &terms, candidate);
    weft_method_format(&candidate->method, candidate->name, sizeof candidate->name);
    c->choice->count++;
}

static void add_samples(struct chooser *c, enum weft_technique technique, int bits)
{
    if (!c->params->any_samples)
        add(c, technique, c->passes.samples, bits);
    for (int m = MIN_SAMPLES; c->params->any_samples && m <= MAX_SAMPLES; m *= 2)
        add(c, technique, m, bits);
}

static void add_bits(struct chooser *c, enum weft_technique technique)
{
    const bool any = c->params->any_bits && weft_target_bits(c->passes.profile.target) > 0;
    if (!any)
        add_samples(c, technique, c->passes.bits);
    for (int i = 0; any && i < BITS_COUNT; i++)
        add_samples(c, technique, unorm_bits[i]);
}

static void add_techniques(struct chooser *c)
{
    if (!c->params->any_technique)
        add_bits(c, c->passes.technique);
    for (int t = 0; c->params->any_technique && t < TECHNIQUE_COUNT; t++)
        add_bits(c, techniques[t]);
}

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result plan(void *priv, struct weft_candidate *candidate, void **out)
{
    struct chooser *c = priv;
    struct weft_pass_plan_params params = params_of(c, &candidate->method);
    weft_pass_plan *made = NULL;
    const enum weft_result res = weft_pass_plan_create(&params, &made);
    if (res != WEFT_OK) // whatever a plan is refused for, others may do
        return res == WEFT_ERR_CANCELLED || res == WEFT_ERR_MEMORY ? res : WEFT_ERR_UNSUPPORTED;
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(made);
    const struct weft_pass_work work = weft_pass_work_of(info);
    candidate->method.bits = weft_target_bits(info->profile.target) > 0 ? info->bits : 0;
    candidate->method.samples = info->samples;
    weft_method_format(&candidate->method, candidate->name, sizeof candidate->name);
    set_figures(c, &work, &info->bound, candidate);
    struct weft_bound_terms rest = info->bound;
    rest.e2 = rest.e2_quantised = rest.e2_sampled = 0.0;
    c->rest = find_part(c, &rest) * c->choice->max_error;
    *out = made;
    return WEFT_OK;
}

static void destroy(void *made)
{
    weft_pass_plan *plan = made;
    weft_pass_plan_destroy(&plan);
}

static void learn(void *priv, const struct weft_candidate *planned)
{
    const struct chooser *c = priv;
    weft_search_learn(c->choice->candidates, c->choice->count, planned, c->rest);
}

// ---- the choice ---------------------------------------------------------------------------------

static enum weft_result check(const struct weft_resample_choose_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->sources && p->source_count >= 1 && p->max_error);
    weft_require(p->log, p->width >= 1 && p->height >= 1);
    for (size_t i = 0; i < p->source_count; i++) {
        weft_require(p->log, p->sources[i]);
        weft_require(p->log, p->max_error[i] > 0.0);
    }
    res = WEFT_OK;
fail:
    return res;
}

static void set_max_error(const struct chooser *c)
{
    c->choice->max_error = INFINITY;
    for (size_t i = 0; i < c->params->source_count; i++)
        if (width_of(statistics(c, i)) > 0.0)
            c->choice->max_error =
                fmin(c->choice->max_error, c->params->max_error[i] / width_of(statistics(c, i)));
    if (isinf(c->choice->max_error)) // all are exact
        c->choice->max_error = 0.0;
}

static enum weft_result search(const struct weft_resample_choose_params *params,
                               struct weft_resample_choice *out)
{
    struct chooser c = {.params = params,
                        .model = params->model ? params->model : &weft_cost_default,
                        .passes = params->passes,
                        .choice = out};
    struct weft_quiet_log quiet;
    if (!c.passes.kernel.info)
        weft_kernel_parse(params->log, "catmull-rom", &c.passes.kernel);
    weft_quiet_log_init(&quiet, params->log);
    c.passes.worst_case = WEFT_WORST_ANY;
    c.passes.log = &quiet.log;
    c.slope = c.passes.kernel.radial ? 0.0 : weft_analysis_slope(&c.passes.kernel);
    set_max_error(&c);
    add_techniques(&c);
    const struct weft_search search = {.candidates = out->candidates,
                                       .count = out->count,
                                       .max_error = out->max_error,
                                       .tells_best = true,
                                       .quiet = &quiet,
                                       .priv = &c,
                                       .plan = plan,
                                       .destroy = destroy,
                                       .learn = learn};
    struct weft_search_result result;
    const enum weft_result res = weft_search_run(&search, &result);
    out->chosen = result.chosen;
    out->best = result.best;
    out->plan = result.plan;
    out->planned = result.planned;
    return res;
}

enum weft_result weft_resample_choose(const struct weft_resample_choose_params *params,
                                      struct weft_resample_choice *out)
{
    *out = (struct weft_resample_choice){.chosen = -1, .best = -1};
    enum weft_result res = check(params);
    if (res == WEFT_OK && !(out->candidates = calloc(MAX_CHOICES, sizeof *out->candidates))) {
        weft_error(params->log, "out of memory for %d candidates", MAX_CHOICES);
        res = WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK)
        res = search(params, out);
    if (res != WEFT_OK)
        weft_resample_choice_clear(out);
    return res;
}

void weft_resample_choice_clear(struct weft_resample_choice *choice)
{
    weft_pass_plan_destroy(&choice->plan);
    weft_resample_plan_destroy(&choice->separable);
    free(choice->candidates);
    *choice = (struct weft_resample_choice){.chosen = -1, .best = -1};
}
