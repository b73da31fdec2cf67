// SPDX-License-Identifier: BSD-3-Clause
// Cases of samplers and taps: how fine their weights are, and where they lie.
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/stability/cases.h"

// The limit is what the slice's plan promises.
static enum weft_result compare_naive(const struct weft_stability_params *params,
                                      const struct weft_stability_slice *slice,
                                      const struct weft_naive_slice *naive, float *pixels,
                                      struct weft_stability_result *result)
{
    struct weft_stability_ways ways;
    const enum weft_result res = weft_stability_compare_ways(params, slice, naive, pixels, &ways);
    result->limit = ways.bound.relative;
    result->ours = ways.ours.relative_maximum;
    result->naive = ways.naive.relative_maximum;
    return res;
}

// ---- weights of samplers ------------------------------------------------------------------------

enum { MAGNIFIED = 2048 };

static int count_levels(const float *pixels, int count)
{
    int levels = 1;
    for (int i = 1; i < count; i++)
        levels += pixels[i] != pixels[i - 1];
    return levels;
}

// From a black voxel to a white one, 2048 pixels: a ramp.
static enum weft_result measure_filter_weights(const struct weft_stability_params *params,
                                               struct weft_stability_result *result)
{
    static const float data[4] = {0.0f, 0.0f, 1.0f, 1.0f};
    const struct weft_stability_slice slice = {.kernel = "linear",
                                               .data = data,
                                               .size = {4, 1, 1},
                                               .geometry = {.origin = {1.0, -0.5, 0.0},
                                                            .u = {1.0, 0.0, 0.0},
                                                            .v = {0.0, 1.0, 0.0},
                                                            .width = MAGNIFIED,
                                                            .height = 1}};
    const struct weft_naive_slice naive = {
        .lookup = WEFT_NAIVE_SAMPLER, .source = GL_R8, .target = GL_R32F};
    float pixels[MAGNIFIED];
    const enum weft_result res = compare_naive(params, &slice, &naive, pixels, result);
    weft_stability_say(result, "relative", "a ramp of %d pixels has %d levels", MAGNIFIED,
                       res == WEFT_OK ? count_levels(pixels, MAGNIFIED) : 0);
    return res;
}

const struct weft_stability_case weft_stability_filter_weights = {
    .name = "filter-weights",
    .failure = "8-bit textures are filtered with 256 weights: steps when magnified",
    .naive = "GL_LINEAR on an 8-bit texture",
    .ours = "weights from polynomial tiles, summed in single precision",
    .source = "Mesa 22.3, lp_bld_sample_soa.c, use_aos",
    .needs_context = true,
    .measure = measure_filter_weights,
};

static enum weft_result measure_texel_centres(const struct weft_stability_params *params,
                                              struct weft_stability_result *result)
{
    enum { N = 16, SHOWN = 40 };
    const int size[3] = {N, N, N};
    float pixels[SHOWN * SHOWN];
    float *data = malloc(N * N * N * sizeof *data);
    if (!data)
        return WEFT_ERR_MEMORY;
    weft_stability_fill_noise(data, size);
    const struct weft_stability_slice slice = {
        .kernel = "linear",
        .data = data,
        .size = {N, N, N},
        .geometry = weft_stability_oblique((const int32_t[3]){0, 0, 0}, N, SHOWN, SHOWN)};
    const struct weft_naive_slice naive = {
        .lookup = WEFT_NAIVE_CORNERS, .source = GL_R32F, .target = GL_R32F};
    const enum weft_result res = compare_naive(params, &slice, &naive, pixels, result);
    free(data);
    weft_stability_say(result, "relative",
                       "positions are off by up to half a voxel, values by %.2f", result->naive);
    return res;
}

const struct weft_stability_case weft_stability_texel_centres = {
    .name = "texel-centres",
    .failure = "texture coordinates run from border to border, samples from centre to centre",
    .naive = "the sampler at position / (size - 1)",
    .ours = "voxels by their integer coordinates",
    .source = "OpenGL 4.5, section 8.14",
    .needs_context = true,
    .measure = measure_texel_centres,
};

// ---- the same size ------------------------------------------------------------------------------

enum { COLUMNS = 1920, ROWS = 3 };

static int count_changed(const float *pixels, const float *data)
{
    int changed = 0;
    for (int i = 0; i < COLUMNS * ROWS; i++)
        changed += pixels[i] != data[i];
    return changed;
}

// Small samples, and beside every third a large one, whose weight is to be exactly 0.
static void fill_contrasts(float *data)
{
    for (int i = 0; i < COLUMNS * ROWS; i++)
        data[i] = (i % 3 ? 1.0f : 1e30f) * weft_stability_noise(i, 0, 0);
}

static enum weft_result measure_same_size(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    const struct weft_naive_slice naive = {
        .normalised = true, .source = GL_R32F, .target = GL_R32F};
    struct weft_stability_bound bound;
    float *data = malloc(2 * COLUMNS * ROWS * sizeof *data);
    if (!data)
        return WEFT_ERR_MEMORY;
    float *pixels = data + COLUMNS * ROWS;
    const struct weft_stability_slice slice = {.kernel = "catmull-rom",
                                               .data = data,
                                               .size = {COLUMNS, ROWS, 1},
                                               .geometry = {.origin = {-0.5, -0.5, 0.0},
                                                            .u = {COLUMNS, 0.0, 0.0},
                                                            .v = {0.0, ROWS, 0.0},
                                                            .width = COLUMNS,
                                                            .height = ROWS}};
    fill_contrasts(data);
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &bound);
    result->ours = count_changed(pixels, data);
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, &slice, &naive, pixels);
    result->naive = count_changed(pixels, data);
    // Positions of whole ratios are whole, and there an interpolating kernel is 0, 1, 0 and 0.
    result->limit = 0.0;
    free(data);
    weft_stability_say(result, "pixels",
                       "%d columns of the same size: %.0f of %d samples come back changed", COLUMNS,
                       result->naive, COLUMNS * ROWS);
    return res;
}

const struct weft_stability_case weft_stability_same_size = {
    .name = "same-size",
    .failure = "a picture resampled to its own size is not the picture",
    .naive = "positions by way of a texture coordinate, in single precision",
    .ours = "positions that are exact where the ratio is whole",
    .needs_context = true,
    .measure = measure_same_size,
};

// ---- odd widths ---------------------------------------------------------------------------------

static enum weft_result measure_odd_width(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    enum { N = 12, SHOWN = 24 };
    static const char *const kernels[] = {"bspline2", "bspline4", "bspline6"};
    const int size[3] = {N, N, N};
    float data[N * N * N], pixels[SHOWN * SHOWN];
    struct weft_stability_slice slice = {
        .data = data,
        .size = {N, N, N},
        .geometry = weft_stability_oblique((const int32_t[3]){0, 0, 0}, N, SHOWN, SHOWN)};
    enum weft_result res = WEFT_OK;
    weft_stability_fill_noise(data, size);
    result->naive = result->ours = result->limit = 0.0;
    for (size_t k = 0; res == WEFT_OK && k < WEFT_COUNT(kernels); k++) {
        struct weft_verify_report naive = {0}, ours = {0};
        struct weft_stability_bound bound = {0};
        slice.kernel = kernels[k];
        res = weft_stability_slice_run(params, &slice, pixels, &bound);
        if (res == WEFT_OK)
            res = weft_stability_compare(params->log, &slice, pixels, NULL, &ours);
        if (res == WEFT_OK)
            res = weft_naive_convolve(params->log, &slice, WEFT_NAIVE_FLOOR, pixels);
        if (res == WEFT_OK)
            res = weft_stability_compare(params->log, &slice, pixels, NULL, &naive);
        result->naive = fmax(result->naive, naive.relative_maximum);
        result->ours = fmax(result->ours, ours.relative_maximum);
        // What the plans promise, the largest of the three.
        result->limit = fmax(result->limit, bound.relative);
    }
    weft_stability_say(result, "relative",
                       "bspline2, bspline4 and bspline6: naive values are off "
                       "by up to %.2f of the largest sample",
                       result->naive);
    return res;
}

const struct weft_stability_case weft_stability_odd_width = {
    .name = "odd-width",
    .failure = "kernels of 3, 5 and 7 taps are shifted by half a voxel",
    .naive = "the first tap from floor(x), as for even widths",
    .ours = "the first tap from floor(x + 1/2)",
    .needs_context = true,
    .measure = measure_odd_width,
};
