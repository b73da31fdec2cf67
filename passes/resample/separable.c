// SPDX-License-Identifier: BSD-3-Clause
// Resampling along one axis and then the other, in single precision, channel by channel.
#include "passes/resample/resample_impl.h"
#include "passes/separable/separable.h"

static void make_request(const weft_resample_plan *plan, const weft_resample_source *source, int c,
                         struct weft_separable_params *out)
{
    *out = (struct weft_separable_params){
        .kernel = plan->info.kernel,
        .size = {weft_resample_values_along(source, 0), weft_resample_values_along(source, 1)},
        .samples = weft_resample_values(source, c),
        .width = plan->info.width,
        .height = plan->info.height,
        .x = plan->at[0],
        .y = plan->at[1],
        .memory_bytes = plan->memory_bytes,
    };
}

static void add_work(struct weft_resample_work *sum, const struct weft_separable_report *one)
{
    const struct weft_resample_work work = {
        .tiles = one->rectangles,
        .prepare_seconds = one->prepare_seconds,
        .upload_seconds = one->upload_seconds,
        .pass_seconds = one->pass_seconds,
        .readback_seconds = one->readback_seconds,
        .uploaded_bytes = one->uploaded_bytes,
        .peak_bytes = one->peak_bytes,
        .draws = one->passes,
        .first_axis = one->first_axis,
        .fetches_per_pixel = one->fetches_per_pixel,
    };
    weft_resample_work_add(sum, &work);
}

enum weft_result weft_resample_run_separable(weft_resample_compiled *compiled,
                                             const struct weft_resample_run_params *params,
                                             struct weft_resample_work *work)
{
    const int channels = params->source->info.channels;
    struct weft_resample_steps steps = {.outer = params->progress, .steps = channels};
    const struct weft_progress progress = {weft_resample_report_step, &steps};
    enum weft_result res = WEFT_OK;
    for (int c = 0; res == WEFT_OK && c < channels; c++, steps.step++) {
        struct weft_separable_params request;
        struct weft_separable_report report;
        make_request(compiled->plan, params->source, c, &request);
        request.pixels = params->plane[c];
        request.stride = params->stride;
        request.progress = &progress;
        request.log = params->log;
        res = weft_separable_run(compiled->context, &request, &report);
        if (res == WEFT_OK)
            add_work(work, &report);
    }
    return res;
}
