// SPDX-License-Identifier: BSD-3-Clause
// How far pixels may be off.
#include <math.h>
#include <stdlib.h>

#include "filter/analysis/analysis.h"
#include "filter/analysis/error.h"
#include "passes/warp/warp_impl.h"
#include "tiles/volume/volume.h"

static double unit_of(const struct weft_warp_plan *plan)
{
    return plan->info.sums == WEFT_SUMS_DOUBLE ? 0x1p-53 : 0x1p-24;
}

// Of the taps of one axis: what their weights are off by together, and what they add up to at most.
struct axis {
    double off, gain, taps;
};

// Engines in single precision round the fraction to 24 bits, and where a number of segments is no
// power of two what it becomes times that.
static struct axis plain_axis(const struct weft_warp_plan *plan)
{
    const struct weft_slice_kernel *kernel = weft_kernel_facts_compute(plan->facts);
    const int segments = plan->weights->tiles.segments;
    const bool single = plan->info.sums == WEFT_SUMS_FLOAT;
    const double fraction = single ? 0x1p-25 : 0x1p-53;
    const double scaled = segments & (segments - 1) ? unit_of(plan) : 0.0;
    return (struct axis){.off = plan->weights->error + (fraction + scaled) * kernel->slope,
                         .gain = kernel->gain,
                         .taps = plan->info.kernel.width};
}

// The largest sum of |weights| of the scales up to the largest, from positions among some scales;
// from 32 on it is that of the integral of |h|.
static double stretched_gain(const struct weft_warp_plan *plan, int axis, double *weights)
{
    enum { SCALES = 12, POSITIONS = 32 };
    const double most = fmin(plan->info.scale[axis], 32.0);
    double largest = 0.0;
    for (int s = 1; s <= SCALES; s++)
        for (int i = 0; i < POSITIONS; i++) {
            int64_t first;
            const double scale = pow(most, (double)s / SCALES);
            const int count =
                weft_warp_weights(plan, (double)i / POSITIONS, scale, &first, weights);
            double sum = 0.0;
            for (int k = 0; k < count; k++)
                sum += fabs(weights[k]);
            largest = fmax(largest, sum);
        }
    return largest;
}

// Weights are computed in double, and rounded to what sums are in.
static enum weft_result stretched_axis(const struct weft_warp_plan *plan, int axis,
                                       struct axis *out)
{
    const struct axis plain = plain_axis(plan);
    double *weights = calloc((size_t)plan->info.taps[axis], sizeof *weights);
    if (!weights) {
        weft_error(plan->log, "out of memory for %d weights", plan->info.taps[axis]);
        return WEFT_ERR_MEMORY;
    }
    // Between the positions it can be a little more.
    out->gain = fmax(plain.gain, 1.03 * stretched_gain(plan, axis, weights));
    free(weights);
    out->taps = plan->info.taps[axis];
    out->off = out->gain * unit_of(plan) + 2.0 * plan->weights->tiles.sum_error +
               0x1p-45 * (out->taps + plain.gain);
    out->off = fmax(out->off, plain.off);
    return WEFT_OK;
}

// |sum w' f - sum w f| with w' = wx' wy', the products' roundings, and those of the sums: each term
// has one of its product and one an addition on each axis.
enum weft_result weft_warp_set_bound(struct weft_warp_plan *plan)
{
    struct weft_warp_info *info = &plan->info;
    struct axis x = plain_axis(plan), y = x;
    enum weft_result res = plan->stretches ? stretched_axis(plan, 0, &x) : WEFT_OK;
    if (res == WEFT_OK && plan->stretches)
        res = stretched_axis(plan, 1, &y);
    if (res != WEFT_OK)
        return res;
    const double gain = x.gain * y.gain;
    const double roundings = expm1((x.taps + y.taps + 2.0) * log1p(unit_of(plan)));
    plan->gain = fmax(gain, 1.0);
    info->bound = (struct weft_bound_terms){
        .relative = (x.gain + x.off) * (y.gain + y.off) * (1.0 + roundings) - gain,
        .absolute =
            0x1p-125 * (fmax(x.taps, y.taps) + fmax(x.gain, y.gain)) * (1.0 + fmax(x.gain, y.gain)),
        .rounded_gain = info->sums == WEFT_SUMS_DOUBLE ? gain : 0.0,
        .prefilter = weft_prefilter_error(&info->kernel, 2, WEFT_VOLUME_PREFILTER_ERROR),
    };
    return WEFT_OK;
}

int weft_warp_scale_bits(const struct weft_warp_plan *plan,
                         const struct weft_resample_statistics *statistics)
{
    enum { MOST = 124 };
    int bits;
    frexp(plan->gain * fmax(fabs(statistics->low), fabs(statistics->high)), &bits);
    return bits > MOST ? bits - MOST : 0;
}

// What GL flushes to 0 is larger by as much as samples are made smaller.
struct weft_bound weft_warp_bound(const weft_warp_plan *plan,
                                  const struct weft_resample_statistics *statistics, double result)
{
    struct weft_bound_terms terms = plan->info.bound;
    const double largest = fmax(fabs(statistics->low), fabs(statistics->high));
    if (plan->separable)
        terms = weft_separable_plan_bound(plan->separable, largest, WEFT_VOLUME_PREFILTER_ERROR);
    else
        terms.absolute = ldexp(terms.absolute, weft_warp_scale_bits(plan, statistics));
    return weft_resample_bound_of(&terms, statistics, result);
}
