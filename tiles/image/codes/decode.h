// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/codes/decode.h - interleaved values of PNG and TIFF files as planes of light (not
// installed).
#ifndef WEFT_TILES_IMAGE_CODES_DECODE_H
#define WEFT_TILES_IMAGE_CODES_DECODE_H

#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

// What a channel of a PNG or TIFF image holds, by the end of its name: "left.A" is alpha.
enum weft_codes_role {
    WEFT_CODES_RED,
    WEFT_CODES_GREEN,
    WEFT_CODES_BLUE,
    WEFT_CODES_GREY,
    WEFT_CODES_ALPHA,
    WEFT_CODES_OTHER
};
enum weft_codes_role weft_codes_role(const char *name);

// Whether a type is one of codes, and the largest of them.
bool weft_codes_is_integer(enum weft_pixel_type type);
uint32_t weft_codes_largest(enum weft_pixel_type type);

// Fills the planes of an image, of its rows, from values of all rows, interleaved in the channels'
// order and of their one type: integer codes become light by image->transfer, which is not AUTO,
// and colours are multiplied by alpha if image->codes does not say that they are. Alpha and other
// channels are code / largest code. Each value is rounded to float once, and once for alpha.
// Returns WEFT_ERR_MEMORY without a log line.
enum weft_result weft_codes_decode(const void *values, int threads, struct weft_image *image);

WEFT_END_DECLS
#endif
