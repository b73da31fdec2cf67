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

// Of one axis: the sum over taps of the error of each weight of an order, whose kernel's slope this
// is, in units of the largest |voxel|.
static double weight_error(const struct weft_slice_plan *plan, int order, double slope)
{
    // A fraction times a number of segments that is no power of two is rounded; in single precision
    // the fraction is before, to 24 bits.
    const int segments = plan->weights[order]->tiles.segments;
    const double scaled = segments & (segments - 1) ? unit_of(plan) : 0.0;
    const double fraction = plan->info.sums == WEFT_SUMS_DOUBLE ? 0.0 : 0x1p-25;
    const double position = fraction + scaled + position_error(&plan->footprint->grid);
    return plan->weights[order]->error + position * slope;
}

double weft_slice_weight_bound(const struct weft_slice_plan *plan)
{
    return weight_error(plan, 0, weft_footprint_kernel(plan->footprint)->slope);
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

// Of an output, along each axis of the volume: the largest sum of |weights| of its order, and of
// what they are off by.
struct spread {
    double gain[3], error[3];
};

// Of the axes that are convolved along.
static double product_of(const struct weft_slice_plan *plan, const double a[3])
{
    if (a[0] == a[1] && a[1] == a[2])
        return pow(a[0], convolved_axes(plan));
    return a[0] * a[1] * a[2];
}

static double largest_of(const double a[3])
{
    return fmax(a[0], fmax(a[1], a[2]));
}

// |result - exact| / largest |sample| <= weight errors, one an axis, and the sums' roundings; sums
// along an axis beforehand are rounded once.
static double relative_bound(const struct weft_slice_plan *plan, const struct spread *spread)
{
    const struct weft_kernel *kernel = &plan->info.kernel;
    double reached[3];
    for (int a = 0; a < 3; a++)
        reached[a] = spread->gain[a] + spread->error[a];
    // A product and the additions after it, on each level; the first one is to 0. The CPU engine
    // has no more: see passes/fused/lines/lines.h.
    double sums = convolved_axes(plan) * kernel->width * unit_of(plan);
    return product_of(plan, reached) * (1.0 + sums) * (1.0 + (plan->axes.summed ? UNIT : 0.0)) -
           product_of(plan, spread->gain);
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
static void set_rounding(const struct weft_slice_plan *plan, const struct spread *spread,
                         const struct weft_volume_info *volume, struct weft_bound_terms *terms)
{
    double whole = plan->info.kernel.prefiltered ? terms->prefilter.gain
                   : plan->axes.summed           ? pow(plan->smooth.gain, 3)
                                                 : product_of(plan, spread->gain);
    if (plan->clamp_to_samples) // which are off, too
        whole = fmax(whole, 1.0);
    terms->sample_rounding = volume->rounded ? 1.0001 * UNIT * whole : 0.0;
    terms->absolute_rounding = whole * volume->largest_rounding;
}

// What coefficients make of an output.
static struct weft_prefilter_error prefilter_error(const struct weft_slice_plan *plan,
                                                   const struct weft_derivative *of)
{
    struct weft_prefilter_error along[3];
    for (int a = 0; a < 3; a++)
        along[a] = weft_kernel_facts_compute(plan->kernels[of->along[a]])->along;
    return weft_prefilter_error_join(along, 3);
}

// Everything of a source that is not float is relative to its range: samples and sums of at most
// its width, and what subtracting its offset and adding it again round. Derivatives lose the offset
// where weights add up to one; where they do not, it counts as often as weights are off.
static double absolute_bound(const struct weft_slice_plan *plan, bool value, double whole,
                             double relative)
{
    const double width = plan->range.high - plan->range.low;
    const double offset = fmax(fabs(plan->range.low), fabs(plan->range.high));
    const double own = width * (weft_source_format_error(plan->info.source) * (whole + relative) +
                                relative + 2.0 * UNIT * whole);
    if (value)
        return own + 4.0 * UNIT * whole * offset;
    return plan->info.kernel.unit_sum ? own : own + offset * (relative + 4.0 * UNIT * whole);
}

static void set_terms(struct weft_slice_plan *plan, const struct spread *spread, bool value,
                      struct weft_slice_output *out)
{
    const double whole = product_of(plan, spread->gain);
    double relative = relative_bound(plan, spread), along = 0.0;
    for (int i = 0; i < plan->axes.kept; i++)
        along += fabs(plan->axes.weight[i]);
    if (!plan->axes.summed)
        along = 1.0;
    if (plan->axes.separable)
        relative = separable_bound(plan, spread->gain[0]);
    out->bound = (struct weft_bound_terms){
        .relative = relative * along,
        .absolute = plan->smooth.error + flushed(plan, largest_of(spread->gain)),
        .rounded_gain = plan->info.sums == WEFT_SUMS_DOUBLE ? whole * along : 0.0,
    };
    if (value)
        out->bound.prefilter = weft_footprint_kernel(plan->footprint)->prefilter;
    else if (plan->info.kernel.prefiltered)
        out->bound.prefilter = prefilter_error(plan, &out->derivative);
    if (plan->info.source == WEFT_SOURCE_FLOAT)
        return;
    out->bound.relative = 0.0;
    out->bound.absolute += absolute_bound(plan, value, whole, relative);
}

// The slope of weights that are looked up in samples is that of what was sampled.
static enum weft_result find_slope(const struct weft_slice_plan *plan, int order, double *out)
{
    const struct weft_slice_weights *weights = plan->weights[order];
    enum weft_result res = WEFT_OK;
    if (order && weights->samples)
        res = weft_kernel_facts_weights(plan->log, plan->kernels[order], 0, false, plan->info.sums,
                                        &weights);
    if (res == WEFT_OK)
        *out = order ? weights->slope : weft_footprint_kernel(plan->footprint)->slope;
    return res;
}

enum weft_result weft_slice_bound_set(struct weft_slice_plan *plan, double smooth_error)
{
    double gain[WEFT_LINE_ORDERS] = {0.0}, error[WEFT_LINE_ORDERS] = {0.0};
    enum weft_result res = WEFT_OK;
    for (int n = 0; res == WEFT_OK && n < WEFT_LINE_ORDERS; n++) {
        double slope;
        if (!plan->weights[n])
            continue;
        res = find_slope(plan, n, &slope);
        if (res != WEFT_OK)
            return res;
        gain[n] = weft_kernel_facts_compute(plan->kernels[n])->gain;
        error[n] = weight_error(plan, n, slope);
    }
    set_smooth(plan, smooth_error);
    if (plan->axes.separable)
        plan->smooth.error = 0.0;
    set_largest_fit(plan, largest_of(gain));
    if (plan->info.source != WEFT_SOURCE_FLOAT && plan->axes.summed)
        widen_range(&plan->axes, &plan->range);
    for (int o = 0; o < plan->info.output_count; o++) {
        struct weft_slice_output *out = &plan->info.output[o];
        const int *along = out->derivative.along;
        struct spread spread;
        for (int a = 0; a < 3; a++) {
            spread.gain[a] = gain[along[a]];
            spread.error[a] = error[along[a]];
        }
        set_terms(plan, &spread, along[0] + along[1] + along[2] == 0, out);
        set_rounding(plan, &spread, weft_volume_get_info(weft_footprint_voxels(plan->footprint)),
                     &out->bound);
        set_stated_bound(&plan->info.kernel, out);
    }
    return res;
}
