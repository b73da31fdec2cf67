// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/work.h"

#include <math.h>

#include "passes/plan/plan_impl.h"

// What weights that do not add up to one are corrected by: their sums along each axis.
static double exact_weights(const struct weft_kernel *kernel, int dims)
{
    return kernel->unit_sum || kernel->normalised ? 0.0 : (double)dims * kernel->width;
}

struct weft_pass_work weft_pass_work_of(const struct weft_pass_plan_info *plan)
{
    return (struct weft_pass_work){
        .target = plan->profile.target,
        .dot4 = plan->technique == WEFT_TECHNIQUE_DOT4,
        .passes = plan->passes->pass_count,
        .fetches = plan->fetches,
        .tile_bytes = (double)plan->tile_bytes,
        .exact_weights = exact_weights(&plan->kernel, plan->dims),
    };
}

// Tiles that mirror others are stored once; those of dot4 hold four taps each.
static double least_tile_values(const struct weft_pass_plan_params *p, double groups)
{
    const double stored = pow((p->kernel.width + 1) / 2, p->dims);
    return pow(p->samples, p->dims) * (p->technique == WEFT_TECHNIQUE_DOT4 ? 4.0 * groups : stored);
}

static double value_bytes(const struct weft_pass_plan_params *p)
{
    const int target_bytes = (weft_target_bits(p->profile.target) + 7) / 8;
    if (target_bytes == 0)
        return p->profile.target == WEFT_TARGET_HALF ? 2.0 : 4.0;
    return p->technique == WEFT_TECHNIQUE_LOG ? target_bytes : p->bits > 8 ? 2.0 : 1.0;
}

struct weft_pass_work weft_pass_work_least(const struct weft_pass_plan_params *params)
{
    struct weft_pass_plan_params p = *params;
    p.log = NULL;
    if (weft_planner_resolve(&p, &p) != WEFT_OK)
        return (struct weft_pass_work){.target = WEFT_TARGET_UNORM8};
    const bool dot4 = p.technique == WEFT_TECHNIQUE_DOT4;
    const double taps = pow(p.kernel.width, p.dims), groups = dot4 ? ceil(taps / 4.0) : taps;
    const double parts = p.technique == WEFT_TECHNIQUE_SPLIT_PRECISION ? 2.0 : 1.0;
    return (struct weft_pass_work){
        .target = p.profile.target,
        .dot4 = dot4,
        .passes = parts * ceil(groups / p.taps_per_pass),
        .fetches = 2.0 * groups,
        .tile_bytes = least_tile_values(&p, groups) * value_bytes(&p),
        .exact_weights = exact_weights(&p.kernel, p.dims),
    };
}

struct weft_bound_terms weft_pass_bound_least(const struct weft_pass_plan_params *params,
                                              double slope)
{
    struct weft_pass_plan_params p = *params;
    p.log = NULL;
    if (weft_planner_resolve(&p, &p) != WEFT_OK)
        return (struct weft_bound_terms){.e2 = NAN};
    const bool coded = weft_target_bits(p.profile.target) > 0;
    const double e2 = 0.25 * slope / p.samples;
    return (struct weft_bound_terms){
        .e2 = e2,
        .e2_sampled = p.kernel.prefiltered ? 0.5 * e2 : 0.0,
        .e3 = coded ? 0.5 / weft_target_one(p.profile.target) : 0.0,
    };
}
