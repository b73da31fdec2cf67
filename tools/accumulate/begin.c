// SPDX-License-Identifier: BSD-3-Clause
// What the frames of `weft accumulate` have in common, and the accumulator for them.
#include <stdlib.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"

static enum weft_result look_at_first(struct accumulate_job *job)
{
    const struct weft_image_load_params params = {
        .path = job->frame[0].path, .info_only = true, .log = report_log()};
    return weft_image_load(&params, &job->image);
}

static enum weft_result choose_channels(struct accumulate_job *job)
{
    job->channel = calloc(job->image.channel_count, sizeof *job->channel);
    if (!job->channel) {
        report_error("out of memory for %zu channels", job->image.channel_count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t c = 0; c < job->image.channel_count; c++)
        job->channel[c] = (struct accumulate_channel){.averaged = job->averaged_count++,
                                                      .widest = job->image.channels[c].type};
    return WEFT_OK;
}

static enum weft_result make_accumulator(struct accumulate_job *job)
{
    const struct weft_accumulator_params params = {
        .width = job->image.width,
        .height = job->image.height,
        .channel_count = job->averaged_count,
        .method = WEFT_ACCUMULATE_EXACT,
        .frame_count = job->frame_count,
        .cpu = {.threads = job->threads},
        .log = report_log(),
    };
    return weft_accumulator_create(&params, &job->accumulator);
}

enum weft_result accumulate_begin(struct accumulate_job *job)
{
    enum weft_result res = look_at_first(job);
    if (res == WEFT_OK)
        res = choose_channels(job);
    if (res == WEFT_OK)
        res = make_accumulator(job);
    return res;
}
