// SPDX-License-Identifier: BSD-3-Clause
// The picture of `weft accumulate`: in colour where there are R, G and B.
#include <stdio.h>
#include <string.h>

#include "tools/accumulate/job.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

static const float *plane_named(const struct weft_image *image, int layer, const char *of,
                                const char *name)
{
    char whole[600];
    snprintf(whole, sizeof whole, "%.*s%s", layer, of, name);
    const size_t c = accumulate_find_channel(image, whole);
    return c < image->channel_count ? image->channels[c].plane : NULL;
}

// Those without a layer, or else of the first layer that has all three.
static bool find_colours(const struct accumulate_job *job, const float *out[3])
{
    const struct weft_image *image = &job->result;
    for (size_t i = 0; i <= image->channel_count; i++) {
        const char *name = i ? image->channels[i - 1].name : "", *dot = strrchr(name, '.');
        const int layer = dot ? (int)(dot - name) + 1 : 0;
        if (i && (!dot || job->channel[i - 1].averaged < 0))
            continue;
        out[0] = plane_named(image, layer, name, "R");
        out[1] = plane_named(image, layer, name, "G");
        out[2] = plane_named(image, layer, name, "B");
        if (out[0] && out[1] && out[2])
            return true;
    }
    return false;
}

// Y, or else the first channel that holds colour.
static const float *grey_plane(const struct accumulate_job *job)
{
    const float *plane = plane_named(&job->result, 0, "", "Y");
    for (size_t c = 0; !plane && c < job->image.channel_count; c++)
        if (job->channel[c].averaged >= 0)
            plane = job->result.channels[c].plane;
    return plane;
}

bool accumulate_keeps(const struct accumulate_job *job, enum accumulate_option output)
{
    return job->option[ACCUMULATE_NO_CLOBBER].given && !(job->written & 1u << output);
}

struct preview_options accumulate_preview_options(const struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    return (struct preview_options){.preview = o[ACCUMULATE_PREVIEW].text,
                                    .range = &o[ACCUMULATE_RANGE],
                                    .colour_map = &o[ACCUMULATE_COLOUR_MAP],
                                    .exposure = &o[ACCUMULATE_EXPOSURE],
                                    .annotate = &o[ACCUMULATE_ANNOTATE],
                                    .title = &o[ACCUMULATE_TITLE],
                                    .no_clobber = accumulate_keeps(job, ACCUMULATE_PREVIEW)};
}

static bool annotate(const struct accumulate_job *job, const struct preview_options *options,
                     struct annotation *out)
{
    char title[ANNOTATION_TEXT], caption[ANNOTATION_TEXT];
    snprintf(title, sizeof title, "%.300s", paths_base_name(job->operands[0]));
    snprintf(caption, sizeof caption, "mean of %lld frame%s, %.120s, %d x %d pixels",
             (long long)job->added, job->added == 1 ? "" : "s", job->weights.text,
             job->result.width, job->result.height);
    const bool asked = preview_annotate(options, title, caption, out);
    snprintf(out->quantity, sizeof out->quantity, "value");
    return asked;
}

enum weft_result accumulate_save_preview(struct accumulate_job *job)
{
    struct preview_options options = accumulate_preview_options(job);
    const struct weft_image *image = &job->result;
    const float *colour[3];
    bool coloured = !job->request.colour_map && find_colours(job, colour);
    struct annotation annotation;
    if (annotate(job, &options, &annotation))
        options.annotation = &annotation;
    if (!coloured && preview_shows_light(&options)) {
        colour[0] = colour[1] = colour[2] = grey_plane(job);
        coloured = true;
    }
    const enum weft_result res =
        !coloured ? preview_save(&options, job->request.colour_map, image->width, image->height,
                                 grey_plane(job), job->preview_range)
                  : preview_save_colour(&options, job->request.how.threads, image->width,
                                        image->height, colour, job->preview_range);
    job->written |= res == WEFT_OK ? 1u << ACCUMULATE_PREVIEW : 0;
    return res;
}
