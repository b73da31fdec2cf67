// SPDX-License-Identifier: BSD-3-Clause
#include "filter/rectangle.h"

#include "filter/check.h"

enum weft_result weft_rectangle_within(const struct weft_log *log,
                                       const struct weft_rectangle *part, int32_t width,
                                       int32_t height, struct weft_rectangle *out)
{
    *out = *part;
    if (!part->x && !part->y && !part->width && !part->height)
        *out = (struct weft_rectangle){0, 0, width, height};
    if (out->x >= 0 && out->y >= 0 && out->width > 0 && out->height > 0 &&
        (int64_t)out->x + out->width <= width && (int64_t)out->y + out->height <= height)
        return WEFT_OK;
    weft_error(log, "a part of %d x %d pixels from (%d, %d) on is not within %d x %d pixels",
               part->width, part->height, part->x, part->y, width, height);
    return WEFT_ERR_ARGUMENT;
}

static int32_t smaller(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t larger(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

struct weft_rectangle weft_rectangle_common(const struct weft_rectangle *a,
                                            const struct weft_rectangle *b)
{
    const int32_t x = larger(a->x, b->x), y = larger(a->y, b->y);
    const int32_t width = smaller(a->x + a->width, b->x + b->width) - x;
    const int32_t height = smaller(a->y + a->height, b->y + b->height) - y;
    return width > 0 && height > 0 ? (struct weft_rectangle){x, y, width, height}
                                   : (struct weft_rectangle){0};
}
