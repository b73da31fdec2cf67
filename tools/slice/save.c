// SPDX-License-Identifier: BSD-3-Clause
// The files of a slice.
#include "tools/slice/stages.h"

#include <math.h>

#include "tools/common/attributes.h"
#include "tools/common/report.h"
#include "tools/common/saved.h"
#include "tools/slice/save.h"

struct preview_options slice_preview_options(const struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    return (struct preview_options){.input = job->input,
                                    .output = job->output,
                                    .preview = job->preview,
                                    .range = &job->setup->range,
                                    .colour_map = &o[SLICE_COLOUR_MAP],
                                    .no_clobber = o[SLICE_NO_CLOBBER].given};
}

enum weft_result slice_write_exr(struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    const struct option_value *o = job->setup->option;
    struct weft_image_attribute attributes[SLICE_ATTRIBUTES];
    struct weft_image_channel channel = {
        .name = "Y", .type = (enum weft_pixel_type)o[SLICE_TYPE].integer[0], .plane = job->pixels};
    attributes_of_texts(job->attributes, job->attribute_count, attributes);
    const struct weft_image image = {
        .width = g->width,
        .height = g->height,
        .display_max = {g->width - 1, g->height - 1},
        .compression = (enum weft_image_compression)o[SLICE_COMPRESSION].integer[0],
        .channel_count = 1,
        .channels = &channel,
        .attribute_count = job->attribute_count,
        .attributes = attributes,
    };
    const struct weft_image_save_params params = {
        .path = job->output,
        .no_clobber = o[SLICE_NO_CLOBBER].given,
        .verify = o[SLICE_VERIFY].given,
        .threads = job->setup->engine.cpu.threads,
        .packed = job->bands ? slice_stream_give : NULL,
        .packed_priv = job,
        .progress = report_writing(job->output),
        .log = report_log(),
    };
    const enum weft_result res = weft_image_save_parts(&image, 1, &params, &job->saved);
    job->saved.overflows += job->packing.overflows;
    job->saved.rounding = fmax(job->saved.rounding, job->packing.rounding);
    if (res == WEFT_OK)
        saved_warn(job->output, &job->saved);
    return res;
}

static enum weft_result write_preview(struct slice_job *job)
{
    const struct preview_options preview = slice_preview_options(job);
    return preview_save(&preview, job->setup->colour_map, job->geometry.width, job->geometry.height,
                        job->pixels, job->preview_range);
}

enum weft_result slice_save(struct slice_job *job)
{
    double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    if (job->stream)
        res = slice_stream_end(job);
    else if (job->output)
        res = slice_write_exr(job);
    if (res == WEFT_OK && job->preview)
        res = write_preview(job);
    job->write_seconds = report_now_seconds() - start;
    return res;
}
