// SPDX-License-Identifier: BSD-3-Clause
// The picture of `weft accumulate`: in colour where there are R, G and B.
#include "tools/accumulate/job.h"
#include "tools/common/report.h"

static const float *plane_named(const struct weft_image *image, const char *name)
{
    const size_t c = accumulate_find_channel(image, name);
    return c < image->channel_count ? image->channels[c].plane : NULL;
}

// Y, or else the first channel that holds colour.
static const float *grey_plane(const struct accumulate_job *job)
{
    const float *plane = plane_named(&job->result, "Y");
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
        .red = plane_named(image, "R"),
        .green = plane_named(image, "G"),
        .blue = plane_named(image, "B"),
        .threads = job->request.threads,
        .log = report_log(),
    };
    enum weft_result res;
    if (!colour.red || !colour.green || !colour.blue || job->request.colour_map) {
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
