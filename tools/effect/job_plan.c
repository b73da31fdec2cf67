// SPDX-License-Identifier: BSD-3-Clause
// The plan of `weft effect`, and what it says of the picture.
#include <math.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"

// What is in sight in the middle of the time, and how far out of focus.
static void look(struct effect_job *job)
{
    const struct effect_params *p = &job->params;
    const double middle = 0.5 * (p->time[0] + p->time[1]);
    struct weft_camera camera;
    scene_depths(p->scene[0], p->size, middle, &job->depth[0], &job->depth[1]);
    scene_camera_at(p->scene[0], middle, &camera);
    for (int i = 0; i < 2; i++)
        job->circle[i] = weft_camera_circle(&camera, p->size, job->plan.aperture, job->plan.focus,
                                            job->depth[i]);
    if (isnan(job->depth[0]))
        report_warning("nothing of scene %s is in the picture", p->scene[0]->name);
}

enum weft_result effect_job_make_plan(struct effect_job *job)
{
    const double start = report_now_seconds();
    const enum weft_result res = effect_plan_make(&job->params, &job->plan);
    if (res == WEFT_OK)
        look(job);
    if (res == WEFT_OK && job->option[ASK_UNTIL].given && !job->plan.extends)
        report_warning(
            "--until: the first frames of this plan are chosen from all at random, not "
            "evenly spread: --jitter sobol, halton or r2 are sets that can end anywhere");
    job->seconds.plan = report_now_seconds() - start;
    return res;
}
