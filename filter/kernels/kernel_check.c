// SPDX-License-Identifier: BSD-3-Clause
// Kernels and records as users hand them in.
#include <math.h>
#include <stdio.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

enum { MAX_DEGREE = 64 };

static const double largest_radius = 0.5 * WEFT_KERNEL_MAX_WIDTH;

static bool complain(const struct weft_log *log, const struct weft_kernel_info *info,
                     const char *member, const char *what)
{
    weft_error(log, "kernel %s: %s: %s", info->name ? info->name : "without a name", member, what);
    return false;
}

static bool check_params(const struct weft_log *log, const struct weft_kernel_info *info)
{
    for (int i = 0; i < WEFT_KERNEL_PARAMS && info->params[i].name; i++) {
        const struct weft_kernel_param *p = &info->params[i];
        if (!(p->min <= p->initial && p->initial <= p->max))
            return complain(log, info, "params", "an initial value is outside its range");
    }
    return true;
}

bool weft_kernel_check_info(const struct weft_log *log, const struct weft_kernel_info *info)
{
    if (!info->name || !info->name[0])
        return complain(log, info, "name", "missing");
    if (!info->weight)
        return complain(log, info, "weight", "missing");
    if (!(info->radius >= 0.0)) // weft_kernel_create tells those that are too large
        return complain(log, info, "radius", "below 0, or no number");
    if (info->radius == 0.0 && !info->params[0].name)
        return complain(log, info, "radius", "0, and there is no parameter that has it");
    if (info->derivation < 0 || info->derivation > 2)
        return complain(log, info, "derivation", "not in 0 to 2");
    if ((info->derivation > 0) != (info->primitive != NULL))
        return complain(log, info, "primitive", "what has a derivation has one, and nothing else");
    if (info->degree < -1 || info->degree > MAX_DEGREE)
        return complain(log, info, "degree", "not in -1 to 64");
    if (info->continuity < -1)
        return complain(log, info, "continuity", "below -1");
    if (info->order < 0 || info->order_prefiltered < 0)
        return complain(log, info, "order", "below 0");
    return check_params(log, info);
}

// By the weights at some positions. A claim of 1e-6 may come from single precision.
static bool check_claims(const struct weft_log *log, const struct weft_kernel *kernel)
{
    enum { POSITIONS = 9 };
    const double tolerance = 1e-6;
    for (int i = 0; i < POSITIONS; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
        weft_kernel_weights(kernel, i / (double)POSITIONS, weights);
        for (int j = 0; j < kernel->width; j++)
            sum += weights[j];
        if (!isfinite(sum))
            return complain(log, kernel->info, "weight", "not finite");
        if (kernel->unit_sum && !kernel->normalised && !(fabs(sum - 1.0) <= tolerance))
            return complain(log, kernel->info, "unit_sum", "the weights do not add up to 1");
    }
    for (int k = 0; kernel->interpolating && !kernel->normalised && k <= kernel->support; k++) {
        const double h = kernel->info->weight(kernel, k);
        if (k < kernel->support && !(fabs(h - (k == 0)) <= tolerance))
            return complain(log, kernel->info, "interpolating", "h(k) is not 1 at 0, 0 elsewhere");
    }
    return true;
}

static bool check_members(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    for (int i = 0; i < WEFT_KERNEL_PARAMS && info->params[i].name; i++)
        if (!(kernel->param[i] >= info->params[i].min && kernel->param[i] <= info->params[i].max))
            return complain(log, info, "param", "outside its range");
    if (!(kernel->support > 0.0 && kernel->support <= largest_radius))
        return complain(log, info, "support", "not in (0, 8]");
    if (kernel->width != (int)ceil(2.0 * kernel->support))
        return complain(log, info, "width", "not the whole number from twice the support up");
    if (kernel->continuity < -1)
        return complain(log, info, "continuity", "below -1");
    if (kernel->order < 0 || kernel->order_prefiltered < 0)
        return complain(log, info, "order", "below 0");
    if (kernel->normalised && info->derivation > 0)
        return complain(log, info, "normalised", "the weights of a derivative add up to 0");
    if (kernel->radial && (kernel->prefiltered || info->derivation > 0))
        return complain(log, info, "radial", "not with prefiltered or derivation");
    return true;
}

enum weft_result weft_kernel_check(const struct weft_log *log, const struct weft_kernel *kernel)
{
    if (!kernel || !kernel->info) {
        weft_error(log, "no kernel: its info is missing (see weft_kernel_create)");
        return WEFT_ERR_ARGUMENT;
    }
    if (!weft_kernel_check_info(log, kernel->info) || !check_members(log, kernel))
        return WEFT_ERR_ARGUMENT;
    if (kernel->prefiltered && weft_kernel_check_prefilter(log, kernel->info) != WEFT_OK)
        return WEFT_ERR_ARGUMENT;
    return kernel->radial || check_claims(log, kernel) ? WEFT_OK : WEFT_ERR_ARGUMENT;
}
