// SPDX-License-Identifier: BSD-3-Clause
// Cases of where slices and volumes lie, and of their extent.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/stability/cases.h"

// ---- far from the origin ------------------------------------------------------------------------

enum { FAR_SIDE = 24, FAR_SHOWN = 64 };

static enum weft_result measure_far_away(const struct weft_stability_params *params,
                                         struct weft_stability_result *result)
{
    const int size[3] = {FAR_SIDE, FAR_SIDE, FAR_SIDE};
    const int32_t first[3] = {10000019, -20000003, 30000001};
    float pixels[FAR_SHOWN * FAR_SHOWN];
    float *data = malloc(FAR_SIDE * FAR_SIDE * FAR_SIDE * sizeof *data);
    if (!data)
        return WEFT_ERR_MEMORY;
    weft_stability_fill_noise(data, size);
    struct weft_stability_slice slice = {
        .kernel = "catmull-rom",
        .data = data,
        .size = {FAR_SIDE, FAR_SIDE, FAR_SIDE},
        .geometry = weft_stability_oblique(first, FAR_SIDE, FAR_SHOWN, FAR_SHOWN)};
    const struct weft_naive_slice naive = {.source = GL_R32F, .target = GL_R32F};
    struct weft_stability_error error = {0};
    memcpy(slice.first, first, sizeof first);
    // The limit is what the slice's plan promises anywhere.
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &result->limit);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &error);
    result->ours = weft_stability_relative(&error);
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, &slice, &naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &error);
    result->naive = weft_stability_relative(&error);
    free(data);
    weft_stability_say(result, "relative",
                       "at index 10^7 single precision knows whole voxels only: "
                       "values are off by %.2f",
                       result->naive);
    return res;
}

const struct weft_stability_case weft_stability_far_away = {
    .name = "far-away",
    .failure = "voxels at indices of 10^7 and more",
    .naive = "a shader's positions in single precision",
    .ours = "positions in fixed point relative to a local origin",
    .needs_context = true,
    .measure = measure_far_away,
};

// ---- planes that are none -----------------------------------------------------------------------

static const struct weft_slice_geometry degenerate[] = {
    {.u = {0, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = 4},
    {.u = {1, 0, 0}, .v = {0, 0, 0}, .width = 4, .height = 4},
    {.u = {1, 1, 0}, .v = {2, 2, 0}, .width = 4, .height = 4},
    {.u = {1, 2, 3}, .v = {-1, -2, -3}, .width = 4, .height = 4},
    {.u = {1, NAN, 0}, .v = {0, 1, 0}, .width = 4, .height = 4},
    {.u = {1, 0, 0}, .v = {0, INFINITY, 0}, .width = 4, .height = 4},
    {.origin = {NAN, 0, 0}, .u = {1, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = 4},
    {.origin = {-INFINITY, 0, 0}, .u = {1, 0, 0}, .v = {0, 1, 0}, .width = 4, .height = 4},
};

// Whether a naive engine goes on with a plane that has no distance from the origin.
static bool naive_accepts_garbage(const struct weft_slice_geometry *g)
{
    const float u[3] = {(float)g->u[0], (float)g->u[1], (float)g->u[2]};
    const float v[3] = {(float)g->v[0], (float)g->v[1], (float)g->v[2]};
    const float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                        u[0] * v[1] - u[1] * v[0]};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    float distance = 0.0f;
    for (int a = 0; a < 3; a++)
        distance += n[a] / length * (float)g->origin[a];
    return !isfinite(distance);
}

struct refusal {
    int errors;
    bool clear; // one line that names what is wrong
};

static void keep_refusal(void *priv, enum weft_log_level level, const char *message)
{
    struct refusal *r = priv;
    if (level != WEFT_LOG_ERROR)
        return;
    r->errors++;
    r->clear = strstr(message, "parallel") || strstr(message, "finite");
}

static enum weft_result refuses(weft_volume *volume, const struct weft_slice_geometry *geometry,
                                bool *refused)
{
    struct refusal refusal = {0};
    const struct weft_log log = {keep_refusal, &refusal};
    const struct weft_slice_params slice = {
        .space = WEFT_SPACE_INDEX, .geometry = *geometry, .log = &log};
    weft_slice_plan *plan = NULL;
    const enum weft_result res = weft_slice_plan_create(volume, &slice, &plan);
    weft_slice_plan_destroy(&plan);
    *refused = res == WEFT_ERR_ARGUMENT && refusal.errors == 1 && refusal.clear;
    return res == WEFT_ERR_MEMORY ? res : WEFT_OK;
}

static enum weft_result measure_degenerate(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    static const float data[8];
    weft_volume *volume = NULL;
    enum weft_result res = weft_volume_create(
        weft_volume_params(.size = {2, 2, 2}, .data = data, .log = params->log), &volume);
    int garbage = 0, accepted = 0;
    for (size_t i = 0; res == WEFT_OK && i < WEFT_COUNT(degenerate); i++) {
        bool refused = false;
        res = refuses(volume, &degenerate[i], &refused);
        accepted += !refused;
        garbage += naive_accepts_garbage(&degenerate[i]);
    }
    weft_volume_destroy(&volume);
    result->naive = garbage;
    result->ours = accepted;
    result->limit = 0.0; // each is to be refused
    weft_stability_say(result, "requests",
                       "of %zu requests without a plane, %d go on with a normal or distance that "
                       "is NaN",
                       WEFT_COUNT(degenerate), garbage);
    return res;
}

const struct weft_stability_case weft_stability_degenerate = {
    .name = "degenerate",
    .failure = "slices with edges that are zero, parallel or not finite",
    .naive = "the plane's normal by a cross product, divided by its length",
    .ours = "refused when planned, with one line that says why",
    .measure = measure_degenerate,
};

// ---- small volumes ------------------------------------------------------------------------------

// Adds one volume and kernel to the largest errors, and to the largest limit.
static enum weft_result compare_small(const struct weft_stability_params *params, const int size[3],
                                      const char *kernel, enum weft_naive_mistake mistake,
                                      struct weft_stability_result *result)
{
    enum { SHOWN = 16 };
    float data[200], pixels[SHOWN * SHOWN];
    struct weft_stability_error naive = {0}, ours = {0};
    double bound = 0.0;
    struct weft_stability_slice slice = {
        .kernel = kernel,
        .data = data,
        .geometry = weft_stability_oblique((const int32_t[3]){-3, -3, -3}, 8.0, SHOWN, SHOWN)};
    memcpy(slice.size, size, sizeof slice.size);
    weft_stability_fill_noise(data, size);
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &bound);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &ours);
    if (res == WEFT_OK)
        res = weft_naive_convolve(params->log, &slice, mistake, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &naive);
    result->naive = fmax(result->naive, weft_stability_relative(&naive));
    result->ours = fmax(result->ours, weft_stability_relative(&ours));
    result->limit = fmax(result->limit, bound);
    return res;
}

static enum weft_result measure_one_voxel(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    static const int sizes[][3] = {{1, 1, 1}, {1, 9, 9}, {100, 1, 2}, {10, 10, 1}};
    enum weft_result res = WEFT_OK;
    result->naive = result->ours = result->limit = 0.0;
    // The limit is the largest that the slices' plans promise.
    for (size_t s = 0; res == WEFT_OK && s < WEFT_COUNT(sizes); s++)
        res = compare_small(params, sizes[s], "catmull-rom", WEFT_NAIVE_NORMALISED, result);
    weft_stability_say(result, "relative",
                       "1x1x1, 1x9x9, 100x1x2 and 10x10x1 voxels: 0 / 0 along an axis of one");
    return res;
}

const struct weft_stability_case weft_stability_one_voxel = {
    .name = "one-voxel",
    .failure = "volumes that are one voxel thick",
    .naive = "coordinates divided by size - 1",
    .ours = "voxels by their integer coordinates",
    .needs_context = true,
    .measure = measure_one_voxel,
};

static enum weft_result measure_wide_kernel(const struct weft_stability_params *params,
                                            struct weft_stability_result *result)
{
    static const char *const kernels[] = {"bspline7", "lanczos:5", "hann-sinc:4"};
    static const int size[3] = {3, 2, 4};
    enum weft_result res = WEFT_OK;
    result->naive = result->ours = result->limit = 0.0;
    // The limit is the largest that the slices' plans promise.
    for (size_t k = 0; res == WEFT_OK && k < WEFT_COUNT(kernels); k++)
        res = compare_small(params, size, kernels[k], WEFT_NAIVE_DROP, result);
    weft_stability_say(result, "relative",
                       "8 and 10 taps on 3x2x4 voxels: without those outside, "
                       "values are off by %.2f",
                       result->naive);
    return res;
}

const struct weft_stability_case weft_stability_wide_kernel = {
    .name = "wide-kernel",
    .failure = "kernels wider than the volume, whose edge is to be held",
    .naive = "taps outside are left out",
    .ours = "taps outside are the nearest voxel, however far",
    .needs_context = true,
    .measure = measure_wide_kernel,
};
