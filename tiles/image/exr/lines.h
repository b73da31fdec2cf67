// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/exr/lines.h - planes as lines of a file, and back (not installed).
#ifndef WEFT_TILES_IMAGE_EXR_LINES_H
#define WEFT_TILES_IMAGE_EXR_LINES_H

#include "filter/half.h"
#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

// Pixels of planes of `stride` values in a row.
struct weft_lines {
    size_t stride, x, y, width, count;
};

// Stores `count` lines of `width` pixels from (x, y) on as the format has them: in each line one
// channel after the other, little-endian; halves are rounded to nearest even, and what they lose is
// added up.
void weft_lines_gather(const struct weft_image_channel *const *channels, size_t channel_count,
                       const struct weft_lines *lines, unsigned char *out,
                       struct weft_half_losses *losses);

WEFT_END_DECLS
#endif
