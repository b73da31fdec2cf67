// SPDX-License-Identifier: BSD-3-Clause
#include "passes/choose/method_impl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis/analysis.h"
#include "filter/check.h"
#include "filter/analysis/error.h"

const char *const weft_algorithm_names[] = {"fused", "separable", "passes", "hardware", NULL};

struct weft_method_plan {
    struct weft_method_plan_info info;
    struct weft_slice_statistics statistics;
    weft_slice_plan *slice;
    weft_pass_plan *passes;
    weft_hardware_plan *hardware;
    struct weft_bound_terms terms;
    uint64_t memory_bytes;
    const struct weft_log *log;
};

// ---- names --------------------------------------------------------------------------------------

int weft_method_format(const struct weft_method *method, char *text, size_t size)
{
    char samples[16] = "", bits[16] = "";
    if (method->engine == WEFT_ENGINE_CPU)
        return snprintf(text, size, "%s cpu %s", weft_name(weft_algorithm_names, method->algorithm),
                        weft_name(weft_sums_names, method->sums));
    if (method->algorithm == WEFT_ALGORITHM_SEPARABLE)
        return snprintf(text, size, "separable");
    if (method->algorithm == WEFT_ALGORITHM_HARDWARE)
        return snprintf(text, size, "hardware %s", weft_source_format_name(method->source));
    if (method->algorithm == WEFT_ALGORITHM_FUSED) {
        if (method->lookup != WEFT_LOOKUP_POLYNOMIAL)
            snprintf(samples, sizeof samples, " M=%d", method->samples);
        return snprintf(text, size, "fused %s %s %s%s", weft_layout_name(method->layout),
                        weft_source_format_name(method->source),
                        weft_name(weft_lookup_names, method->lookup), samples);
    }
    if (method->bits)
        snprintf(bits, sizeof bits, " %d bits", method->bits);
    return snprintf(text, size, "passes %s %s M=%d%s", method->profile.name,
                    weft_name(weft_technique_names, method->technique), method->samples, bits);
}

// ---- the list -----------------------------------------------------------------------------------

struct list {
    struct weft_method *methods;
    size_t count, capacity;
    bool failed;
};

static void add(struct list *list, struct weft_method method)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity ? 2 * list->capacity : 64;
        void *methods = realloc(list->methods, capacity * sizeof *list->methods);
        list->failed |= !methods;
        if (!methods)
            return;
        list->methods = methods;
        list->capacity = capacity;
    }
    list->methods[list->count++] = method;
}

static void add_cpu(struct list *list)
{
    for (int algorithm = WEFT_ALGORITHM_FUSED; algorithm <= WEFT_ALGORITHM_SEPARABLE; algorithm++)
        for (int sums = WEFT_SUMS_FLOAT; sums <= WEFT_SUMS_DOUBLE; sums++)
            add(list, (struct weft_method){.algorithm = (enum weft_algorithm)algorithm,
                                           .engine = WEFT_ENGINE_CPU,
                                           .sums = (enum weft_sums)sums});
}

static void add_fused(struct list *list)
{
    for (int layout = WEFT_LAYOUT_INTERLEAVED; layout <= WEFT_LAYOUT_PLAIN; layout++)
        for (int source = 0; source < WEFT_SOURCE_FORMATS; source++)
            add(list, (struct weft_method){.layout = (enum weft_layout)layout,
                                           .source = (enum weft_source_format)source});
    for (int lookup = WEFT_LOOKUP_LINEAR; lookup <= WEFT_LOOKUP_NEAREST; lookup++)
        for (int samples = 16; samples <= 512; samples *= 2)
            add(list, (struct weft_method){.layout = WEFT_LAYOUT_INTERLEAVED,
                                           .lookup = (enum weft_lookup)lookup,
                                           .samples = samples});
}

static void add_hardware(struct list *list)
{
    for (int source = 0; source < WEFT_SOURCE_FORMATS; source++)
        add(list, (struct weft_method){.algorithm = WEFT_ALGORITHM_HARDWARE,
                                       .source = (enum weft_source_format)source});
}

static bool can_run(const struct weft_profile *profile, enum weft_technique technique)
{
    // The others keep bits that only unorm targets lack.
    return technique <= WEFT_TECHNIQUE_DOT4 || weft_target_bits(profile->target) > 0;
}

static void add_passes(struct list *list)
{
    enum { MIDDLE_SAMPLES = 32, MOST_SAMPLES = 64, MANY_BITS = 12 };
    static const char *const profiles[] = {"fp32", "fp16", "unorm16", "unorm8"};
    for (size_t p = 0; p < WEFT_COUNT(profiles); p++) {
        for (int technique = 0; weft_technique_names[technique]; technique++) {
            for (int samples = 16; samples <= MOST_SAMPLES; samples *= 2) {
                struct weft_method method = {.algorithm = WEFT_ALGORITHM_MULTIPASS,
                                             .samples = samples,
                                             .profile = *weft_profile_find(profiles[p]),
                                             .technique = (enum weft_technique)technique};
                const bool usual = technique <= WEFT_TECHNIQUE_DOT4;
                if (!can_run(&method.profile, method.technique) ||
                    !(usual || samples == MIDDLE_SAMPLES))
                    continue;
                add(list, method);
                // Finer weights than the target's codes, as far as products have room.
                method.bits = MANY_BITS;
                if (usual && method.profile.target == WEFT_TARGET_UNORM8)
                    add(list, method);
            }
        }
    }
}

enum weft_result weft_method_list(const struct weft_log *log, struct weft_method **out,
                                  size_t *count)
{
    struct list list = {0};
    add_fused(&list);
    add_hardware(&list);
    add(&list, (struct weft_method){.algorithm = WEFT_ALGORITHM_SEPARABLE});
    add_passes(&list);
    add_cpu(&list);
    if (list.failed) {
        weft_error(log, "not enough memory for a list of %zu methods", list.count);
        free(list.methods);
        list = (struct list){0};
    }
    *out = list.methods;
    *count = list.count;
    return list.failed ? WEFT_ERR_MEMORY : WEFT_OK;
}

// ---- plans --------------------------------------------------------------------------------------

// Whether voxels are stored in one of several formats.
static bool has_source(const struct weft_method *method)
{
    return method->engine == WEFT_ENGINE_GL && (method->algorithm == WEFT_ALGORITHM_FUSED ||
                                                method->algorithm == WEFT_ALGORITHM_HARDWARE);
}

// What the method decides of the slice.
struct weft_slice_params weft_method_slice_params(const struct weft_method_params *p)
{
    struct weft_slice_params slice = p->slice;
    const struct weft_method *method = &p->method;
    if (method->algorithm != WEFT_ALGORITHM_SEPARABLE)
        slice.without |= WEFT_SAVING_SEPARABLE;
    if (method->algorithm == WEFT_ALGORITHM_MULTIPASS ||
        method->algorithm == WEFT_ALGORITHM_HARDWARE)
        slice.without |= WEFT_SAVING_AXIS; // boxes, or textures, hold every tap
    slice.engine = method->engine;
    slice.sums = method->sums;
    if (method->engine == WEFT_ENGINE_CPU)
        slice.layout = WEFT_LAYOUT_AUTO; // its own
    if (!has_source(method))
        return slice;
    slice.source = method->source;
    if (method->algorithm == WEFT_ALGORITHM_FUSED) {
        slice.layout = method->layout;
        slice.lookup = method->lookup;
        slice.samples = method->samples;
    }
    slice.low = p->statistics.low;
    // One value maps to 0, whatever the range's width.
    slice.high =
        p->statistics.high > p->statistics.low ? p->statistics.high : p->statistics.low + 1.0;
    return slice;
}

struct weft_pass_plan_params weft_method_pass_params(const struct weft_method_params *p)
{
    const struct weft_method *method = &p->method;
    return *weft_pass_plan_params(.kernel = p->slice.kernel, .dims = 3, .profile = method->profile,
                                  .samples = method->samples, .bits = method->bits,
                                  .technique = method->technique, .worst_case = WEFT_WORST_ANY,
                                  .memory_bytes = p->slice.memory_bytes,
                                  .progress = p->slice.progress, .log = p->slice.log);
}

struct weft_bound_values weft_method_values(const struct weft_slice_statistics *s)
{
    return (struct weft_bound_values){.low = s->low,
                                      .high = s->high,
                                      .sample_low = s->voxel_low,
                                      .sample_high = s->voxel_high,
                                      .beyond = s->beyond};
}

struct weft_work weft_method_work(const struct weft_method *method,
                                  const struct weft_slice_plan *request,
                                  const struct weft_slice_plan *placed,
                                  const struct weft_pass_work *passes, double samples)
{
    const struct weft_slice_geometry *g = &request->footprint->grid.index;
    struct weft_work work = {
        .algorithm = method->algorithm,
        .engine = method->engine,
        .sums = method->sums,
        .pixels = (double)g->width * g->height,
        .voxels = (double)WEFT_BRICK_VOXELS * (double)placed->info.bricks_read,
    };
    switch (method->algorithm) {
    case WEFT_ALGORITHM_FUSED:
        if (method->engine == WEFT_ENGINE_CPU)
            work.of.fused_cpu = weft_slice_fused_cpu_work(request, placed);
        else
            work.of.fused = weft_slice_fused_work(request, placed, method->layout);
        break;
    case WEFT_ALGORITHM_SEPARABLE:
        work.of.separable = weft_slice_separable_work(request);
        break;
    case WEFT_ALGORITHM_MULTIPASS:
        work.of.passes.plan = *passes;
        work.of.passes.samples = samples;
        break;
    case WEFT_ALGORITHM_HARDWARE:
        break;
    }
    return work;
}

static enum weft_result plan_passes(weft_method_plan *plan, const struct weft_method_params *p)
{
    struct weft_pass_plan_params params = weft_method_pass_params(p);
    params.kernel = plan->info.slice->kernel;
    enum weft_result res = weft_pass_plan_create(&params, &plan->passes);
    if (res != WEFT_OK)
        return res;
    const struct weft_pass_plan_info *info = plan->info.passes =
        weft_pass_plan_get_info(plan->passes);
    const bool coded = weft_target_bits(info->profile.target) > 0;
    plan->info.method.bits = coded ? info->bits : 0;
    plan->terms = weft_slice_multipass_bound_terms(plan->slice, plan->passes);
    plan->info.bytes += info->tile_bytes + info->target_bytes_per_pixel *
                                               (uint64_t)p->slice.geometry.width *
                                               (uint64_t)p->slice.geometry.height;
    plan->info.fetches = info->fetches;
    return WEFT_OK;
}

struct weft_sampler weft_method_sampler(const struct weft_method_params *p)
{
    return p->sampler.max_size ? p->sampler : weft_sampler_assume(p->method.source);
}

static enum weft_result plan_hardware(weft_method_plan *plan, const struct weft_method_params *p)
{
    const enum weft_result res = weft_hardware_plan_create(
        weft_hardware_params(.slice = plan->slice, .sampler = weft_method_sampler(p),
                             .memory_bytes = p->slice.memory_bytes, .log = p->slice.log),
        &plan->hardware);
    if (res != WEFT_OK)
        return res;
    const struct weft_hardware_plan_info *info = plan->info.hardware =
        weft_hardware_plan_get_info(plan->hardware);
    plan->terms = info->bound;
    plan->info.bytes = info->memory_bytes;
    plan->info.fetches = info->fetches_per_pixel;
    return WEFT_OK;
}

// The leading term, for a signal whose derivatives are as large as its samples' differences.
static double leading_e1(const struct weft_kernel *kernel,
                         const struct weft_slice_statistics *statistics)
{
    const int order = kernel->order;
    if (order < 1 || order > WEFT_STATISTICS_DIFFERENCES)
        return NAN;
    return weft_error_e1(kernel, 3, statistics->difference[order - 1]);
}

static void tell(weft_method_plan *plan)
{
    struct weft_method_plan_info *info = &plan->info;
    const struct weft_bound_values values = weft_method_values(&plan->statistics);
    struct weft_method method = info->method;
    struct weft_pass_work passes = {0};
    double samples = 0.0;
    method.layout = info->slice->layout;
    if (info->passes) {
        passes = weft_pass_work_of(info->passes);
        samples = weft_slice_multipass_samples(plan->slice->footprint);
    }
    info->work = weft_method_work(&method, plan->slice, plan->slice, &passes, samples);
    if (info->hardware)
        info->work.of.hardware = info->hardware->work;
    info->bound = weft_bound_compute(&plan->terms, &values).total;
    info->e1 = leading_e1(&info->slice->kernel, &plan->statistics);
    weft_method_format(&info->method, info->name, sizeof info->name);
}

// Whether the engine has the algorithm and the sums.
static enum weft_result check_engine(const struct weft_method *method, const struct weft_log *log)
{
    const bool cpu = method->engine == WEFT_ENGINE_CPU;
    const bool both =
        method->algorithm == WEFT_ALGORITHM_FUSED || method->algorithm == WEFT_ALGORITHM_SEPARABLE;
    if (cpu ? both : method->sums == WEFT_SUMS_FLOAT)
        return WEFT_OK;
    weft_debug(log, cpu ? "the CPU engine has no passes, and no texture sampler"
                        : "OpenGL has no sums in double precision");
    return WEFT_ERR_UNSUPPORTED;
}

// Whether a source on OpenGL holds the voxels.
static enum weft_result check_source(const struct weft_method_params *p)
{
    const struct weft_slice_params slice = weft_method_slice_params(p);
    const struct weft_source_range range = {slice.low, slice.high};
    if (!weft_source_format_holds(slice.source, &range)) {
        weft_debug(p->slice.log, "a source of format %s does not hold voxels from %g to %g",
                   weft_source_format_name(slice.source), slice.low, slice.high);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (slice.source < WEFT_SOURCE_UNORM16 || !p->statistics.not_finite)
        return WEFT_OK;
    weft_debug(p->slice.log, "a source of format %s does not hold the %llu voxels not finite",
               weft_source_format_name(slice.source), (unsigned long long)p->statistics.not_finite);
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_method_check(const struct weft_method_params *p)
{
    const struct weft_method *method = &p->method;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(p->slice.log, method->algorithm, WEFT_ALGORITHM_HARDWARE);
    weft_require_enum(p->slice.log, method->engine, WEFT_ENGINE_CPU);
    weft_require_enum(p->slice.log, method->sums, WEFT_SUMS_DOUBLE);
    weft_require_enum(p->slice.log, method->layout, WEFT_LAYOUT_PLAIN);
    weft_require_enum(p->slice.log, method->source, WEFT_SOURCE_UNORM8);
    weft_require_enum(p->slice.log, method->lookup, WEFT_LOOKUP_NEAREST);
    weft_require_enum(p->slice.log, method->technique, WEFT_TECHNIQUE_LOG);
    res = check_engine(method, p->slice.log);
    if (res == WEFT_OK && has_source(method))
        res = check_source(p);
    if (res == WEFT_OK && method->algorithm == WEFT_ALGORITHM_HARDWARE &&
        p->slice.clamp_to_samples) {
        weft_debug(p->slice.log,
                   "the texture sampler does not clamp to the samples next to a pixel");
        res = WEFT_ERR_UNSUPPORTED;
    }
    if (res == WEFT_OK && method->algorithm == WEFT_ALGORITHM_MULTIPASS &&
        method->technique == WEFT_TECHNIQUE_LOG && p->statistics.low < 0.0) {
        weft_debug(p->slice.log, "logarithms need voxels from 0 on, not from %g",
                   p->statistics.low);
        res = WEFT_ERR_UNSUPPORTED;
    }
fail:
    return res;
}

enum weft_result weft_method_plan_create(weft_volume *volume,
                                         const struct weft_method_params *params,
                                         weft_method_plan **out)
{
    *out = NULL;
    enum weft_result res = weft_method_check(params);
    weft_method_plan *plan = NULL;
    if (res != WEFT_OK)
        return res;
    const struct weft_slice_params slice = weft_method_slice_params(params);
    res = WEFT_ERR_MEMORY;
    plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(params->slice.log, "not enough memory to plan a method");
        return res;
    }
    plan->info.method = params->method;
    plan->statistics = params->statistics;
    plan->memory_bytes = params->slice.memory_bytes;
    plan->log = params->slice.log;
    res = weft_slice_plan_create(volume, &slice, &plan->slice);
    if (res != WEFT_OK)
        goto fail;
    const struct weft_slice_plan_info *info = plan->info.slice =
        weft_slice_plan_get_info(plan->slice);
    if (params->method.algorithm == WEFT_ALGORITHM_SEPARABLE &&
        !(info->savings & WEFT_SAVING_SEPARABLE)) {
        weft_debug(plan->log, "the slice does not run along the volume's axes");
        res = WEFT_ERR_UNSUPPORTED;
        goto fail;
    }
    plan->info.bytes = info->memory_bytes;
    plan->info.fetches = info->fetches_per_pixel;
    plan->terms = info->output[0].bound;
    if (params->method.algorithm == WEFT_ALGORITHM_MULTIPASS)
        res = plan_passes(plan, params);
    if (params->method.algorithm == WEFT_ALGORITHM_HARDWARE)
        res = plan_hardware(plan, params);
    if (res != WEFT_OK)
        goto fail;
    tell(plan);
    *out = plan;
    return WEFT_OK;
fail:
    weft_method_plan_destroy(&plan);
    return res;
}

void weft_method_plan_destroy(weft_method_plan **plan)
{
    if (!plan || !*plan)
        return;
    weft_hardware_plan_destroy(&(*plan)->hardware);
    weft_slice_plan_destroy(&(*plan)->slice);
    weft_pass_plan_destroy(&(*plan)->passes);
    free(*plan);
    *plan = NULL;
}

void weft_method_plan_set_log(weft_method_plan *plan, const struct weft_log *log)
{
    plan->log = plan->slice->log = log;
    if (plan->hardware)
        plan->hardware->log = log;
}

const struct weft_method_plan_info *weft_method_plan_get_info(const weft_method_plan *plan)
{
    return &plan->info;
}

const weft_slice_plan *weft_method_plan_get_slice(const weft_method_plan *plan)
{
    return plan->slice;
}

const weft_pass_plan *weft_method_plan_get_passes(const weft_method_plan *plan)
{
    return plan->passes;
}

// ---- runs ---------------------------------------------------------------------------------------

enum weft_result weft_method_run(const weft_method_plan *plan,
                                 const struct weft_method_run_params *params,
                                 struct weft_method_report *report)
{
    const struct weft_slice_passes passes = {
        .plan = plan->passes,
        .low = plan->statistics.low,
        .high = plan->statistics.high > plan->statistics.low ? plan->statistics.high
                                                             : plan->statistics.low + 1.0,
        .memory_bytes = plan->memory_bytes,
        .log = plan->log,
    };
    const struct weft_slice_compile_params where = {
        .context = plan->info.method.engine == WEFT_ENGINE_CPU ? NULL : params->context,
        .cpu = params->cpu,
        .passes = plan->passes ? &passes : NULL,
        .hardware = plan->hardware,
    };
    struct weft_method_report own = {0};
    const double start = weft_now_seconds();
    const enum weft_result res = weft_slice_run_once(
        plan->slice, &where,
        weft_slice_run_params(.pixels = params->pixels, .progress = params->progress), &own.slice);
    own.seconds = weft_now_seconds() - start;
    if (res == WEFT_OK && report)
        *report = own;
    return res;
}
