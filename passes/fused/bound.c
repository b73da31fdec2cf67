// SPDX-License-Identifier: BSD-3-Clause
// What a slice's plan knows of its kernel: error bounds.
#include <float.h>
#include <math.h>
#include <string.h>

#include "filter/analysis/analysis.h"
#include "filter/analysis/error.h"
#include "passes/separable/separable.h"
#include "passes/fused/plan.h"

// ---- error bound --------------------------------------------------------------------------------

static const double UNIT = 0x1p-24; // unit roundoff of single precision

// Positions are off by their rounding and what steps add up to (passes/positions/grid.h).
static double position_error(const struct weft_slice_grid *grid)
{
    return 0x1p-30 + 511 * ldexp(0.5, -grid->fraction_bits);
}

// Roundoff of products, sums and weights.
static double unit_of(const struct weft_slice_plan *plan)
{
    return plan->info.sums == WEFT_SUMS_DOUBLE ? 0x1p-53 : UNIT;
}

// Of one axis: the sum over taps of the error of each weight, in units of the largest |voxel|.
double weft_slice_weight_bound(const struct weft_slice_plan *plan)
{
    const double slope = weft_footprint_kernel(plan->footprint)->slope;
    // A fraction times a number of segments that is no power of two is rounded; in single precision
    // the fraction is before, to 24 bits.
    const int segments = plan->weights->tiles.segments;
    const double scaled = segments & (segments - 1) ? unit_of(plan) : 0.0;
    const double fraction = plan->info.sums == WEFT_SUMS_DOUBLE ? 0.0 : 0x1p-25;
    const double position = fraction + scaled + position_error(&plan->footprint->grid);
    return plan->weights->error + position * slope;
}

double weft_slice_position_bound(const struct weft_slice_plan *plan)
{
    const double gain = plan->smooth.gain;
    return 3.0 * gain * gain * position_error(&plan->footprint->grid) *
           weft_footprint_kernel(plan->footprint)->slope;
}

static int convolved_axes(const struct weft_slice_plan *plan)
{
    return plan->axes.summed ? 2 : 3;
}

// |result - exact| / largest |sample| <= weight errors, one an axis, and the sums' roundings; sums
// along an axis beforehand are rounded once.
static double relative_bound(const struct weft_slice_plan *plan, double gain)
{
    const struct weft_kernel *kernel = &plan->info.kernel;
    double weights = weft_slice_weight_bound(plan);
    int axes = convolved_axes(plan);
    // A product and the additions after it, on each level; the first one is to 0. The CPU engine
    // has no more: see passes/fused/lines/lines.h.
    double sums = axes * kernel->width * unit_of(plan);
    return pow(gain + weights, axes) * (1.0 + sums) * (1.0 + (plan->axes.summed ? UNIT : 0.0)) -
           pow(gain, axes);
}

// Of samples summed before, positions off by what fixed-point steps are.
static double separable_bound(const struct weft_slice_plan *plan, double gain)
{
    const enum weft_sums sums = plan->info.sums;
    struct weft_kernel kernel = plan->info.kernel;
    kernel.prefiltered = false; // of coefficients, where it reads them
    // With double sums only pixels are rounded to floats.
    const double own = weft_separable_bound_terms(&kernel, sums, 1.0, 1.0).relative;
    const double unit = sums == WEFT_SUMS_DOUBLE ? 0x1p-53 : UNIT;
    const double position = position_error(&plan->footprint->grid);
    return own * (1.0 + unit) + unit * gain * gain +
           2.0 * gain * position * weft_footprint_kernel(plan->footprint)->slope;
}

// What GL may flush to zero is below 2^-126: on each level of sums up to `width` products and as
// many sums, beneath those levels that come after it, and the samples.
static double flushed(const struct weft_slice_plan *plan, double gain)
{
    double levels = 0.0;
    for (int i = 0; i < convolved_axes(plan); i++)
        levels = levels * gain + 1.0;
    return 0x1p-125 * (plan->info.kernel.width + gain) * levels;
}

// Sums of fit voxels stay within a quarter of what floats hold; ranges of other sources do anyway.
static void set_largest_fit(struct weft_slice_plan *plan, double gain)
{
    plan->largest_fit = FLT_MAX;
    if (plan->info.source == WEFT_SOURCE_FLOAT)
        plan->largest_fit = (float)(0.25 * FLT_MAX / pow(fmax(gain, 1.0), 3));
}

// Sums along an axis reach this far.
static void widen_range(const struct weft_slice_axes *axes, struct weft_source_range *range)
{
    struct weft_source_range wide = {0.0, 0.0};
    for (int i = 0; i < axes->kept; i++) {
        double w = axes->weight[i];
        wide.low += w * (w > 0.0 ? range->low : range->high);
        wide.high += w * (w > 0.0 ? range->high : range->low);
    }
    *range = wide;
}

static void set_smooth(struct weft_slice_plan *plan, double error)
{
    const struct weft_slice_kernel *kernel = weft_footprint_kernel(plan->footprint);
    plan->smooth = (struct weft_slice_smooth){.gain = kernel->gain};
    if (!plan->info.kernel.unit_sum)
        return;
    plan->smooth.error = error;
    plan->smooth.curvature = kernel->curvature;
}

// What a prefiltered kernel reads are coefficients, of up to `gain` times the voxels, whatever
// those are.
static void set_stated_bound(const struct weft_kernel *kernel, struct weft_slice_output *out)
{
    const struct weft_bound_terms *terms = &out->bound;
    // Pixels that are rounded to floats in the end are of any size that there can be.
    const double rounded =
        terms->rounded_gain > 0.0 ? UNIT * (terms->rounded_gain + terms->relative) : 0.0;
    const double relative = terms->relative + rounded, more = 1.0 + relative;
    struct weft_prefilter prefilter;
    out->error_bound = relative + terms->sample_rounding;
    out->error_beyond = more * terms->prefilter.beyond;
    out->error_absolute = terms->absolute + terms->absolute_rounding;
    if (!kernel->prefiltered || weft_prefilter_compute(NULL, kernel, &prefilter) != WEFT_OK)
        return;
    out->error_bound = pow(prefilter.gain, 3) * (relative + more * terms->prefilter.coefficient) +
                       more * terms->prefilter.sample + terms->sample_rounding;
}

// What a grid's numbers lose as floats: integers an absolute amount, doubles half a unit each.
static void set_rounding(struct weft_slice_plan *plan, const struct weft_volume_info *volume)
{
    struct weft_bound_terms *terms = &plan->info.output[0].bound;
    double whole =
        plan->info.kernel.prefiltered ? terms->prefilter.gain : pow(plan->smooth.gain, 3);
    if (plan->clamp_to_samples) // which are off, too
        whole = fmax(whole, 1.0);
    terms->sample_rounding = volume->rounded ? 1.0001 * UNIT * whole : 0.0;
    terms->absolute_rounding = whole * volume->largest_rounding;
}

static void set_terms(struct weft_slice_plan *plan, double smooth_error)
{
    struct weft_slice_plan_info *info = &plan->info;
    const struct weft_slice_kernel *kernel = weft_footprint_kernel(plan->footprint);
    double gain = kernel->gain, whole = pow(gain, convolved_axes(plan));
    double relative = relative_bound(plan, gain), along = 0.0;
    for (int i = 0; i < plan->axes.kept; i++)
        along += fabs(plan->axes.weight[i]);
    set_smooth(plan, smooth_error);
    if (plan->axes.separable) {
        plan->smooth.error = 0.0;
        relative = separable_bound(plan, gain);
    }
    set_largest_fit(plan, gain);
    struct weft_bound_terms *terms = &info->output[0].bound;
    *terms = (struct weft_bound_terms){
        .relative = relative * (plan->axes.summed ? along : 1.0),
        .absolute = plan->smooth.error + flushed(plan, gain),
        .rounded_gain =
            info->sums == WEFT_SUMS_DOUBLE ? whole * (plan->axes.summed ? along : 1.0) : 0.0,
        .prefilter = kernel->prefilter,
    };
    if (info->source == WEFT_SOURCE_FLOAT)
        return;
    // Everything is relative to the range then: samples and sums of at most its width, and what
    // subtracting its offset and adding it again round.
    if (plan->axes.summed)
        widen_range(&plan->axes, &plan->range);
    double width = plan->range.high - plan->range.low;
    double offset = fmax(fabs(plan->range.low), fabs(plan->range.high));
    terms->relative = 0.0;
    terms->absolute += width * (weft_source_format_error(info->source) * (whole + relative) +
                                relative + 2.0 * UNIT * whole) +
                       4.0 * UNIT * whole * offset;
}

void weft_slice_bound_set(struct weft_slice_plan *plan, double smooth_error)
{
    set_terms(plan, smooth_error);
    set_rounding(plan, weft_volume_get_info(weft_footprint_voxels(plan->footprint)));
    set_stated_bound(&plan->info.kernel, &plan->info.output[0]);
}
