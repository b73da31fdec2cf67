// SPDX-License-Identifier: BSD-3-Clause
// Compiled plans, run by whichever engine they are for.
#include <stdlib.h>

#include "passes/resample/resample_impl.h"

// ---- compile ------------------------------------------------------------------------------------

static enum weft_result compile_passes(weft_resample_compiled *compiled)
{
    const weft_resample_plan *plan = compiled->plan;
    const enum weft_result res = weft_multipass_compile(
        compiled->context, weft_multipass_params(.plan = plan->passes, .log = plan->log),
        &compiled->passes);
    if (res != WEFT_OK)
        return res;
    const struct weft_multipass_info *info = weft_multipass_get_info(compiled->passes);
    compiled->info = (struct weft_resample_compiled_info){
        .seconds = info->seconds, .tile_bytes = info->tile_bytes, .programs = info->programs};
    return WEFT_OK;
}

static enum weft_result compile_separable(weft_resample_compiled *compiled,
                                          const struct weft_cpu *cpu)
{
    const double start = weft_now_seconds();
    const enum weft_result res = weft_separable_compile(
        compiled->plan->separable,
        weft_separable_compile_params(.context = compiled->context, .cpu = *cpu),
        &compiled->separable);
    compiled->info = (struct weft_resample_compiled_info){.seconds = weft_now_seconds() - start,
                                                          .programs = compiled->context ? 2 : 0};
    return res;
}

enum weft_result weft_resample_compile(const weft_resample_plan *plan,
                                       const struct weft_resample_compile_params *params,
                                       weft_resample_compiled **out)
{
    *out = NULL;
    weft_resample_compiled *compiled = calloc(1, sizeof *compiled);
    if (!compiled) {
        weft_error(plan->log, "out of memory for a compiled plan");
        return WEFT_ERR_MEMORY;
    }
    *compiled = (weft_resample_compiled){
        .plan = plan, .context = params->context, .threads = params->cpu.threads};
    const enum weft_result res =
        plan->passes ? compile_passes(compiled) : compile_separable(compiled, &params->cpu);
    if (res == WEFT_OK)
        *out = compiled;
    else
        weft_resample_compiled_destroy(&compiled);
    return res;
}

void weft_resample_compiled_destroy(weft_resample_compiled **compiled)
{
    if (!compiled || !*compiled)
        return;
    weft_multipass_destroy(&(*compiled)->passes);
    weft_separable_destroy(&(*compiled)->separable);
    free(*compiled);
    *compiled = NULL;
}

const struct weft_resample_compiled_info *
weft_resample_compiled_get_info(const weft_resample_compiled *compiled)
{
    return &compiled->info;
}

// ---- run ----------------------------------------------------------------------------------------

static void measure(const struct weft_resample_run_params *params, struct weft_statistics *pixels)
{
    for (int c = 0; c < params->source->info.channels; c++)
        for (int64_t y = 0; y < params->part.height; y++)
            weft_statistics_add(pixels, params->plane[c] + y * params->stride,
                                (size_t)params->part.width);
}

enum weft_result weft_resample_run(weft_resample_compiled *compiled,
                                   const struct weft_resample_run_params *params,
                                   struct weft_resample_report *report)
{
    const weft_resample_plan *plan = compiled->plan;
    struct weft_resample_run_params p = *params;
    struct weft_resample_report done = {.pixels = WEFT_STATISTICS_NONE};
    enum weft_result res = weft_resample_check_request(p.log, plan, p.source, &p.part,
                                                       (const float *const *)p.plane, &p.stride);
    if (res == WEFT_OK)
        res = plan->passes ? weft_resample_run_passes(compiled, &p, &done.work)
                           : weft_resample_run_separable(compiled, &p, &done);
    if (res == WEFT_OK && plan->info.clamp)
        res = weft_resample_clamp(plan, &p, compiled->threads);
    if (res == WEFT_OK && report && (plan->passes || plan->info.clamp)) {
        done.pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
        measure(&p, &done.pixels);
    }
    if (report)
        *report = done;
    return res;
}
