// SPDX-License-Identifier: BSD-3-Clause
// Kernels and records as users hand them in.
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

static const double largest_radius = 0.5 * WEFT_KERNEL_MAX_WIDTH;

bool weft_kernel_complain(const struct weft_log *log, const struct weft_kernel_info *info,
                          const char *format, ...)
{
    char what[512];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    weft_error(log, "kernel %s: %s", info->name && info->name[0] ? info->name : "without a name",
               what);
    return false;
}
#define complain weft_kernel_complain

static bool check_params(const struct weft_log *log, const struct weft_kernel_info *info)
{
    for (int i = 0; i < WEFT_KERNEL_PARAMS && info->params[i].name; i++) {
        const struct weft_kernel_param *p = &info->params[i];
        if (!(p->min <= p->initial && p->initial <= p->max))
            return complain(log, info, ".params[%d] (%s): .initial is %g, not in [%g, %g]", i,
                            p->name, p->initial, p->min, p->max);
    }
    return true;
}

bool weft_kernel_check_info(const struct weft_log *log, const struct weft_kernel_info *info)
{
    if (!info->name || !info->name[0])
        return complain(log, info, ".name is missing");
    if (!info->weight)
        return complain(log, info, ".weight is missing");
    if (!(info->radius >= 0.0)) // weft_kernel_create tells those that are too large
        return complain(log, info, ".radius is %g", info->radius);
    if (info->radius == 0.0 && !info->params[0].name)
        return complain(log, info, ".radius is 0, and there is no parameter that has it");
    if (info->derivation < 0 || info->derivation > 2)
        return complain(log, info, ".derivation is %d, not in 0 to 2", info->derivation);
    if ((info->derivation > 0) != (info->primitive != NULL))
        return complain(log, info, ".primitive is %s, but .derivation is %d",
                        info->primitive ? "given" : "missing", info->derivation);
    if (info->primitive && info->primitive->derivation != 0)
        return complain(log, info, ".primitive is a derivative itself: its .derivation is %d",
                        info->primitive->derivation);
    if (info->degree < -1 || info->degree > WEFT_KERNEL_MAX_DEGREE)
        return complain(log, info, ".degree is %d, not in -1 to %d", info->degree,
                        WEFT_KERNEL_MAX_DEGREE);
    if (info->continuity < -1)
        return complain(log, info, ".continuity is %d, below -1", info->continuity);
    if (info->order < 0)
        return complain(log, info, ".order is %d, below 0", info->order);
    if (info->order_prefiltered < 0)
        return complain(log, info, ".order_prefiltered is %d, below 0", info->order_prefiltered);
    return check_params(log, info);
}

static bool check_integers(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const double tolerance = 1e-6;
    for (int k = -(int)kernel->support; kernel->interpolating && k < kernel->support; k++) {
        const double h = kernel->info->weight(kernel, k);
        if (!(fabs(h - (k == 0)) <= tolerance))
            return complain(log, kernel->info,
                            ".interpolating is claimed, but the weight at %d is %g, not %d", k, h,
                            k == 0);
    }
    return true;
}

// By the weights at some positions. A claim of 1e-6 may come from single precision.
static bool check_claims(const struct weft_log *log, const struct weft_kernel *kernel)
{
    enum { POSITIONS = 8 };
    const double tolerance = 1e-6;
    for (int i = 0; i < POSITIONS; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
        weft_kernel_weights(kernel, i / (double)POSITIONS, weights);
        for (int j = 0; j < kernel->width; j++)
            sum += weights[j];
        if (!isfinite(sum))
            return complain(log, kernel->info, ".weight: at fraction %g weights are not finite",
                            i / (double)POSITIONS);
        if (kernel->unit_sum && !kernel->normalised && !(fabs(sum - 1.0) <= tolerance))
            return complain(log, kernel->info,
                            ".unit_sum is claimed, but the weights at fraction %g sum to %.9g",
                            i / (double)POSITIONS, sum);
    }
    return kernel->normalised || check_integers(log, kernel);
}

static bool check_members(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    for (int i = 0; i < WEFT_KERNEL_PARAMS && info->params[i].name; i++)
        if (!(kernel->param[i] >= info->params[i].min && kernel->param[i] <= info->params[i].max))
            return complain(log, info, ".param[%d] is %g: %s is in [%g, %g]", i, kernel->param[i],
                            info->params[i].name, info->params[i].min, info->params[i].max);
    if (!(kernel->support > 0.0 && kernel->support <= largest_radius))
        return complain(log, info, ".support is %g, not in (0, %g]", kernel->support,
                        largest_radius);
    if (kernel->width != (int)ceil(2.0 * kernel->support))
        return complain(log, info, ".width is %d, but twice the support is %g", kernel->width,
                        2.0 * kernel->support);
    if (kernel->continuity < -1)
        return complain(log, info, ".continuity is %d, below -1", kernel->continuity);
    if (kernel->order < 0)
        return complain(log, info, ".order is %d, below 0", kernel->order);
    if (kernel->order_prefiltered < 0)
        return complain(log, info, ".order_prefiltered is %d, below 0", kernel->order_prefiltered);
    if (kernel->normalised && info->derivation > 0)
        return complain(log, info, ".normalised: the weights of a derivative add up to 0");
    if (kernel->radial && (kernel->prefiltered || info->derivation > 0))
        return complain(log, info, ".radial goes not with .prefiltered, nor with .derivation");
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
