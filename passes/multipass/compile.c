// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <stdlib.h>

#include "filter/threads.h"
#include "passes/cpu/cpu.h"
#include "passes/multipass/gl.h"

static int sum_limit(const struct weft_multipass *m)
{
    const double limit = m->passes->range * m->one * exp2(m->extra_bits);
    return m->passes->exact_inside || !(limit < INT_MAX) ? INT_MAX : (int)limit;
}

static struct weft_job_limits limits_of(const weft_context *context)
{
    if (!context)
        return (struct weft_job_limits){INT32_MAX, INT_MAX};
    const struct weft_context_info *info = weft_context_get_info(context);
    return (struct weft_job_limits){info->max_buffer_texels, info->max_target_size};
}

enum weft_result weft_multipass_compile_work(weft_context *context,
                                             const struct weft_multipass_work *work,
                                             const struct weft_log *log, weft_multipass **out)
{
    const double start = weft_now_seconds();
    *out = NULL;
    enum weft_result res = weft_multipass_check_list(log, work);
    if (res != WEFT_OK)
        return res;
    weft_multipass *m = calloc(1, sizeof *m);
    if (!m) {
        weft_error(log, "not enough memory for a compiled plan");
        return WEFT_ERR_MEMORY;
    }
    m->log = log;
    m->work = *work;
    m->passes = work->passes;
    m->threads = work->threads > 0 ? work->threads : weft_threads_available();
    m->threads = m->threads < WEFT_CPU_MAX_THREADS ? m->threads : WEFT_CPU_MAX_THREADS;
    m->limits = limits_of(context);
    m->one = weft_target_one(m->passes->target);
    m->floats = m->one == 0;
    m->extra_bits = m->passes->extra_bits;
    m->limit = sum_limit(m);
    weft_multipass_axis_kernels(&m->work, &m->axes);
    res = weft_multipass_create_tiles(m);
    if (res == WEFT_OK)
        res = weft_multipass_check_sums(m);
    if (res == WEFT_OK && context)
        res = weft_multipass_gl_create(context, m);
    m->info.tile_bytes = m->tiles.bytes;
    m->info.seconds = weft_now_seconds() - start;
    if (res == WEFT_OK)
        *out = m;
    else
        weft_multipass_destroy(&m);
    return res;
}

enum weft_result weft_multipass_compile(weft_context *context,
                                        const struct weft_multipass_params *params,
                                        weft_multipass **out)
{
    struct weft_multipass_work work;
    *out = NULL;
    const enum weft_result res = weft_multipass_plan_work(params->log, params->plan, &work);
    work.threads = params->threads;
    return res == WEFT_OK ? weft_multipass_compile_work(context, &work, params->log, out) : res;
}

void weft_multipass_destroy(weft_multipass **compiled)
{
    if (!compiled || !*compiled)
        return;
    weft_multipass_gl_destroy(*compiled);
    free((*compiled)->tiles.data);
    free((*compiled)->source.data);
    free((*compiled)->groups);
    free(*compiled);
    *compiled = NULL;
}

const struct weft_multipass_info *weft_multipass_get_info(const weft_multipass *compiled)
{
    return &compiled->info;
}

enum weft_result weft_multipass_run_boxes(weft_multipass *compiled,
                                          const struct weft_multipass_run_params *params,
                                          const struct weft_sample_boxes *boxes,
                                          struct weft_multipass_report *report)
{
    struct weft_multipass_report figures = {0};
    struct weft_multipass_job job;
    const double start = weft_now_seconds();
    enum weft_result res = weft_multipass_job_create(compiled, params, boxes, &job);
    if (res != WEFT_OK)
        return res;
    figures.prepare_seconds = weft_now_seconds() - start;
    figures.source_bytes = job.source.bytes;
    figures.tile_bytes = compiled->info.tile_bytes;
    figures.position_bytes = job.pixels * sizeof *job.entries;
    res = compiled->gl ? weft_multipass_gl_run(&job, &figures)
                       : weft_multipass_cpu_run(&job, &figures);
    if (res == WEFT_OK) {
        weft_job_go_on(params->progress, 1.0);
        if (report)
            *report = figures;
    }
    weft_multipass_job_destroy(&job);
    return res;
}

enum weft_result weft_multipass_run(weft_multipass *compiled,
                                    const struct weft_multipass_run_params *params,
                                    struct weft_multipass_report *report)
{
    return weft_multipass_run_boxes(compiled, params, NULL, report);
}
