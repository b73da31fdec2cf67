// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/picture.h"

#include <stdio.h>
#include <stdlib.h>

#include "tools/common/attributes.h"
#include "tools/common/report.h"
#include "tools/draw/preview.h"

const char *const picture_channel_names[] = {"R", "G", "B", "A", NULL};

enum weft_result picture_create(const int size[2], struct picture *out)
{
    const size_t pixels = (size_t)size[0] * (size_t)size[1];
    out->image = (struct weft_image){.width = size[0],
                                     .height = size[1],
                                     .display_max = {size[0] - 1, size[1] - 1},
                                     .channel_count = PICTURE_CHANNELS,
                                     .channels = out->channel};
    for (int c = 0; c < PICTURE_CHANNELS; c++) {
        snprintf(out->channel[c].name, sizeof out->channel[c].name, "%s", picture_channel_names[c]);
        out->channel[c].plane = malloc(pixels * sizeof(float));
        if (out->channel[c].plane)
            continue;
        report_error("out of memory for a picture of %d x %d pixels", size[0], size[1]);
        return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

void picture_clear(struct picture *picture)
{
    for (int c = 0; c < PICTURE_CHANNELS; c++)
        free(picture->channel[c].plane);
    *picture = (struct picture){0};
}

void picture_turn_over(const int size[2], float *plane)
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

void picture_set_attributes(struct picture *picture, size_t count)
{
    picture->image.attribute_count = count;
    attributes_of_texts(picture->text, count, picture->attribute);
    picture->image.attributes = picture->attribute;
}

void picture_measure(const struct picture *picture, struct weft_statistics out[PICTURE_CHANNELS])
{
    const size_t pixels = (size_t)picture->image.width * (size_t)picture->image.height;
    uint64_t not_finite = 0;
    for (int c = 0; c < PICTURE_CHANNELS; c++) {
        out[c] = (struct weft_statistics)WEFT_STATISTICS_NONE;
        weft_statistics_add(&out[c], picture->channel[c].plane, pixels);
        not_finite += out[c].not_finite;
    }
    if (not_finite)
        report_warning("%llu values of the picture are not finite", (unsigned long long)not_finite);
}

enum weft_result picture_save_preview(const struct picture *picture,
                                      const struct preview_options *options, int threads,
                                      float range[2])
{
    const struct weft_image_channel *channel = picture->channel;
    const float *colour[3] = {channel[0].plane, channel[1].plane, channel[2].plane};
    return preview_save_colour(options, threads, picture->image.width, picture->image.height,
                               colour, range);
}

json_t *picture_json(const struct weft_statistics statistics[PICTURE_CHANNELS])
{
    json_t *list = json_array();
    for (int c = 0; c < PICTURE_CHANNELS; c++)
        json_array_append_new(list, json_pack("{s:s,s:o,s:o,s:o}", "name", picture_channel_names[c],
                                              "minimum", json_number(statistics[c].minimum),
                                              "maximum", json_number(statistics[c].maximum),
                                              "not_finite", json_count(statistics[c].not_finite)));
    return list;
}
