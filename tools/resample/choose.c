// SPDX-License-Identifier: BSD-3-Clause
// The cheapest passes of `weft resample` within --max-error: techniques, samples and bits of tiles
// are tried, bounds are the plans' own, and costs those that weft calibrate measured.
#include <math.h>
#include <stdlib.h>

#include "tools/common/cost_file.h"
#include "tools/common/report.h"
#include "tools/resample/job.h"

enum { MIN_SAMPLES = 16, MAX_SAMPLES = 512, SAMPLES_COUNT = 7, BITS_COUNT = 4 };
static const enum weft_technique techniques[] = {WEFT_TECHNIQUE_PLAIN, WEFT_TECHNIQUE_DOT4,
                                                 WEFT_TECHNIQUE_SPLIT_PRECISION,
                                                 WEFT_TECHNIQUE_HIERARCHICAL};
static const int unorm_bits[BITS_COUNT] = {8, 10, 12, 14};
enum { TECHNIQUE_COUNT = 4, MAX_CHOICES = TECHNIQUE_COUNT * SAMPLES_COUNT * BITS_COUNT };

struct search {
    struct resample_job *job;
    int channels;
    double relative; // the error allowed, to the range's width
    struct weft_cost_model model;
    struct weft_pass_plan_params params;
    weft_pass_plan *best;
    struct resample_choice *best_choice, *closest; // in the job's list
};

static const struct option_value *plan_option(const struct search *s, enum resample_plan_option o)
{
    return &s->job->option[RESAMPLE_PLAN + o];
}

static bool shares(const struct search *s, const struct resample_group *group)
{
    return group->count == s->channels && group->high > group->low;
}

// Least of the groups that share a plan.
static void set_allowed_error(struct search *s)
{
    s->relative = INFINITY;
    for (size_t i = 0; i < s->job->group_count; i++) {
        const struct resample_group *g = &s->job->group[i];
        if (shares(s, g))
            s->relative = fmin(s->relative, g->max_error / (g->high - g->low));
    }
}

static double predict(const struct search *s, const struct weft_pass_plan_info *plan)
{
    const struct resample_job *job = s->job;
    const struct weft_kernel *kernel = &plan->kernel;
    const struct weft_cost_work work = {
        .engine = WEFT_ENGINE_MULTIPASS,
        .pixels = (double)job->result.width * job->result.height,
        .samples = (double)(job->image.width + 2 * job->pad) * (job->image.height + 2 * job->pad),
        .fetches = plan->fetches,
        .target = plan->profile.target,
        .dot4 = plan->technique == WEFT_TECHNIQUE_DOT4,
        .passes = plan->passes->pass_count,
        .tile_bytes = (double)plan->tile_bytes,
        .exact_weights = kernel->unit_sum || kernel->normalised ? 0.0 : 2.0 * kernel->width,
    };
    double groups = 0.0;
    for (size_t g = 0; g < job->group_count; g++)
        groups += job->group[g].count == s->channels;
    return groups * weft_cost_of(&s->model, &work);
}

// Of the groups that share the plan: the largest bound, to the width of the range that is read, and
// the largest part of a group's budget that its bound takes. Values that are all the same are
// exact.
static void set_bounds(const struct search *s, const struct weft_pass_plan_info *plan,
                       struct resample_choice *choice)
{
    for (size_t i = 0; i < s->job->group_count; i++) {
        const struct resample_group *g = &s->job->group[i];
        if (!shares(s, g))
            continue;
        const double bound = resample_bound_of(plan, g, 0.0).total;
        choice->relative = fmax(choice->relative, bound / (g->high - g->low));
        choice->part = fmax(choice->part, bound / g->max_error);
    }
}

// *next: whether there may be a use for more samples.
static enum weft_result try_plan(struct search *s, bool *next)
{
    weft_pass_plan *plan = NULL;
    *next = true;
    enum weft_result res = weft_pass_plan_create(&s->params, &plan);
    if (res == WEFT_ERR_CANCELLED || res == WEFT_ERR_MEMORY)
        return res;
    if (res != WEFT_OK) // what a profile cannot do is not among the choices
        return WEFT_OK;
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    struct resample_choice *choice = &s->job->choices[s->job->choice_count++];
    *choice = (struct resample_choice){
        .technique = info->technique,
        .samples = info->samples,
        .bits = weft_target_bits(info->profile.target) > 0 ? info->bits : 0,
        .channels = s->channels,
        .seconds = predict(s, info),
        .bytes = info->tile_bytes,
    };
    set_bounds(s, info, choice);
    choice->good = choice->part <= 1.0;
    *next = !choice->good;
    if (!s->closest || choice->relative < s->closest->relative)
        s->closest = choice;
    if (choice->good && (!s->best || choice->seconds < s->best_choice->seconds)) {
        weft_pass_plan_destroy(&s->best);
        s->best = plan;
        s->best_choice = choice;
        return WEFT_OK;
    }
    weft_pass_plan_destroy(&plan);
    return WEFT_OK;
}

// Planning takes seconds then: only where twice the samples may do, and nothing else does.
static bool may_be_finer(const struct search *s, size_t before)
{
    const struct resample_job *job = s->job;
    return !s->best && job->choice_count > before &&
           job->choices[job->choice_count - 1].part <= 2.0;
}

// Finer tiles only cost more once they are fine enough.
static enum weft_result try_samples(struct search *s)
{
    const bool given = plan_option(s, RESAMPLE_PLAN_RESOLUTION)->given;
    const int first = given ? s->params.samples : MIN_SAMPLES;
    const int last = given ? first : MAX_SAMPLES;
    const size_t before = s->job->choice_count;
    enum weft_result res = WEFT_OK;
    bool next = true;
    for (int samples = first; res == WEFT_OK && next && samples <= last; samples *= 2) {
        s->params.samples = samples;
        res = try_plan(s, &next);
    }
    if (res == WEFT_OK && next && !given && may_be_finer(s, before)) {
        s->params.samples = 2 * MAX_SAMPLES;
        res = try_plan(s, &next);
    }
    s->params.samples = first;
    return res;
}

static enum weft_result try_bits(struct search *s)
{
    const bool unorm = weft_target_bits(s->params.profile.target) > 0;
    if (!unorm || plan_option(s, RESAMPLE_PLAN_BITS)->given)
        return try_samples(s);
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < BITS_COUNT; i++) {
        s->params.bits = unorm_bits[i];
        res = try_samples(s);
    }
    return res;
}

static enum weft_result try_techniques(struct search *s)
{
    if (plan_option(s, RESAMPLE_PLAN_TECHNIQUE)->given)
        return try_bits(s);
    const bool unorm = weft_target_bits(s->params.profile.target) > 0;
    enum weft_result res = WEFT_OK;
    for (int t = 0; res == WEFT_OK && t < TECHNIQUE_COUNT; t++) {
        s->params.technique = techniques[t];
        const bool single = techniques[t] != WEFT_TECHNIQUE_DOT4 || s->channels == 1;
        // The others keep bits that only unorm targets lack.
        if (single && (unorm || techniques[t] <= WEFT_TECHNIQUE_DOT4))
            res = try_bits(s);
    }
    return res;
}

// Says what the best would be.
static enum weft_result refuse(const struct search *s)
{
    const char *wanted = s->job->option[RESAMPLE_MAX_ERROR].text;
    s->job->over_budget = true;
    if (s->closest)
        report_error("no passes of profile %s are within --max-error %s, %.3g of the range: the "
                     "best bound is %.3g of it (%s, %d samples, %d bits)",
                     s->params.profile.name, wanted, s->relative, s->closest->relative,
                     weft_technique_names[s->closest->technique], s->closest->samples,
                     s->closest->bits);
    else
        report_error("profile %s has no passes for this kernel, within --max-error %s or not",
                     s->params.profile.name, wanted);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result choose(struct search *s, weft_pass_plan **out)
{
    set_allowed_error(s);
    enum weft_result res =
        resample_plan_params(&s->job->option[RESAMPLE_PLAN], RESAMPLE_DEFAULT_PROFILE,
                             &s->job->kernel, 2, s->channels, &s->params);
    if (res != WEFT_OK)
        return res;
    s->params.worst_case = WEFT_WORST_ANY;
    s->params.log = NULL; // refusals are no errors here
    res = try_techniques(s);
    if (res == WEFT_OK && !s->best)
        res = refuse(s);
    if (res != WEFT_OK) {
        weft_pass_plan_destroy(&s->best);
        return res;
    }
    s->best_choice->chosen = true;
    *out = s->best;
    return res;
}

static void load_costs(const struct resample_job *job, struct weft_cost_model *model)
{
    *model = weft_cost_default;
    if (job->context)
        cost_file_load(weft_context_get_info(job->context)->renderer, model, NULL);
}

enum weft_result resample_choose_plans(struct resample_job *job)
{
    bool wanted[2] = {false, false};
    enum weft_result res = WEFT_OK;
    for (size_t g = 0; g < job->group_count; g++)
        wanted[job->group[g].count > 1] = true;
    job->choices = calloc(2 * MAX_CHOICES, sizeof *job->choices);
    if (!job->choices) {
        report_error("out of memory for %d plans", 2 * MAX_CHOICES);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; res == WEFT_OK && i < 2; i++) {
        struct search search = {.job = job,
                                .channels = i ? RESAMPLE_MAX_TOGETHER : 1,
                                .params = *weft_pass_plan_params()};
        load_costs(job, &search.model);
        if (wanted[i])
            res = choose(&search, i ? &job->together : &job->single);
    }
    return res;
}
