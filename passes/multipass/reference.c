// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/kernels/kernel_nd.h"
#include "filter/analysis/reference.h"
#include "passes/multipass/job.h"
#include "passes/verify/pixel_error.h"

void weft_multipass_axis_kernels(const struct weft_multipass_work *w, struct weft_axis_kernels *out)
{
    for (int a = 0; a < 3; a++)
        out->kernel[a] = w->kernel;
    out->sums_are_one = w->derivative == 0 && (w->kernel.unit_sum || w->kernel.normalised);
    if (w->derivative)
        weft_kernel_derive(NULL, &w->kernel, &out->kernel[w->derivative - 1]);
}

int weft_multipass_weights(const struct weft_multipass_work *work,
                           const struct weft_axis_kernels *axes, const double position[3],
                           double *weights, int64_t first[3])
{
    const int dims = work->passes->dims;
    double values[3][WEFT_KERNEL_MAX_WIDTH];
    if (!work->derivative)
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

// Sums as Neumaier (1974); taps of weight 0 do not count, as in the reference.
static double derivative_at(const struct weft_multipass_work *work,
                            const struct weft_axis_kernels *axes, const double position[3],
                            struct plane *plane)
{
    const int width = work->kernel.width, dims = work->passes->dims;
    const int rows = dims > 1 ? width : 1;
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    const int count = weft_multipass_weights(work, axes, position, weights, first);
    double total = 0.0, lost = 0.0;
    for (int i = 0; i < count; i++) {
        if (weights[i] == 0.0)
            continue;
        const int64_t index[3] = {first[0] + i % width, first[1] + i / width % rows,
                                  first[2] + i / width / rows};
        const double term = weights[i] * fetch(plane, index);
        const double next = total + term;
        lost += fabs(total) >= fabs(term) ? (total - next) + term : (term - next) + total;
        total = next;
    }
    return isfinite(total) ? total + lost : total;
}

double weft_multipass_refer(const struct weft_multipass_work *work,
                            const struct weft_axis_kernels *axes,
                            const struct weft_samples *samples, int channel,
                            const double position[3])
{
    struct plane plane = {samples, channel};
    if (work->derivative)
        return derivative_at(work, axes, position, &plane);
    return weft_reference_compute(&work->kernel, work->passes->dims, position, fetch, &plane).value;
}

struct verifier {
    const struct weft_multipass_params *params;
    const struct weft_multipass_work *work;
    struct weft_axis_kernels axes;
    double square_sum;
    uint64_t compared;
    struct weft_multipass_error error;
};

static void check_pixel(struct verifier *v, int x, int y, int channel)
{
    struct weft_multipass_error *e = &v->error;
    const size_t at = (size_t)y * (size_t)v->params->grid->width + (size_t)x;
    double position[3];
    bool mismatch;
    weft_multipass_position(v->params->grid, x, y, position);
    const double exact =
        weft_multipass_refer(v->work, &v->axes, v->params->samples, channel, position);
    const double error = weft_pixel_error(v->params->pixels[channel][at], exact, &mismatch);
    e->not_finite_mismatches += mismatch;
    if (isnan(error))
        return;
    v->square_sum += error * error;
    v->compared++;
    if (error > e->maximum || v->compared == 1) {
        e->maximum = error;
        e->at_x = x;
        e->at_y = y;
        e->channel = channel;
    }
}

enum weft_result weft_multipass_verify_work(const struct weft_multipass_work *work,
                                            const struct weft_multipass_params *params,
                                            struct weft_multipass_error *out)
{
    struct verifier v = {.params = params, .work = work};
    *out = (struct weft_multipass_error){0};
    enum weft_result res = weft_multipass_work_check(work, params);
    if (res == WEFT_OK && work->derivative)
        res = weft_kernel_derive(params->log, &work->kernel, &v.axes.kernel[0]);
    if (res != WEFT_OK)
        return res;
    weft_multipass_axis_kernels(work, &v.axes);
    const struct weft_pixel_grid *grid = params->grid;
    for (int y = 0; y < grid->height; y++) {
        if (!weft_job_go_on(params->progress, (double)y / grid->height))
            return WEFT_ERR_CANCELLED;
        for (int x = 0; x < grid->width; x++)
            for (int c = 0; c < work->channels; c++)
                check_pixel(&v, x, y, c);
    }
    weft_job_go_on(params->progress, 1.0);
    v.error.rms = v.compared ? sqrt(v.square_sum / (double)v.compared) : 0.0;
    *out = v.error;
    return WEFT_OK;
}

enum weft_result weft_multipass_verify(const struct weft_multipass_params *params,
                                       struct weft_multipass_error *out)
{
    struct weft_multipass_work work;
    const enum weft_result res = weft_multipass_plan_work(params, &work);
    return res == WEFT_OK ? weft_multipass_verify_work(&work, params, out) : res;
}
