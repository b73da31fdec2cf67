// SPDX-License-Identifier: BSD-3-Clause
// Drawing and adding the frames of `weft effect`.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"

// ---- what is drawn into -------------------------------------------------------------------------

// Without frames to be drawn a context is needed to choose by alone.
static enum weft_result create_context(struct effect_job *job)
{
    const double start = report_now_seconds();
    if (job->option[ASK_EXPLAIN].given && job->how.method != WEFT_ACCUMULATE_AUTO)
        return WEFT_OK;
    const enum weft_result res = weft_context_create(
        weft_context_params(.kind = job->how.context, .log = report_log()), &job->context);
    job->seconds.context = report_now_seconds() - start;
    return res;
}

static enum weft_result create_drawings(struct effect_job *job)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < job->scene_count && res == WEFT_OK; i++) {
        struct scene_drawing_params *params =
            scene_drawing_params(.scene = &job->scene[i].scene, .context = job->context,
                                 .log = report_log());
        if (job->params.effects & EFFECT_RADIOSITY)
            params->shadow_size = 512; // of many lights, whose edges are averaged
        if (job->request.shadow_size)
            params->shadow_size = job->request.shadow_size;
        res = scene_drawing_create(params, &job->scene[i].drawing);
    }
    return res;
}

// Whether the method's targets hold floats, so that what is not finite may go through: to look for
// it in each frame takes longer than to add it, and the result shows it.
static bool takes_nonfinite(const struct accumulation *how)
{
    switch (how->method) {
    case WEFT_ACCUMULATE_TREE:
    case WEFT_ACCUMULATE_BLEND:
        return how->bits == 32;
    case WEFT_ACCUMULATE_BUFFER:
        return false;
    default:
        return true;
    }
}

// Light is linear and float but where targets are of codes.
static bool draws_floats(enum weft_accumulate_method method)
{
    return method != WEFT_ACCUMULATE_TREE && method != WEFT_ACCUMULATE_BLEND;
}

static enum weft_result create_accumulator(struct effect_job *job, const double *weights,
                                           weft_accumulator **out)
{
    const struct option_value *o = job->option;
    const bool known = !o[ASK_UNTIL].given;
    struct weft_accumulator_params params = {
        .width = job->params.size[0],
        .height = job->params.size[1],
        .channel_count = PICTURE_CHANNELS,
        .frame_count = known ? job->plan.count : 0,
        .weight = known ? weights : NULL,
        .frames_on_gl = true,
        .nonfinite = takes_nonfinite(&job->how) ? WEFT_NONFINITE_PROPAGATE : WEFT_NONFINITE_ERROR,
        .part = job->divided.is,
        .keep = o[ASK_STDERR].given || o[ASK_UNTIL].given ? WEFT_KEEP_VARIANCE : 0,
        .context = job->context,
        .log = report_log(),
    };
    accumulation_set(&job->how, &params);
    params.frame_bits = draws_floats(params.method) ? 32 : 0;
    params.emulate |= !job->context;
    if (!(params.low < params.high))
        params.high = takes_nonfinite(&job->how) ? job->brightest : 1.0;
    job->low = params.low;
    job->high = params.high;
    return weft_accumulator_create(&params, out);
}

enum weft_result effect_job_create(struct effect_job *job, weft_accumulator **out)
{
    double *weights = malloc((size_t)job->plan.count * sizeof *weights);
    if (!weights) {
        report_error("out of memory for %lld weights", (long long)job->plan.count);
        return WEFT_ERR_MEMORY;
    }
    effect_plan_get_weights(&job->plan, weights);
    const enum weft_result res = create_accumulator(job, weights, out);
    free(weights);
    return res;
}

void effect_job_check_range(const struct effect_job *job)
{
    const struct weft_accumulator_report *r = &job->report;
    const bool codes = r->bits == 8 || r->bits == 16;
    double most = codes ? job->brightest : -HUGE_VAL;
    for (int c = 0; c < 3; c++)
        most = fmax(most, job->statistics[c].maximum);
    if (r->method == WEFT_ACCUMULATE_EXACT || !(most > job->high))
        return;
    if (codes)
        report_warning("targets of %d bits hold light from %g to %g, and there is light of %.3g: "
                       "it is cut off in each frame (--source-range 0,%.3g)",
                       r->bits, job->low, job->high, most, most);
    else
        report_warning("the bound %.3g is of light up to %g, and there is light of %.3g: there it "
                       "is larger by as much",
                       r->bound, job->high, most);
}

enum weft_result effect_job_check_bound(struct effect_job *job, double bound)
{
    const enum weft_result res = accumulation_check_bound(&job->how, job->planned.method, bound);
    job->over_budget |= res != WEFT_OK;
    return res;
}

static enum weft_result begin_adding(struct effect_job *job)
{
    const enum weft_result res = effect_job_create(job, &job->accumulator);
    if (res != WEFT_OK) {
        job->over_budget = res == WEFT_ERR_UNSUPPORTED && job->how.max_error > 0.0 &&
                           job->how.method == WEFT_ACCUMULATE_AUTO;
        return res;
    }
    weft_accumulator_get_report(job->accumulator, &job->planned);
    // It is looked at again once the frames are known.
    return isfinite(job->planned.bound) ? effect_job_check_bound(job, job->planned.bound) : WEFT_OK;
}

// Negative weights are a filter's, or a fade's.
static enum weft_result check_weights(const struct effect_job *job)
{
    const enum weft_accumulate_method method = job->how.method;
    if (!(job->plan.weights.negative > 0.0) ||
        (method != WEFT_ACCUMULATE_TREE && method != WEFT_ACCUMULATE_BLEND))
        return WEFT_OK;
    report_error("--method %s takes no negative weights, and %.3g %% of these are: exact, buffer "
                 "and float do",
                 weft_accumulate_method_names[method], 100.0 * job->plan.weights.negative);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result effect_job_begin(struct effect_job *job)
{
    const struct option_value *branching = &job->option[ASK_ADDING + ACCUMULATION_BRANCHING];
    enum weft_result res = check_weights(job);
    if (res == WEFT_OK)
        res = accumulation_check_branching(&job->how, branching->text, job->plan.count);
    if (res == WEFT_OK)
        res = create_context(job);
    const double start = report_now_seconds();
    if (res == WEFT_OK)
        res = begin_adding(job);
    if (res == WEFT_OK && !job->option[ASK_EXPLAIN].given)
        res = create_drawings(job);
    job->seconds.prepare = report_now_seconds() - start;
    return res;
}

// ---- frames -------------------------------------------------------------------------------------

enum weft_result effect_job_draw_range(struct effect_job *job, int64_t first, int64_t count,
                                       const struct weft_progress *progress)
{
    scene_drawing *drawing[EFFECT_MAX_SCENES];
    for (int i = 0; i < job->scene_count; i++)
        drawing[i] = job->scene[i].drawing;
    const double start = report_now_seconds();
    const enum weft_result res = effect_run(
        effect_run_params(.plan = &job->plan, .drawing = drawing, .accumulator = job->accumulator,
                          .first = first, .count = count, .progress = progress),
        NULL);
    job->seconds.draw += report_now_seconds() - start;
    return res;
}

int64_t effect_job_next_end(const struct effect_job *job)
{
    const int64_t next = accumulation_next_judged(&job->how.until, job->judged);
    return job->option[ASK_UNTIL].given && next < job->plan.count ? next : job->plan.count;
}

enum weft_result effect_job_judge(struct effect_job *job)
{
    const double start = report_now_seconds();
    if (!job->option[ASK_UNTIL].given ||
        job->added < accumulation_next_judged(&job->how.until, job->judged))
        return WEFT_OK;
    const enum weft_result res =
        weft_accumulator_judge(job->accumulator, &job->how.until, &job->convergence);
    job->judged = job->added;
    job->stopped = res == WEFT_OK && job->convergence.enough && job->added < job->plan.count;
    job->seconds.judge += report_now_seconds() - start;
    return res;
}

// Of all frames, where a range of them is drawn. False once an interrupt has come.
struct range {
    int64_t first, count, all;
    const struct weft_progress *progress;
};

static bool report_range(void *priv, double fraction)
{
    const struct range *r = priv;
    const double done = (double)r->first + fraction * (double)r->count;
    return r->progress->report(r->progress->priv, done / (double)r->all);
}

enum weft_result effect_job_draw(struct effect_job *job)
{
    enum weft_result res = WEFT_OK;
    char doing[64];
    snprintf(doing, sizeof doing, "drawing %lld frames", (long long)job->plan.count);
    while (res == WEFT_OK && !job->stopped && job->added < job->plan.count) {
        const int64_t count = effect_job_next_end(job) - job->added;
        struct range range = {job->added, count, job->plan.count, report_progress(doing)};
        const struct weft_progress progress = {report_range, &range};
        res = effect_job_draw_range(job, job->added, count, &progress);
        job->added += res == WEFT_OK ? count : 0;
        if (res == WEFT_OK)
            res = effect_job_judge(job);
    }
    report_erase_progress();
    for (int i = job->scene_count - 1; i >= 0 && res == WEFT_OK; i--)
        if (job->scene[i].drawing)
            scene_drawing_get_shadow(job->scene[i].drawing, &job->shadow);
    return res;
}
