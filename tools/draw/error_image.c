// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/error_image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/draw/preview.h"
#include "tools/options/saved.h"

const char *const error_image_endings[] = {".exr", ".png", NULL};

static size_t plane_size(const struct error_image *image)
{
    return (size_t)image->width * (size_t)image->height;
}

enum weft_result error_image_create(int32_t width, int32_t height, int channels,
                                    struct error_image *out)
{
    *out = (struct error_image){.width = width, .height = height, .channels = channels};
    out->plane = calloc(plane_size(out) * (size_t)channels, sizeof *out->plane);
    if (out->plane)
        return WEFT_OK;
    report_error("out of memory for the errors of %d x %d pixels", width, height);
    return WEFT_ERR_MEMORY;
}

void error_image_clear(struct error_image *image)
{
    free(image->plane);
    *image = (struct error_image){.plane = NULL};
}

void error_image_tell(void *part, int x, int y, int channel, double value, double reference)
{
    const struct error_image_part *p = part;
    const size_t c = p->channel ? p->channel[channel] : (size_t)channel;
    float *out = p->image->plane + c * plane_size(p->image) + (size_t)y * (size_t)p->image->width;
    const bool finite = isfinite(value), expected = isfinite(reference);
    out[x] = finite && expected ? (float)(value - reference) : finite == expected ? 0.0f : NAN;
}

// ---- files --------------------------------------------------------------------------------------

static enum weft_result save_exr(const struct error_image *image,
                                 const struct error_image_save_params *p)
{
    struct weft_image_channel *channels = calloc((size_t)image->channels, sizeof *channels);
    struct weft_image_save_report saved;
    if (!channels)
        return WEFT_ERR_MEMORY;
    for (int c = 0; c < image->channels; c++) {
        snprintf(channels[c].name, sizeof channels[c].name, "%s",
                 p->channels ? p->channels[c].name : "Y");
        channels[c].plane = image->plane + (size_t)c * plane_size(image);
    }
    const struct weft_image out = {.width = image->width,
                                   .height = image->height,
                                   .display_max = {image->width - 1, image->height - 1},
                                   .channel_count = (size_t)image->channels,
                                   .channels = channels};
    const enum weft_result res =
        saved_write(&out, p->output->text, p->no_clobber, p->threads, &saved);
    free(channels);
    return res;
}

// Of all channels the error farthest from 0, which NAN is; to be freed.
static float *combine(const struct error_image *image)
{
    const size_t size = plane_size(image);
    float *out = malloc(size * sizeof *out);
    for (size_t i = 0; out && i < size; i++) {
        out[i] = image->plane[i];
        for (int c = 1; c < image->channels; c++) {
            const float other = image->plane[(size_t)c * size + i];
            if (isnan(other) || fabsf(other) > fabsf(out[i]))
                out[i] = other;
        }
    }
    return out;
}

static enum weft_result save_png(const struct error_image *image,
                                 const struct error_image_save_params *p, const float range[2])
{
    const struct option_value none = {.given = false};
    const struct option_value shown = {.given = range[0] < range[1],
                                       .number = {range[0], range[1]}};
    struct annotation annotation = *p->annotation;
    const struct preview_options options = {.preview = p->output->text,
                                            .range = &shown,
                                            .colour_map = &none,
                                            .annotation = &annotation,
                                            .no_clobber = p->no_clobber};
    float *plane = combine(image), found[2];
    if (!plane)
        return WEFT_ERR_MEMORY;
    snprintf(annotation.quantity, sizeof annotation.quantity, "error");
    const enum weft_result res = preview_save(&options, weft_colour_map_find("cool-warm"),
                                              image->width, image->height, plane, found);
    free(plane);
    return res;
}

enum weft_result error_image_save(const struct error_image *image,
                                  const struct error_image_save_params *p, float range[2])
{
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    weft_statistics_add(&s, image->plane, plane_size(image) * (size_t)image->channels);
    const double most = isnan(s.minimum) ? 0.0 : fmax(-s.minimum, s.maximum);
    range[0] = -(float)most;
    range[1] = (float)most;
    return p->output->integer[0] == 0 ? save_exr(image, p) : save_png(image, p, range);
}
