// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>

#include "passes/multipass/compiled.h"
#include "passes/verify/pixel_error.h"

struct verifier {
    const struct weft_multipass_verify_params *params;
    const struct weft_multipass_work *work;
    struct weft_axis_kernels axes;
    int64_t stride;
    double square_sum;
    uint64_t compared;
    struct weft_multipass_error error;
};

static void check_pixel(struct verifier *v, int x, int y, int channel)
{
    struct weft_multipass_error *e = &v->error;
    const int64_t at = y * v->stride + x;
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
                                            const struct weft_multipass_verify_params *params,
                                            struct weft_multipass_error *out)
{
    struct verifier v = {.params = params, .work = work};
    *out = (struct weft_multipass_error){0};
    const struct weft_multipass_request request = {
        .samples = params->samples,
        .grid = params->grid,
        .pixels = {params->pixels[0], params->pixels[1], params->pixels[2], params->pixels[3]},
        .stride = params->stride,
    };
    enum weft_result res = weft_multipass_check_list(params->log, work);
    if (res == WEFT_OK)
        res = weft_multipass_check_request(params->log, work, &request);
    if (res == WEFT_OK && work->derivative)
        res = weft_kernel_derive(params->log, &work->kernel, &v.axes.kernel[0]);
    if (res != WEFT_OK)
        return res;
    weft_multipass_axis_kernels(work, &v.axes);
    v.stride = weft_multipass_stride(&request);
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

enum weft_result weft_multipass_verify(const struct weft_multipass_verify_params *params,
                                       struct weft_multipass_error *out)
{
    struct weft_multipass_work work;
    const enum weft_result res = weft_multipass_plan_work(params->log, params->plan, &work);
    return res == WEFT_OK ? weft_multipass_verify_work(&work, params, out) : res;
}
