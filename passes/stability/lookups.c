// SPDX-License-Identifier: BSD-3-Clause
// Cases of samplers and taps: how fine their weights are, and where they lie.
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/stability/cases.h"

// Both ways of a slice, as relative errors. pixels: room for one of them.
static enum weft_result compare_naive(const struct weft_stability_params *params,
                                      const struct weft_stability_slice *slice,
                                      const struct weft_naive_slice *naive, float *pixels,
                                      struct weft_stability_result *result)
{
    struct weft_stability_error error = {0};
    enum weft_result res = weft_stability_slice_run(params, slice, pixels, &result->limit);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, slice, pixels, 0.0, &error);
    result->ours = weft_stability_relative(&error);
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, slice, naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, slice, pixels, 0.0, &error);
    result->naive = weft_stability_relative(&error);
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
    // The limit is what the slice's plan promises.
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
    // The limit is what the slice's plan promises.
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

// ---- positions on the lattice -------------------------------------------------------------------

enum { LATTICE = 16 };

static enum weft_result lattice_naive(const struct weft_stability_params *params, const float *data,
                                      float *pixels, double *error)
{
    const struct weft_samples samples = {
        .size = {LATTICE, LATTICE, 1}, .plane = {data}, .low = -1.0, .high = 1.0};
    const struct weft_pixel_grid grid = {
        .width = LATTICE, .height = LATTICE, .du = {1.0}, .dv = {0.0, 1.0}};
    struct weft_convolve_error e = {0};
    struct weft_plan_error bounds = {0};
    const enum weft_result res = weft_stability_passes_run(
        params, weft_plan_params(.samples = 16, .profile = *weft_profile_find("fp32")), &samples,
        &grid, pixels, &e, &bounds);
    *error = e.maximum;
    return res;
}

static enum weft_result measure_on_lattice(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    const int size[3] = {LATTICE, LATTICE, 1};
    float data[LATTICE * LATTICE], pixels[LATTICE * LATTICE];
    const struct weft_stability_slice slice = {.kernel = "catmull-rom",
                                               .data = data,
                                               .size = {LATTICE, LATTICE, 1},
                                               .geometry = {.origin = {-0.5, -0.5, 0.0},
                                                            .u = {LATTICE, 0.0, 0.0},
                                                            .v = {0.0, LATTICE, 0.0},
                                                            .width = LATTICE,
                                                            .height = LATTICE}};
    double bound;
    weft_stability_fill_noise(data, size);
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &bound);
    result->ours = 0.0;
    for (int i = 0; res == WEFT_OK && i < LATTICE * LATTICE; i++)
        result->ours = fmax(result->ours, fabs((double)pixels[i] - (double)data[i]));
    // At fraction 0 the polynomials of Catmull-Rom are 0, 1, 0 and 0 without a rounding.
    result->limit = 0.0;
    if (res == WEFT_OK)
        res = lattice_naive(params, data, pixels, &result->naive);
    weft_stability_say(result, "absolute", "samples in [-1, 1] come back changed by up to %.3f",
                       result->naive);
    return res;
}

const struct weft_stability_case weft_stability_on_lattice = {
    .name = "on-lattice",
    .failure = "an interpolating kernel does not return the samples themselves",
    .naive = "tiles sampled at centres, looked up at the nearest of 16 samples",
    .ours = "polynomial tiles, exact at fraction 0",
    .source = "Hadwiger, Hauser and Moeller, WSCG 2003",
    .needs_context = true,
    .measure = measure_on_lattice,
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
        struct weft_stability_error naive = {0}, ours = {0};
        double bound = 0.0;
        slice.kernel = kernels[k];
        res = weft_stability_slice_run(params, &slice, pixels, &bound);
        if (res == WEFT_OK)
            res = weft_stability_compare(params->log, &slice, pixels, 0.0, &ours);
        if (res == WEFT_OK)
            res = weft_naive_convolve(params->log, &slice, WEFT_NAIVE_FLOOR, pixels);
        if (res == WEFT_OK)
            res = weft_stability_compare(params->log, &slice, pixels, 0.0, &naive);
        result->naive = fmax(result->naive, weft_stability_relative(&naive));
        result->ours = fmax(result->ours, weft_stability_relative(&ours));
        // What the plans promise, the largest of the three.
        result->limit = fmax(result->limit, bound);
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
