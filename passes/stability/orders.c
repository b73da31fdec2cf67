// SPDX-License-Identifier: BSD-3-Clause
// Cases of passes on 8-bit targets: their order, their bias, the rounding of their weights.
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/stability/cases.h"

enum { SIDE = 8, M = 8, SHIFTED = SIDE * M, PIXELS = SHIFTED * SHIFTED };

static const char paper[] = "Hadwiger, Hauser and Moeller, WSCG 2003";

// A constant 1.0 comes back as 1.0: the weights of a position add up to 255 codes, products with
// the code of 1.0 are whole, so sums have no rounding but the result's to single precision, if the
// range is not scaled to leave other levels' roundings a margin.
static const double constant_limit_lsb = 255.0 * 0x1p-24;

// Reconstructs a constant 1.0, M pixels a sample, so that every sample of the tiles is met.
static enum weft_result run_constant(const struct weft_stability_params *params,
                                     const struct weft_pass_plan_params *plan, double *error_lsb,
                                     struct weft_pass_plan_error *bounds)
{
    const double step = 1.0 / M;
    const struct weft_pixel_grid grid = {
        .width = SHIFTED,
        .height = SHIFTED,
        .origin = {0.5 * step, 0.5 * step, plan->dims > 2 ? 0.5 * step : 0.0},
        .du = {step},
        .dv = {0, step}};
    struct weft_verify_report error = {0};
    float *plane = malloc((SIDE * SIDE * SIDE + PIXELS) * sizeof *plane);
    if (!plane)
        return WEFT_ERR_MEMORY;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        plane[i] = 1.0f;
    const struct weft_samples samples = {
        .size = {SIDE, SIDE, plan->dims > 2 ? SIDE : 1}, .plane = {plane}, .low = 0.0, .high = 1.0};
    const enum weft_result res = weft_stability_passes_run(
        params, plan, &samples, &grid, plane + SIDE * SIDE * SIDE, &error, bounds);
    *error_lsb = 255.0 * error.maximum;
    free(plane);
    return res;
}

static enum weft_result compare(const struct weft_stability_params *params,
                                const struct weft_pass_plan_params *naive,
                                const struct weft_pass_plan_params *ours,
                                struct weft_stability_result *result,
                                struct weft_pass_plan_error *bounds)
{
    enum weft_result res = run_constant(params, naive, &result->naive, bounds);
    return res == WEFT_OK ? run_constant(params, ours, &result->ours, bounds) : res;
}

// ---- orders -------------------------------------------------------------------------------------

static enum weft_result measure_order(const struct weft_stability_params *params, int dims,
                                      struct weft_stability_result *result)
{
    struct weft_pass_plan_error bounds = {0};
    const struct weft_pass_plan_params *naive =
        weft_pass_plan_params(.dims = dims, .samples = M, .taps_per_pass = 1,
                              .order = WEFT_ORDER_NATURAL);
    const struct weft_pass_plan_params *ours =
        weft_pass_plan_params(.dims = dims, .samples = M, .taps_per_pass = 1, .no_scale = true);
    const enum weft_result res = compare(params, naive, ours, result, &bounds);
    result->limit = constant_limit_lsb;
    weft_stability_say(result, "LSB", "Catmull-Rom in %dD: a constant 255 comes out as %.0f", dims,
                       255.0 - result->naive);
    return res;
}

static enum weft_result measure_order_2d(const struct weft_stability_params *params,
                                         struct weft_stability_result *result)
{
    return measure_order(params, 2, result);
}

static enum weft_result measure_order_3d(const struct weft_stability_params *params,
                                         struct weft_stability_result *result)
{
    return measure_order(params, 3, result);
}

const struct weft_stability_case weft_stability_order_2d = {
    .name = "order-2d",
    .failure = "sums of passes leave [0, 1] on the way and clamp, bi-cubic on 8 bits",
    .naive = "passes in the order of the taps",
    .ours = "the order that the planner finds",
    .source = paper,
    .measure = measure_order_2d,
};

const struct weft_stability_case weft_stability_order_3d = {
    .name = "order-3d",
    .failure = "sums of passes leave [0, 1] on the way and clamp, tri-cubic on 8 bits",
    .naive = "passes in the order of the taps",
    .ours = "the order that the planner finds",
    .source = paper,
    .measure = measure_order_3d,
};

static enum weft_result measure_gradient_bias(const struct weft_stability_params *params,
                                              struct weft_stability_result *result)
{
    struct weft_pass_plan_error bounds = {0};
    const struct weft_pass_plan_params *naive =
        weft_pass_plan_params(.derivative = {{1, 0, 0}}, .samples = M, .taps_per_pass = 1,
                              .order = WEFT_ORDER_NATURAL, .single_bias = true);
    const struct weft_pass_plan_params *ours =
        weft_pass_plan_params(.derivative = {{1, 0, 0}}, .samples = M, .taps_per_pass = 1);
    const enum weft_result res = compare(params, naive, ours, result, &bounds);
    // 1.0 is a code, positions are those of the tiles' samples, and the weights there add up to 0
    // exactly: what is left of the plan's bound is that of its arithmetic.
    result->limit = 255.0 * bounds.e3;
    weft_stability_say(result, "LSB", "a constant's slope comes out as %.3f, ours as %.3f",
                       result->naive / 255.0, result->ours / 255.0);
    return res;
}

const struct weft_stability_case weft_stability_gradient_bias = {
    .name = "gradient-bias",
    .failure = "signed sums on unsigned targets clamp",
    .naive = "a bias of 0.5 in front of all passes",
    .ours = "a bias in every pass, passes in a planned order",
    .source = paper,
    .measure = measure_gradient_bias,
};

// ---- weights ------------------------------------------------------------------------------------

static enum weft_result measure_ripple(const struct weft_stability_params *params, int dims,
                                       struct weft_stability_result *result)
{
    struct weft_pass_plan_error bounds = {0};
    const struct weft_pass_plan_params *naive =
        weft_pass_plan_params(.dims = dims, .samples = M, .round_singly = true);
    const struct weft_pass_plan_params *ours =
        weft_pass_plan_params(.dims = dims, .samples = M, .no_scale = true);
    const enum weft_result res = compare(params, naive, ours, result, &bounds);
    result->limit = constant_limit_lsb;
    weft_stability_say(result, "LSB", "Catmull-Rom in %dD: a constant 255 ripples by %.1f LSB",
                       dims, result->naive);
    return res;
}

static enum weft_result measure_ripple_2d(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    return measure_ripple(params, 2, result);
}

static enum weft_result measure_ripple_3d(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    return measure_ripple(params, 3, result);
}

const struct weft_stability_case weft_stability_ripple_2d = {
    .name = "ripple-2d",
    .failure = "weights of 8 bits do not add up to 1: constants ripple, bi-cubic",
    .naive = "each weight rounded by itself",
    .ours = "weights of a position rounded so that their sum stays",
    .source = paper,
    .measure = measure_ripple_2d,
};

const struct weft_stability_case weft_stability_ripple_3d = {
    .name = "ripple-3d",
    .failure = "weights of 8 bits do not add up to 1: constants ripple, tri-cubic",
    .naive = "each weight rounded by itself",
    .ours = "weights of a position rounded so that their sum stays",
    .source = paper,
    .measure = measure_ripple_3d,
};
