// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slice/budget.h"

#include <math.h>
#include <stdio.h>

#include "tools/methods/candidates.h"
#include "tools/common/report.h"
#include "tools/ranks/ranks.h"
#include "tools/slice/stages.h"

static enum weft_result report_none(struct slice_job *job)
{
    const struct weft_choice *choice = &job->choice;
    const double rounding = weft_slice_plan_get_info(job->plan)->output[0].bound.absolute_rounding;
    char rounded[80] = "";
    if (rounding > 0.0)
        snprintf(rounded, sizeof rounded, ", %.3g of it by integers that no float holds", rounding);
    job->over_budget = true;
    if (choice->best < 0)
        report_error("no method of making this slice applies");
    else
        report_error("no method is within %.3g: the best is %s, within %.3g%s (voxels from %.6g to "
                     "%.6g)",
                     job->max_error, choice->candidates[choice->best].name,
                     choice->candidates[choice->best].bound, rounded, choice->statistics.voxel_low,
                     choice->statistics.voxel_high);
    return WEFT_ERR_LIMIT;
}

static enum weft_result choose(struct slice_job *job, const struct weft_profile *profile)
{
    const struct engine *engine = &job->setup->engine;
    struct weft_choose_params params = {
        .slice = job->slice_params,
        .max_error = job->max_error,
        .engines = engine_candidates(engine, job->setup->context),
        .threads = engine->cpu.threads,
        .profile = profile,
        .model = &engine->model,
    };
    params.slice.footprint = weft_slice_plan_get_footprint(job->plan); // it is measured
    enum weft_result res = weft_choose(job->volume, &params, &job->choice);
    if (res == WEFT_OK && job->choice.chosen < 0 &&
        engine_has_more_candidates(engine, &params.engines)) {
        weft_choice_clear(&job->choice);
        res = weft_choose(job->volume, &params, &job->choice);
    }
    if (res != WEFT_OK)
        return res;
    // What was considered is told even where nothing meets the budget.
    if (job->choice.chosen < 0 && job->setup->option[SLICE_EXPLAIN].given)
        slice_budget_print(job);
    if (job->choice.chosen < 0)
        return report_none(job);
    job->plan = weft_method_plan_get_slice(job->choice.plan);
    job->passes = weft_method_plan_get_passes(job->choice.plan);
    job->hardware = weft_method_plan_get_info(job->choice.plan)->hardware;
    return WEFT_OK;
}

enum weft_result slice_choose(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    const struct option_value *profile_text = &o[SLICE_PASSES + PASS_PROFILE];
    struct weft_profile profile;
    struct budget budget;
    if (!o[SLICE_MAX_ERROR].given)
        return WEFT_OK;
    const double start = report_now_seconds();
    enum weft_result res = budget_parse(o[SLICE_MAX_ERROR].text, &budget);
    if (res == WEFT_OK && profile_text->given)
        res = weft_profile_parse(report_log(), profile_text->text, &profile);
    res =
        slice_measure(job, res, weft_slice_plan_get_footprint(job->plan), &job->choice.statistics);
    // The others are told what rank 0 chooses.
    if (res != WEFT_OK || !(ranks_tells() || job->setup->divided.frames))
        return res;
    engine_load_costs(&job->setup->engine, job->setup->context);
    job->max_error =
        budget_error(&budget, job->choice.statistics.voxel_low, job->choice.statistics.voxel_high);
    res = choose(job, profile_text->given ? &profile : NULL);
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

// ---- what was considered ------------------------------------------------------------------------

json_t *slice_budget_json(const struct slice_job *job)
{
    const struct weft_method_plan_info *method = weft_method_plan_get_info(job->choice.plan);
    json_t *candidates = json_array();
    char model[ENGINE_TEXT];
    for (size_t i = 0; i < job->choice.count; i++)
        json_array_append_new(candidates, candidate_json(&job->choice.candidates[i]));
    return json_pack("{s:o,s:s,s:o,s:o,s:o,s:o,s:o,s:o}", "max_error", json_number(job->max_error),
                     "method", method->name, "bound", json_number(method->bound), "e1",
                     json_number(method->e1), "low", json_number(job->choice.statistics.voxel_low),
                     "high", json_number(job->choice.statistics.voxel_high), "cost_model",
                     json_text(engine_model_name(&job->setup->engine, model)), "candidates",
                     candidates);
}

// The methods that would have been faster, by what kept them out.
static void print_reason(const struct slice_job *job)
{
    const struct weft_choice *choice = &job->choice;
    const struct weft_candidate *chosen = &choice->candidates[choice->chosen];
    const struct weft_method_plan_info *method = weft_method_plan_get_info(choice->plan);
    printf("%s: of the %zu methods the fastest whose bound is within the budget; %d are predicted "
           "to be faster and exceed it\n",
           chosen->name, choice->count, choice->chosen);
    if (method->slice->savings & WEFT_SAVING_SMOOTH)
        printf("its own bound is %.3g; smooth pieces may take the rest\n", chosen->bound);
    printf("E1 of the kernel, beside the budget: about %.3g\n", method->e1);
}

void slice_budget_print(const struct slice_job *job)
{
    const struct weft_choice *choice = &job->choice;
    char model[ENGINE_TEXT];
    printf("budget %.3g for voxels from %.6g to %.6g; times predicted by the cost model of %s\n",
           job->max_error, choice->statistics.voxel_low, choice->statistics.voxel_high,
           engine_model_name(&job->setup->engine, model));
    candidates_print(choice->candidates, choice->count, "bound");
    if (choice->chosen >= 0)
        print_reason(job);
}
