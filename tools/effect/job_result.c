// SPDX-License-Identifier: BSD-3-Clause
// The mean of `weft effect` and its standard error as images, and their files.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/attributes.h"
#include "tools/common/report.h"
#include "tools/common/saved.h"
#include "tools/effect/job.h"

const char *const effect_channel_names[] = {"R", "G", "B", "A", NULL};

// ---- images -------------------------------------------------------------------------------------

static enum weft_result allocate(const struct effect_job *job, struct effect_picture *out)
{
    const int *size = job->params.size;
    const size_t pixels = (size_t)size[0] * (size_t)size[1];
    out->image = (struct weft_image){.width = size[0],
                                     .height = size[1],
                                     .display_max = {size[0] - 1, size[1] - 1},
                                     .channel_count = EFFECT_CHANNELS,
                                     .channels = out->channel};
    for (int c = 0; c < EFFECT_CHANNELS; c++) {
        snprintf(out->channel[c].name, sizeof out->channel[c].name, "%s", effect_channel_names[c]);
        out->channel[c].plane = malloc(pixels * sizeof(float));
        if (out->channel[c].plane)
            continue;
        report_error("out of memory for a picture of %d x %d pixels", size[0], size[1]);
        return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

// OpenGL's rows go up, a picture's down.
static void turn_over(const int size[2], float *plane)
{
    const size_t width = (size_t)size[0];
    for (int y = 0; y < size[1] / 2; y++) {
        float *a = plane + (size_t)y * width, *b = plane + (size_t)(size[1] - 1 - y) * width;
        for (size_t x = 0; x < width; x++) {
            const float at = a[x];
            a[x] = b[x];
            b[x] = at;
        }
    }
}

static enum weft_result fill(struct effect_job *job, enum weft_accumulated what,
                             struct effect_picture *out)
{
    const struct option_value *o = job->option;
    const bool mean = what == WEFT_ACCUMULATED_MEAN;
    enum weft_result res = allocate(job, out);
    for (int c = 0; c < EFFECT_CHANNELS && res == WEFT_OK; c++) {
        res = weft_accumulator_current(job->accumulator, what, c, out->channel[c].plane, 0);
        if (res == WEFT_OK)
            turn_over(job->params.size, out->channel[c].plane);
        if (mean)
            out->channel[c].type = (enum weft_pixel_type)o[ASK_TYPE].integer[0];
    }
    out->image.compression = (enum weft_image_compression)o[ASK_COMPRESSION].integer[0];
    out->image.attribute_count =
        effect_job_attributes(job, mean ? NULL : "standard error of the mean", out->text);
    attributes_of_texts(out->text, out->image.attribute_count, out->attribute);
    out->image.attributes = out->attribute;
    return res;
}

static void measure(struct effect_job *job)
{
    const size_t pixels = (size_t)job->params.size[0] * (size_t)job->params.size[1];
    uint64_t not_finite = 0;
    for (int c = 0; c < EFFECT_CHANNELS; c++) {
        job->statistics[c] = (struct weft_statistics)WEFT_STATISTICS_NONE;
        weft_statistics_add(&job->statistics[c], job->mean.channel[c].plane, pixels);
        not_finite += job->statistics[c].not_finite;
    }
    if (not_finite)
        report_warning("%llu values of the picture are not finite", (unsigned long long)not_finite);
    effect_job_check_range(job);
}

enum weft_result effect_job_make_result(struct effect_job *job)
{
    const double start = report_now_seconds();
    weft_accumulator_get_report(job->accumulator, &job->report);
    enum weft_result res = effect_job_check_bound(job, job->report.bound);
    if (res == WEFT_OK)
        res = fill(job, WEFT_ACCUMULATED_MEAN, &job->mean);
    if (res == WEFT_OK)
        measure(job);
    if (res == WEFT_OK && job->option[ASK_STDERR].given)
        res = fill(job, WEFT_ACCUMULATED_STANDARD_ERROR, &job->error);
    job->seconds.result = report_now_seconds() - start;
    return res;
}

// ---- files --------------------------------------------------------------------------------------

static enum weft_result save(const struct effect_job *job, enum effect_option option,
                             struct effect_picture *picture)
{
    const struct option_value *o = job->option;
    return o[option].given ? saved_write(&picture->image, o[option].text, o[ASK_NO_CLOBBER].given,
                                         job->how.threads, &picture->saved)
                           : WEFT_OK;
}

static enum weft_result save_preview(struct effect_job *job)
{
    const struct option_value *o = job->option;
    const struct preview_options options = {.preview = o[ASK_PREVIEW].text,
                                            .range = &o[ASK_RANGE],
                                            .no_clobber = o[ASK_NO_CLOBBER].given};
    const struct weft_image_channel *channel = job->mean.channel;
    const float *colour[3] = {channel[0].plane, channel[1].plane, channel[2].plane};
    return o[ASK_PREVIEW].given
               ? preview_save_colour(&options, job->how.threads, job->params.size[0],
                                     job->params.size[1], colour, job->preview_range)
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

static void clear_picture(struct effect_picture *picture)
{
    for (int c = 0; c < EFFECT_CHANNELS; c++)
        free(picture->channel[c].plane);
}

void effect_job_clear(struct effect_job *job)
{
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
    clear_picture(&job->mean);
    clear_picture(&job->error);
}
