// SPDX-License-Identifier: BSD-3-Clause
// filter/rectangle.h - a part of a picture.
#ifndef WEFT_FILTER_RECTANGLE_H
#define WEFT_FILTER_RECTANGLE_H

#include "base.h"

WEFT_BEGIN_DECLS

// Pixels x to x + width - 1 of rows y to y + height - 1. All 0, where a part may be left out: all
// of the picture. A part of a picture has the pixels that all of it has there, bit for bit: places,
// ranges and choices are those of the whole.
struct weft_rectangle {
    int32_t x, y, width, height;
};

// Sets *out to a part of a picture, to all of it where the part is all 0. Returns
// WEFT_ERR_ARGUMENT, after a log line with the numbers, where it is not within the picture; *out is
// then the part as it is. Pure.
WEFT_API enum weft_result weft_rectangle_within(const struct weft_log *log,
                                                const struct weft_rectangle *part, int32_t width,
                                                int32_t height, struct weft_rectangle *out);
// The pixels that two have in common; all 0 where there are none. Pure.
WEFT_API struct weft_rectangle weft_rectangle_common(const struct weft_rectangle *a,
                                                     const struct weft_rectangle *b);

WEFT_END_DECLS
#endif
