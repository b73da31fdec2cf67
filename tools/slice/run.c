// SPDX-License-Identifier: BSD-3-Clause
// The pixels of a slice: the run, the check.
#include "tools/slice/stages.h"

#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"

enum weft_result slice_allocate(struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    if (job->setup->option[SLICE_EXPLAIN].given)
        return WEFT_OK;
    size_t bytes = (size_t)g->width * (size_t)g->height * sizeof *job->pixels;
    job->pixels = malloc(bytes);
    if (!job->pixels) {
        report_error("out of memory: %zu bytes for %d x %d pixels", bytes, g->width, g->height);
        return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

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

enum weft_result slice_run(struct slice_job *job)
{
    const struct weft_progress *progress = report_progress("slicing");
    const enum weft_result res =
        job->choice.plan
            ? slice_run_method(job, job->choice.plan, job->pixels, progress, &job->report)
            : slice_run_plan(job, job->plan, job->own_hardware, job->pixels, progress,
                             &job->report);
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
    const struct weft_volume_open_params params = {
        .path = job->input, .grid = info->name, .rest = true, .log = report_log()};
    return info->values_rounded && !job->setup->rest ? weft_volume_open(&params, &job->setup->rest)
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
    const enum weft_result res = open_rest(job);
    return res == WEFT_OK
               ? weft_slice_verify(
                     plan, pixels,
                     weft_slice_verify_params(.rest = job->setup->rest, .progress = progress), out)
               : res;
}

enum weft_result slice_verify(struct slice_job *job)
{
    if (!job->setup->option[SLICE_VERIFY].given)
        return WEFT_OK;
    double start = report_now_seconds();
    enum weft_result res =
        slice_verify_plan(job, job->plan, job->pixels, report_progress("verifying"), &job->error);
    if (res == WEFT_OK)
        res = slice_finish_verify(job);
    job->verify_seconds = report_now_seconds() - start;
    return res;
}

enum weft_result slice_finish_verify(struct slice_job *job)
{
    const enum weft_result res = slice_bound_hardware(job);
    job->error_bound = error_bound(job);
    return res;
}
