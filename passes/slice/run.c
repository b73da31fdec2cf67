// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "filter/statistics.h"
#include "passes/fused/cpu.h"
#include "passes/fused/run.h"
#include "passes/hardware/run.h"
#include "passes/slice/slice_impl.h"

// One of the engines.
struct weft_slice {
    const struct weft_slice_plan *plan;
    const struct weft_log *log;
    weft_context *context;
    struct weft_cpu cpu; // of plans for the CPU engine, and of what lays voxels out
    weft_fused *fused;
    weft_fused_cpu *fused_cpu;
    weft_hardware *hardware;
    weft_slice_separable *separable;
    weft_slice_multipass *multipass;
};

static enum weft_result compile_engine(weft_slice *slice, const struct weft_slice_compile_params *p)
{
    if (p->passes)
        return weft_slice_multipass_compile(slice->context, &slice->cpu, slice->plan, p->passes,
                                            &slice->multipass);
    if (p->hardware)
        return weft_hardware_compile(slice->context, p->hardware, &slice->hardware);
    if (slice->plan->axes.separable)
        return weft_slice_separable_compile(slice->context, &slice->cpu, slice->plan,
                                            &slice->separable);
    if (slice->plan->info.engine == WEFT_ENGINE_CPU)
        return weft_fused_cpu_compile(&slice->cpu, slice->plan, &slice->fused_cpu);
    return weft_fused_compile(slice->context, slice->plan, &slice->fused);
}

// A plan is compiled for the engine that it was made for; the CPU runs any plan of passes.
static enum weft_result check_engine(const struct weft_log *log, const weft_slice_plan *plan,
                                     const struct weft_slice_compile_params *p,
                                     struct weft_cpu *cpu)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, p->context || p->passes || plan->info.engine == WEFT_ENGINE_CPU);
    weft_require(log, !p->context || plan->info.engine == WEFT_ENGINE_GL);
    weft_require(log, !p->hardware || (p->context && !p->passes && p->hardware->slice == plan));
    if (p->passes && weft_slice_derives(plan)) {
        weft_error(log, "the passes of a plan make values: plan the slice without derivatives");
        return WEFT_ERR_UNSUPPORTED;
    }
    res = weft_cpu_resolve(log, &p->cpu, cpu);
fail:
    return res;
}

enum weft_result weft_slice_compile(const weft_slice_plan *plan,
                                    const struct weft_slice_compile_params *params,
                                    weft_slice **out)
{
    *out = NULL;
    const struct weft_slice_passes *passes = params->passes;
    const struct weft_log *log = passes ? passes->log : plan ? plan->log : NULL;
    weft_slice *slice = NULL;
    struct weft_cpu cpu;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, plan != NULL);
    res = check_engine(log, plan, params, &cpu);
    if (res != WEFT_OK)
        return res;
    slice = calloc(1, sizeof *slice);
    if (!slice) {
        weft_error(log, "not enough memory to compile the slice");
        return WEFT_ERR_MEMORY;
    }
    slice->plan = plan;
    slice->log = log;
    slice->context = params->context;
    slice->cpu = cpu;
    res = compile_engine(slice, params);
    if (res == WEFT_OK)
        *out = slice;
    else
        weft_slice_destroy(&slice);
fail:
    return res;
}

void weft_slice_destroy(weft_slice **slice)
{
    if (!slice || !*slice)
        return;
    weft_fused_destroy(&(*slice)->fused);
    weft_fused_cpu_destroy(&(*slice)->fused_cpu);
    weft_hardware_destroy(&(*slice)->hardware);
    weft_slice_separable_destroy(&(*slice)->separable);
    weft_slice_multipass_destroy(&(*slice)->multipass);
    free(*slice);
    *slice = NULL;
}

// Of the fused pass, or of hardware filtering.
static enum weft_result run_fused(weft_slice *slice, const struct weft_slice_run_params *p,
                                  struct weft_slice_report *out, struct weft_statistics *measured)
{
    const struct weft_slice_pixels pixels = {p->pixels, p->stride, p->plane_stride, p->texture};
    struct weft_fused_report r = {0};
    const enum weft_result res =
        slice->fused      ? weft_fused_run(slice->fused, &pixels, p->progress, &r)
        : slice->hardware ? weft_hardware_run(slice->hardware, &pixels, p->progress, &r)
                          : weft_fused_cpu_run(slice->fused_cpu, &pixels, p->progress, &r);
    *out = (struct weft_slice_report){
        .read_seconds = r.read_seconds,
        .layout_seconds = r.layout_seconds,
        .upload_seconds = r.upload_seconds,
        .pass_seconds = r.pass_seconds,
        .readback_seconds = r.readback_seconds,
        .uploaded_bytes = r.uploaded_bytes,
        .peak_bytes = r.peak_bytes,
        .passes = r.passes,
        .cells_constant = r.cells_constant,
        .cells_smooth = r.cells_smooth,
        .fetches = r.fetches,
        .exact_pixels = r.exact_pixels,
    };
    if (r.pixels.count)
        *measured = r.pixels;
    return res;
}

// Pixels of passes are made in memory, and uploaded.
static enum weft_result run_multipass(weft_slice *slice, const struct weft_slice_run_params *p,
                                      struct weft_slice_report *out)
{
    const struct weft_rectangle *part = &slice->plan->info.part;
    struct weft_slice_run_params own = *p;
    float *pixels = NULL;
    if (!p->pixels) {
        own.stride = part->width;
        own.pixels = pixels = malloc((size_t)part->width * (size_t)part->height * sizeof *pixels);
        if (!pixels) {
            weft_error(slice->log, "not enough memory for %d x %d pixels", part->width,
                       part->height);
            return WEFT_ERR_MEMORY;
        }
    }
    enum weft_result res = weft_slice_multipass_run(slice->multipass, &own, out);
    const float *const plane[1] = {own.pixels};
    if (res == WEFT_OK && p->texture)
        res = weft_texture_write(slice->context, p->texture, part->width, part->height, 1, plane,
                                 own.stride);
    free(pixels);
    return res;
}

// `pixels` stays empty where the engine has not measured them.
static enum weft_result run_engine(weft_slice *slice, const struct weft_slice_run_params *p,
                                   struct weft_slice_report *out, struct weft_statistics *pixels)
{
    if (slice->multipass)
        return run_multipass(slice, p, out);
    if (slice->fused || slice->fused_cpu || slice->hardware)
        return run_fused(slice, p, out, pixels);
    return weft_slice_separable_run(slice->separable, p, out, pixels);
}

static void measure_pixels(const struct weft_rectangle *part, const struct weft_slice_run_params *p,
                           struct weft_statistics *pixels, struct weft_slice_report *out)
{
    const bool measured = pixels->count > 0 || !p->pixels;
    for (int y = 0; !measured && y < part->height; y++)
        weft_statistics_add(pixels, p->pixels + y * p->stride, (size_t)part->width);
    out->minimum = p->pixels ? (float)pixels->minimum : (float)NAN;
    out->maximum = p->pixels ? (float)pixels->maximum : (float)NAN;
    out->not_finite = pixels->not_finite;
}

enum weft_result weft_slice_run(weft_slice *slice, const struct weft_slice_run_params *params,
                                struct weft_slice_report *report)
{
    const struct weft_rectangle *part = &slice->plan->info.part;
    struct weft_slice_run_params p = *params;
    struct weft_slice_report own = {0};
    struct weft_statistics pixels = WEFT_STATISTICS_NONE;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(slice->log, p.pixels || p.texture);
    weft_require(slice->log, !p.texture || slice->context);
    weft_require(slice->log, p.stride == 0 || (p.stride >= part->width && p.stride <= INT32_MAX));
    if (p.stride == 0)
        p.stride = part->width;
    weft_require(slice->log, p.plane_stride == 0 || p.plane_stride >= part->height * p.stride);
    if (p.plane_stride == 0)
        p.plane_stride = part->height * p.stride;
    const uint64_t read = weft_slice_bricks_read(slice->plan);
    res = run_engine(slice, &p, &own, &pixels);
    if (res != WEFT_OK)
        return res;
    own.bricks_read = weft_slice_bricks_read(slice->plan) - read;
    if (slice->plan->info.engine == WEFT_ENGINE_CPU)
        own.cpu = slice->cpu;
    if (p.progress && p.progress->report)
        p.progress->report(p.progress->priv, 1.0);
    measure_pixels(part, &p, &pixels, &own);
    if (report)
        *report = own;
fail:
    return res;
}

enum weft_result weft_slice_run_once(const weft_slice_plan *plan,
                                     const struct weft_slice_compile_params *where,
                                     const struct weft_slice_run_params *params,
                                     struct weft_slice_report *report)
{
    weft_slice *slice;
    enum weft_result res = weft_slice_compile(plan, where, &slice);
    if (res == WEFT_OK)
        res = weft_slice_run(slice, params, report);
    weft_slice_destroy(&slice);
    return res;
}

// ---- reports ------------------------------------------------------------------------------------

void weft_slice_report_add(struct weft_slice_report *sum, const struct weft_slice_report *one)
{
    sum->read_seconds += one->read_seconds;
    sum->layout_seconds += one->layout_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->bricks_read += one->bricks_read;
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->peak_bytes = one->peak_bytes > sum->peak_bytes ? one->peak_bytes : sum->peak_bytes;
    sum->passes += one->passes;
    sum->cells_constant += one->cells_constant;
    sum->cells_smooth += one->cells_smooth;
    sum->fetches += one->fetches;
    sum->minimum = fminf(sum->minimum, one->minimum);
    sum->maximum = fmaxf(sum->maximum, one->maximum);
    sum->not_finite += one->not_finite;
    sum->exact_pixels += one->exact_pixels;
    sum->clamped += one->clamped;
    sum->rectangles += one->rectangles;
    sum->clamps += one->clamps;
    sum->largest_clamp = fmax(sum->largest_clamp, one->largest_clamp);
}
