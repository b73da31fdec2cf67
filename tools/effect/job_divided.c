// SPDX-License-Identifier: BSD-3-Clause
// The frames of `weft effect` on several ranks. What a frame shows is the plan's, which every rank
// has made by itself: numbers are those of the frame, whoever draws it.
#include <stdio.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"
#include "tools/ranks/ranks.h"

static bool is_counted(void *priv, int64_t i)
{
    const struct effect_job *job = priv;
    return job->plan.frames[job->added + i].weight != 0.0;
}

static int64_t count_added(const struct effect_job *job)
{
    int64_t counted = 0;
    for (int64_t i = 0; i < job->added; i++)
        counted += job->plan.frames[i].weight != 0.0;
    return counted;
}

// ---- blocks -------------------------------------------------------------------------------------

// How the last frame of the first scene that a block has found its shadows.
struct found {
    int64_t frame;
    struct scene_shadow_info shadow;
};

static enum weft_result run(void *priv, int64_t first, int64_t count, void **data, size_t *size)
{
    struct effect_job *job = priv;
    const enum weft_result res = effect_job_draw_range(job, job->added + first, count, NULL);
    int64_t at = job->added + first + count - 1;
    while (at >= job->added + first &&
           (job->plan.frames[at].scene != 0 || job->plan.frames[at].weight == 0.0))
        at--;
    if (res != WEFT_OK || at < job->added + first)
        return res;
    struct found *found = calloc(1, sizeof *found);
    if (!found)
        return WEFT_ERR_MEMORY;
    found->frame = at;
    scene_drawing_get_shadow(job->scene[0].drawing, &found->shadow);
    *data = found;
    *size = sizeof *found;
    return WEFT_OK;
}

// Of all frames, the last one tells.
static enum weft_result take(void *priv, int64_t first, int64_t count, const void *data,
                             size_t size)
{
    struct effect_job *job = priv;
    const struct found *found = data;
    (void)first;
    (void)count;
    if (size != sizeof *found)
        return WEFT_ERR_FORMAT;
    if (found->frame < job->divided.shadow_of)
        return WEFT_OK;
    job->divided.shadow_of = found->frame;
    job->shadow = found->shadow;
    return WEFT_OK;
}

static enum weft_result create(void *priv, weft_accumulator **out)
{
    return effect_job_create(priv, out);
}

// ---- rounds -------------------------------------------------------------------------------------

// Of all frames, where a round of them is drawn.
struct drawn {
    int64_t added, count, all;
    const struct weft_progress *progress;
};

static bool report_round(void *priv, double fraction)
{
    const struct drawn *d = priv;
    const double done = (double)d->added + fraction * (double)d->count;
    return d->progress->report(d->progress->priv, done / (double)d->all);
}

static enum weft_result draw_round(struct effect_job *job, int64_t count)
{
    char doing[64];
    snprintf(doing, sizeof doing, "drawing %lld frames", (long long)job->plan.count);
    struct drawn drawn = {job->added, count, job->plan.count, report_progress(doing)};
    const struct weft_progress progress = {report_round, &drawn};
    const struct rank_frames frames = {
        .count = count,
        .counted = count_added(job),
        .batch = job->how.batch ? job->how.batch : 1,
        .request = &job->divided.request,
        .counts = is_counted,
        .run = run,
        .take = take,
        .priv = job,
        .progress = &progress,
    };
    enum weft_result res = rank_frames_add(&frames, &job->divided.report);
    if (res == WEFT_OK)
        res = rank_frames_join(&job->accumulator, create, job, &job->divided.report);
    job->added += res == WEFT_OK ? count : 0;
    return res;
}

// Rank 0 judges, and where it is enough all stop.
static enum weft_result judge(struct effect_job *job)
{
    enum weft_result res = ranks_agree(ranks_tells() ? effect_job_judge(job) : WEFT_OK);
    if (res == WEFT_OK)
        res = ranks_share(&job->judged, sizeof job->judged);
    return res == WEFT_OK ? ranks_share(&job->stopped, sizeof job->stopped) : res;
}

enum weft_result effect_job_draw_divided(struct effect_job *job)
{
    enum weft_result res = ranks_check_alike(job->context, job->divided.request.mixed);
    job->divided.shadow_of = -1;
    while (res == WEFT_OK && !job->stopped && job->added < job->plan.count) {
        res = draw_round(job, effect_job_next_end(job) - job->added);
        if (res == WEFT_OK)
            res = judge(job);
    }
    report_erase_progress();
    return res;
}
