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

// Whether pixels are in the end what GL has drawn.
static bool draws_pixels(const weft_resample_plan *plan)
{
    return !plan->passes && !plan->info.clamp;
}

// The request is checked. Without planes pixels are drawn to the texture alone.
static enum weft_result run(weft_resample_compiled *compiled,
                            const struct weft_resample_run_params *p, bool measures,
                            struct weft_resample_report *done)
{
    const weft_resample_plan *plan = compiled->plan;
    enum weft_result res = plan->passes ? weft_resample_run_passes(compiled, p, &done->work)
                                        : weft_resample_run_separable(compiled, p, done);
    if (res == WEFT_OK && plan->info.clamp)
        res = weft_resample_clamp(plan, p, compiled->threads);
    if (res == WEFT_OK && measures && !draws_pixels(plan)) {
        done->pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
        measure(p, &done->pixels);
    }
    return res;
}

// Planes of the run's own, where the caller has none, which then are uploaded.
static enum weft_result run_through_memory(weft_resample_compiled *compiled,
                                           const struct weft_resample_run_params *params,
                                           bool measures, struct weft_resample_report *done)
{
    struct weft_resample_run_params p = *params;
    const int channels = p.source->info.channels;
    const size_t pixels = (size_t)p.part.width * (size_t)p.part.height;
    float *own = NULL;
    p.texture = NULL;
    if (!p.plane[0]) {
        own = malloc(pixels * (size_t)channels * sizeof *own);
        if (!own) {
            weft_error(p.log, "not enough memory for %d x %d pixels of %d channels", p.part.width,
                       p.part.height, channels);
            return WEFT_ERR_MEMORY;
        }
        p.stride = p.part.width;
        for (int c = 0; c < channels; c++)
            p.plane[c] = own + (size_t)c * pixels;
    }
    enum weft_result res = run(compiled, &p, measures && !own, done);
    if (res == WEFT_OK)
        res = weft_texture_write(compiled->context, params->texture, p.part.width, p.part.height,
                                 channels, (const float *const *)p.plane, p.stride);
    if (own)
        done->pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
    free(own);
    return res;
}

enum weft_result weft_resample_run(weft_resample_compiled *compiled,
                                   const struct weft_resample_run_params *params,
                                   struct weft_resample_report *report)
{
    struct weft_resample_run_params p = *params;
    struct weft_resample_report done = {.pixels = WEFT_STATISTICS_NONE};
    const bool planes = !p.texture || p.plane[0];
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p.log, !p.texture || compiled->context);
    res = weft_resample_check_request(p.log, compiled->plan, p.source, &p.part,
                                      planes ? (const float *const *)p.plane : NULL, &p.stride);
    if (res == WEFT_OK && p.texture && !draws_pixels(compiled->plan))
        res = run_through_memory(compiled, &p, report != NULL, &done);
    else if (res == WEFT_OK)
        res = run(compiled, &p, report != NULL, &done);
    if (report)
        *report = done;
fail:
    return res;
}
