// SPDX-License-Identifier: BSD-3-Clause
#include "passes/choose/choose.h"

#include <math.h>
#include <stdlib.h>

#include "filter/analysis/analysis.h"
#include "filter/check.h"
#include "passes/choose/method_impl.h"
#include "passes/choose/search.h"

struct chooser {
    const struct weft_choose_params *params;
    const struct weft_cost_model *model;
    weft_volume *volume;
    struct weft_choice *choice;
    struct weft_quiet_log quiet;
    weft_slice_plan *base; // fused, interleaved floats: what lies where
    double slope;          // largest sum of |h'|
    double samples;        // of the boxes of passes
};

static struct weft_method_params params_of(const struct chooser *c,
                                           const struct weft_method *method)
{
    struct weft_method_params params = {
        .method = *method, .slice = c->params->slice, .statistics = c->choice->statistics};
    params.slice.kernel = c->base->info.kernel;
    params.slice.footprint = c->base->footprint;
    params.slice.log = &c->quiet.log;
    if (c->params->samplers && method->algorithm == WEFT_ALGORITHM_HARDWARE)
        params.sampler = c->params->samplers[method->source];
    return params;
}

// ---- figures of what is not planned -------------------------------------------------------------

// Voxels, and pixels as they are computed and read back.
static double common_bytes(const struct weft_work *work)
{
    return 4.0 * work->voxels + 8.0 * work->pixels;
}

static double fused_bytes(const struct weft_work *work)
{
    const struct weft_fused_work *w = &work->of.fused;
    if (work->engine == WEFT_ENGINE_CPU)
        return 4.0 * work->of.fused_cpu.samples + common_bytes(work);
    const int samples = w->layout == WEFT_LAYOUT_PLAIN ? 1 : 4;
    return w->texels * samples * weft_source_format_bytes(w->source) + common_bytes(work);
}

// The samples twice, and what is between the passes.
static double separable_bytes(const struct weft_work *work, const struct weft_slice_plan *request)
{
    const struct weft_separable_work *w = &work->of.separable;
    return 8.0 * w->summed / request->axes.kept +
           4.0 * (w->taps / request->info.kernel.width - work->pixels) + common_bytes(work);
}

// Exact: bounds need no cells, only the kernel and the axes.
static void set_slice_figures(const struct chooser *c, const struct weft_slice_plan *request,
                              struct weft_candidate *candidate)
{
    const struct weft_bound_values values = weft_method_values(&c->choice->statistics);
    struct weft_work work = weft_method_work(&candidate->method, request, c->base, NULL, 0.0);
    work.threads = c->params->threads;
    candidate->state = WEFT_CANDIDATE_DEARER;
    candidate->bound = weft_bound_compute(&request->info.output[0].bound, &values).total;
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes =
        (uint64_t)(work.algorithm == WEFT_ALGORITHM_FUSED ? fused_bytes(&work)
                                                          : separable_bytes(&work, request));
}

// Likewise; a texture is at most twice as large along an axis as its blocks.
static enum weft_result set_hardware_figures(const struct chooser *c,
                                             const struct weft_method_params *params,
                                             const struct weft_slice_plan *request,
                                             struct weft_candidate *candidate)
{
    const struct weft_bound_values values = weft_method_values(&c->choice->statistics);
    const struct weft_sampler sampler = weft_method_sampler(params);
    struct weft_work work = weft_method_work(&candidate->method, request, c->base, NULL, 0.0);
    struct weft_hardware_figures figures;
    const enum weft_result res =
        weft_hardware_figures_find(&c->quiet.log, request, c->base, &sampler, &figures);
    if (res != WEFT_OK)
        return res;
    work.of.hardware = figures.work;
    candidate->state = WEFT_CANDIDATE_DEARER;
    candidate->bound = weft_bound_compute(&figures.bound, &values).total;
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes =
        (uint64_t)(figures.work.texels * weft_source_format_bytes(figures.work.source) +
                   common_bytes(&work));
    return WEFT_OK;
}

// The least that a plan of passes could have.
static void set_passes_figures(const struct chooser *c, const struct weft_method_params *params,
                               struct weft_candidate *candidate)
{
    const struct weft_bound_values values = weft_method_values(&c->choice->statistics);
    const struct weft_pass_plan_params passes = weft_method_pass_params(params);
    const struct weft_pass_work least = weft_pass_work_least(&passes);
    const struct weft_bound_terms terms = weft_pass_bound_least(&passes, c->slope);
    const struct weft_work work =
        weft_method_work(&candidate->method, c->base, c->base, &least, c->samples);
    if (least.passes == 0.0) // the profile cannot
        return;
    candidate->estimated = true;
    candidate->state = WEFT_CANDIDATE_DEARER;
    candidate->bound = weft_bound_compute(&terms, &values).total;
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes = (uint64_t)(least.tile_bytes + common_bytes(&work));
}

// ---- candidates ---------------------------------------------------------------------------------

static bool is_wanted(const struct weft_choose_params *p, const struct weft_method *method)
{
    if (p->engines && !(p->engines & 1u << method->engine))
        return false;
    if (p->profile)
        return method->algorithm == WEFT_ALGORITHM_MULTIPASS;
    return method->algorithm != WEFT_ALGORITHM_FUSED || p->slice.layout == WEFT_LAYOUT_AUTO ||
           p->slice.layout == method->layout;
}

// With a profile, the passes of the list stand for those on it.
static bool adapt(const struct weft_choose_params *p, struct weft_method *method)
{
    if (!p->profile)
        return true;
    if (method->profile.target != p->profile->target)
        return false;
    method->profile = *p->profile;
    return method->technique != WEFT_TECHNIQUE_DOT4 || p->profile->dot_width >= 3;
}

static enum weft_result consider_slice(struct chooser *c, const struct weft_method_params *params,
                                       struct weft_candidate *candidate)
{
    const struct weft_slice_params slice = weft_method_slice_params(params);
    weft_slice_plan *request = NULL;
    enum weft_result res = weft_slice_request_create(c->volume, &slice, &request);
    if (res == WEFT_OK && candidate->method.algorithm == WEFT_ALGORITHM_HARDWARE)
        res = set_hardware_figures(c, params, request, candidate);
    else if (res == WEFT_OK &&
             (candidate->method.algorithm == WEFT_ALGORITHM_FUSED || request->axes.separable))
        set_slice_figures(c, request, candidate);
    weft_slice_plan_destroy(&request);
    return weft_quiet_log_refuses(&c->quiet, res) ? WEFT_OK : res;
}

static enum weft_result consider(struct chooser *c, struct weft_method method)
{
    struct weft_candidate candidate = {.state = WEFT_CANDIDATE_REFUSED, .bound = NAN};
    enum weft_result res = WEFT_OK;
    if (!is_wanted(c->params, &method) || !adapt(c->params, &method))
        return WEFT_OK;
    const struct weft_method_params params = params_of(c, &method);
    candidate.method = method;
    const bool applies = weft_method_check(&params) == WEFT_OK;
    if (applies && method.algorithm != WEFT_ALGORITHM_MULTIPASS)
        res = consider_slice(c, &params, &candidate);
    else if (applies && !c->params->slice.clamp_to_samples)
        set_passes_figures(c, &params, &candidate);
    weft_method_format(&candidate.method, candidate.name, sizeof candidate.name);
    c->choice->candidates[c->choice->count++] = candidate;
    return res;
}

static enum weft_result list_candidates(struct chooser *c)
{
    struct weft_choice *choice = c->choice;
    struct weft_method *methods = NULL;
    size_t count = 0;
    enum weft_result res = weft_method_list(c->params->slice.log, &methods, &count);
    choice->candidates = res == WEFT_OK ? calloc(count, sizeof *choice->candidates) : NULL;
    if (res == WEFT_OK && !choice->candidates) {
        weft_error(c->params->slice.log, "not enough memory for %zu candidates", count);
        res = WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; res == WEFT_OK && i < count; i++)
        res = consider(c, methods[i]);
    free(methods);
    return res;
}

// ---- plans --------------------------------------------------------------------------------------

// Bounding a cell's second differences takes the time of so many pixels, give or take.
static bool smooth_may_pay(const struct chooser *c)
{
    enum { PIXELS_PER_CELL = 1500 };
    const struct weft_slice_geometry *g = &c->base->info.geometry;
    double cells = 0.0;
    for (int i = 0; i < c->base->info.tile_count; i++)
        cells += (double)c->base->tiles[i].cells_laid_out;
    return (double)g->width * g->height >= PIXELS_PER_CELL * cells;
}

// A fused plan gives what its own bound leaves to smooth pieces; that stays the candidate's bound.
static enum weft_result plan(void *priv, struct weft_candidate *candidate, void **out)
{
    const struct chooser *c = priv;
    struct weft_method_params params = params_of(c, &candidate->method);
    weft_method_plan *made = NULL;
    if (candidate->method.algorithm == WEFT_ALGORITHM_FUSED && smooth_may_pay(c))
        params.slice.smooth_error = fmax(0.0, 0.999 * (c->params->max_error - candidate->bound));
    const enum weft_result res = weft_method_plan_create(c->volume, &params, &made);
    if (res != WEFT_OK)
        return res;
    const struct weft_method_plan_info *info = weft_method_plan_get_info(made);
    struct weft_work work = info->work;
    work.threads = c->params->threads;
    if (candidate->method.algorithm == WEFT_ALGORITHM_MULTIPASS)
        candidate->bound = info->bound;
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes = info->bytes;
    *out = made;
    return WEFT_OK;
}

static void learn(void *priv, const struct weft_candidate *planned)
{
    const struct chooser *c = priv;
    if (planned->method.algorithm == WEFT_ALGORITHM_MULTIPASS)
        weft_search_learn(c->choice->candidates, c->choice->count, planned, 0.0);
}

static void destroy(void *made)
{
    weft_method_plan *plan = made;
    weft_method_plan_destroy(&plan);
}

// ---- the choice ---------------------------------------------------------------------------------

static enum weft_result prepare(struct chooser *c)
{
    const struct weft_method usual = {.layout = WEFT_LAYOUT_INTERLEAVED};
    const struct weft_method_params params = {.method = usual, .slice = c->params->slice};
    struct weft_slice_params slice = weft_method_slice_params(&params);
    slice.layout = WEFT_LAYOUT_AUTO; // whatever fits
    enum weft_result res = weft_slice_plan_create(c->volume, &slice, &c->base);
    if (res != WEFT_OK)
        return res;
    c->slope = weft_analysis_slope(&c->base->info.kernel);
    c->samples = weft_slice_multipass_samples(c->base->footprint);
    return weft_footprint_statistics(c->base->footprint, c->params->slice.progress,
                                     &c->choice->statistics);
}

static enum weft_result search(struct chooser *c)
{
    struct weft_choice *choice = c->choice;
    const struct weft_search search = {.candidates = choice->candidates,
                                       .count = choice->count,
                                       .max_error = c->params->max_error,
                                       .quiet = &c->quiet,
                                       .priv = c,
                                       .plan = plan,
                                       .destroy = destroy,
                                       .learn = learn};
    struct weft_search_result result;
    const enum weft_result res = weft_search_run(&search, &result);
    choice->chosen = result.chosen;
    choice->best = result.best;
    choice->plan = result.plan;
    if (choice->plan)
        weft_method_plan_set_log(choice->plan, c->params->slice.log);
    choice->planned = result.planned;
    return res;
}

enum weft_result weft_choose(weft_volume *volume, const struct weft_choose_params *params,
                             struct weft_choice *out)
{
    *out = (struct weft_choice){.chosen = -1, .best = -1};
    struct chooser c = {.params = params,
                        .model = params->model ? params->model : &weft_cost_default,
                        .volume = volume,
                        .choice = out};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (!(params->max_error >= 0.0)) {
        weft_error(params->slice.log, "an error budget must be 0 or more: %g", params->max_error);
        goto fail;
    }
    weft_require(params->slice.log, params->engines < 1u << (WEFT_ENGINE_CPU + 1));
    weft_require(params->slice.log, params->threads >= 0);
    weft_quiet_log_init(&c.quiet, params->slice.log);
    res = prepare(&c);
    if (res == WEFT_OK)
        res = list_candidates(&c);
    if (res == WEFT_OK)
        res = search(&c);
fail:
    weft_slice_plan_destroy(&c.base);
    if (res != WEFT_OK)
        weft_choice_clear(out);
    return res;
}

void weft_choice_clear(struct weft_choice *choice)
{
    if (!choice)
        return;
    free(choice->candidates);
    weft_method_plan_destroy(&choice->plan);
    *choice = (struct weft_choice){.chosen = -1, .best = -1};
}

// ---- engines ------------------------------------------------------------------------------------

static double predict(const struct weft_cost_model *model, const struct weft_slice_plan *plan,
                      enum weft_engine engine, int threads)
{
    const bool planned = engine == plan->info.engine;
    const struct weft_method method = {
        .algorithm = plan->axes.separable ? WEFT_ALGORITHM_SEPARABLE : WEFT_ALGORITHM_FUSED,
        .engine = engine,
        .sums = planned ? plan->info.sums : WEFT_SUMS_FLOAT,
        .layout = planned ? plan->info.layout : WEFT_LAYOUT_INTERLEAVED,
    };
    struct weft_work work = weft_method_work(&method, plan, plan, NULL, 0.0);
    work.threads = threads;
    return weft_cost_of(model, &work);
}

enum weft_engine weft_choose_engine(const struct weft_cost_model *model,
                                    const weft_slice_plan *plan, int threads)
{
    const double gl = predict(model, plan, WEFT_ENGINE_GL, threads);
    return predict(model, plan, WEFT_ENGINE_CPU, threads) < gl ? WEFT_ENGINE_CPU : WEFT_ENGINE_GL;
}
