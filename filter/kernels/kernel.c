// SPDX-License-Identifier: BSD-3-Clause
// Making kernels of records, and of one another.
#include "filter/kernels/kernel.h"

#include <math.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"

// A user's record, once its members make sense.
static enum weft_result check_own(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    struct weft_kernel primitive = {0};
    if (info->primitive &&
        weft_kernel_create(log, info->primitive, kernel->param, &primitive) != WEFT_OK) {
        weft_kernel_complain(log, info, ".primitive takes no such parameters, or is wrong itself");
        return WEFT_ERR_ARGUMENT;
    }
    return weft_kernel_check_claims(log, kernel, &primitive) ? WEFT_OK : WEFT_ERR_ARGUMENT;
}

enum weft_result weft_kernel_create(const struct weft_log *log, const struct weft_kernel_info *info,
                                    const double *param, struct weft_kernel *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, out);
    *out = (struct weft_kernel){0};
    weft_require(log, info);
    const bool own = !weft_kernel_is_listed(info);
    if (own && !weft_kernel_check_info(log, info))
        goto fail;
    struct weft_kernel kernel = {.info = info};
    for (size_t i = 0; i < weft_kernel_param_count(info); i++) {
        const struct weft_kernel_param *p = &info->params[i];
        const double value = param && !isnan(param[i]) ? param[i] : p->initial;
        if (!(value >= p->min && value <= p->max)) {
            weft_error(log, "kernel %s: %s = %g is not in [%g, %g]", info->name, p->name, value,
                       p->min, p->max);
            goto fail;
        }
        kernel.param[i] = value;
    }
    kernel.support = info->radius > 0.0 ? info->radius : kernel.param[0];
    if (!(kernel.support > 0.0 && kernel.support <= 0.5 * WEFT_KERNEL_MAX_WIDTH)) {
        weft_error(log, "kernel %s: half-width %g is not in (0, %g]", info->name, kernel.support,
                   0.5 * WEFT_KERNEL_MAX_WIDTH);
        goto fail;
    }
    kernel.width = (int)ceil(2.0 * kernel.support);
    kernel.continuity = info->continuity;
    kernel.order = info->order;
    kernel.order_prefiltered = info->order_prefiltered;
    kernel.interpolating = info->interpolating;
    kernel.unit_sum = info->unit_sum;
    if (info->refine)
        info->refine(&kernel);
    res = own ? weft_kernel_check(log, &kernel) : WEFT_OK;
    if (own && res == WEFT_OK)
        res = check_own(log, &kernel);
    if (res == WEFT_OK)
        *out = kernel;
fail:
    return res;
}

enum weft_result weft_kernel_normalise(const struct weft_log *log, struct weft_kernel *kernel)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    if (kernel->info->derivation > 0) {
        weft_error(log, "kernel %s: the weights of a derivative add up to 0, not to 1",
                   kernel->info->name);
        goto fail;
    }
    if (!kernel->unit_sum) {
        kernel->normalised = kernel->unit_sum = true;
        kernel->order = kernel->order > 1 ? kernel->order : 1;
        kernel->order_prefiltered = kernel->order_prefiltered > 1 ? kernel->order_prefiltered : 1;
    }
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_kernel_make_radial(const struct weft_log *log, struct weft_kernel *kernel)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    if (kernel->info->derivation > 0) {
        weft_error(log, "kernel %s: a derivative along one axis cannot be radial",
                   kernel->info->name);
        goto fail;
    }
    if (kernel->prefiltered) {
        weft_error(log, "kernel %si: prefiltered splines are products, not radial",
                   kernel->info->name);
        goto fail;
    }
    kernel->radial = true;
    kernel->unit_sum = kernel->normalised;
    kernel->order = kernel->order_prefiltered = kernel->normalised ? 1 : 0;
    // At a sample, the nearest tap that h(k) = 0 says nothing about is sqrt(2) away.
    kernel->interpolating = kernel->interpolating && kernel->support <= M_SQRT2;
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_kernel_make_prefiltered(const struct weft_log *log,
                                              struct weft_kernel *kernel)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    res = weft_kernel_check_prefilter(log, kernel->info);
    if (res != WEFT_OK)
        goto fail;
    if (kernel->radial) {
        weft_error(log, "kernel %s: radial kernels have no prefilter", kernel->info->name);
        res = WEFT_ERR_ARGUMENT;
        goto fail;
    }
    kernel->prefiltered = true;
    kernel->order =
        weft_kernel_primitive(kernel->info)->order_prefiltered - kernel->info->derivation;
fail:
    return res;
}

static const struct weft_kernel_info *find_derivative(const struct weft_kernel_info *info)
{
    const struct weft_kernel_info *primitive = info->derivation ? info->primitive : info;
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (weft_kernel_list[i]->primitive == primitive &&
            weft_kernel_list[i]->derivation == info->derivation + 1)
            return weft_kernel_list[i];
    return NULL;
}

enum weft_result weft_kernel_derive(const struct weft_log *log, const struct weft_kernel *kernel,
                                    struct weft_kernel *out)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(log, out);
    const struct weft_kernel given = *kernel;
    const struct weft_kernel_info *info = find_derivative(given.info);
    *out = (struct weft_kernel){0};
    if (given.radial) {
        weft_error(log, "kernel %s: the slope of a radial kernel is no product of weights",
                   given.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (given.normalised) {
        weft_error(log, "kernel %s: divided by the sum of its weights, it has no derived record",
                   given.info->name);
        goto fail;
    }
    if (!info) {
        weft_error(log, "kernel %s: the catalogue has no record of its derivative",
                   given.info->name);
        goto fail;
    }
    struct weft_kernel derived;
    if (weft_kernel_create(log, info, given.param, &derived) != WEFT_OK)
        goto fail;
    weft_require(log, derived.width == given.width);
    res = given.prefiltered ? weft_kernel_make_prefiltered(log, &derived) : WEFT_OK;
    if (!res)
        *out = derived;
fail:
    return res;
}
