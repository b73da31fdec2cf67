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
    struct weft_stability_ways ways;
    memcpy(slice.first, first, sizeof first);
    const enum weft_result res = weft_stability_compare_ways(params, &slice, &naive, pixels, &ways);
    result->ours = ways.ours.relative_maximum;
    result->naive = ways.naive.relative_maximum;
    result->limit = ways.bound.relative; // what the slice's plan promises anywhere
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

// ---- small volumes ------------------------------------------------------------------------------

// Adds one volume and kernel to the largest errors, and to the largest limit.
static enum weft_result compare_small(const struct weft_stability_params *params, const int size[3],
                                      const char *kernel, enum weft_naive_mistake mistake,
                                      bool constant, struct weft_stability_result *result)
{
    enum { SHOWN = 16 };
    float data[200], pixels[SHOWN * SHOWN];
    struct weft_verify_report naive = {0}, ours = {0};
    struct weft_stability_bound bound = {0};
    struct weft_stability_slice slice = {
        .kernel = kernel,
        .data = data,
        .geometry = weft_stability_oblique((const int32_t[3]){-3, -3, -3}, 8.0, SHOWN, SHOWN)};
    memcpy(slice.size, size, sizeof slice.size);
    for (int i = 0; constant && i < size[0] * size[1] * size[2]; i++)
        data[i] = 1.0f;
    if (!constant)
        weft_stability_fill_noise(data, size);
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &bound);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, NULL, &ours);
    if (res == WEFT_OK)
        res = weft_naive_convolve(params->log, &slice, mistake, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, NULL, &naive);
    result->naive = fmax(result->naive, naive.relative_maximum);
    result->ours = fmax(result->ours, ours.relative_maximum);
    result->limit = fmax(result->limit, bound.relative);
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
        res = compare_small(params, sizes[s], "catmull-rom", WEFT_NAIVE_NORMALISED, false, result);
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
    static const char *const kernels[] = {"bspline7", "lanczos:5+unit", "hann-sinc:4+unit"};
    static const int size[3] = {3, 2, 4};
    enum weft_result res = WEFT_OK;
    result->naive = result->ours = result->limit = 0.0;
    // The limit is the largest that the slices' plans promise.
    for (size_t k = 0; res == WEFT_OK && k < WEFT_COUNT(kernels); k++)
        res = compare_small(params, size, kernels[k], WEFT_NAIVE_DROP, true, result);
    weft_stability_say(result, "relative",
                       "8 and 10 taps on 3x2x4 voxels of 1: without those outside, "
                       "a constant is off by %.2f",
                       result->naive);
    return res;
}

const struct weft_stability_case weft_stability_wide_kernel = {
    .name = "wide-kernel",
    .failure = "kernels wider than the volume: a constant does not stay constant",
    .naive = "taps outside are left out, as fetches out of range read 0",
    .ours = "taps outside are the nearest voxel, however far",
    .needs_context = true,
    .measure = measure_wide_kernel,
};
