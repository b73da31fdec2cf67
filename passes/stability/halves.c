// SPDX-License-Identifier: BSD-3-Clause
// Cases of half floats: many passes, values beyond them.
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/stability/cases.h"

// ---- passes in half floats ----------------------------------------------------------------------

enum { SIDE = 16, SHIFTED = 48, PIXELS = SHIFTED * SHIFTED };

// On the fp16 profile, so many taps a pass.
static enum weft_result run_half(const struct weft_stability_params *params, int taps_per_pass,
                                 const float *plane, float *pixels,
                                 struct weft_verify_report *error)
{
    struct weft_pass_plan_error bounds;
    const struct weft_samples samples = {
        .size = {SIDE, SIDE, SIDE}, .plane = {plane}, .low = 0.0, .high = 1.0};
    const struct weft_pixel_grid grid = {.width = SHIFTED,
                                         .height = SHIFTED,
                                         .origin = {4.0625, 4.0625, 7.5625},
                                         .du = {0.125},
                                         .dv = {0, 0.125}};
    struct weft_pass_plan_params *plan =
        weft_pass_plan_params(.dims = 3, .samples = 8, .taps_per_pass = taps_per_pass,
                              .profile = *weft_profile_find("fp16"));
    const enum weft_result res = weft_kernel_parse(params->log, "bspline", &plan->kernel);
    return res == WEFT_OK
               ? weft_stability_passes_run(params, plan, &samples, &grid, pixels, error, &bounds)
               : res;
}

// All samples near 1, where a half float has steps of 2^-11.
static enum weft_result measure_half_passes(const struct weft_stability_params *params,
                                            struct weft_stability_result *result)
{
    const int size[3] = {SIDE, SIDE, SIDE};
    struct weft_verify_report many = {0}, few = {0};
    float *plane = malloc((SIDE * SIDE * SIDE + PIXELS) * sizeof *plane);
    if (!plane)
        return WEFT_ERR_MEMORY;
    float *pixels = plane + SIDE * SIDE * SIDE;
    weft_stability_fill_noise(plane, size);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        plane[i] = 0.95f + 0.05f * plane[i];
    enum weft_result res = run_half(params, 1, plane, pixels, &many);
    if (res == WEFT_OK)
        res = run_half(params, 0, plane, pixels, &few);
    free(plane);
    if (res != WEFT_OK)
        return res;
    result->naive = many.maximum;
    result->ours = few.maximum;
    // Sums of samples and weights of at most 1 stay below 1, where half floats are 2^-11 apart, so
    // that a store loses less than that. Positions are those of the tiles' samples; weights,
    // samples and the result are rounded to single precision.
    const int passes = 64 / weft_profile_find("fp16")->taps_per_pass;
    result->limit = passes * 0x1p-11 + 3.0 * 0x1p-24;
    weft_stability_say(result, "of 1.0",
                       "64 passes of a tap each lose up to %.2g, as many taps a pass as the "
                       "profile has %.2g",
                       result->naive, result->ours);
    return WEFT_OK;
}

const struct weft_stability_case weft_stability_half_passes = {
    .name = "half-passes",
    .failure = "a tri-cubic kernel in 64 passes on a half-float target",
    .naive = "a tap a pass, each sum stored as a half float",
    .ours = "as many taps a pass as the target's hardware sums in single precision",
    .source = "Mesa 22.3, lp_bld_conv.c: stores to half floats truncate",
    .measure = measure_half_passes,
};

// ---- values beyond half floats ------------------------------------------------------------------

enum { WIDE = 16, SHOWN = 32 };

static enum weft_result half_naive(const struct weft_stability_params *params, const float *plane,
                                   float *pixels, double *error)
{
    const struct weft_stability_slice slice = {.kernel = "catmull-rom",
                                               .data = plane,
                                               .size = {WIDE, WIDE, 1},
                                               .geometry = {.origin = {2.0, 2.0, 0.0},
                                                            .u = {12.0, 0.0, 0.0},
                                                            .v = {0.0, 12.0, 0.0},
                                                            .width = SHOWN,
                                                            .height = SHOWN}};
    const struct weft_naive_slice naive = {.source = GL_R16F, .target = GL_R16F};
    struct weft_verify_report e = {0};
    enum weft_result res = weft_naive_slice_run(params, &slice, &naive, pixels);
    if (res == WEFT_OK)
        res = weft_stability_compare(params->log, &slice, pixels, NULL, &e);
    *error = e.relative_maximum;
    return res;
}

static enum weft_result half_ours(const struct weft_stability_params *params, const float *plane,
                                  float *pixels, struct weft_stability_result *result)
{
    const double step = 12.0 / SHOWN, high = 1e5;
    const struct weft_samples samples = {
        .size = {WIDE, WIDE, 1}, .plane = {plane}, .low = 0.0, .high = high};
    const struct weft_pixel_grid grid = {.width = SHOWN,
                                         .height = SHOWN,
                                         .origin = {2.0 + 0.5 * step, 2.0 + 0.5 * step},
                                         .du = {step},
                                         .dv = {0, step}};
    struct weft_verify_report error = {0};
    struct weft_pass_plan_error bounds = {0};
    const enum weft_result res = weft_stability_passes_run(
        params, weft_pass_plan_params(.profile = *weft_profile_find("fp16")), &samples, &grid,
        pixels, &error, &bounds);
    result->ours = error.maximum / high;
    // The plan's, for any input, in units of the range that was mapped; and the result's rounding.
    result->limit = bounds.bound_any + 0x1p-24;
    return res;
}

static enum weft_result measure_half_overflow(const struct weft_stability_params *params,
                                              struct weft_stability_result *result)
{
    const int size[3] = {WIDE, WIDE, 1};
    float plane[WIDE * WIDE], pixels[SHOWN * SHOWN];
    int infinite = 0;
    weft_stability_fill_noise(plane, size);
    for (int i = 0; i < WIDE * WIDE; i++)
        plane[i] = 5e4f + 5e4f * plane[i];
    enum weft_result res = half_naive(params, plane, pixels, &result->naive);
    for (int i = 0; res == WEFT_OK && i < SHOWN * SHOWN; i++)
        infinite += !isfinite(pixels[i]);
    if (res == WEFT_OK)
        res = half_ours(params, plane, pixels, result);
    weft_stability_say(result, "relative", "samples up to 100000: %d of %d pixels are not finite",
                       infinite, SHOWN * SHOWN);
    return res;
}

const struct weft_stability_case weft_stability_half_overflow = {
    .name = "half-overflow",
    .failure = "samples beyond 65504, the largest half float",
    .naive = "half-float texture and target, values as they are",
    .ours = "the planner's fp16 profile, the range mapped to [0, 1]",
    .source = "IEEE 754, binary16",
    .needs_context = true,
    .measure = measure_half_overflow,
};
