// SPDX-License-Identifier: BSD-3-Clause
// Cases of what samples hold: wide ranges, marks, NaN, steps.
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis/analysis.h"
#include "filter/check.h"
#include "passes/stability/cases.h"
#include "tiles/image/image.h"

// ---- images -------------------------------------------------------------------------------------

struct plane {
    int width, height;
    float *data;
    bool generated;
};

// The first channel of an image in the data folder; where there is none, `fill` makes one.
static enum weft_result get_plane(const struct weft_stability_params *params, const char *name,
                                  float (*fill)(int x, int y), struct plane *out)
{
    enum { SIDE = 400 };
    char path[4096];
    struct weft_image image;
    *out = (struct plane){.width = SIDE, .height = SIDE, .generated = true};
    snprintf(path, sizeof path, "%s/%s", params->data_folder ? params->data_folder : "", name);
    // A missing image is no error: its log stays silent.
    if (params->data_folder &&
        weft_image_load(&(struct weft_image_load_params){.path = path}, &image) == WEFT_OK) {
        out->width = image.width;
        out->height = image.height;
        out->generated = false;
        out->data = image.channels[0].plane;
        image.channels[0].plane = NULL;
        weft_image_clear(&image);
        return WEFT_OK;
    }
    out->data = malloc((size_t)SIDE * SIDE * sizeof *out->data);
    if (!out->data)
        return WEFT_ERR_MEMORY;
    for (int i = 0; i < SIDE * SIDE; i++)
        out->data[i] = fill(i % SIDE, i / SIDE);
    return WEFT_OK;
}

static const char *plane_name(const struct plane *plane, const char *name)
{
    return plane->generated ? "a generated image" : name;
}

// ---- dynamic range ------------------------------------------------------------------------------

static const char wide_name[] = "WideFloatRange.exr";

// +-10^-30 to 10^37.
static float fill_wide(int x, int y)
{
    const double exponent = -30.0 + 67.0 * fabs(y - 199.5) / 199.5;
    return (float)((y < 200 ? -1.0 : 1.0) * (1.0 + x / 400.0) * pow(10.0, exponent));
}

// A plane seen in SHOWN^2 pixels: the limit is all of the plan's bound, at every pixel.
static enum weft_result compare_plane(const struct weft_stability_params *params,
                                      const struct plane *plane, int shown,
                                      const struct weft_naive_slice *naive, float *pixels,
                                      struct weft_stability_result *result)
{
    const struct weft_stability_slice slice = {.kernel = "catmull-rom",
                                               .data = plane->data,
                                               .size = {plane->width, plane->height, 1},
                                               .geometry = {.origin = {2.0, 1.0, 0.0},
                                                            .u = {plane->width - 9.0, 3.0, 0.0},
                                                            .v = {2.0, plane->height - 9.0, 0.0},
                                                            .width = shown,
                                                            .height = shown}};
    struct weft_stability_ways ways;
    const enum weft_result res = weft_stability_compare_ways(params, &slice, naive, pixels, &ways);
    result->ours = ways.ours.share;
    result->naive = ways.naive.share;
    result->limit = 1.0;
    return res;
}

static enum weft_result measure_wide_range(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    enum { SHOWN = 160 };
    const struct weft_naive_slice naive = {.source = GL_R32F, .target = GL_R32F, .mapped = true};
    struct plane plane;
    float *pixels = malloc(SHOWN * SHOWN * sizeof *pixels);
    enum weft_result res = get_plane(params, wide_name, fill_wide, &plane);
    if (res == WEFT_OK && !pixels)
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = compare_plane(params, &plane, SHOWN, &naive, pixels, result);
    free(plane.data);
    free(pixels);
    weft_stability_say(result, "of the bound",
                       "%s, 60 orders of magnitude and more: mapped to [0, 1], %s",
                       plane_name(&plane, wide_name),
                       isinf(result->naive) ? "the range itself is beyond single precision"
                                            : "the small samples are lost beside the large ones");
    return res;
}

const struct weft_stability_case weft_stability_wide_range = {
    .name = "wide-range",
    .failure = "samples of both signs and more than 60 orders of magnitude",
    .naive = "the range mapped to [0, 1] in single precision, and back",
    .ours = "samples as they are, in single precision",
    .image = wide_name,
    .needs_context = true,
    .measure = measure_wide_range,
};

// ---- no data ------------------------------------------------------------------------------------

// A map with FLT_MAX where nothing is known, as image and terrain formats have it.
static float fill_no_data(int x, int y)
{
    return x > y ? FLT_MAX : 100.0f * weft_stability_noise(x, y, 0);
}

static enum weft_result measure_no_data(const struct weft_stability_params *params,
                                        struct weft_stability_result *result)
{
    enum { SIDE = 48, SHOWN = 96 };
    const struct weft_naive_slice naive = {.source = GL_R32F, .target = GL_R32F};
    float data[SIDE * SIDE], pixels[SHOWN * SHOWN];
    for (int i = 0; i < SIDE * SIDE; i++)
        data[i] = fill_no_data(i % SIDE, i / SIDE);
    const struct plane plane = {.width = SIDE, .height = SIDE, .data = data};
    const enum weft_result res = compare_plane(params, &plane, SHOWN, &naive, pixels, result);
    weft_stability_say(result, "of the bound", "FLT_MAX where nothing is known: %s",
                       isinf(result->naive) ? "sums overflow that come back to finite values"
                                            : "no sum overflows here");
    return res;
}

const struct weft_stability_case weft_stability_no_data = {
    .name = "no-data",
    .failure = "FLT_MAX as a mark: sums overflow on their way to a finite result",
    .naive = "taps summed as they come, in single precision",
    .ours = "samples scaled so that no sum on the way overflows",
    .needs_context = true,
    .measure = measure_no_data,
};

// ---- NaN and infinity ---------------------------------------------------------------------------

static const char rings_name[] = "BrightRingsNanInf.exr";

static float fill_rings(int x, int y)
{
    if (x % 20 == 0 && y % 20 == 0 && x >= 320 && y >= 320)
        return x % 40 ? NAN : INFINITY;
    return 500.0f + 500.0f * (float)sin(0.05 * hypot(x, y));
}

// Pixels that are finite and should not be, or the other way round.
static enum weft_result count_mismatches(const struct weft_stability_params *params,
                                         const struct plane *plane,
                                         const struct weft_slice_geometry *geometry, float *pixels,
                                         struct weft_stability_result *result)
{
    const struct weft_naive_slice naive = {
        .lookup = WEFT_NAIVE_LINEAR_OF_FOUR, .source = GL_R32F, .target = GL_R32F};
    const struct weft_stability_slice slice = {.kernel = "linear",
                                               .data = plane->data,
                                               .size = {plane->width, plane->height, 1},
                                               .geometry = *geometry};
    struct weft_stability_ways ways;
    const enum weft_result res = weft_stability_compare_ways(params, &slice, &naive, pixels, &ways);
    result->ours = (double)ways.ours.not_finite_mismatches;
    result->naive = (double)ways.naive.not_finite_mismatches;
    result->limit = 0.0; // exactly what eq. 1 of the kernel reaches with a weight that is not 0
    return res;
}

static enum weft_result measure_not_finite(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    enum { SHOWN = 128 };
    // Every not finite sample of the file's lower left quarter, and no position on a sample.
    static const struct weft_slice_geometry geometry = {.origin = {310.13, 310.17, 0.0},
                                                        .u = {83.1, 0.0, 0.0},
                                                        .v = {0.0, 83.3, 0.0},
                                                        .width = SHOWN,
                                                        .height = SHOWN};
    struct plane plane;
    float *pixels = malloc(SHOWN * SHOWN * sizeof *pixels);
    enum weft_result res = get_plane(params, rings_name, fill_rings, &plane);
    if (res == WEFT_OK && !pixels)
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = count_mismatches(params, &plane, &geometry, pixels, result);
    free(plane.data);
    free(pixels);
    weft_stability_say(result, "pixels", "%s: %.0f of %d pixels are NaN beyond the kernel's reach",
                       plane_name(&plane, rings_name), result->naive, SHOWN * SHOWN);
    return res;
}

const struct weft_stability_case weft_stability_not_finite = {
    .name = "not-finite",
    .failure = "NaN and infinity spread to pixels that they do not touch",
    .naive = "rows of four samples, padded with weights of 0",
    .ours = "samples past the last tap are never multiplied",
    .image = rings_name,
    .needs_context = true,
    .measure = measure_not_finite,
};

static enum weft_result measure_zero_weight(const struct weft_stability_params *params,
                                            struct weft_stability_result *result)
{
    enum { SIDE = 40 };
    float data[SIDE * SIDE], pixels[SIDE * SIDE];
    const struct plane plane = {.width = SIDE, .height = SIDE, .data = data};
    static const struct weft_slice_geometry lattice = {.origin = {-0.5, -0.5, 0.0},
                                                       .u = {SIDE, 0.0, 0.0},
                                                       .v = {0.0, SIDE, 0.0},
                                                       .width = SIDE,
                                                       .height = SIDE};
    for (int i = 0; i < SIDE * SIDE; i++)
        data[i] = i % 97 == 0 ? NAN : i % 89 == 0 ? INFINITY : weft_stability_noise(i, 0, 0);
    const enum weft_result res = count_mismatches(params, &plane, &lattice, pixels, result);
    weft_stability_say(result, "pixels",
                       "linear interpolation at the samples themselves: %.0f of %d pixels are NaN "
                       "by a weight of 0",
                       result->naive, SIDE * SIDE);
    return res;
}

const struct weft_stability_case weft_stability_zero_weight = {
    .name = "zero-weight",
    .failure = "NaN and infinity spread by taps whose weight is exactly 0",
    .naive = "every tap times its weight",
    .ours = "a tap of weight 0 does not count",
    .source = "IEEE 754: 0 times NaN, or infinity, is NaN",
    .needs_context = true,
    .measure = measure_zero_weight,
};

// ---- steps --------------------------------------------------------------------------------------

// By how much pixels leave [0, 1].
static double excess(const float *pixels, int count)
{
    double most = 0.0;
    for (int i = 0; i < count; i++)
        most = fmax(most, fmax((double)pixels[i] - 1.0, -(double)pixels[i]));
    return most;
}

static enum weft_result measure_ringing(const struct weft_stability_params *params,
                                        struct weft_stability_result *result)
{
    enum { N = 20, SHOWN = 1024 };
    float data[N], pixels[SHOWN];
    struct weft_stability_slice slice = {.data = data,
                                         .size = {N, 1, 1},
                                         .geometry = {.origin = {4.0, -0.5, 0.0},
                                                      .u = {11.0, 0.0, 0.0},
                                                      .v = {0.0, 1.0, 0.0},
                                                      .width = SHOWN,
                                                      .height = 1}};
    struct weft_stability_bound bound;
    for (int i = 0; i < N; i++)
        data[i] = i < N / 2 ? 0.0f : 1.0f;
    slice.kernel = "catmull-rom";
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &bound);
    const double cubic = excess(pixels, SHOWN);
    slice.kernel = "lanczos:3+unit";
    if (res == WEFT_OK)
        res = weft_stability_slice_run(params, &slice, pixels, &bound);
    result->naive = excess(pixels, SHOWN);
    slice.clamp = true;
    if (res == WEFT_OK)
        res = weft_stability_slice_run(params, &slice, pixels, &bound);
    result->ours = excess(pixels, SHOWN);
    result->limit =
        bound.relative; // clamping to samples in range leaves nothing but the plan's error
    weft_stability_say(result, "of the step",
                       "Lanczos overshoots by %.1f %%, Catmull-Rom by %.1f %%; clamped: %.1g",
                       100.0 * result->naive, 100.0 * cubic, result->ours);
    return res;
}

const struct weft_stability_case weft_stability_ringing = {
    .name = "ringing",
    .failure = "reconstructions leave the range of the samples next to a step",
    .naive = "Lanczos with six taps",
    .ours = "the same, each pixel clamped to the samples next to it",
    .source = "Mitchell and Netravali, SIGGRAPH 1988",
    .needs_context = true,
    .measure = measure_ringing,
};
