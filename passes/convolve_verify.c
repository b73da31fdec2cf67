// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "filter/reference.h"
#include "passes/convolve_job.h"

struct verifier {
    const struct weft_convolve_params *params;
    const struct weft_convolve_work *work;
    struct weft_kernel derived; // along the axis of the plan's derivative
    double square_sum;
    uint64_t compared;
    struct weft_convolve_error error;
};

// Where samples are fetched from.
struct plane {
    const struct weft_samples *samples;
    int channel;
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct plane *plane = priv;
    const int *size = plane->samples->size;
    size_t at = 0;
    for (int a = 2; a >= 0; a--) {
        const int64_t i = index[a] < 0 ? 0 : index[a] >= size[a] ? size[a] - 1 : index[a];
        at = at * (size_t)size[a] + (size_t)i;
    }
    return (double)plane->samples->plane[plane->channel][at];
}

// The tensor product of weights, one axis having the derived kernel's; sums as Neumaier (1974).
static double derivative_at(const struct verifier *v, const double position[3], struct plane *plane)
{
    const struct weft_kernel *kernel = &v->work->kernel;
    const int width = kernel->width, dims = v->work->passes->dims;
    double weights[3][WEFT_KERNEL_MAX_WIDTH] = {{1.0}, {1.0}, {1.0}};
    int64_t first[3] = {0};
    for (int a = 0; a < dims; a++)
        first[a] = weft_kernel_weights(a + 1 == v->work->derivative ? &v->derived : kernel,
                                       position[a], weights[a]);
    double total = 0.0, lost = 0.0;
    for (int k = 0; k < (dims > 2 ? width : 1); k++) {
        for (int j = 0; j < (dims > 1 ? width : 1); j++) {
            for (int i = 0; i < width; i++) {
                const int64_t index[3] = {first[0] + i, first[1] + j, first[2] + k};
                const double term =
                    weights[0][i] * weights[1][j] * weights[2][k] * fetch(plane, index);
                const double next = total + term;
                lost += fabs(total) >= fabs(term) ? (total - next) + term : (term - next) + total;
                total = next;
            }
        }
    }
    return isfinite(total) ? total + lost : total;
}

static double refer(const struct verifier *v, int x, int y, int channel)
{
    struct plane plane = {v->params->samples, channel};
    double position[3];
    weft_convolve_position(v->params->grid, x, y, position);
    if (v->work->derivative)
        return derivative_at(v, position, &plane);
    return weft_reference_compute(&v->work->kernel, v->work->passes->dims, position, fetch, &plane)
        .value;
}

static void check_pixel(struct verifier *v, int x, int y, int channel)
{
    struct weft_convolve_error *e = &v->error;
    const size_t at = (size_t)y * (size_t)v->params->grid->width + (size_t)x;
    const double value = (double)v->params->pixels[channel][at];
    const double reference = refer(v, x, y, channel);
    if (!isfinite(value) || !isfinite(reference)) {
        e->not_finite_mismatches += isfinite(value) != isfinite(reference);
        return;
    }
    const double error = fabs(value - reference);
    v->square_sum += error * error;
    v->compared++;
    if (error > e->maximum || v->compared == 1) {
        e->maximum = error;
        e->at_x = x;
        e->at_y = y;
        e->channel = channel;
    }
}

enum weft_result weft_convolve_verify_work(const struct weft_convolve_work *work,
                                           const struct weft_convolve_params *params,
                                           struct weft_convolve_error *out)
{
    struct verifier v = {.params = params, .work = work};
    *out = (struct weft_convolve_error){0};
    enum weft_result res = weft_convolve_work_check(work, params);
    if (res == WEFT_OK && work->derivative)
        res = weft_kernel_derive(params->log, &work->kernel, &v.derived);
    if (res != WEFT_OK)
        return res;
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

enum weft_result weft_convolve_verify(const struct weft_convolve_params *params,
                                      struct weft_convolve_error *out)
{
    struct weft_convolve_work work;
    const enum weft_result res = weft_convolve_plan_work(params, &work);
    return res == WEFT_OK ? weft_convolve_verify_work(&work, params, out) : res;
}
