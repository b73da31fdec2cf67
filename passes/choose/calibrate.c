// SPDX-License-Identifier: BSD-3-Clause
// Small jobs whose times tell one unknown of the cost model after the other.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/choose/cost.h"

// A cube, and a slab as wide as separable slices want it; PIXELS^2 of most slices.
enum {
    SIDE = 128,
    SLAB_SIDE = 512,
    SLAB_HEIGHT = 8,
    PIXELS = 256,
    TINY = 8,
    FEW_RUNS = 4,
    RUNS = 40,
    STEPS = 102
};
// Of a job's runs: two are then enough, or four.
static const double LONG_SECONDS = 0.2, SHORT_SECONDS = 0.06;

// A job's nanoseconds, without what any run of its method takes, and what it is about. The least of
// some runs: whatever else the machine does only adds to them, and differences are taken.
struct timed {
    double whole, read, layout, passes; // layout: with upload; passes: with reading back
    // The work, as its algorithm describes it.
    double voxels, samples;
    struct weft_fused_work fused;
    struct weft_hardware_work hardware;
    struct weft_fused_cpu_work fused_cpu;
    struct weft_separable_work separable;
    struct weft_pass_work plan;
};

struct calibration {
    const struct weft_log *log;
    weft_context *context;
    const struct weft_progress *progress;
    weft_volume *cube, *slab;
    float *pixels;
    struct timed fixed; // of any run of the method
    int steps;
    enum weft_result result;
    struct weft_cost_model model;
};

struct job {
    struct weft_method method;
    const char *kernel;
    bool oblique, slab;
    int pixels;
    double low; // of the range that is mapped
};

// ---- volumes ------------------------------------------------------------------------------------

static float noise(size_t i)
{
    uint32_t h = (uint32_t)i * 2654435761u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    return (float)(h >> 8) * 0x1p-24f;
}

static enum weft_result create_volumes(struct calibration *c)
{
    const size_t count = (size_t)SIDE * SIDE * SIDE;
    _Static_assert(SIDE * SIDE * SIDE == SLAB_SIDE * SLAB_SIDE * SLAB_HEIGHT, "");
    float *data = malloc(count * sizeof *data);
    c->pixels = malloc((size_t)4 * PIXELS * PIXELS * sizeof *c->pixels);
    if (!data || !c->pixels) {
        free(data);
        weft_error(c->log, "not enough memory to calibrate with %zu voxels", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        data[i] = noise(i);
    struct weft_volume_params *params =
        weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data, .log = c->log);
    enum weft_result res = weft_volume_create(params, &c->cube);
    memcpy(params->size, (int[3]){SLAB_SIDE, SLAB_SIDE, SLAB_HEIGHT}, sizeof params->size);
    if (res == WEFT_OK)
        res = weft_volume_create(params, &c->slab);
    free(data);
    return res;
}

static struct weft_slice_geometry plane(const struct job *job)
{
    struct weft_slice_geometry g = {
        .origin = {8.0, 14.0, 16.0}, .width = job->pixels, .height = job->pixels};
    const double side = job->pixels == TINY ? 4.0 : job->slab ? 496.0 : 104.0;
    memcpy(g.u, job->oblique ? (double[3]){88, 28, 40} : (double[3]){side, 0, 0}, sizeof g.u);
    memcpy(g.v, job->oblique ? (double[3]){-8, 68, 56} : (double[3]){0, side, 0}, sizeof g.v);
    if (job->slab)
        memcpy(g.origin, (double[3]){8.2, 8.2, 3.3}, sizeof g.origin);
    return g;
}

// ---- jobs ---------------------------------------------------------------------------------------

static void set_work(const struct weft_work *work, struct timed *out)
{
    out->voxels = work->voxels;
    switch (work->algorithm) {
    case WEFT_ALGORITHM_FUSED:
        if (work->engine == WEFT_ENGINE_CPU)
            out->fused_cpu = work->of.fused_cpu;
        else
            out->fused = work->of.fused;
        break;
    case WEFT_ALGORITHM_SEPARABLE:
        out->separable = work->of.separable;
        break;
    case WEFT_ALGORITHM_MULTIPASS:
        out->plan = work->of.passes.plan;
        out->samples = work->of.passes.samples;
        break;
    case WEFT_ALGORITHM_HARDWARE:
        out->hardware = work->of.hardware;
        break;
    }
}

// The first run reads the voxels and links programs; the least of all is without.
static enum weft_result run(struct calibration *c, const weft_method_plan *plan, struct timed *out)
{
    double whole = INFINITY, layout = INFINITY, passes = INFINITY, read = 0.0;
    enum weft_result res = WEFT_OK;
    const double start = weft_now_seconds();
    for (int i = 0; res == WEFT_OK && i < RUNS; i++) {
        struct weft_method_report report;
        if (i >= 2 && weft_now_seconds() - start > (i < FEW_RUNS ? LONG_SECONDS : SHORT_SECONDS))
            break;
        res = weft_method_run(
            plan, weft_method_run_params(.context = c->context, .pixels = c->pixels), &report);
        if (res != WEFT_OK)
            return res;
        read = i == 0 ? report.slice.read_seconds : read;
        whole = fmin(whole, report.seconds - report.slice.read_seconds);
        layout = fmin(layout, report.slice.layout_seconds + report.slice.upload_seconds);
        passes = fmin(passes, report.slice.pass_seconds + report.slice.readback_seconds);
    }
    *out = (struct timed){
        .whole = 1e9 * (whole + read) - c->fixed.whole,
        .read = 1e9 * read,
        .layout = 1e9 * layout - c->fixed.layout,
        .passes = 1e9 * passes - c->fixed.passes,
    };
    set_work(&weft_method_plan_get_info(plan)->work, out);
    return res;
}

static bool go_on(struct calibration *c)
{
    const double fraction = fmin(1.0, (double)c->steps++ / STEPS);
    if (c->result == WEFT_OK && c->progress && c->progress->report &&
        !c->progress->report(c->progress->priv, fraction))
        c->result = WEFT_ERR_CANCELLED;
    return c->result == WEFT_OK;
}

// After a failure everything is 0 and nothing runs any more.
static struct timed timed(struct calibration *c, struct job job)
{
    struct timed out = {0};
    struct weft_method_params params = {
        .method = job.method,
        .statistics = {.low = job.low, .high = 1.0, .voxels = (uint64_t)SIDE * SIDE * SIDE},
        .slice = {.space = WEFT_SPACE_INDEX, .geometry = plane(&job), .log = c->log},
    };
    weft_volume *volume = job.slab ? c->slab : c->cube;
    weft_method_plan *plan = NULL;
    if (go_on(c))
        c->result = weft_kernel_parse(c->log, job.kernel, &params.slice.kernel);
    if (c->result == WEFT_OK)
        c->result = weft_method_plan_create(volume, &params, &plan);
    if (c->result == WEFT_OK)
        c->result = run(c, plan, &out);
    weft_method_plan_destroy(&plan);
    return c->result == WEFT_OK ? out : (struct timed){0};
}

// Next to no pixels: what is left is what a run takes whatever it does.
static double find_start(struct calibration *c, struct job job)
{
    c->fixed = (struct timed){0};
    job.pixels = TINY;
    job.kernel = "linear";
    c->fixed = timed(c, job);
    return fmax(c->fixed.whole - c->fixed.read, 1e3);
}

static double positive(double x)
{
    return isfinite(x) ? fmax(x, 1e-3) : 1e-3;
}

// ---- the methods --------------------------------------------------------------------------------

// What is neither reading voxels nor passes.
static double beside(const struct timed *t)
{
    return t->whole - t->read - t->passes;
}

// Kernels of few and of many taps tell a fetch from what a pixel takes anyhow.
static void calibrate_sources(struct calibration *c, struct job job)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = (double)PIXELS * PIXELS;
    double rest = 0.0;
    job.pixels = PIXELS;
    for (int layout = 0; layout < WEFT_COST_LAYOUTS; layout++) {
        for (int source = 0; source < WEFT_SOURCE_FORMATS; source++) {
            job.method.layout = (enum weft_layout)(layout + 1);
            job.method.source = (enum weft_source_format)source;
            job.kernel = "linear";
            const struct timed few = timed(c, job);
            job.kernel = "bspline5";
            const struct timed many = timed(c, job);
            const double weights = (many.fused.weights - few.fused.weights) * m->weights;
            const double fetch = positive(((many.passes - few.passes) / pixels - weights) /
                                          (many.fused.fetches - few.fused.fetches));
            m->fetch[layout][source] = fetch;
            m->texel[layout][source] =
                positive((many.layout - pixels * m->entry) / many.fused.texels);
            rest +=
                few.passes / pixels - few.fused.fetches * fetch - few.fused.weights * m->weights;
        }
    }
    m->pixel = positive(rest / (WEFT_COST_LAYOUTS * WEFT_SOURCE_FORMATS));
}

static void calibrate_fused(struct calibration *c)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = 4.0 * PIXELS * PIXELS;
    struct job job = {.method.layout = WEFT_LAYOUT_INTERLEAVED, .oblique = true};
    m->start[WEFT_ALGORITHM_FUSED] = find_start(c, job);
    job.kernel = "bspline5";
    job.pixels = PIXELS;
    const struct timed smaller = timed(c, job);
    job.pixels = 2 * PIXELS;
    const struct timed larger = timed(c, job);
    job.method.lookup = WEFT_LOOKUP_NEAREST;
    job.method.samples = 1;
    const struct timed flat = timed(c, job);
    job.method.samples = 64;
    const struct timed sampled = timed(c, job);
    job.method.lookup = WEFT_LOOKUP_POLYNOMIAL;
    m->voxel = positive(larger.read / larger.voxels);
    m->entry = positive((larger.layout - smaller.layout) / (0.75 * pixels));
    m->weights = positive((larger.passes - flat.passes) /
                          ((larger.fused.weights - flat.fused.weights) * pixels));
    m->weights_fetched =
        positive(m->weights + (sampled.passes - flat.passes) / (sampled.fused.weights * pixels));
    calibrate_sources(c, job);
}

// Kernels of few and of many fetches, as of fused sources; pixels take what they do there. A
// context whose sampler does not do keeps the defaults.
static void calibrate_hardware(struct calibration *c)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = (double)PIXELS * PIXELS;
    struct job job = {.method.algorithm = WEFT_ALGORITHM_HARDWARE, .oblique = true};
    struct weft_sampler sampler;
    for (int source = 0; source < WEFT_SOURCE_FORMATS; source++)
        if (weft_sampler_measure(c->context, (enum weft_source_format)source, &sampler) != WEFT_OK)
            return;
    m->start[WEFT_ALGORITHM_HARDWARE] = find_start(c, job);
    job.pixels = PIXELS;
    for (int source = 0; source < WEFT_SOURCE_FORMATS; source++) {
        job.method.source = (enum weft_source_format)source;
        job.kernel = "linear";
        const struct timed few = timed(c, job);
        job.kernel = "bspline3";
        const struct timed many = timed(c, job);
        const double weights = (many.hardware.weights - few.hardware.weights) * m->weights;
        m->hardware_fetch[source] = positive(((many.passes - few.passes) / pixels - weights) /
                                             (many.hardware.fetches - few.hardware.fetches));
        m->hardware_texel[source] =
            positive((many.layout - pixels * m->entry) / many.hardware.texels);
    }
}

static void calibrate_separable(struct calibration *c)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = 4.0 * PIXELS * PIXELS;
    struct job job = {.method.algorithm = WEFT_ALGORITHM_SEPARABLE, .slab = true};
    m->start[WEFT_ALGORITHM_SEPARABLE] = find_start(c, job);
    job.pixels = 2 * PIXELS;
    job.kernel = "catmull-rom";
    const struct timed cubic = timed(c, job);
    job.kernel = "bspline7";
    const struct timed wide = timed(c, job);
    const struct weft_separable_work *few = &cubic.separable;
    const struct weft_separable_work *many = &wide.separable;
    m->summed = positive(cubic.layout / few->summed);
    m->tap = positive((wide.passes - cubic.passes) / (many->taps - few->taps));
    m->separable_pixel = positive(
        (beside(&cubic) + cubic.passes - few->taps * m->tap - few->summed * m->summed) / pixels);
}

// What tiles of so many samples take by their bytes, where next to no pixels are drawn: the
// difference between two numbers of samples.
static double time_tile_byte(struct calibration *c, struct job job, int few, int many)
{
    job.oblique = false;
    job.pixels = TINY;
    job.method.samples = few;
    const struct timed less = timed(c, job);
    job.method.samples = many;
    const struct timed more = timed(c, job);
    return positive((beside(&more) - beside(&less)) /
                    (more.plan.tile_bytes - less.plan.tile_bytes));
}

// Tiles that are far beyond a core's cache.
static void calibrate_far(struct calibration *c, struct job job, const struct timed *near)
{
    job.oblique = true;
    job.method.samples = 64;
    const struct timed far = timed(c, job);
    c->model.pass_far = positive((far.passes / near->passes - 1.0) /
                                 log2(far.plan.tile_bytes / WEFT_COST_NEAR_BYTES));
}

// Plain passes of a target, two plans of different passes tell a pass from its fetches.
static void calibrate_plain(struct calibration *c, struct job job)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = (double)PIXELS * PIXELS;
    const enum weft_target_format t = job.method.profile.target;
    m->tile_byte[t][0] = time_tile_byte(c, job, 16, 32);
    job.oblique = true;
    const struct timed many = timed(c, job);
    job.oblique = false;
    const struct timed flat = timed(c, job);
    if (t == WEFT_TARGET_FLOAT)
        calibrate_far(c, job, &many);
    job.method.profile.taps_per_pass = 1;
    const struct timed one = timed(c, job);
    // passes a + fetches b, of one and flat.
    const double determinant =
        one.plan.passes * flat.plan.fetches - flat.plan.passes * one.plan.fetches;
    m->pass[t] = positive((one.passes * flat.plan.fetches - flat.passes * one.plan.fetches) /
                          (pixels * determinant));
    m->pass_fetch[t][0] =
        positive((flat.passes / pixels - flat.plan.passes * m->pass[t]) / flat.plan.fetches);
    m->pass_sample[t][0] =
        positive((beside(&many) - beside(&flat)) / (many.samples - flat.samples));
    if (t == WEFT_TARGET_FLOAT)
        m->pass_pixel = positive((beside(&flat) - flat.samples * m->pass_sample[t][0]) / pixels);
}

static void calibrate_dot4(struct calibration *c, struct job job)
{
    struct weft_cost_model *m = &c->model;
    const double pixels = (double)PIXELS * PIXELS;
    const enum weft_target_format t = job.method.profile.target;
    // Past 32 MiB malloc asks the kernel for new pages.
    m->tile_byte[t][1] = time_tile_byte(c, job, 16, 64);
    job.oblique = true;
    const struct timed many = timed(c, job);
    job.oblique = false;
    const struct timed flat = timed(c, job);
    m->pass_fetch[t][1] =
        positive((flat.passes / pixels - flat.plan.passes * m->pass[t]) / flat.plan.fetches);
    m->pass_sample[t][1] =
        positive((beside(&many) - beside(&flat)) / (many.samples - flat.samples));
}

static void calibrate_passes(struct calibration *c)
{
    static const char *const profiles[] = {"fp32", "fp16", "unorm16", "unorm8"};
    const double pixels = (double)PIXELS * PIXELS;
    struct job job = {.method = {.algorithm = WEFT_ALGORITHM_MULTIPASS,
                                 .samples = 16,
                                 .profile = *weft_profile_find("fp32")},
                      .kernel = "linear"};
    c->model.start[WEFT_ALGORITHM_MULTIPASS] = find_start(c, job);
    job.pixels = PIXELS;
    for (size_t p = 0; p < WEFT_COUNT(profiles); p++) {
        job.kernel = "catmull-rom";
        job.method.profile = *weft_profile_find(profiles[p]);
        calibrate_plain(c, job);
        job.method.technique = WEFT_TECHNIQUE_DOT4;
        calibrate_dot4(c, job);
        job.method.technique = WEFT_TECHNIQUE_PLAIN;
    }
    // Where the range begins at 0 nothing is added to the result, and no sum is needed for it.
    job.kernel = "lanczos:2";
    const struct timed without = timed(c, job);
    job.low = -1.0;
    const struct timed with = timed(c, job);
    c->model.pass_weight = positive((with.passes - without.passes) / (12.0 * pixels));
}

static void calibrate_gl(struct calibration *c)
{
    calibrate_fused(c);
    calibrate_hardware(c);
    calibrate_separable(c);
    calibrate_passes(c);
    snprintf(c->model.renderer, sizeof c->model.renderer, "%s",
             weft_context_get_info(c->context)->renderer);
}

// ---- the CPU engine -----------------------------------------------------------------------------

// By taps, as weft_cost_model.cpu_row.
static const char *const width_kernels[WEFT_COST_WIDTHS] = {"linear", "catmull-rom", "bspline5",
                                                            "bspline7"};

// What pixels take without reading and layout, each.
static double pixel_ns(const struct timed *t, const struct job *job)
{
    return (t->whole - t->read - t->layout) / ((double)job->pixels * job->pixels);
}

// Where the plane is turned about an axis, voxels are summed along it before, and pixels have the
// width's root of rows: what is left is what a pixel takes anyhow.
static void calibrate_cpu_fused(struct calibration *c, enum weft_sums sums)
{
    struct weft_cost_model *m = &c->model;
    struct job job = {.method = {.engine = WEFT_ENGINE_CPU, .sums = sums}, .oblique = true};
    struct timed t[WEFT_COST_WIDTHS];
    double layout = 0.0, samples = 0.0;
    m->cpu_fused_start[sums] = find_start(c, job);
    job.pixels = 2 * PIXELS;
    for (int w = 0; w < WEFT_COST_WIDTHS; w++) {
        job.kernel = width_kernels[w];
        t[w] = timed(c, job);
        layout += t[w].layout;
        samples += t[w].fused_cpu.samples;
    }
    job.oblique = false;
    const struct timed flat = timed(c, job), *deep = &t[WEFT_COST_WIDTHS - 1];
    const double row = positive((pixel_ns(deep, &job) - pixel_ns(&flat, &job)) /
                                (deep->fused_cpu.rows - flat.fused_cpu.rows));
    const double pixel = pixel_ns(&flat, &job) - flat.fused_cpu.rows * row;
    m->cpu_pixel[sums] = positive(fmin(pixel, pixel_ns(&t[0], &job)));
    for (int w = 0; w < WEFT_COST_WIDTHS; w++)
        m->cpu_row[sums][w] =
            positive((pixel_ns(&t[w], &job) - m->cpu_pixel[sums]) / t[w].fused_cpu.rows);
    m->cpu_sample[sums] = positive(layout / samples);
    if (!c->context)
        m->voxel = positive(t[0].read / t[0].voxels);
}

static void calibrate_cpu_separable(struct calibration *c, enum weft_sums sums)
{
    struct weft_cost_model *m = &c->model;
    struct job job = {
        .method = {.algorithm = WEFT_ALGORITHM_SEPARABLE, .engine = WEFT_ENGINE_CPU, .sums = sums},
        .slab = true};
    double layout = 0.0, summed = 0.0;
    m->cpu_separable_start[sums] = find_start(c, job);
    job.pixels = 2 * PIXELS;
    for (int w = 0; w < WEFT_COST_WIDTHS; w++) {
        job.kernel = width_kernels[w];
        const struct timed t = timed(c, job);
        m->cpu_separable_tap[sums][w] = positive((t.whole - t.read - t.layout) / t.separable.taps);
        layout += t.layout;
        summed += t.separable.summed;
    }
    m->cpu_summed[sums] = positive(layout / summed);
}

static void calibrate_cpu(struct calibration *c)
{
    c->model.instructions = weft_instruction_set_best();
    c->model.threads = weft_cpu_threads();
    for (int sums = 0; sums < WEFT_COST_SUMS; sums++) {
        calibrate_cpu_fused(c, (enum weft_sums)sums);
        calibrate_cpu_separable(c, (enum weft_sums)sums);
    }
}

enum weft_result weft_cost_calibrate(const struct weft_log *log, weft_context *context,
                                     const struct weft_progress *progress,
                                     struct weft_cost_model *out)
{
    struct calibration c = {
        .log = log, .context = context, .progress = progress, .model = weft_cost_default};
    *out = (struct weft_cost_model){0};
    c.result = create_volumes(&c);
    if (c.result == WEFT_OK && context)
        calibrate_gl(&c);
    if (c.result == WEFT_OK)
        calibrate_cpu(&c);
    if (c.result == WEFT_OK) {
        *out = c.model;
        if (progress && progress->report)
            progress->report(progress->priv, 1.0);
    }
    weft_volume_destroy(&c.cube);
    weft_volume_destroy(&c.slab);
    free(c.pixels);
    return c.result;
}
