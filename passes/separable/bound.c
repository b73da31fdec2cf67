// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/analysis/analysis.h"
#include "passes/separable/separable_impl.h"

// What errors grow by: taps of both axes, the product of their gains, and the larger of each.
struct growth {
    double taps, gain, most_taps, most_gain;
};

static struct growth growth_of(const struct weft_kernel *kernel)
{
    struct weft_kernel plain = *kernel;
    plain.prefiltered = false;
    const double gain = weft_analysis_gain(&plain);
    return (struct growth){2.0 * kernel->width, gain * gain, kernel->width, gain};
}

// Of kernels as they are that of any position; of stretched ones that of the plan's own.
static struct growth growth_of_plan(const weft_separable_plan *plan)
{
    const struct weft_separable_info *i = &plan->info;
    if (i->stretch[0] == 1.0 && i->stretch[1] == 1.0)
        return growth_of(&i->kernel);
    return (struct growth){(double)i->taps[0] + i->taps[1], i->gain[0] * i->gain[1],
                           fmax(i->taps[0], i->taps[1]), fmax(i->gain[0], i->gain[1])};
}

// Both axes: n + 1 factors of up to 1 + u each a term.
static double sums_error(const struct growth *g, enum weft_sums sums)
{
    const double unit = sums == WEFT_SUMS_DOUBLE ? 0x1p-53 : 0x1p-24;
    return g->gain * expm1((g->taps + 2.0) * log1p(unit));
}

static double error_of(const struct growth *g, enum weft_sums sums)
{
    const double error = sums_error(g, sums);
    return sums == WEFT_SUMS_DOUBLE ? error + 0x1p-24 * (g->gain + error) : error;
}

double weft_separable_error_bound(const struct weft_kernel *kernel, enum weft_sums sums)
{
    const struct growth g = growth_of(kernel);
    return error_of(&g, sums);
}

double weft_separable_plan_error(const weft_separable_plan *plan)
{
    const struct growth g = growth_of_plan(plan);
    return error_of(&g, plan->info.sums);
}

// What is below 2^-126 GL may flush to 0. On the CPU it is rounded to multiples of 2^-149, and
// where scaling makes samples or weights as small no more is lost than GL may lose; doubles lose
// nothing, and a pixel half of 2^-149.
static struct weft_bound_terms terms_of(const struct weft_kernel *kernel, const struct growth *g,
                                        enum weft_sums sums, double largest, double cut)
{
    const double scale = g->gain * largest >= 0x1p127 ? 4.0 * g->gain : 1.0;
    const double lost = 0x1p-125 * (g->most_taps + g->most_gain) * (1.0 + g->most_gain) * scale;
    return (struct weft_bound_terms){
        .relative = sums_error(g, sums),
        .absolute = largest > 0.0 ? lost : 0.0,
        .rounded_gain = sums == WEFT_SUMS_DOUBLE ? g->gain : 0.0,
        .prefilter = weft_prefilter_error(kernel, 2, cut),
    };
}

struct weft_bound_terms weft_separable_bound_terms(const struct weft_kernel *kernel,
                                                   enum weft_sums sums, double largest, double cut)
{
    const struct growth g = growth_of(kernel);
    return terms_of(kernel, &g, sums, largest, cut);
}

struct weft_bound_terms weft_separable_plan_bound(const weft_separable_plan *plan, double largest,
                                                  double cut)
{
    const struct growth g = growth_of_plan(plan);
    return terms_of(&plan->info.kernel, &g, plan->info.sums, largest, cut);
}
