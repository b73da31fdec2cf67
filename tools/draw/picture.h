// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/picture.h - pictures that verbs draw, red, green, blue and coverage, as images and
// files.
#ifndef WEFT_TOOLS_DRAW_PICTURE_H
#define WEFT_TOOLS_DRAW_PICTURE_H

#include "tools/common/json.h"

enum { PICTURE_CHANNELS = 4, PICTURE_ATTRIBUTES = 32 };
extern const char *const picture_channel_names[]; // "R", "G", "B", "A"; NULL-ended

// A picture as an image, row 0 on top. It stays where it is: the image points into it. All zero:
// none.
struct picture {
    struct weft_image image;
    struct weft_image_channel channel[PICTURE_CHANNELS]; // planes of floats are owned
    struct weft_metadata text[PICTURE_ATTRIBUTES];       // what attributes say
    struct weft_image_attribute attribute[PICTURE_ATTRIBUTES];
    struct weft_image_save_report saved; // of the last file
};

// Makes room for so many pixels. On failure it may hold a part, for picture_clear. Returns
// WEFT_ERR_MEMORY after an error line.
enum weft_result picture_create(const int size[2], struct picture *out);
void picture_clear(struct picture *picture); // accepts one of all zero, leaves zeros behind

// Turns a plane upside down: OpenGL's rows go up, a picture's down.
void picture_turn_over(const int size[2], float *plane);

// Puts the first `count` texts into the image's attributes.
void picture_set_attributes(struct picture *picture, size_t count);

// Statistics of each channel. A warning tells of values that are not finite.
void picture_measure(const struct picture *picture, struct weft_statistics out[PICTURE_CHANNELS]);

// The picture as 8-bit PNG in sRGB, as preview_save_colour of tools/draw/preview.h.
struct preview_options;
enum weft_result picture_save_preview(const struct picture *picture,
                                      const struct preview_options *options, int threads,
                                      float range[2]);
// The statistics of the channels for a report.
json_t *picture_json(const struct weft_statistics statistics[PICTURE_CHANNELS]);

#endif
