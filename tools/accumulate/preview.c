// SPDX-License-Identifier: BSD-3-Clause
// The picture of `weft accumulate`: in colour where there are R, G and B.
#include <stdio.h>
#include <string.h>

#include "tools/accumulate/job.h"
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
static bool find_colours(const struct accumulate_job *job, struct weft_colour_preview_params *out)
{
    const struct weft_image *image = &job->result;
    for (size_t i = 0; i <= image->channel_count; i++) {
        const char *name = i ? image->channels[i - 1].name : "", *dot = strrchr(name, '.');
        const int layer = dot ? (int)(dot - name) + 1 : 0;
        if (i && (!dot || job->channel[i - 1].averaged < 0))
            continue;
        out->red = plane_named(image, layer, name, "R");
        out->green = plane_named(image, layer, name, "G");
        out->blue = plane_named(image, layer, name, "B");
        if (out->red && out->green && out->blue)
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

enum weft_result accumulate_save_preview(struct accumulate_job *job)
{
    const struct option_value *o = job->option;
    const struct weft_image *image = &job->result;
    const struct preview_options options = {.preview = o[ACCUMULATE_PREVIEW].text,
                                            .range = &o[ACCUMULATE_RANGE],
                                            .colour_map = &o[ACCUMULATE_COLOUR_MAP],
                                            .no_clobber =
                                                accumulate_keeps(job, ACCUMULATE_PREVIEW)};
    struct weft_colour_preview_params colour = {
        .path = options.preview,
        .no_clobber = options.no_clobber,
        .width = image->width,
        .height = image->height,
        .threads = job->request.how.threads,
        .log = report_log(),
    };
    enum weft_result res;
    if (job->request.colour_map || !find_colours(job, &colour)) {
        res = preview_save(&options, job->request.colour_map, image->width, image->height,
                           grey_plane(job), job->preview_range);
    } else {
        if (options.range->given) {
            colour.low = (float)options.range->number[0];
            colour.high = (float)options.range->number[1];
        }
        report_stage("writing", options.preview);
        job->preview_range[0] = colour.low;
        job->preview_range[1] = options.range->given ? colour.high : 1.0f;
        res = weft_colour_preview_save(&colour);
    }
    job->written |= res == WEFT_OK ? 1u << ACCUMULATE_PREVIEW : 0;
    return res;
}
