// SPDX-License-Identifier: BSD-3-Clause
#include "passes/simple/simple.h"

#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/choose/choose.h"
#include "passes/points/points.h"
#include "passes/slice/slice.h"

enum { DEFAULT_SIDE = 512 };

static enum weft_result open_grid(const struct weft_log *log, const char *path, const char *grid,
                                  weft_volume **out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, path);
    res = weft_volume_open(weft_volume_open_params(.path = path, .grid = grid, .log = log), out);
fail:
    return res;
}

// All zero is the engines' default.
static enum weft_result read_kernel(const struct weft_log *log, const char *text,
                                    struct weft_kernel *out)
{
    *out = (struct weft_kernel){0};
    return text ? weft_kernel_parse(log, text, out) : WEFT_OK;
}

// ---- slices -------------------------------------------------------------------------------------

static bool is_zero(const double v[3])
{
    return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0;
}

static double world_length(const struct weft_volume_info *info, enum weft_space space,
                           const double edge[3])
{
    double length = 0.0;
    for (int r = 0; r < 3; r++) {
        const double *m = info->index_to_world[r];
        const double along =
            space == WEFT_SPACE_WORLD ? edge[r] : m[0] * edge[0] + m[1] * edge[1] + m[2] * edge[2];
        length = hypot(length, along);
    }
    return length;
}

static void widen(double origin[3], double edge[3], double factor)
{
    for (int i = 0; i < 3; i++) {
        origin[i] -= 0.5 * (factor - 1.0) * edge[i];
        edge[i] *= factor;
    }
}

static void make_square(const struct weft_volume_info *info, enum weft_space space,
                        struct weft_slice_geometry *g)
{
    const double along = world_length(info, space, g->u) / g->width;
    const double down = world_length(info, space, g->v) / g->height;
    if (along < down)
        widen(g->origin, g->u, down / along);
    else if (down < along)
        widen(g->origin, g->v, along / down);
}

static enum weft_result find_axis(const struct weft_log *log,
                                  const struct weft_slice_file_params *p, int *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const char axis = p->axis ? p->axis : 'z';
    if (axis < 'x' || axis > 'z') {
        weft_error(log, "slice: .axis is %d ('%c'): it is 'x', 'y' or 'z'", axis,
                   axis > ' ' ? axis : '?');
        goto fail;
    }
    if (p->at && !isfinite(*p->at)) {
        weft_error(log, "slice: .at is %g", *p->at);
        goto fail;
    }
    *out = axis - 'x';
    res = WEFT_OK;
fail:
    return res;
}

static enum weft_result find_geometry(const weft_volume *volume,
                                      const struct weft_slice_file_params *p,
                                      struct weft_slice_geometry *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const int side = p->width || p->height ? 0 : DEFAULT_SIDE;
    const int width = side ? side : p->width ? p->width : p->height;
    const int height = side ? side : p->height ? p->height : p->width;
    weft_require_enum(p->log, p->space, WEFT_SPACE_INDEX);
    if (width < 1 || height < 1) {
        weft_error(p->log, "slice: %d x %d pixels", p->width, p->height);
        goto fail;
    }
    if (!is_zero(p->u) || !is_zero(p->v) || !is_zero(p->origin)) {
        if (p->axis || p->at || p->fill) {
            weft_error(p->log, "slice: .axis, .at and .fill exclude .origin, .u and .v");
            goto fail;
        }
        *out = (struct weft_slice_geometry){.width = width, .height = height};
        for (int i = 0; i < 3; i++) {
            out->origin[i] = p->origin[i];
            out->u[i] = p->u[i];
            out->v[i] = p->v[i];
        }
        return weft_slice_size_compute(p->log, volume, p->space, out);
    }
    int axis;
    res = find_axis(p->log, p, &axis);
    if (res == WEFT_OK)
        res = weft_slice_axis_geometry(p->log, volume, p->space, axis, p->at ? *p->at : NAN, width,
                                       height, out);
    if (res == WEFT_OK && !p->fill)
        make_square(weft_volume_get_info(volume), p->space, out);
fail:
    return res;
}

// One progress of two stages, of which planning is the shorter one.
static const double planned_share = 0.25;

struct stage {
    const struct weft_progress *whole;
    double from, to;
};

static bool report_stage(void *priv, double fraction)
{
    const struct stage *s = priv;
    return s->whole->report(s->whole->priv, s->from + fraction * (s->to - s->from));
}

static struct weft_progress progress_of(const struct stage *s)
{
    return (struct weft_progress){s->whole && s->whole->report ? report_stage : NULL, (void *)s};
}

// A plan for OpenGL that the CPU engine would run faster is made anew, on what it reaches.
static enum weft_result plan_slice(weft_volume *volume, const struct weft_slice_file_params *p,
                                   struct weft_slice_params *slice, weft_slice_plan **out)
{
    const struct weft_context_info *gl = p->context ? weft_context_get_info(p->context) : NULL;
    slice->engine = gl ? WEFT_ENGINE_GL : WEFT_ENGINE_CPU;
    slice->max_target_size = gl ? gl->max_target_size : 0;
    slice->max_buffer_texels = gl ? gl->max_buffer_texels : 0;
    enum weft_result res = weft_slice_plan_create(volume, slice, out);
    if (res != WEFT_OK || !gl || gl->hardware)
        return res;
    if (weft_choose_engine(&weft_cost_default, *out, p->cpu.threads) == WEFT_ENGINE_GL)
        return res;
    weft_slice_plan *first = *out;
    slice->engine = WEFT_ENGINE_CPU;
    slice->progress = NULL; // has been told
    slice->footprint = weft_slice_plan_get_footprint(first);
    res = weft_slice_plan_create(volume, slice, out);
    weft_slice_plan_destroy(&first);
    return res;
}

static enum weft_result run_slice(const weft_slice_plan *plan, enum weft_engine engine,
                                  const struct weft_slice_file_params *p,
                                  const struct weft_cpu *cpu, float *pixels)
{
    const struct stage stage = {p->progress, planned_share, 1.0};
    const struct weft_progress progress = progress_of(&stage);
    struct weft_slice_compile_params where = {0};
    if (engine == WEFT_ENGINE_GL)
        where.context = p->context;
    else
        where.cpu = *cpu;
    return weft_slice_run_once(
        plan, &where,
        weft_slice_run_params(.pixels = pixels, .stride = p->stride, .progress = &progress), NULL);
}

enum weft_result weft_slice_volume(weft_volume *volume, const struct weft_slice_file_params *params,
                                   float *pixels)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_slice_file_params *p = params ? params : weft_slice_file_params();
    const struct stage stage = {p->progress, 0.0, planned_share};
    const struct weft_progress progress = progress_of(&stage);
    weft_slice_plan *plan = NULL;
    weft_require(p->log, volume);
    weft_require(p->log, pixels);
    weft_require(p->log, !p->grid);
    struct weft_slice_params slice = {
        .space = p->space, .memory_bytes = p->memory_bytes, .progress = &progress, .log = p->log};
    struct weft_cpu cpu; // also where OpenGL runs: what is wrong is told
    res = weft_cpu_resolve(p->log, &p->cpu, &cpu);
    if (res == WEFT_OK)
        res = read_kernel(p->log, p->kernel, &slice.kernel);
    if (res == WEFT_OK)
        res = find_geometry(volume, p, &slice.geometry);
    if (res == WEFT_OK)
        res = plan_slice(volume, p, &slice, &plan);
    if (res == WEFT_OK)
        res = run_slice(plan, slice.engine, p, &cpu, pixels);
fail:
    weft_slice_plan_destroy(&plan);
    return res;
}

enum weft_result weft_slice_file(const char *path, const struct weft_slice_file_params *params,
                                 float *pixels)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_slice_file_params of_volume =
        params ? *params : (struct weft_slice_file_params){WEFT_SLICE_FILE_DEFAULTS};
    weft_volume *volume = NULL;
    weft_require(of_volume.log, pixels); // before a reader is started
    res = open_grid(of_volume.log, path, of_volume.grid, &volume);
    of_volume.grid = NULL;
    if (res == WEFT_OK)
        res = weft_slice_volume(volume, &of_volume, pixels);
fail:
    weft_volume_destroy(&volume);
    return res;
}

// ---- points -------------------------------------------------------------------------------------

// The engine's derivatives are in index space, a plane each; gradients lie together.
static enum weft_result sample_gradients(weft_points *points, const weft_volume *volume,
                                         const struct weft_sample_params *p,
                                         struct weft_points_run_params *run, float (*gradient)[3])
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const enum weft_quantity quantity = WEFT_QUANTITY_GRADIENT;
    struct weft_quantities list;
    struct weft_quantity_transform transform;
    float *const value = run->out, *planes = NULL;
    res = weft_quantities_create(p->log, &quantity, 1, &list);
    if (res == WEFT_OK)
        res = weft_quantity_transform_create(
            p->log,
            p->space == WEFT_SPACE_WORLD ? weft_volume_get_info(volume)->index_to_world : NULL,
            &transform);
    if (res != WEFT_OK)
        goto fail;
    size_t bytes;
    planes = weft_size_mul(run->count, 4 * sizeof *planes, &bytes) ? malloc(bytes) : NULL;
    if (!planes) {
        weft_error(p->log, "sample: no memory for the derivatives of %zu points", run->count);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    run->out = planes;
    res = weft_points_run(points, run, NULL);
    for (size_t i = 0; i < run->count && res == WEFT_OK; i++) {
        double derivative[3], channel[3];
        for (size_t a = 0; a < 3; a++)
            derivative[a] = (double)planes[(a + 1) * run->count + i];
        weft_quantities_compute(&list, &transform, derivative, channel);
        value[i] = planes[i];
        for (int a = 0; a < 3; a++)
            gradient[i][a] = (float)channel[a];
    }
fail:
    free(planes);
    return res;
}

enum weft_result weft_sample(weft_volume *volume, const struct weft_sample_params *params,
                             size_t count, const double (*position)[3], float *value,
                             float (*gradient)[3])
{
    static const struct weft_derivative derivative[] = {
        {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_sample_params *p = params ? params : weft_sample_params();
    weft_points *points = NULL;
    struct weft_kernel kernel;
    weft_require(p->log, volume);
    weft_require(p->log, count == 0 || (position && value));
    weft_require(p->log, !p->grid);
    res = read_kernel(p->log, p->kernel, &kernel);
    if (res == WEFT_OK)
        res = weft_points_create(
            weft_points_params(.volume = volume, .kernel = kernel, .space = p->space,
                               .derivative = gradient ? derivative : NULL,
                               .derivative_count = gradient ? 4 : 0, .cpu = p->cpu,
                               .memory_bytes = p->memory_bytes, .log = p->log),
            &points);
    if (res != WEFT_OK || count == 0)
        goto fail;
    struct weft_points_run_params run = {
        .count = count, .position = position, .out = value, .progress = p->progress};
    res = gradient ? sample_gradients(points, volume, p, &run, gradient)
                   : weft_points_run(points, &run, NULL);
fail:
    weft_points_destroy(&points);
    return res;
}

enum weft_result weft_sample_file(const char *path, const struct weft_sample_params *params,
                                  size_t count, const double (*position)[3], float *value,
                                  float (*gradient)[3])
{
    struct weft_sample_params of_volume =
        params ? *params : (struct weft_sample_params){WEFT_SAMPLE_DEFAULTS};
    weft_volume *volume = NULL;
    enum weft_result res = open_grid(of_volume.log, path, of_volume.grid, &volume);
    of_volume.grid = NULL;
    if (res == WEFT_OK)
        res = weft_sample(volume, &of_volume, count, position, value, gradient);
    weft_volume_destroy(&volume);
    return res;
}
