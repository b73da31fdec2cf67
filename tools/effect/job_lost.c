// SPDX-License-Identifier: BSD-3-Clause
// How much light a clamped radiosity loses: frames that show what clamping took away, averaged.
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"
#include "tools/ranks/ranks.h"

// First frames and pixels along a side that are enough to know it by a few percent of itself.
enum { FRAMES = 128, SIDE = 128 };

// The first frames, which are a sample of all, in a smaller picture. To be cleared.
static enum weft_result make_part(const struct effect_job *job, struct effect_plan *out)
{
    const int *size = job->plan.size;
    const int longer = size[0] > size[1] ? size[0] : size[1];
    *out = job->plan;
    out->count = job->added < FRAMES ? job->added : FRAMES;
    out->frames = malloc((size_t)out->count * sizeof *out->frames);
    if (!out->frames)
        return WEFT_ERR_MEMORY;
    memcpy(out->frames, job->plan.frames, (size_t)out->count * sizeof *out->frames);
    for (int axis = 0; axis < 2 && longer > SIDE; axis++)
        out->size[axis] = (size[axis] * SIDE + longer - 1) / longer;
    for (int64_t k = 0; k < out->count; k++)
        memcpy(out->frames[k].show.camera.size, out->size, sizeof out->size);
    return WEFT_OK;
}

// The mean of red, green and blue over all pixels.
static enum weft_result find_mean(weft_accumulator *accumulator, const int size[2], double *out)
{
    const size_t pixels = (size_t)size[0] * (size_t)size[1];
    float *plane = malloc(pixels * sizeof *plane);
    enum weft_result res = plane ? WEFT_OK : WEFT_ERR_MEMORY;
    *out = 0.0;
    for (int c = 0; c < 3 && res == WEFT_OK; c++) {
        res = weft_accumulator_current(accumulator, WEFT_ACCUMULATED_MEAN, c, plane, 0);
        for (size_t i = 0; i < pixels && res == WEFT_OK; i++)
            *out += (double)plane[i] / (3.0 * (double)pixels);
    }
    free(plane);
    return res;
}

// The same of the part's frames, with all that they show, or what clamping took away of it.
static enum weft_result draw_mean(const struct effect_job *job, const struct effect_plan *part,
                                  bool clamped_share, double *out)
{
    scene_drawing *drawing[EFFECT_MAX_SCENES];
    weft_accumulator *accumulator = NULL;
    for (int i = 0; i < job->scene_count; i++)
        drawing[i] = job->scene[i].drawing;
    enum weft_result res = weft_accumulator_create(
        weft_accumulator_params(.width = part->size[0], .height = part->size[1],
                                .channel_count = PICTURE_CHANNELS, .method = WEFT_ACCUMULATE_FLOAT,
                                .nonfinite = WEFT_NONFINITE_PROPAGATE, .context = job->context,
                                .log = report_log()),
        &accumulator);
    if (res == WEFT_OK)
        res =
            effect_run(effect_run_params(.plan = part, .drawing = drawing,
                                         .accumulator = accumulator, .clamped_share = clamped_share,
                                         .progress = report_progress("measuring lost light")),
                       NULL);
    if (res == WEFT_OK)
        res = find_mean(accumulator, part->size, out);
    weft_accumulator_destroy(&accumulator);
    return res;
}

// Both means, which several ranks share among each other.
struct means {
    const struct effect_job *job;
    struct effect_plan part;
    double mean[2]; // kept, lost
};

static enum weft_result run(void *priv, int64_t i, void **data, size_t *size)
{
    const struct means *m = priv;
    double *mean = malloc(sizeof *mean);
    if (!mean)
        return WEFT_ERR_MEMORY;
    *data = mean;
    *size = sizeof *mean;
    return draw_mean(m->job, &m->part, i == 1, mean);
}

static enum weft_result take(void *priv, int64_t i, const void *data, size_t size)
{
    struct means *m = priv;
    if (size != sizeof m->mean[i])
        return WEFT_ERR_FORMAT;
    memcpy(&m->mean[i], data, size);
    return WEFT_OK;
}

static enum weft_result measure(struct means *m)
{
    enum weft_result res = WEFT_OK;
    if (m->job->divided.is)
        return weft_ranks_do_items(
            ranks_get(),
            &(struct weft_items){
                .count = 2, .schedule = WEFT_SCHEDULE_STATIC, .run = run, .take = take, .priv = m},
            NULL);
    for (int i = 0; i < 2 && res == WEFT_OK; i++)
        res = draw_mean(m->job, &m->part, i == 1, &m->mean[i]);
    return res;
}

enum weft_result effect_job_measure_lost(struct effect_job *job)
{
    const double start = report_now_seconds();
    struct means means = {.job = job};
    if (!(job->params.effects & EFFECT_RADIOSITY) || job->plan.clamp == 0.0)
        return WEFT_OK;
    enum weft_result res = ranks_agree(make_part(job, &means.part));
    if (res == WEFT_OK)
        res = ranks_agree(measure(&means));
    const struct effect_plan part = means.part;
    const double kept = means.mean[0], lost = means.mean[1];
    job->lost = (struct effect_lost){.frames = part.count,
                                     .size = {part.size[0], part.size[1]},
                                     .share = lost > 0.0 ? lost / (kept + lost) : 0.0};
    free(part.frames);
    report_erase_progress();
    job->seconds.lost = report_now_seconds() - start;
    return res;
}
