// SPDX-License-Identifier: BSD-3-Clause
// The mean of `weft effect` and its standard error as images, and their files.
#include <stdlib.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
#include "tools/effect/job.h"

// ---- images -------------------------------------------------------------------------------------

static enum weft_result fill(struct effect_job *job, enum weft_accumulated what,
                             struct picture *out)
{
    const struct option_value *o = job->option;
    const bool mean = what == WEFT_ACCUMULATED_MEAN;
    enum weft_result res = picture_create(job->params.size, out);
    for (int c = 0; c < PICTURE_CHANNELS && res == WEFT_OK; c++) {
        res = weft_accumulator_current(job->accumulator, what, c, out->channel[c].plane, 0);
        if (res == WEFT_OK)
            picture_turn_over(job->params.size, out->channel[c].plane);
        if (mean)
            out->channel[c].type = (enum weft_pixel_type)o[ASK_TYPE].integer[0];
    }
    out->image.compression = (enum weft_image_compression)o[ASK_COMPRESSION].integer[0];
    picture_set_attributes(
        out, effect_job_attributes(job, mean ? NULL : "standard error of the mean", out->text));
    return res;
}

enum weft_result effect_job_make_result(struct effect_job *job)
{
    const double start = report_now_seconds();
    weft_accumulator_get_report(job->accumulator, &job->report);
    enum weft_result res = effect_job_check_bound(job, job->report.bound);
    if (res == WEFT_OK)
        res = fill(job, WEFT_ACCUMULATED_MEAN, &job->mean);
    if (res == WEFT_OK) {
        picture_measure(&job->mean, job->statistics);
        effect_job_check_range(job);
    }
    if (res == WEFT_OK && job->option[ASK_STDERR].given)
        res = fill(job, WEFT_ACCUMULATED_STANDARD_ERROR, &job->error);
    job->seconds.result = report_now_seconds() - start;
    return res;
}

// ---- files --------------------------------------------------------------------------------------

static enum weft_result save(const struct effect_job *job, enum effect_option option,
                             struct picture *picture)
{
    const struct option_value *o = job->option;
    return o[option].given ? saved_write(&picture->image, o[option].text, o[ASK_NO_CLOBBER].given,
                                         job->how.threads, &picture->saved)
                           : WEFT_OK;
}

struct preview_options effect_job_preview(const struct effect_job *job)
{
    static const struct option_value none = {.given = false};
    const struct option_value *o = job->option;
    return (struct preview_options){.preview = o[ASK_PREVIEW].text,
                                    .range = &o[ASK_RANGE],
                                    .colour_map = &none,
                                    .exposure = &o[ASK_EXPOSURE],
                                    .annotate = &o[ASK_ANNOTATE],
                                    .title = &o[ASK_TITLE],
                                    .no_clobber = o[ASK_NO_CLOBBER].given};
}

static enum weft_result save_preview(struct effect_job *job)
{
    const struct option_value *o = job->option;
    struct preview_options options = effect_job_preview(job);
    char title[ANNOTATION_TEXT], caption[ANNOTATION_TEXT];
    struct annotation annotation;
    snprintf(title, sizeof title, "%.100s: %.200s", job->operands[0],
             job->scene_count ? paths_base_name(job->scene[0].name) : "");
    snprintf(caption, sizeof caption, "%lld frame%s, %d x %d pixels", (long long)job->added,
             job->added == 1 ? "" : "s", job->mean.image.width, job->mean.image.height);
    if (preview_annotate(&options, title, caption, &annotation))
        options.annotation = &annotation;
    return o[ASK_PREVIEW].given
               ? picture_save_preview(&job->mean, &options, job->how.threads, job->preview_range)
               : WEFT_OK;
}

enum weft_result effect_job_save(struct effect_job *job)
{
    const double start = report_now_seconds();
    enum weft_result res = save(job, ASK_OUTPUT, &job->mean);
    if (res == WEFT_OK)
        res = save(job, ASK_STDERR, &job->error);
    if (res == WEFT_OK)
        res = save_preview(job);
    job->seconds.write = report_now_seconds() - start;
    return res;
}

// ---- the end ------------------------------------------------------------------------------------

void effect_job_clear(struct effect_job *job)
{
    rank_frames_clear(&job->divided.report);
    weft_accumulator_destroy(&job->accumulator);
    for (int i = 0; i < job->scene_count; i++) {
        scene_drawing_destroy(&job->scene[i].drawing);
        scene_clear(&job->scene[i].scene);
        free(job->scene[i].name);
    }
    free(job->scene);
    effect_plan_clear(&job->plan);
    weft_context_destroy(&job->context);
    weft_kernel_file_destroy(&job->filter_file);
    picture_clear(&job->mean);
    picture_clear(&job->error);
}
