// SPDX-License-Identifier: BSD-3-Clause
// The pictures of `weft antialias` against exact ones.
#include <math.h>
#include <stdlib.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"
#include "tools/scene/exact.h"

enum weft_result antialias_job_make_exact(struct antialias_job *job, int frame)
{
    const double start = report_now_seconds();
    const int *size = job->params.size;
    if (!job->option[ASK_VERIFY].given)
        return WEFT_OK;
    if (!job->exact)
        job->exact = malloc((size_t)size[0] * (size_t)size[1] * 4 * sizeof *job->exact);
    if (!job->exact) {
        report_error("out of memory for an exact picture of %d x %d pixels", size[0], size[1]);
        return WEFT_ERR_MEMORY;
    }
    const enum weft_result res = scene_exact_draw(
        scene_exact_params(.scene = &job->scene, .size = {size[0], size[1]},
                           .time = antialias_job_time(job, frame), .filter = job->params.filter,
                           .filter_width = job->params.filter_width, .log = report_log(),
                           .progress = report_progress("finding exact coverage")),
        job->exact, &job->exactness.known_to);
    report_erase_progress();
    job->seconds.verify += report_now_seconds() - start;
    return res;
}

static void compare_value(const struct antialias_job *job, int frame, int x, int y, int channel,
                          struct antialias_exactness *out)
{
    const int *size = job->params.size;
    const size_t drawn = (size_t)y * (size_t)size[0] + (size_t)x,
                 exact = (size_t)(size[1] - 1 - y) * (size_t)size[0] + (size_t)x;
    const double difference = fabs((double)job->picture.channel[channel].plane[drawn] -
                                   job->exact[4 * exact + (size_t)channel]);
    out->values++;
    out->square += difference * difference;
    // What is no number is the largest.
    if (difference <= out->largest || isnan(out->largest))
        return;
    out->largest = difference;
    out->at[0] = x;
    out->at[1] = y;
    out->channel = channel;
    out->frame = frame;
}

void antialias_job_compare(struct antialias_job *job, int frame)
{
    const double start = report_now_seconds();
    for (int y = 0; y < job->params.size[1] && job->exact; y++)
        for (int x = 0; x < job->params.size[0]; x++)
            for (int channel = 0; channel < PICTURE_CHANNELS; channel++)
                compare_value(job, frame, x, y, channel, &job->exactness);
    job->seconds.verify += report_now_seconds() - start;
}
