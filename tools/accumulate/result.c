// SPDX-License-Identifier: BSD-3-Clause
// The mean of `weft accumulate` and its standard error as images, and their files.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/attributes.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"

// ---- images -------------------------------------------------------------------------------------

static enum weft_result no_memory(const struct accumulate_job *job)
{
    report_error("out of memory for the mean of %zu channels of %d x %d pixels",
                 job->image.channel_count, job->image.width, job->image.height);
    return WEFT_ERR_MEMORY;
}

// With planes for what is averaged; others are borrowed, or left out of the standard error.
static enum weft_result allocate(struct accumulate_job *job, bool all, struct weft_image *out)
{
    const struct weft_image *in = &job->image;
    const size_t pixels = (size_t)in->width * (size_t)in->height;
    if (out->channels)
        return WEFT_OK;
    *out = *in;
    out->attributes = NULL;
    out->attribute_count = out->channel_count = 0;
    out->channels = calloc(in->channel_count, sizeof *out->channels);
    bool whole = out->channels != NULL;
    for (size_t c = 0; whole && c < in->channel_count; c++) {
        struct weft_image_channel *channel = &out->channels[out->channel_count];
        if (job->channel[c].averaged < 0 && !all)
            continue;
        *channel = in->channels[c];
        if (job->channel[c].averaged >= 0) {
            channel->integers = NULL;
            channel->plane = malloc(pixels * sizeof *channel->plane);
            whole = channel->plane != NULL;
        }
        out->channel_count += whole;
    }
    return whole ? WEFT_OK : no_memory(job);
}

static enum weft_pixel_type type_of(const struct accumulate_job *job,
                                    const struct accumulate_channel *channel)
{
    const struct option_value *given = &job->option[ACCUMULATE_TYPE];
    if (given->given)
        return (enum weft_pixel_type)given->integer[0];
    return channel->widest == WEFT_PIXEL_HALF ? WEFT_PIXEL_HALF : WEFT_PIXEL_FLOAT;
}

static enum weft_result fill(struct accumulate_job *job, enum weft_accumulated what,
                             struct weft_image *out)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; res == WEFT_OK && i < out->channel_count; i++) {
        struct weft_image_channel *channel = &out->channels[i];
        const size_t c = accumulate_find_channel(&job->image, channel->name);
        if (job->channel[c].averaged < 0)
            continue;
        channel->type =
            what == WEFT_ACCUMULATED_MEAN ? type_of(job, &job->channel[c]) : WEFT_PIXEL_FLOAT;
        res = weft_accumulator_current(job->accumulator, what, job->channel[c].averaged,
                                       channel->plane, 0);
    }
    return res;
}

// The first frame's attributes, then our own.
static enum weft_result set_attributes(struct accumulate_job *job, const char *what,
                                       struct weft_image *out)
{
    const struct weft_image *in = &job->image;
    const double scale[2] = {1.0, 1.0};
    unsigned char numbers[2][4]; // not used at this scale
    struct weft_metadata *texts = calloc(ACCUMULATE_ATTRIBUTES, sizeof *texts);
    struct weft_image_attribute *list =
        calloc(in->attribute_count + 1 + ACCUMULATE_ATTRIBUTES, sizeof *list);
    if (!texts || !list) {
        free(texts);
        free(list);
        return no_memory(job);
    }
    free(out->attributes);
    const size_t kept = attributes_scaled(in, scale, list, numbers);
    const size_t own = accumulate_attributes(job, what, texts);
    attributes_of_texts(texts, own, list + kept);
    out->attributes = list;
    out->attribute_count = kept + own;
    struct weft_metadata **place = out == &job->result ? &job->texts : &job->error_texts;
    free(*place);
    *place = texts;
    return WEFT_OK;
}

static enum weft_result measure(struct accumulate_job *job)
{
    const size_t pixels = (size_t)job->image.width * (size_t)job->image.height;
    if (!job->statistics)
        job->statistics = calloc(job->image.channel_count, sizeof *job->statistics);
    if (!job->statistics)
        return no_memory(job);
    for (size_t c = 0; c < job->result.channel_count; c++) {
        job->statistics[c] = (struct weft_statistics)WEFT_STATISTICS_NONE;
        weft_statistics_add(&job->statistics[c], job->result.channels[c].plane, pixels);
    }
    return WEFT_OK;
}

static void choose_compression(struct accumulate_job *job)
{
    const struct option_value *given = &job->option[ACCUMULATE_COMPRESSION];
    const enum weft_image_compression from = job->image.compression;
    job->result.compression = given->given                   ? (unsigned)given->integer[0]
                              : weft_image_is_writable(from) ? from
                                                             : WEFT_IMAGE_ZIP;
    job->error.compression = job->result.compression;
}

enum weft_result accumulate_make_result(struct accumulate_job *job)
{
    const double start = report_now_seconds();
    weft_accumulator_get_report(job->accumulator, &job->report);
    enum weft_result res = allocate(job, true, &job->result);
    if (res == WEFT_OK)
        res = fill(job, WEFT_ACCUMULATED_MEAN, &job->result);
    if (res == WEFT_OK)
        res = set_attributes(job, NULL, &job->result);
    if (res == WEFT_OK)
        res = measure(job);
    if (res == WEFT_OK && job->option[ACCUMULATE_STDERR].given) {
        res = allocate(job, false, &job->error);
        if (res == WEFT_OK)
            res = fill(job, WEFT_ACCUMULATED_STANDARD_ERROR, &job->error);
        if (res == WEFT_OK)
            res = set_attributes(job, "standard error of the mean", &job->error);
    }
    choose_compression(job);
    job->result_seconds += report_now_seconds() - start;
    return res;
}

// ---- files --------------------------------------------------------------------------------------

static void warn_of_losses(const struct accumulate_job *job)
{
    const struct weft_image *in = &job->image;
    const char *path = job->frame[job->reference].path;
    if (job->kind != WEFT_IMAGE_FILE_EXR)
        return;
    if (!job->option[ACCUMULATE_COMPRESSION].given && !weft_image_is_writable(in->compression))
        report_warning("%s: not kept: compression %s (zip is written)%s", path,
                       weft_image_compression_names[in->compression],
                       in->tiled ? "; tiles (lines are written)" : "");
    else if (in->tiled)
        report_warning("%s: not kept: tiles (lines are written)", path);
}

static enum weft_result save(struct accumulate_job *job, const struct weft_image *image,
                             enum accumulate_option option, struct weft_image_save_report *saved)
{
    const enum weft_result res =
        saved_write(image, job->option[option].text, accumulate_keeps(job, option),
                    job->request.how.threads, saved);
    job->written |= res == WEFT_OK ? 1u << option : 0;
    return res;
}

enum weft_result accumulate_save(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    const double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    if (o[ACCUMULATE_OUTPUT].given)
        warn_of_losses(job);
    if (o[ACCUMULATE_OUTPUT].given)
        res = save(job, &job->result, ACCUMULATE_OUTPUT, &job->saved);
    if (res == WEFT_OK && o[ACCUMULATE_STDERR].given)
        res = save(job, &job->error, ACCUMULATE_STDERR, &job->error_saved);
    if (res == WEFT_OK && o[ACCUMULATE_PREVIEW].given)
        res = accumulate_save_preview(job);
    job->write_seconds += report_now_seconds() - start;
    return res;
}

// ---- the end ------------------------------------------------------------------------------------

static void clear_image(const struct accumulate_job *job, struct weft_image *image)
{
    for (size_t i = 0; image->channels && i < image->channel_count; i++) {
        const size_t c = accumulate_find_channel(&job->image, image->channels[i].name);
        if (job->channel[c].averaged >= 0)
            free(image->channels[i].plane);
    }
    free(image->channels);
    free(image->attributes);
}

void accumulate_clear(struct accumulate_job *job)
{
    rank_frames_clear(&job->divided.report);
    weft_accumulator_destroy(&job->accumulator);
    weft_context_destroy(&job->context);
    clear_image(job, &job->result);
    clear_image(job, &job->error);
    weft_image_clear(&job->image);
    accumulate_clear_decoder(&job->decoder);
    for (int64_t i = 0; i < job->frame_count; i++) {
        free(job->frame[i].path);
        free(job->frame[i].problem);
    }
    free(job->frame);
    free(job->sequence);
    free(job->channel);
    free(job->plane);
    free(job->texts);
    free(job->error_texts);
    free(job->statistics);
}
