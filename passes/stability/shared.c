// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/stability/cases.h"

void weft_stability_say(struct weft_stability_result *result, const char *unit, const char *format,
                        ...)
{
    va_list list;
    snprintf(result->unit, sizeof result->unit, "%s", unit);
    va_start(list, format);
    vsnprintf(result->text, sizeof result->text, format, list);
    va_end(list);
}

float weft_stability_noise(int x, int y, int z)
{
    uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u ^ (uint32_t)z * 83492791u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (float)((double)(h ^ h >> 16) / 2147483647.5 - 1.0);
}

void weft_stability_fill_noise(float *data, const int size[3])
{
    for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++)
            for (int x = 0; x < size[0]; x++)
                *data++ = weft_stability_noise(x, y, z);
}

// ---- averages -----------------------------------------------------------------------------------

struct weft_plane weft_stability_frame(const struct weft_stability_frames *frames, int index)
{
    const size_t size =
        (size_t)frames->width * (size_t)frames->height * weft_plane_type_size(frames->type);
    return (struct weft_plane){.values = (const char *)frames->values + (size_t)index * size,
                               .type = frames->type};
}

enum weft_result weft_stability_accumulate(const struct weft_stability_params *params,
                                           const struct weft_stability_frames *frames,
                                           struct weft_accumulator_params how, double weight,
                                           float *out, struct weft_accumulator_report *report)
{
    weft_accumulator *a = NULL;
    how.width = frames->width;
    how.height = frames->height;
    how.channel_count = 1;
    how.context = params->context;
    how.emulate = !params->context;
    how.log = params->log;
    enum weft_result res = weft_accumulator_create(&how, &a);
    for (int i = 0; i < frames->count && res == WEFT_OK; i++) {
        const struct weft_plane plane = weft_stability_frame(frames, i);
        res = weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, weight);
    }
    if (res == WEFT_OK)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0);
    if (res == WEFT_OK && report)
        weft_accumulator_get_report(a, report);
    weft_accumulator_destroy(&a);
    return res;
}

// ---- slices -------------------------------------------------------------------------------------

struct weft_slice_geometry weft_stability_oblique(const int32_t first[3], double length, int width,
                                                  int height)
{
    static const double u[3] = {0.9, 0.4, 0.2}, v[3] = {-0.3, 0.8, 0.5};
    struct weft_slice_geometry g = {.width = width, .height = height};
    for (int a = 0; a < 3; a++) {
        g.u[a] = u[a] * length;
        g.v[a] = v[a] * length;
        g.origin[a] = first[a] + 0.5 * length - 0.5 * (g.u[a] + g.v[a]);
    }
    return g;
}

enum weft_result weft_stability_slice_run(const struct weft_stability_params *params,
                                          const struct weft_stability_slice *slice, float *pixels,
                                          struct weft_stability_bound *bound)
{
    struct weft_volume_params *volume_params =
        weft_volume_params(.data = slice->data, .log = params->log);
    struct weft_slice_params slice_params = {.space = WEFT_SPACE_INDEX,
                                             .geometry = slice->geometry,
                                             .clamp_to_samples = slice->clamp,
                                             .log = params->log};
    weft_volume *volume = NULL;
    weft_slice_plan *plan = NULL;
    memcpy(volume_params->size, slice->size, sizeof slice->size);
    memcpy(volume_params->origin, slice->first, sizeof slice->first);
    enum weft_result res = weft_kernel_parse(params->log, slice->kernel, &slice_params.kernel);
    if (res == WEFT_OK)
        res = weft_volume_create(volume_params, &volume);
    if (res == WEFT_OK)
        res = weft_slice_plan_create(volume, &slice_params, &plan);
    if (res == WEFT_OK) {
        const struct weft_slice_output *value = weft_slice_plan_get_info(plan)->output;
        *bound = (struct weft_stability_bound){value->error_bound, value->error_absolute};
        res = weft_slice_run_once(plan, weft_slice_compile_params(.context = params->context),
                                  weft_slice_run_params(.pixels = pixels), NULL);
    }
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    return res;
}

static int64_t clamped(int64_t i, int size)
{
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

// `priv` is a slice.
static double fetch(void *priv, const int64_t index[3])
{
    const struct weft_stability_slice *s = priv;
    const int64_t x = clamped(index[0] - s->first[0], s->size[0]),
                  y = clamped(index[1] - s->first[1], s->size[1]),
                  z = clamped(index[2] - s->first[2], s->size[2]);
    return (double)s->data[(z * s->size[1] + y) * s->size[0] + x];
}

static void pixel_position(const struct weft_slice_geometry *g, int x, int y, double position[3])
{
    for (int a = 0; a < 3; a++)
        position[a] =
            g->origin[a] + (x + 0.5) / g->width * g->u[a] + (y + 0.5) / g->height * g->v[a];
}

// In coordinates from the first voxel on, which are exact where index coordinates are large.
static struct weft_pixel_grid grid_of(const struct weft_stability_slice *slice)
{
    const struct weft_slice_geometry *g = &slice->geometry;
    struct weft_pixel_grid grid = {.width = g->width, .height = g->height};
    for (int a = 0; a < 3; a++) {
        grid.du[a] = g->u[a] / g->width;
        grid.dv[a] = g->v[a] / g->height;
        grid.origin[a] = (g->origin[a] - slice->first[a]) + 0.5 * grid.du[a] + 0.5 * grid.dv[a];
    }
    return grid;
}

enum weft_result weft_stability_compare(const struct weft_log *log,
                                        const struct weft_stability_slice *slice,
                                        const float *pixels,
                                        const struct weft_stability_bound *bound,
                                        struct weft_verify_report *out)
{
    const struct weft_pixel_grid grid = grid_of(slice);
    struct weft_pixels_verify_params *params =
        weft_pixels_verify_params(.dims = 3, .grid = &grid,
                                  .size = {slice->size[0], slice->size[1], slice->size[2]},
                                  .samples = {{.values = slice->data}},
                                  .pixels = {{.values = pixels}}, .how = {.max_seconds = INFINITY},
                                  .log = log);
    *out = (struct weft_verify_report){0};
    if (bound) {
        params->bound_relative = bound->relative;
        params->bound_absolute = bound->absolute;
    }
    const enum weft_result res = weft_kernel_parse(log, slice->kernel, &params->kernel[0]);
    return res == WEFT_OK ? weft_pixels_verify(params, out) : res;
}

enum weft_result weft_stability_compare_ways(const struct weft_stability_params *params,
                                             const struct weft_stability_slice *slice,
                                             const struct weft_naive_slice *naive, float *pixels,
                                             struct weft_stability_ways *out)
{
    *out = (struct weft_stability_ways){0};
    enum weft_result res = weft_stability_slice_run(params, slice, pixels, &out->bound);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, slice, pixels, &out->bound, &out->ours);
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, slice, naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, slice, pixels, &out->bound, &out->naive);
    return res;
}

// ---- passes of plans ----------------------------------------------------------------------------

enum weft_result weft_stability_passes_run(const struct weft_stability_params *params,
                                           const struct weft_pass_plan_params *plan_params,
                                           const struct weft_samples *samples,
                                           const struct weft_pixel_grid *grid, float *pixels,
                                           struct weft_verify_report *error,
                                           struct weft_pass_plan_error *bounds)
{
    struct weft_pass_plan_params p = *plan_params;
    weft_pass_plan *plan = NULL;
    p.log = params->log;
    enum weft_result res = weft_pass_plan_create(&p, &plan);
    if (res != WEFT_OK)
        return res;
    *bounds = weft_pass_plan_get_info(plan)->error;
    weft_multipass *compiled = NULL;
    const struct weft_multipass_run_params run = {
        .samples = samples, .grid = grid, .pixels = {pixels}, .log = params->log};
    const struct weft_multipass_verify_params verify = {.plan = plan,
                                                        .samples = samples,
                                                        .grid = grid,
                                                        .pixels = {pixels},
                                                        .how = {.max_seconds = INFINITY},
                                                        .log = params->log};
    res = weft_multipass_compile(
        params->context, weft_multipass_params(.plan = plan, .log = params->log), &compiled);
    if (res == WEFT_OK)
        res = weft_multipass_run(compiled, &run, NULL);
    if (res == WEFT_OK)
        res = weft_multipass_verify(&verify, error);
    weft_multipass_destroy(&compiled);
    weft_pass_plan_destroy(&plan);
    return res;
}

// ---- naive, on the CPU --------------------------------------------------------------------------

// Weights and the first tap along one axis, from the first voxel on; NAN weights for NAN.
static int64_t naive_weights(const struct weft_kernel *kernel, double at, double *weights)
{
    const double below = isnan(at) ? 0.0 : floor(at);
    for (int j = 0; j < kernel->width; j++)
        weights[j] = isnan(at)
                         ? (double)NAN
                         : weft_kernel_weight(kernel, at - below + weft_kernel_offset(kernel) - j);
    return (int64_t)below - (kernel->width - 1) / 2;
}

static double naive_sum(const struct weft_stability_slice *s, const struct weft_kernel *kernel,
                        enum weft_naive_mistake mistake, const double position[3])
{
    double weights[3][WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
    int64_t tap[3];
    const int w = kernel->width;
    for (int a = 0; a < 3; a++) {
        double at = position[a] - s->first[a];
        if (mistake == WEFT_NAIVE_NORMALISED)
            at = at / (s->size[a] - 1) * (s->size[a] - 1);
        tap[a] = naive_weights(kernel, at, weights[a]);
    }
    for (int i = 0; i < w * w * w; i++) {
        const int j[3] = {i % w, i / w % w, i / w / w};
        int64_t index[3];
        bool outside = false;
        double weight = 1.0;
        for (int a = 0; a < 3; a++) {
            weight *= weights[a][j[a]];
            outside |= tap[a] + j[a] < 0 || tap[a] + j[a] >= s->size[a];
            index[a] = s->first[a] + tap[a] + j[a];
        }
        if (!outside || mistake != WEFT_NAIVE_DROP)
            sum += weight * fetch((void *)s, index);
    }
    return sum;
}

enum weft_result weft_naive_convolve(const struct weft_log *log,
                                     const struct weft_stability_slice *slice,
                                     enum weft_naive_mistake mistake, float *pixels)
{
    struct weft_kernel kernel;
    const struct weft_slice_geometry *g = &slice->geometry;
    enum weft_result res = weft_kernel_parse(log, slice->kernel, &kernel);
    for (int y = 0; res == WEFT_OK && y < g->height; y++) {
        for (int x = 0; x < g->width; x++) {
            double position[3];
            pixel_position(g, x, y, position);
            *pixels++ = (float)naive_sum(slice, &kernel, mistake, position);
        }
    }
    return res;
}
