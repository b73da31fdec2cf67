// SPDX-License-Identifier: BSD-3-Clause
#include "filter/analysis/bound.h"

#include <math.h>

static double largest_of(double low, double high)
{
    return fmax(fabs(low), fabs(high));
}

static double find_e2(const struct weft_bound_terms *t, double width, double samples)
{
    const double any = t->e2 * width;
    if (t->e2_quantised == 0.0 && t->e2_sampled == 0.0)
        return any;
    return fmin(any, t->e2_quantised * width + t->e2_sampled * samples);
}

// Samples beyond those in reach change a spline at the pixel and at the nearest position.
static double find_prefilter(const struct weft_bound_terms *t, double read, double sample,
                             double beyond)
{
    const struct weft_prefilter_error *e = &t->prefilter;
    const double whole = e->coefficient * read + e->sample * sample + e->beyond * beyond;
    const double outside = t->e2_sampled > 0.0 ? 2.0 * e->beyond * (sample + beyond) : 0.0;
    return (1.0 + t->relative + t->e2) * whole + outside;
}

struct weft_bound weft_bound_compute(const struct weft_bound_terms *t,
                                     const struct weft_bound_values *v)
{
    const double width = v->high - v->low, read = largest_of(v->low, v->high);
    const double sample = largest_of(v->sample_low, v->sample_high);
    struct weft_bound bound = {
        .source = t->source * width,
        .e2 = find_e2(t, width, v->sample_high - v->sample_low),
        .e3 = t->e3 * width + t->relative * read + t->absolute,
        .clamp = t->clamp * width,
        .prefilter = find_prefilter(t, read, sample, v->beyond),
    };
    const double before = bound.source + bound.e2 + bound.e3 + bound.clamp + bound.prefilter;
    const double result = v->result > 0.0 ? v->result : t->rounded_gain * read + before;
    bound.rounding = t->sample_rounding * sample + t->absolute_rounding +
                     (t->rounded_gain > 0.0 ? 0x1p-24 * result : 0.0);
    bound.total = before + bound.rounding;
    return bound;
}
