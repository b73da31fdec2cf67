// SPDX-License-Identifier: BSD-3-Clause
// The pixels of a slice: the run, the check.
#include "tools/slice/stages.h"

#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"

// What both kinds of run tell, and the plan's bound for what it was run on, which for prefiltered
// kernels are the voxels themselves, too.
static enum weft_result set_passes_report(struct slice_job *job)
{
    const struct weft_slice_report *r = &job->report;
    struct weft_slice_statistics statistics = job->choice.statistics;
    const bool measured = job->choice.plan || job->setup->kernel.prefiltered;
    enum weft_result res = WEFT_OK;
    if (!job->choice.plan && job->setup->kernel.prefiltered)
        res = weft_footprint_statistics(weft_slice_plan_get_footprint(job->plan),
                                        report_progress("measuring"), &statistics);
    const struct weft_bound_terms terms = weft_slice_multipass_bound_terms(job->plan, job->passes);
    const struct weft_bound_values values = {
        .low = r->low,
        .high = r->high,
        .sample_low = measured ? statistics.voxel_low : r->low,
        .sample_high = measured ? statistics.voxel_high : r->high,
        .beyond = statistics.beyond,
        .result = fmax(0.0, fmax(-r->minimum, r->maximum)), // both are NAN if none is finite
    };
    job->bound = weft_bound_compute(&terms, &values);
    return res;
}

enum weft_result slice_run_method(const struct slice_job *job, const weft_method_plan *plan,
                                  float *pixels, const struct weft_progress *progress,
                                  struct weft_slice_report *out)
{
    struct weft_method_report report;
    const enum weft_result res = weft_method_run(
        plan,
        weft_method_run_params(.context = job->setup->context, .cpu = job->setup->engine.cpu,
                               .pixels = pixels, .progress = progress),
        &report);
    *out = report.slice;
    return res;
}

enum weft_result slice_run_plan(const struct slice_job *job, const weft_slice_plan *plan,
                                const weft_hardware_plan *hardware, float *pixels,
                                const struct weft_progress *progress, struct weft_slice_report *out)
{
    const struct option_value *range = &job->setup->option[SLICE_PASSES + PASS_SOURCE_RANGE];
    const struct weft_slice_passes passes = {
        .plan = job->passes,
        .low = range->given ? range->number[0] : NAN,
        .high = range->given ? range->number[1] : NAN,
        .memory_bytes = (uint64_t)job->setup->option[SLICE_MEMORY].integer[0],
        .log = report_log(),
    };
    return weft_slice_run_once(
        plan,
        weft_slice_compile_params(.context = job->setup->context, .cpu = job->setup->engine.cpu,
                                  .passes = job->passes ? &passes : NULL, .hardware = hardware),
        weft_slice_run_params(.pixels = pixels, .progress = progress), out);
}

// Where no float holds the values, nothing is left to be shown.
static enum weft_result check_values(struct slice_job *job)
{
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    const struct weft_slice_geometry *g = &weft_slice_plan_get_info(job->plan)->geometry;
    if (!info->values_infinite || job->report.not_finite < (uint64_t)g->width * (uint64_t)g->height)
        return WEFT_OK;
    report_error("%s: no pixel is finite: %llu values of grid '%s' are beyond the range of floats "
                 "(3.4e38)",
                 job->input, (unsigned long long)info->values_infinite, info->name);
    return WEFT_ERR_UNSUPPORTED;
}

static size_t plane_size(const struct slice_job *job)
{
    return (size_t)job->geometry.width * (size_t)job->geometry.height;
}

// Channels of a slab are made of each cut, before they are combined.
static enum weft_result run_slab(struct slice_job *job, const struct weft_progress *progress)
{
    const struct weft_slab_params params = slice_slab_params(job);
    const enum weft_result res = weft_slab_run(
        &params,
        weft_slice_compile_params(.context = params.slice.engine == WEFT_ENGINE_GL
                                                 ? job->setup->context
                                                 : NULL,
                                  .cpu = job->setup->engine.cpu),
        weft_slice_run_params(.pixels = slice_channel_planes(job), .progress = progress),
        &job->report);
    return res == WEFT_OK ? slice_finish_run(job) : res;
}

enum weft_result slice_run(struct slice_job *job)
{
    const struct weft_progress *progress = report_progress("slicing");
    if (job->slab.cuts)
        return run_slab(job, progress);
    float *planes = slice_planes(job) + (size_t)job->run * plane_size(job);
    const enum weft_result res =
        job->choice.plan
            ? slice_run_method(job, job->choice.plan, planes, progress, &job->report)
            : slice_run_plan(job, job->plan, job->own_hardware, planes, progress, &job->report);
    return res == WEFT_OK ? slice_finish_run(job) : res;
}

enum weft_result slice_finish_run(struct slice_job *job)
{
    enum weft_result res = WEFT_OK;
    job->made = true;
    job->by_passes = job->passes != NULL;
    if (job->passes)
        res = set_passes_report(job);
    return res == WEFT_OK ? check_values(job) : res;
}

// The part of the grid's integers that floats lack, so that they are verified as they are stored.
static enum weft_result open_rest(struct slice_job *job)
{
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    const struct weft_volume_open_params params = {.path = job->input,
                                                   .grid = info->name,
                                                   .raw = job->setup->raw,
                                                   .component = info->component,
                                                   .rest = true,
                                                   .log = report_log()};
    return info->values_rounded && !job->source->rest
               ? weft_volume_open(&params, &job->source->rest)
               : WEFT_OK;
}

// By the plan; NAN where voxels outside --source-range were clamped.
static double error_bound(const struct slice_job *job)
{
    const bool ranged = job->setup->option[SLICE_PASSES + PASS_SOURCE_RANGE].given;
    if (!job->passes)
        return ranged ? NAN : job->error.bound;
    return ranged && job->report.clamped ? NAN : job->bound.total;
}

enum weft_result slice_verify_plan(struct slice_job *job, const weft_slice_plan *plan,
                                   const float *pixels, const struct weft_progress *progress,
                                   struct weft_verify_report *out)
{
    struct error_image_part part = {.image = &job->errors};
    const bool all = job->errors.plane != NULL;
    const enum weft_result res = open_rest(job);
    return res == WEFT_OK
               ? weft_slice_verify(plan, pixels,
                                   weft_slice_verify_params(.rest = job->source->rest,
                                                            .progress = progress,
                                                            .max_seconds = all ? INFINITY : 0.0,
                                                            .tell = all ? error_image_tell : NULL,
                                                            .tell_priv = &part),
                                   out)
               : res;
}

// A plan of passes has one derivative, of which the plan of the slice knows nothing.
static enum weft_result plan_derivative(const struct slice_job *job, weft_slice_plan **out)
{
    struct weft_slice_params params = job->slice_params;
    params.engine = WEFT_ENGINE_CPU;
    params.layout = WEFT_LAYOUT_AUTO;
    params.source = WEFT_SOURCE_FLOAT;
    params.footprint = weft_slice_plan_get_footprint(job->plan);
    params.derivative = &job->setup->quantities.derivative[job->run];
    params.derivative_count = 1;
    return weft_slice_plan_create(job->volume, &params, out);
}

static enum weft_result verify_outputs(struct slice_job *job, struct weft_verify_report *out)
{
    const struct weft_progress *progress = report_progress("verifying");
    const float *planes = slice_planes(job) + (size_t)job->run * plane_size(job);
    weft_slice_plan *own = NULL;
    enum weft_result res = WEFT_OK;
    if (job->setup->option[SLICE_ERROR_IMAGE].given)
        res = error_image_create(job->geometry.width, job->geometry.height, 1, &job->errors);
    if (res == WEFT_OK && job->passes && job->derived)
        res = plan_derivative(job, &own);
    if (res == WEFT_OK)
        res = slice_verify_plan(job, own ? own : job->plan, planes, progress, out);
    weft_slice_plan_destroy(&own);
    return res;
}

// How near an error comes to its bound.
static double share_of(const struct weft_verify_report *error, double bound)
{
    return error->not_finite_mismatches ? INFINITY : error->maximum / fmax(bound, 0x1p-1000);
}

// Of what was verified so far the one that is told by itself.
static void take_worst(struct slice_job *job, const struct weft_verify_report *error)
{
    const struct weft_verify_report before = job->error;
    const double bound = job->error_bound;
    job->error = *error;
    job->error_bound = error_bound(job);
    if (job->verified++ && !(share_of(error, job->error_bound) > share_of(&before, bound))) {
        job->error = before;
        job->error_bound = bound;
    }
}

enum weft_result slice_verify(struct slice_job *job)
{
    struct weft_verify_report errors[WEFT_DERIVATIVES];
    const int count = job->passes ? 1 : weft_slice_plan_get_info(job->plan)->output_count;
    if (!job->setup->option[SLICE_VERIFY].given)
        return WEFT_OK;
    const double start = report_now_seconds();
    enum weft_result res = verify_outputs(job, errors);
    if (res == WEFT_OK && slice_is_plain(job->setup)) {
        job->error = errors[0];
        res = slice_finish_verify(job);
    }
    for (int i = 0; i < count && res == WEFT_OK && !slice_is_plain(job->setup); i++) {
        take_worst(job, &errors[i]);
        job->output_error[job->run + i] = errors[i];
        job->output_bound[job->run + i] = job->passes ? job->bound.total : errors[i].bound;
    }
    job->verify_seconds += report_now_seconds() - start;
    return res;
}

enum weft_result slice_finish_verify(struct slice_job *job)
{
    const enum weft_result res = slice_bound_hardware(job);
    job->error_bound = error_bound(job);
    return res;
}

// Passes compute one derivative after another; others all at once.
enum weft_result slice_compute(struct slice_job *job)
{
    const int runs = job->passes && job->derived ? job->setup->quantities.derivative_count : 1;
    enum weft_result res = WEFT_OK;
    for (job->run = 0; job->run < runs && res == WEFT_OK; job->run++) {
        if (runs > 1)
            job->passes = job->setup->passes[job->run];
        res = slice_run(job);
        if (res == WEFT_OK)
            res = slice_verify(job);
        if (job->runs++)
            weft_slice_report_add(&job->total, &job->report);
        else
            job->total = job->report;
    }
    job->report = job->total;
    if (res == WEFT_OK)
        res = slice_make_channels(job);
    if (res == WEFT_OK && job->verified)
        slice_bound_channels(job, job->output_bound);
    return res;
}
