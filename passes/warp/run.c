// SPDX-License-Identifier: BSD-3-Clause
// Compiled plans, run by whichever engine they are for.
#include <stdlib.h>

#include "filter/threads.h"
#include "passes/warp/warp_impl.h"

// ---- compile ------------------------------------------------------------------------------------

static enum weft_result check_context(const struct weft_warp_plan *plan,
                                      const struct weft_resample_compile_params *params)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(plan->log, !params->context == (plan->info.engine == WEFT_ENGINE_CPU));
    res = WEFT_OK;
fail:
    return res;
}

static enum weft_result compile(const struct weft_warp_plan *plan,
                                const struct weft_resample_compile_params *params,
                                struct weft_warp_compiled *compiled)
{
    const struct weft_separable_compile_params separable = {.context = params->context,
                                                            .cpu = params->cpu};
    if (plan->separable)
        return weft_separable_compile(plan->separable, &separable, &compiled->separable);
    return plan->info.engine == WEFT_ENGINE_CPU
               ? weft_warp_cpu_compile(plan, &params->cpu, &compiled->cpu)
               : weft_warp_gl_compile(params->context, plan, &compiled->gl);
}

enum weft_result weft_warp_compile(const weft_warp_plan *plan,
                                   const struct weft_resample_compile_params *params,
                                   weft_warp_compiled **out)
{
    *out = NULL;
    enum weft_result res = check_context(plan, params);
    if (res != WEFT_OK)
        return res;
    weft_warp_compiled *compiled = calloc(1, sizeof *compiled);
    if (!compiled) {
        weft_error(plan->log, "out of memory for a compiled warp");
        return WEFT_ERR_MEMORY;
    }
    compiled->plan = plan;
    compiled->threads = params->cpu.threads ? params->cpu.threads : weft_threads_available();
    res = compile(plan, params, compiled);
    if (res == WEFT_OK)
        *out = compiled;
    else
        weft_warp_compiled_destroy(&compiled);
    return res;
}

void weft_warp_compiled_destroy(weft_warp_compiled **compiled)
{
    if (!compiled || !*compiled)
        return;
    weft_separable_destroy(&(*compiled)->separable);
    weft_warp_cpu_destroy(&(*compiled)->cpu);
    weft_warp_gl_destroy(&(*compiled)->gl);
    free(*compiled);
    *compiled = NULL;
}

// ---- run ----------------------------------------------------------------------------------------

// Their kernels were both checked; parameters that coefficients do not depend on do not matter.
static bool reads_the_same(const struct weft_kernel *a, const struct weft_kernel *b)
{
    return a->prefiltered == b->prefiltered && (!a->prefiltered || a->info == b->info);
}

enum weft_result weft_warp_check(const struct weft_warp_plan *plan,
                                 const weft_resample_source *source, struct weft_rectangle *part,
                                 const float *const *plane, int64_t *stride,
                                 const struct weft_log *log)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, source);
    const struct weft_resample_source_info *from = &source->info;
    const struct weft_warp_info *to = &plan->info;
    if (from->width != to->size[0] || from->height != to->size[1] ||
        from->window.width != from->width || from->window.height != from->height) {
        weft_error(log,
                   "warping a source of %d x %d of %d x %d samples by a plan for all of %d x %d",
                   from->window.width, from->window.height, from->width, from->height, to->size[0],
                   to->size[1]);
        goto fail;
    }
    weft_require(log, reads_the_same(&from->kernel, &to->kernel));
    weft_require(log, from->boundary == to->boundary);
    res = weft_rectangle_within(log, part, to->width, to->height, part);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    *stride = *stride ? *stride : part->width;
    weft_require(log, *stride >= part->width);
    for (int c = 0; c < from->channels; c++)
        weft_require(log, plane[c]);
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_warp_run(weft_warp_compiled *compiled,
                               const struct weft_warp_run_params *params,
                               struct weft_resample_report *report)
{
    struct weft_warp_run_params p = *params;
    struct weft_resample_report done = {.pixels = WEFT_STATISTICS_NONE};
    enum weft_result res = weft_warp_check(compiled->plan, p.source, &p.part,
                                           (const float *const *)p.plane, &p.stride, p.log);
    if (res == WEFT_OK)
        res = compiled->separable ? weft_warp_aligned_run(compiled, &p, &done)
              : compiled->cpu     ? weft_warp_cpu_run(compiled->cpu, &p, &done)
                                  : weft_warp_gl_run(compiled->gl, &p, &done);
    if (res == WEFT_OK && report)
        *report = done;
    return res;
}
