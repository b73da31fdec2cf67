// SPDX-License-Identifier: BSD-3-Clause
// Cases of what samples hold: wide ranges, NaN, denormals, steps.
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/analysis.h"
#include "filter/check.h"
#include "passes/stability/cases.h"
#include "tiles/image.h"

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

// +-10^-36 to 10^37.
static float fill_wide(int x, int y)
{
    const double exponent = -36.0 + 73.0 * fabs(y - 199.5) / 199.5;
    return (float)((y < 200 ? -1.0 : 1.0) * (1.0 + x / 400.0) * pow(10.0, exponent));
}

static enum weft_result measure_wide_range(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    enum { SHOWN = 160 };
    // Products below FLT_MIN are denormals, which GL may flush to 0. All 64 together are 2^-18 of
    // this, less than the plan's bound: errors of pixels with smaller samples are relative to it.
    const double smallest = (double)FLT_MIN * 0x1p24;
    const struct weft_naive_slice naive = {.source = GL_R16, .target = GL_R32F, .mapped = true};
    struct weft_stability_error error = {0};
    struct plane plane;
    float *pixels = malloc(SHOWN * SHOWN * sizeof *pixels);
    enum weft_result res = get_plane(params, wide_name, fill_wide, &plane);
    if (res == WEFT_OK && !pixels)
        res = WEFT_ERR_MEMORY;
    const struct weft_stability_slice slice = {.kernel = "catmull-rom",
                                               .data = plane.data,
                                               .size = {plane.width, plane.height, 1},
                                               .geometry = {.origin = {2.0, 1.0, 0.0},
                                                            .u = {plane.width - 9.0, 3.0, 0.0},
                                                            .v = {2.0, plane.height - 9.0, 0.0},
                                                            .width = SHOWN,
                                                            .height = SHOWN}};
    // The limit is what the slice's plan promises, relative to the largest sample in reach.
    if (res == WEFT_OK)
        res = weft_stability_slice_run(params, &slice, pixels, &result->limit);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, smallest, &error);
    result->ours = weft_stability_relative(&error);
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, &slice, &naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, smallest, &error);
    result->naive = weft_stability_relative(&error);
    free(plane.data);
    free(pixels);
    weft_stability_say(result, "relative", "%s, 70 orders of magnitude and more: %s",
                       plane_name(&plane, wide_name),
                       error.mismatches ? "the range itself is beyond single precision"
                                        : "on 16 bits the small ones are lost");
    return res;
}

const struct weft_stability_case weft_stability_wide_range = {
    .name = "wide-range",
    .failure = "samples of both signs and more than 70 orders of magnitude",
    .naive = "the range mapped to [0, 1] on 16 bits, and back",
    .ours = "samples as they are, in single precision",
    .image = wide_name,
    .needs_context = true,
    .measure = measure_wide_range,
};

// ---- NaN and infinity ---------------------------------------------------------------------------

static const char rings_name[] = "BrightRingsNanInf.exr";

static float fill_rings(int x, int y)
{
    if (x % 20 == 0 && y % 20 == 0 && x >= 320 && y >= 320)
        return x % 40 ? NAN : INFINITY;
    return 500.0f + 500.0f * (float)sin(0.05 * hypot(x, y));
}

static enum weft_result measure_not_finite(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    enum { SHOWN = 128 };
    const struct weft_naive_slice naive = {
        .lookup = WEFT_NAIVE_LINEAR_OF_FOUR, .source = GL_R32F, .target = GL_R32F};
    struct weft_stability_error error = {0};
    struct plane plane;
    double bound;
    float *pixels = malloc(SHOWN * SHOWN * sizeof *pixels);
    enum weft_result res = get_plane(params, rings_name, fill_rings, &plane);
    if (res == WEFT_OK && !pixels)
        res = WEFT_ERR_MEMORY;
    // Every not finite sample of the file's lower left quarter, and no position on a sample.
    const struct weft_stability_slice slice = {.kernel = "linear",
                                               .data = plane.data,
                                               .size = {plane.width, plane.height, 1},
                                               .geometry = {.origin = {310.13, 310.17, 0.0},
                                                            .u = {83.1, 0.0, 0.0},
                                                            .v = {0.0, 83.3, 0.0},
                                                            .width = SHOWN,
                                                            .height = SHOWN}};
    if (res == WEFT_OK)
        res = weft_stability_slice_run(params, &slice, pixels, &bound);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &error);
    result->ours = (double)error.mismatches;
    result->limit = 0.0; // exactly what eq. 1 of the kernel reaches
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, &slice, &naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &error);
    result->naive = (double)error.mismatches;
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

// ---- denormals ----------------------------------------------------------------------------------

static enum weft_result measure_denormals(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    enum { N = 12, SHOWN = 24 };
    const int size[3] = {N, N, N};
    float data[N * N * N], pixels[SHOWN * SHOWN];
    const struct weft_naive_slice naive = {.source = GL_R32F, .target = GL_R32F, .mapped = true};
    const struct weft_stability_slice slice = {
        .kernel = "catmull-rom",
        .data = data,
        .size = {N, N, N},
        .geometry = weft_stability_oblique((const int32_t[3]){0, 0, 0}, N, SHOWN, SHOWN)};
    struct weft_stability_error error = {0};
    double bound;
    bool flushed = true;
    weft_stability_fill_noise(data, size);
    for (int i = 0; i < N * N * N; i++)
        data[i] = (float)(1e-40 * (double)data[i]);
    enum weft_result res = weft_stability_slice_run(params, &slice, pixels, &bound);
    for (int i = 0; res == WEFT_OK && i < SHOWN * SHOWN; i++)
        flushed &= pixels[i] == 0.0f;
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &error);
    result->ours = error.mismatches ? (double)INFINITY : error.absolute / (double)FLT_MIN;
    // Nothing is promised of denormals but that they may count as 0, and no more than that is lost.
    result->limit = 1.0;
    if (res == WEFT_OK)
        res = weft_naive_slice_run(params, &slice, &naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, 0.0, &error);
    result->naive = error.mismatches ? (double)INFINITY : error.absolute / (double)FLT_MIN;
    weft_stability_say(result, "FLT_MIN",
                       "samples up to 1e-40: %s; 1 / (high - low) is infinite, "
                       "%d of %d pixels are not finite",
                       flushed ? "all flushed to 0, so lost" : "kept", (int)error.mismatches,
                       SHOWN * SHOWN);
    return res;
}

const struct weft_stability_case weft_stability_denormals = {
    .name = "denormals",
    .failure = "samples below the smallest normal float, 1.2e-38",
    .naive = "the range mapped to [0, 1] by its reciprocal, and back",
    .ours = "samples as they are: denormals may be lost, nothing else",
    .source = "Mesa 22.3, lp_rast.c: denormals are flushed",
    .needs_context = true,
    .measure = measure_denormals,
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
    double bound;
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
    result->limit = bound; // clamping to samples in range leaves nothing but the plan's error
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
