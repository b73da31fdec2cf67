// SPDX-License-Identifier: BSD-3-Clause
// Reading the frames of `weft accumulate`, one after another.
#include <stdio.h>
#include <stdlib.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"

static void set_last_words(const struct accumulate_job *job)
{
    report_set_last_words("weft: ended after %lld of %lld frames, nothing is written",
                          (long long)job->next, (long long)job->frame_count);
}

static enum weft_result add(struct accumulate_job *job, const struct weft_image *image,
                            double weight)
{
    struct weft_plane *plane = calloc(image->channel_count, sizeof *plane);
    if (!plane)
        return WEFT_ERR_MEMORY;
    for (size_t c = 0; c < image->channel_count; c++)
        plane[c].values = image->channels[c].plane;
    const struct weft_frame frame = {.plane = plane};
    const enum weft_result res = weft_accumulator_add(job->accumulator, &frame, weight);
    free(plane);
    return res;
}

static enum weft_result read_frame(struct accumulate_job *job)
{
    const struct accumulate_frame *frame = &job->frame[job->next];
    const struct weft_image_load_params params = {
        .path = frame->path, .threads = job->threads, .log = report_log()};
    struct weft_image image = {0};
    const double start = report_now_seconds();
    enum weft_result res = weft_image_load(&params, &image);
    const double loaded = report_now_seconds();
    job->read_seconds += loaded - start;
    if (res == WEFT_OK && image.channel_count != job->image.channel_count) {
        report_error("%s has %zu channels, %s has %zu", frame->path, image.channel_count,
                     job->frame[0].path, job->image.channel_count);
        res = WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK)
        res = add(job, &image, frame->weight);
    job->add_seconds += report_now_seconds() - loaded;
    weft_image_clear(&image);
    if (res != WEFT_OK)
        return res;
    job->first = job->first < 0 ? job->next : job->first;
    job->added++;
    return WEFT_OK;
}

enum weft_result accumulate_read(struct accumulate_job *job)
{
    enum weft_result res = WEFT_OK;
    while (res == WEFT_OK && job->next < job->frame_count) {
        set_last_words(job);
        res = read_frame(job);
        job->next += res == WEFT_OK;
    }
    return res;
}
