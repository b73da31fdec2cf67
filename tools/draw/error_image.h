// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/error_image.h - pictures of errors: at every pixel the result less the reference in
// double precision, as a verification of all pixels finds it. As EXR the differences themselves; as
// PNG a diverging map, white where there is none, with a legend.
#ifndef WEFT_TOOLS_DRAW_ERROR_IMAGE_H
#define WEFT_TOOLS_DRAW_ERROR_IMAGE_H

#include "tools/draw/annotation.h"
#include "tools/options/options.h"

extern const char *const error_image_endings[]; // ".exr", ".png"; NULL-ended
// clang-format off
#define ERROR_IMAGE_OPTION                                                                         \
    {.name = "error-image", 0, OPTION_OUTPUT, "E.png|E.exr",                                       \
     "with --verify: the difference to double precision at every pixel, all of which are checked " \
     "then, however long it takes; PNG: in colours, with a legend",                                \
     error_image_endings, .group = OPTION_PICTURES}
// clang-format on

// All zero: none.
struct error_image {
    int32_t width, height;
    int channels;
    float *plane; // [channel][y][x]: NAN where only one side is finite, 0 where neither is
};

// Zeros. Returns WEFT_ERR_MEMORY after an error line.
enum weft_result error_image_create(int32_t width, int32_t height, int channels,
                                    struct error_image *out);
void error_image_clear(struct error_image *image); // accepts one of all zero, leaves zeros behind

// What a verification fills in.
struct error_image_part {
    struct error_image *image;
    const size_t *channel; // of each that is verified; NULL: they are the image's
};
// For struct weft_verify_params, with a part.
void error_image_tell(void *part, int x, int y, int channel, double value, double reference);

struct error_image_save_params {
    const struct option_value *output; // of ERROR_IMAGE_OPTION
    bool no_clobber;
    int threads;
    const struct weft_image_channel *channels; // EXR: their names; NULL: there is one, "Y"
    const struct annotation *annotation;       // of the PNG, but for its legend
};
// range[2] receives what is shown as first and last colour: of all channels the largest |error|
// that is finite, and its negative. Of several channels a PNG has the largest one at each pixel.
// Returns WEFT_ERR_MEMORY, WEFT_ERR_WRITE, and what annotation_create returns.
enum weft_result error_image_save(const struct error_image *image,
                                  const struct error_image_save_params *params, float range[2]);

#endif
