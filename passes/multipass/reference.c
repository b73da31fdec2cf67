// SPDX-License-Identifier: BSD-3-Clause
#include "filter/check.h"
#include "filter/kernels/kernel_axes.h"
#include "filter/kernels/kernel_nd.h"
#include "filter/analysis/reference.h"
#include "passes/multipass/reference.h"

enum weft_result weft_multipass_plan_work(const struct weft_log *log, const weft_pass_plan *plan,
                                          struct weft_multipass_work *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = (struct weft_multipass_work){0};
    weft_require(log, plan);
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    *out = (struct weft_multipass_work){.passes = info->passes,
                                        .kernel = info->kernel,
                                        .derivative = info->derivative,
                                        .channels = info->channels};
    return WEFT_OK;
fail:
    return res;
}

void weft_multipass_axis_kernels(const struct weft_multipass_work *w, struct weft_axis_kernels *out)
{
    for (int a = 0; a < 3; a++)
        weft_kernel_derive_times(NULL, &w->kernel, w->derivative.along[a], &out->kernel[a]);
    out->sums_are_one =
        weft_derivative_order(&w->derivative) == 0 && (w->kernel.unit_sum || w->kernel.normalised);
}

int weft_multipass_weights(const struct weft_multipass_work *work,
                           const struct weft_axis_kernels *axes, const double position[3],
                           double *weights, int64_t first[3])
{
    const int dims = work->passes->dims;
    double values[3][WEFT_KERNEL_MAX_WIDTH];
    if (weft_derivative_order(&work->derivative) == 0)
        return weft_kernel_weights_nd(&work->kernel, dims, position, weights, first);
    for (int a = 0; a < 3; a++)
        first[a] = a < dims ? weft_kernel_weights(&axes->kernel[a], position[a], values[a]) : 0;
    return weft_kernel_combine(&work->kernel, dims,
                               (const double *const[3]){values[0], values[1], values[2]}, weights);
}

// Where samples are fetched from.
struct plane {
    const struct weft_samples *samples;
    int channel;
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct plane *plane = priv;
    return (double)
        plane->samples->plane[plane->channel][weft_multipass_sample(plane->samples, index)];
}

double weft_multipass_refer(const struct weft_multipass_work *work,
                            const struct weft_axis_kernels *axes,
                            const struct weft_samples *samples, int channel,
                            const double position[3])
{
    struct plane plane = {samples, channel};
    const int dims = work->passes->dims;
    if (weft_derivative_order(&work->derivative) > 0)
        return weft_reference_compute_axes(axes->kernel, dims, position, fetch, &plane).value;
    return weft_reference_compute(&work->kernel, dims, position, fetch, &plane).value;
}
