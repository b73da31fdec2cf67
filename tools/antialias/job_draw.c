// SPDX-License-Identifier: BSD-3-Clause
// Drawing the pictures of `weft antialias`.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/antialias/job.h"
#include "tools/common/report.h"
#include "tools/render/lamps.h"

// ---- what is drawn, and with what ---------------------------------------------------------------

static enum weft_result make_scene(struct antialias_job *job)
{
    const double start = report_now_seconds();
    enum weft_result res =
        scene_options_make(&job->request, job->scene_name, INFINITY, &job->scene);
    if (res == WEFT_OK)
        res = scene_options_check_shadows(&job->request, &job->scene);
    report_erase_progress();
    job->seconds.scene = report_now_seconds() - start;
    return res;
}

static void set_last_words(const struct antialias_job *job)
{
    if (job->frames > 1)
        report_set_last_words("weft: ended with %d of %d pictures complete", job->drawn,
                              job->frames);
}

static enum weft_result create_context(struct antialias_job *job)
{
    const double start = report_now_seconds();
    const enum weft_result res = weft_context_create(
        weft_context_params(.kind = job->kind, .log = report_log()), &job->context);
    job->params.context = job->context;
    job->params.background = job->scene.background;
    job->seconds.context = report_now_seconds() - start;
    return res;
}

static enum weft_result create_drawing(struct antialias_job *job)
{
    struct scene_drawing_params *params =
        scene_drawing_params(.scene = &job->scene, .context = job->context, .log = report_log());
    if (job->request.shadow_size)
        params->shadow_size = job->request.shadow_size;
    return scene_drawing_create(params, &job->drawing);
}

// Room for a picture and what is told of all.
static enum weft_result allocate(struct antialias_job *job)
{
    const int *size = job->params.size;
    const bool map = job->option[ASK_WEIGHT_MAP].given;
    job->seconds_each = calloc((size_t)job->frames, sizeof *job->seconds_each);
    if (map)
        job->weight = malloc((size_t)size[0] * (size_t)size[1] * sizeof *job->weight);
    if (job->seconds_each && (!map || job->weight))
        return picture_create(size, &job->picture);
    report_error("out of memory for a picture of %d x %d pixels", size[0], size[1]);
    return WEFT_ERR_MEMORY;
}

// Which form it is, where the context decides, is known only now.
static void warn_of_form(const struct antialias_job *job)
{
    const char *const option = antialias_job_form_option(job);
    if (job->params.way == ANTIALIAS_ACAA && job->report.acaa.form == WEFT_ACAA_JITTER && option)
        report_warning("%s: nothing comes of it, as %s: each sample is a picture of its own",
                       option, job->report.acaa.why);
}

enum weft_result antialias_job_begin(struct antialias_job *job)
{
    const bool explain = job->option[ASK_EXPLAIN].given;
    enum weft_result res = make_scene(job);
    if (res == WEFT_OK)
        res = create_context(job);
    const double start = report_now_seconds();
    if (res == WEFT_OK)
        res = antialias_drawer_create(&job->params, &job->drawer);
    if (res == WEFT_OK) {
        antialias_drawer_get_report(job->drawer, &job->report);
        warn_of_form(job);
    }
    if (res == WEFT_OK && !explain)
        res = create_drawing(job);
    if (res == WEFT_OK && !explain)
        res = allocate(job);
    if (res == WEFT_OK && !explain)
        set_last_words(job);
    job->seconds.prepare = report_now_seconds() - start;
    return res;
}

// ---- a picture ----------------------------------------------------------------------------------

struct prepared {
    const struct antialias_job *job;
    struct scene_frame show;
};

// Shadow maps are no part of what is timed.
static enum weft_result prepare(void *priv)
{
    const struct prepared *p = priv;
    const enum weft_result res = scene_drawing_prepare(p->job->drawing, &p->show);
    const weft_gl_function finish = weft_context_find_function(p->job->context, "glFinish");
    if (finish)
        finish();
    return res;
}

enum weft_result antialias_job_prepare(struct antialias_job *job, int frame)
{
    const int *size = job->params.size;
    if (job->prepared == frame)
        return WEFT_OK;
    job->prepared = -1;
    struct prepared p = {job, {.time = antialias_job_time(job, frame)}};
    memcpy(p.show.camera.size, size, sizeof p.show.camera.size);
    scene_lamps_in_middle(&job->scene, &p.show);
    const enum weft_result res = weft_context_call(job->context, prepare, &p);
    job->prepared = res == WEFT_OK ? frame : -1;
    return res;
}

// Of all pictures, where one is drawn. False once an interrupt has come.
struct part {
    int frame, frames;
    const struct weft_progress *progress;
};

static bool report_part(void *priv, double fraction)
{
    const struct part *p = priv;
    return p->progress->report(p->progress->priv, ((double)p->frame + fraction) / p->frames);
}

static enum weft_result read_planes(struct antialias_job *job)
{
    enum weft_result res = WEFT_OK;
    for (int c = 0; c < PICTURE_CHANNELS && res == WEFT_OK; c++)
        res = antialias_drawer_read(job->drawer, c, job->picture.channel[c].plane);
    return res;
}

static enum weft_result run_and_read(struct antialias_job *job, int frame)
{
    char doing[64];
    snprintf(doing, sizeof doing, "drawing %d picture%s", job->frames, job->frames == 1 ? "" : "s");
    struct part part = {frame, job->frames, report_progress(doing)};
    const struct weft_progress progress = {report_part, &part};
    const struct weft_antialias_drawing drawing = {.draw = scene_drawing_pass,
                                                   .priv = job->drawing};
    const double start = report_now_seconds();
    enum weft_result res = antialias_drawer_run(job->drawer, &drawing, frame, &progress);
    if (res == WEFT_OK)
        res = read_planes(job);
    job->seconds_each[frame] = report_now_seconds() - start;
    job->seconds.draw += job->seconds_each[frame];
    if (res == WEFT_OK && !report_part(&part, 1.0))
        res = WEFT_ERR_CANCELLED;
    return res;
}

enum weft_result antialias_job_finish(struct antialias_job *job, int frame)
{
    for (int c = 0; c < PICTURE_CHANNELS; c++)
        picture_turn_over(job->params.size, job->picture.channel[c].plane);
    if (job->weight)
        picture_turn_over(job->params.size, job->weight);
    antialias_job_add_weights(job, frame);
    antialias_job_compare(job, frame);
    picture_measure(&job->picture, job->statistics);
    report_erase_progress();
    const enum weft_result res = antialias_job_save(job, frame);
    job->drawn += res == WEFT_OK;
    set_last_words(job);
    return res;
}

static enum weft_result draw_one(struct antialias_job *job, int frame)
{
    enum weft_result res = antialias_job_make_exact(job, frame);
    if (res == WEFT_OK)
        res = antialias_job_prepare(job, frame);
    if (res == WEFT_OK)
        res = run_and_read(job, frame);
    if (res == WEFT_OK && job->weight)
        res = antialias_drawer_read_weight(job->drawer, job->weight);
    if (res != WEFT_OK)
        return res;
    antialias_drawer_get_report(job->drawer, &job->report);
    return antialias_job_finish(job, frame);
}

enum weft_result antialias_job_draw(struct antialias_job *job)
{
    enum weft_result res = WEFT_OK;
    for (int frame = 0; frame < job->frames && res == WEFT_OK; frame++)
        res = draw_one(job, frame);
    report_erase_progress();
    scene_drawing_get_shadow(job->drawing, &job->shadow);
    return res;
}

// ---- the end ------------------------------------------------------------------------------------

void antialias_job_clear(struct antialias_job *job)
{
    antialias_drawer_destroy(&job->drawer);
    scene_drawing_destroy(&job->drawing);
    scene_clear(&job->scene);
    weft_context_destroy(&job->context);
    weft_kernel_file_destroy(&job->filter_file);
    picture_clear(&job->picture);
    free(job->weight);
    free(job->exact);
    free(job->seconds_each);
    weft_items_report_clear(&job->divided.work);
}
