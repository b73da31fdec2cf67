// SPDX-License-Identifier: BSD-3-Clause
// Resampling along one axis and then the other, channel by channel.
#include <math.h>

#include "passes/resample/resample_impl.h"

void weft_resample_add_separable(const weft_separable_plan *plan,
                                 const struct weft_separable_report *one,
                                 struct weft_resample_work *sum)
{
    const struct weft_separable_info *info = weft_separable_plan_get_info(plan);
    const struct weft_resample_work work = {
        .tiles = one->rectangles,
        .prepare_seconds = one->prepare_seconds,
        .upload_seconds = one->upload_seconds,
        .pass_seconds = one->pass_seconds,
        .readback_seconds = one->readback_seconds,
        .uploaded_bytes = one->uploaded_bytes,
        .peak_bytes = one->peak_bytes,
        .draws = one->passes,
        .first_axis = info->first_axis,
        .fetches_per_pixel = info->fetches_per_pixel,
        .cpu = one->cpu,
    };
    weft_resample_work_add(sum, &work);
}

enum weft_result weft_resample_survey_source(const weft_resample_plan *plan,
                                             const weft_resample_source *source,
                                             struct weft_resample_survey *out)
{
    *out = (struct weft_resample_survey){0};
    enum weft_result res = weft_resample_check_source(plan->log, plan, source);
    for (int c = 0; res == WEFT_OK && !plan->passes && c < source->info.channels; c++)
        res = weft_separable_survey_samples(
            plan->separable,
            weft_separable_run_params(.samples = weft_resample_values(source, c),
                                      .window = weft_resample_values_window(source),
                                      .log = plan->log),
            &out->channel[c]);
    return res;
}

void weft_resample_survey_join(struct weft_resample_survey *sum,
                               const struct weft_resample_survey *other)
{
    for (int c = 0; c < WEFT_RESAMPLE_MAX_CHANNELS; c++)
        weft_separable_survey_join(&sum->channel[c], &other->channel[c]);
}

bool weft_resample_knows_survey(const weft_resample_source *source,
                                struct weft_separable_survey *out)
{
    const struct weft_statistics *s = &source->samples;
    const double largest = fmax(fabs(s->minimum), fabs(s->maximum));
    *out = (struct weft_separable_survey){.largest = largest};
    return !source->info.kernel.prefiltered && s->count > 0 && s->not_finite == 0 &&
           weft_separable_is_safe(largest);
}

enum weft_result weft_resample_run_separable(weft_resample_compiled *compiled,
                                             const struct weft_resample_run_params *params,
                                             struct weft_resample_report *report)
{
    const int channels = params->source->info.channels;
    struct weft_resample_steps steps = {.outer = params->progress, .steps = channels};
    const struct weft_progress progress = {weft_resample_report_step, &steps};
    enum weft_result res = WEFT_OK;
    struct weft_separable_survey known;
    const bool knows = weft_resample_knows_survey(params->source, &known);
    for (int c = 0; res == WEFT_OK && c < channels; c++, steps.step++) {
        struct weft_texture texture = params->texture ? *params->texture : (struct weft_texture){0};
        texture.channel += c;
        const struct weft_separable_run_params run = {
            .samples = weft_resample_values(params->source, c),
            .border = params->source->info.border,
            .window = weft_resample_values_window(params->source),
            .part = params->part,
            .survey = params->survey ? &params->survey->channel[c]
                      : knows        ? &known
                                     : NULL,
            .pixels = params->plane[c],
            .stride = params->stride,
            .texture = params->texture ? &texture : NULL,
            .progress = &progress,
            .log = params->log,
        };
        struct weft_separable_report one;
        res = weft_separable_run(compiled->separable, &run, &one);
        if (res != WEFT_OK)
            break;
        weft_resample_add_separable(compiled->plan->separable, &one, &report->work);
        weft_statistics_join(&report->pixels, &one.pixels);
    }
    return res;
}
