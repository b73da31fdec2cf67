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

WEFT_END_DECLS
#endif
