// SPDX-License-Identifier: BSD-3-Clause
// Slices that the texture sampler filters: with --hardware, or where a budget chose it.
#include "tools/slice/stages.h"

#include "tools/common/report.h"

enum weft_result slice_plan_hardware(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    if (!setup->option[SLICE_HARDWARE].given)
        return WEFT_OK;
    const double start = report_now_seconds();
    const enum weft_source_format source = weft_slice_plan_get_info(job->plan)->source;
    struct weft_hardware_params params = {
        .slice = job->plan, .memory_bytes = slice_memory(setup), .log = report_log()};
    enum weft_result res =
        setup->context ? weft_sampler_measure(setup->context, source, &params.sampler) : WEFT_OK;
    if (res == WEFT_ERR_UNSUPPORTED)
        report_error("this OpenGL does not filter textures of format %s linearly",
                     weft_source_format_name(source));
    if (res == WEFT_OK)
        res = weft_hardware_plan_create(&params, &job->own_hardware);
    if (res == WEFT_OK)
        job->hardware = weft_hardware_plan_get_info(job->own_hardware);
    job->plan_seconds += report_now_seconds() - start;
    return res;
}

enum weft_result slice_bound_hardware(struct slice_job *job)
{
    struct weft_slice_statistics s;
    if (!job->hardware)
        return WEFT_OK;
    const enum weft_result res = weft_footprint_statistics(weft_slice_plan_get_footprint(job->plan),
                                                           report_progress("measuring"), &s);
    const struct weft_bound_values values = {.low = s.low,
                                             .high = s.high,
                                             .sample_low = s.voxel_low,
                                             .sample_high = s.voxel_high,
                                             .beyond = s.beyond};
    if (res == WEFT_OK)
        job->error.bound = weft_bound_compute(&job->hardware->bound, &values).total;
    return res;
}

json_t *slice_hardware_json(const struct weft_hardware_plan_info *info)
{
    const struct weft_sampler *sampler = &info->sampler;
    const int *size = info->texture_size;
    return json_pack("{s:i,s:i,s:i,s:[i,i,i],s:{s:o,s:o},s:{s:o,s:o,s:o}}", "fetches_per_axis",
                     info->fetches_per_axis, "pairs_per_axis", info->pairs_per_axis,
                     "fetches_per_pixel", info->fetches_per_pixel, "texture_size", size[0], size[1],
                     size[2], "sampler", "fraction", json_number(sampler->fraction), "rounding",
                     json_number(sampler->rounding), "bound_parts", "of_range",
                     json_number(info->bound.e3), "of_largest", json_number(info->bound.relative),
                     "absolute", json_number(info->bound.absolute));
}
