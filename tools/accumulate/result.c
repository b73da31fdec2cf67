// SPDX-License-Identifier: BSD-3-Clause
// The mean of `weft accumulate` as an image, and its file.
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/report.h"
#include "tools/common/saved.h"

static enum weft_result allocate(struct accumulate_job *job)
{
    const struct weft_image *in = &job->image;
    struct weft_image *out = &job->result;
    if (out->channels)
        return WEFT_OK;
    *out = *in;
    out->attribute_count = 0;
    out->attributes = NULL;
    out->channels = calloc(in->channel_count, sizeof *out->channels);
    bool whole = out->channels != NULL;
    for (size_t c = 0; whole && c < in->channel_count; c++) {
        out->channels[c] = in->channels[c];
        out->channels[c].plane = malloc((size_t)in->width * (size_t)in->height * sizeof(float));
        whole = out->channels[c].plane != NULL;
    }
    if (!whole)
        report_error("out of memory for %zu channels of %d x %d pixels", in->channel_count,
                     in->width, in->height);
    return whole ? WEFT_OK : WEFT_ERR_MEMORY;
}

enum weft_result accumulate_make_result(struct accumulate_job *job)
{
    const double start = report_now_seconds();
    enum weft_result res = allocate(job);
    for (size_t c = 0; res == WEFT_OK && c < job->image.channel_count; c++) {
        job->result.channels[c].type = job->channel[c].widest;
        res = weft_accumulator_current(job->accumulator, WEFT_ACCUMULATED_MEAN,
                                       job->channel[c].averaged, job->result.channels[c].plane, 0);
    }
    weft_accumulator_get_report(job->accumulator, &job->report);
    job->result_seconds += report_now_seconds() - start;
    return res;
}

enum weft_result accumulate_save(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    const double start = report_now_seconds();
    if (!o[ACCUMULATE_OUTPUT].given)
        return WEFT_OK;
    const struct weft_image_save_params params = {
        .path = o[ACCUMULATE_OUTPUT].text,
        .no_clobber = o[ACCUMULATE_NO_CLOBBER].given,
        .threads = job->threads,
        .progress = report_writing(o[ACCUMULATE_OUTPUT].text),
        .log = report_log(),
    };
    const enum weft_result res = weft_image_save_parts(&job->result, 1, &params, &job->saved);
    if (res == WEFT_OK)
        saved_warn(params.path, &job->saved);
    job->write_seconds += report_now_seconds() - start;
    return res;
}

static void clear_result(struct weft_image *image)
{
    for (size_t c = 0; image->channels && c < image->channel_count; c++) {
        free(image->channels[c].plane);
        free(image->channels[c].integers);
    }
    free(image->channels);
    free(image->attributes);
}

void accumulate_clear(struct accumulate_job *job)
{
    weft_accumulator_destroy(&job->accumulator);
    clear_result(&job->result);
    weft_image_clear(&job->image);
    for (int64_t i = 0; i < job->frame_count; i++) {
        free(job->frame[i].path);
        free(job->frame[i].problem);
    }
    free(job->frame);
    free(job->channel);
    free(job->texts);
}
