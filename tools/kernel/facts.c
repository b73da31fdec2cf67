// SPDX-License-Identifier: BSD-3-Clause
#include "tools/kernel/facts.h"

#include <math.h>

const double kernel_taylor_positions[KERNEL_TAYLOR_POSITIONS] = {0.0, 0.25, 0.5, 0.75};
const double kernel_frequencies[KERNEL_FREQUENCIES] = {0.0,  0.125, 0.25, 0.375, 0.5,
                                                       0.75, 1.0,   1.5,  2.0};

// From positions where no kernel jumps.
static const char *find_symmetry(const struct weft_kernel *kernel)
{
    bool even = true, odd = true;
    for (int i = 0; i < 997; i++) {
        double x = kernel->support * (i + 0.5) / 997, tolerance = 1e-12;
        double a = weft_kernel_weight(kernel, x), b = weft_kernel_weight(kernel, -x);
        even &= fabs(a - b) <= tolerance;
        odd &= fabs(a + b) <= tolerance;
    }
    return even ? "even" : odd ? "odd" : "none";
}

void kernel_facts_gather(struct kernel_facts *f)
{
    const struct weft_kernel *kernel = &f->kernel;
    weft_kernel_format(kernel, f->name, sizeof f->name);
    f->symmetry = find_symmetry(kernel);
    f->order = weft_analysis_order(kernel);
    struct weft_kernel own = *kernel;
    if (kernel->info->derivation == 0 && weft_kernel_make_prefiltered(NULL, &own) == WEFT_OK)
        f->interpolator = weft_analysis_order(&own);
    // A table's record cannot know.
    f->unit_sum = kernel->unit_sum ||
                  (kernel->info->derivation == 0 && !kernel->radial && f->order.order > 0);
    for (int n = 0; n < KERNEL_MOMENTS; n++)
        f->moment[n] = weft_analysis_moment(kernel, n);
    for (int n = 0; n < KERNEL_TAYLOR_ORDERS; n++)
        for (int i = 0; i < KERNEL_TAYLOR_POSITIONS; i++)
            f->taylor[n][i] = weft_analysis_taylor(kernel, n, kernel_taylor_positions[i]);
    for (int i = 0; i < KERNEL_FREQUENCIES; i++)
        f->response[i] = weft_analysis_response(kernel, kernel_frequencies[i]);
    for (int d = 0; d < KERNEL_DIMS; d++)
        f->metrics[d] = weft_analysis_metrics(kernel, d + 1);
    f->overshoot = weft_analysis_overshoot(kernel);
    f->gain = weft_analysis_gain(kernel);
}

bool kernel_needs_prefilter(const struct kernel_facts *f)
{
    return f->kernel.info->derivation == 0 && !f->kernel.radial && !f->kernel.interpolating &&
           !f->kernel.prefiltered && f->order.prefiltered > f->order.order;
}

double kernel_magnitude(struct weft_analysis_response h)
{
    return hypot(h.re, h.im);
}

double kernel_decibel(struct weft_analysis_response h)
{
    return kernel_magnitude(h) > 1e-12 ? 20.0 * log10(kernel_magnitude(h)) : -INFINITY;
}

double kernel_tidy(double x)
{
    return fabs(x) < 1e-13 ? 0.0 : x;
}
