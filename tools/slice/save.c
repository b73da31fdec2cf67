// SPDX-License-Identifier: BSD-3-Clause
// The files of a slice.
#include "tools/slice/stages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/common/attributes.h"
#include "tools/common/report.h"
#include "tools/options/saved.h"
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

// To be freed; NULL: out of memory. What ranks made is one plane.
static struct weft_image_channel *make_channels(const struct slice_job *job, int *count)
{
    *count = job->channel ? job->channel_count : 1;
    const size_t size = (size_t)job->geometry.width * (size_t)job->geometry.height;
    struct weft_image_channel *out = calloc((size_t)*count, sizeof *out);
    for (int i = 0; out && i < *count; i++) {
        out[i].type = (enum weft_pixel_type)job->setup->option[SLICE_TYPE].integer[0];
        out[i].plane = job->pixels ? job->pixels + (size_t)i * size : NULL;
        snprintf(out[i].name, sizeof out[i].name, "%.255s",
                 job->channel ? job->channel[i].name : "Y");
    }
    return out;
}

enum weft_result slice_write_exr(struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    const struct option_value *o = job->setup->option;
    struct weft_image_attribute attributes[SLICE_ATTRIBUTES];
    int channel_count;
    struct weft_image_channel *channels = make_channels(job, &channel_count);
    if (!channels)
        return WEFT_ERR_MEMORY;
    attributes_of_texts(job->attributes, job->attribute_count, attributes);
    const struct weft_image image = {
        .width = g->width,
        .height = g->height,
        .display_max = {g->width - 1, g->height - 1},
        .compression = (enum weft_image_compression)o[SLICE_COMPRESSION].integer[0],
        .channel_count = channel_count,
        .channels = channels,
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
    free(channels);
    job->saved.overflows += job->packing.overflows;
    job->saved.rounding = fmax(job->saved.rounding, job->packing.rounding);
    if (res == WEFT_OK)
        saved_warn(job->output, &job->saved);
    return res;
}

// Light whose code in sRGB is the value's share of the range, so that codes are linear in values.
static float light_of(double share)
{
    return (float)(share <= 0.04045 ? share / 12.92 : pow((share + 0.055) / 1.055, 2.4));
}

static enum weft_result write_colours(struct slice_job *job, const struct preview_options *preview)
{
    const size_t size = (size_t)job->geometry.width * (size_t)job->geometry.height;
    const double low = job->preview_range[0], span = job->preview_range[1] - low;
    float *light = malloc(3 * size * sizeof *light), range[2];
    struct option_value none = {.given = false};
    struct preview_options options = *preview;
    if (!light)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < 3 * size; i++)
        light[i] = light_of(((double)job->pixels[i] - low) / span);
    options.range = &none; // is in the light
    const float *const planes[3] = {light, light + size, light + 2 * size};
    const enum weft_result res =
        preview_save_colour(&options, job->setup->engine.cpu.threads, job->geometry.width,
                            job->geometry.height, planes, range);
    free(light);
    return res;
}

static enum weft_result write_preview(struct slice_job *job)
{
    const struct preview_options preview = slice_preview_options(job);
    if (slice_shows_vector(job, job->preview_range))
        return write_colours(job, &preview);
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
