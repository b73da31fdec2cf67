// SPDX-License-Identifier: BSD-3-Clause
#include "passes/resample/choose.h"

#include <math.h>
#include <stdlib.h>

#include "passes/resample/resample_impl.h"

enum { MIN_SAMPLES = 16, MAX_SAMPLES = 512, SAMPLES_COUNT = 7, BITS_COUNT = 4 };
static const enum weft_technique techniques[] = {WEFT_TECHNIQUE_PLAIN, WEFT_TECHNIQUE_DOT4,
                                                 WEFT_TECHNIQUE_SPLIT_PRECISION,
                                                 WEFT_TECHNIQUE_HIERARCHICAL};
static const int unorm_bits[BITS_COUNT] = {8, 10, 12, 14};
enum { TECHNIQUE_COUNT = 4, MAX_CHOICES = TECHNIQUE_COUNT * SAMPLES_COUNT * BITS_COUNT };

struct search {
    const struct weft_resample_choose_params *params;
    struct weft_cost_model model;
    struct weft_pass_plan_params passes; // what is tried next
    struct weft_resample_choice *choice;
};

static const struct weft_resample_statistics *statistics(const struct search *s, size_t i)
{
    return &s->params->sources[i]->info.statistics;
}

static double width_of(const struct weft_resample_statistics *of)
{
    return of->high - of->low;
}

static void set_allowed_error(struct search *s)
{
    s->choice->relative = INFINITY;
    for (size_t i = 0; i < s->params->source_count; i++)
        if (width_of(statistics(s, i)) > 0.0)
            s->choice->relative =
                fmin(s->choice->relative, s->params->max_error[i] / width_of(statistics(s, i)));
}

static double predict(const struct search *s, const struct weft_pass_plan_info *plan)
{
    const weft_resample_source *source = s->params->sources[0];
    const struct weft_kernel *kernel = &plan->kernel;
    const struct weft_cost_work work = {
        .engine = WEFT_ENGINE_MULTIPASS,
        .pixels = (double)s->params->width * s->params->height,
        .samples =
            (double)weft_resample_values_along(source, 0) * weft_resample_values_along(source, 1),
        .fetches = plan->fetches,
        .target = plan->profile.target,
        .dot4 = plan->technique == WEFT_TECHNIQUE_DOT4,
        .passes = plan->passes->pass_count,
        .tile_bytes = (double)plan->tile_bytes,
        .exact_weights = kernel->unit_sum || kernel->normalised ? 0.0 : 2.0 * kernel->width,
    };
    return (double)s->params->source_count * weft_cost_of(&s->model, &work);
}

// Values that are all the same are exact.
static void set_bounds(const struct search *s, const struct weft_pass_plan_info *plan,
                       struct weft_resample_candidate *candidate)
{
    for (size_t i = 0; i < s->params->source_count; i++) {
        const struct weft_resample_statistics *of = statistics(s, i);
        if (!(width_of(of) > 0.0))
            continue;
        const double bound = weft_resample_bound_of(&plan->bound, of, 0.0).total;
        candidate->relative = fmax(candidate->relative, bound / width_of(of));
        candidate->part = fmax(candidate->part, bound / s->params->max_error[i]);
    }
}

static const struct weft_resample_candidate *best(const struct search *s)
{
    return s->choice->chosen < 0 ? NULL : &s->choice->candidates[s->choice->chosen];
}

// Adds a candidate; returns it.
static struct weft_resample_candidate *add(struct search *s, const struct weft_pass_plan_info *info)
{
    struct weft_resample_choice *choice = s->choice;
    struct weft_resample_candidate *candidate = &choice->candidates[choice->count];
    *candidate = (struct weft_resample_candidate){
        .technique = info->technique,
        .samples = info->samples,
        .bits = weft_target_bits(info->profile.target) > 0 ? info->bits : 0,
        .channels = info->channels,
        .seconds = predict(s, info),
        .bytes = info->tile_bytes,
    };
    set_bounds(s, info, candidate);
    candidate->good = candidate->part <= 1.0;
    if (choice->closest < 0 || candidate->relative < choice->candidates[choice->closest].relative)
        choice->closest = (int)choice->count;
    choice->count++;
    return candidate;
}

// *next: whether there may be a use for more samples.
static enum weft_result try_plan(struct search *s, bool *next)
{
    weft_pass_plan *plan = NULL;
    *next = true;
    const enum weft_result res = weft_pass_plan_create(&s->passes, &plan);
    if (res == WEFT_ERR_CANCELLED || res == WEFT_ERR_MEMORY)
        return res;
    if (res != WEFT_OK) // what a profile cannot do is not among the choices
        return WEFT_OK;
    const struct weft_resample_candidate *candidate = add(s, weft_pass_plan_get_info(plan));
    *next = !candidate->good;
    if (candidate->good && (!best(s) || candidate->seconds < best(s)->seconds)) {
        weft_pass_plan_destroy(&s->choice->plan);
        s->choice->plan = plan;
        s->choice->chosen = (int)s->choice->count - 1;
        return WEFT_OK;
    }
    weft_pass_plan_destroy(&plan);
    return WEFT_OK;
}

// Planning takes seconds then: only where twice the samples may do, and nothing else does.
static bool may_be_finer(const struct search *s, size_t before)
{
    const struct weft_resample_choice *choice = s->choice;
    return choice->chosen < 0 && choice->count > before &&
           choice->candidates[choice->count - 1].part <= 2.0;
}

// Finer tiles only cost more once they are fine enough.
static enum weft_result try_samples(struct search *s)
{
    const size_t before = s->choice->count;
    enum weft_result res = WEFT_OK;
    bool next = true;
    if (!s->params->any_samples)
        return try_plan(s, &next);
    for (int samples = MIN_SAMPLES; res == WEFT_OK && next && samples <= MAX_SAMPLES;
         samples *= 2) {
        s->passes.samples = samples;
        res = try_plan(s, &next);
    }
    if (res == WEFT_OK && next && may_be_finer(s, before)) {
        s->passes.samples = 2 * MAX_SAMPLES;
        res = try_plan(s, &next);
    }
    return res;
}

static enum weft_result try_bits(struct search *s)
{
    if (weft_target_bits(s->passes.profile.target) <= 0 || !s->params->any_bits)
        return try_samples(s);
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < BITS_COUNT; i++) {
        s->passes.bits = unorm_bits[i];
        res = try_samples(s);
    }
    return res;
}

static enum weft_result try_techniques(struct search *s)
{
    if (!s->params->any_technique)
        return try_bits(s);
    const bool unorm = weft_target_bits(s->passes.profile.target) > 0;
    enum weft_result res = WEFT_OK;
    for (int t = 0; res == WEFT_OK && t < TECHNIQUE_COUNT; t++) {
        s->passes.technique = techniques[t];
        const bool single = techniques[t] != WEFT_TECHNIQUE_DOT4 || s->passes.channels <= 1;
        // The others keep bits that only unorm targets lack.
        if (single && (unorm || techniques[t] <= WEFT_TECHNIQUE_DOT4))
            res = try_bits(s);
    }
    return res;
}

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

static enum weft_result search(const struct weft_resample_choose_params *params,
                               struct weft_resample_choice *out)
{
    struct search s = {.params = params,
                       .model = params->model ? *params->model : weft_cost_default,
                       .passes = params->passes,
                       .choice = out};
    if (!s.passes.kernel.info)
        weft_kernel_parse(params->log, "catmull-rom", &s.passes.kernel);
    s.passes.worst_case = WEFT_WORST_ANY;
    s.passes.log = NULL; // refusals are no errors here
    set_allowed_error(&s);
    return try_techniques(&s);
}

enum weft_result weft_resample_choose(const struct weft_resample_choose_params *params,
                                      struct weft_resample_choice *out)
{
    *out = (struct weft_resample_choice){.chosen = -1, .closest = -1};
    enum weft_result res = check(params);
    if (res == WEFT_OK && !(out->candidates = calloc(MAX_CHOICES, sizeof *out->candidates))) {
        weft_error(params->log, "out of memory for %d plans", MAX_CHOICES);
        res = WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK)
        res = search(params, out);
    if (res != WEFT_OK)
        weft_resample_choice_clear(out);
    else if (out->chosen >= 0)
        out->candidates[out->chosen].chosen = true;
    return res;
}

void weft_resample_choice_clear(struct weft_resample_choice *choice)
{
    weft_pass_plan_destroy(&choice->plan);
    free(choice->candidates);
    *choice = (struct weft_resample_choice){0};
}
