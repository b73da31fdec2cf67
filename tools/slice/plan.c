// SPDX-License-Identifier: BSD-3-Clause
// A slice as it is planned without --max-error, which chooses from there on.
#include "tools/slice/stages.h"

#include "tools/common/report.h"

// A source that is not float needs the voxels' range before it is planned.
static enum weft_result find_range(struct slice_job *job, struct weft_slice_params *params)
{
    const struct option_value *range = &job->setup->option[SLICE_PASSES + PASS_SOURCE_RANGE];
    struct weft_slice_params plain = *params;
    weft_slice_plan *plan = NULL;
    if (params->source == WEFT_SOURCE_FLOAT)
        return WEFT_OK;
    if (range->given) {
        params->low = range->number[0];
        params->high = range->number[1];
        return WEFT_OK;
    }
    plain.source = WEFT_SOURCE_FLOAT;
    enum weft_result res = weft_slice_plan_create(job->volume, &plain, &plan);
    struct weft_slice_statistics statistics = {0};
    res = slice_measure(job, res, plan ? weft_slice_plan_get_footprint(plan) : NULL, &statistics);
    weft_slice_plan_destroy(&plan);
    params->low = statistics.low;
    params->high = statistics.high > statistics.low ? statistics.high : statistics.low + 1.0;
    return res;
}

// What is resident leaves a quarter.
static uint64_t plan_memory(const struct slice_setup *setup)
{
    return setup->resident ? slice_memory(setup) / 4 : slice_memory(setup);
}

enum weft_result slice_plan_anew(struct slice_job *job)
{
    struct weft_slice_params *params = &job->slice_params;
    weft_slice_plan *plan = NULL;
    if (params->engine == job->setup->engine.engine && params->resident == job->setup->resident)
        return WEFT_OK;
    const double start = report_now_seconds();
    params->engine = job->setup->engine.engine;
    params->resident = job->setup->resident;
    params->memory_bytes = plan_memory(job->setup);
    params->footprint = weft_slice_plan_get_footprint(job->own_plan);
    const enum weft_result res = weft_slice_plan_create(job->volume, params, &plan);
    params->footprint = NULL;
    weft_slice_plan_destroy(&job->own_plan);
    job->plan = job->own_plan = plan;
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

static enum weft_result make_plan(struct slice_job *job)
{
    double start = report_now_seconds();
    const struct option_value *o = job->setup->option;
    struct weft_slice_params *params = &job->slice_params;
    *params = (struct weft_slice_params){
        .engine = job->setup->engine.engine,
        .sums = job->setup->engine.sums,
        .kernel = job->setup->kernel,
        .space = (enum weft_space)o[SLICE_SPACE].integer[0],
        .geometry = job->geometry,
        .layout = (enum weft_layout)o[SLICE_LAYOUT].integer[0],
        .source = (enum weft_source_format)o[SLICE_SOURCE].integer[0],
        .lookup = (enum weft_lookup)o[SLICE_LOOKUP].integer[0],
        .samples = (int)o[SLICE_PASSES + PASS_RESOLUTION].number[0],
        .clamp_to_samples = o[SLICE_CLAMP].given,
        .without = job->setup->without,
        .may_miss = o[SLICE_SLAB].given && !o[SLICE_EXPLAIN].given,
        .resident = job->setup->resident,
        .memory_bytes = plan_memory(job->setup),
        .progress = report_progress("planning"),
        .log = report_log(),
    };
    const struct weft_quantities *quantities = &job->setup->quantities;
    // Passes are of one derivative each.
    if (job->derived_count && !o[SLICE_PASSES + PASS_PROFILE].given) {
        params->derivative = quantities->derivative;
        params->derivative_count = quantities->derivative_count;
    }
    // Passes, and textures, take every tap's voxels, whatever its weight.
    if (o[SLICE_PASSES + PASS_PROFILE].given || o[SLICE_HARDWARE].given)
        params->without |= WEFT_SAVING_AXIS;
    if (o[SLICE_HARDWARE].given)
        params->layout = WEFT_LAYOUT_PLAIN; // of voxels one by one
    enum weft_result res = find_range(job, params);
    if (res == WEFT_OK)
        res = weft_slice_plan_create(job->volume, params, &job->own_plan);
    job->plan = job->own_plan;
    params->may_miss = true; // that is told once
    if (res == WEFT_OK && !o[SLICE_MAX_ERROR].given) {
        engine_prefer(&job->setup->engine, job->plan);
        res = slice_plan_anew(job);
    }
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

// A plan of passes of the value, or of a derivative.
static enum weft_result plan_output(const struct slice_job *job, const struct weft_kernel *kernel,
                                    int index, weft_pass_plan **out)
{
    const struct option_value *o = &job->setup->option[SLICE_PASSES];
    struct weft_pass_plan_params params = *weft_pass_plan_params();
    const enum weft_result res = pass_plan_params(o, NULL, kernel, 3, 1, &params);
    if (job->derived_count)
        params.derivative = job->setup->quantities.derivative[index];
    return res == WEFT_OK ? weft_pass_plan_create(&params, out) : res;
}

// Passes depend on the kernel and not on the plane.
static enum weft_result plan_passes(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const struct option_value *o = setup->option;
    if (!o[SLICE_PASSES + PASS_PROFILE].given || o[SLICE_MAX_ERROR].given)
        return WEFT_OK;
    const double start = report_now_seconds();
    const struct weft_kernel *kernel = &weft_slice_plan_get_info(job->plan)->kernel;
    enum weft_result res = WEFT_OK;
    const int count = job->derived_count ? job->derived_count : 1;
    for (int i = 0; i < count && res == WEFT_OK; i++)
        if (!setup->passes[i])
            res = plan_output(job, kernel, i, &setup->passes[i]);
    job->passes = setup->passes[0];
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

enum weft_result slice_plan(struct slice_job *job)
{
    enum weft_result res = make_plan(job);
    if (res == WEFT_OK)
        res = plan_passes(job);
    return res == WEFT_OK ? slice_place_slab(job) : res;
}
