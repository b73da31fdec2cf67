// SPDX-License-Identifier: BSD-3-Clause
// Rows of planes of any type as texels.
#include <string.h>

#include "passes/accumulate/frame.h"

static size_t step_of(const struct weft_plane *plane)
{
    return plane->step ? plane->step : 1;
}

enum weft_plane_type weft_frame_common_type(const struct weft_plane *planes, int count)
{
    bool halves = true, bytes = true, codes = true;
    for (int c = 0; c < count; c++) {
        halves = halves && planes[c].type == WEFT_PLANE_HALF;
        bytes = bytes && planes[c].type == WEFT_PLANE_UNORM8;
        codes =
            codes && (planes[c].type == WEFT_PLANE_UNORM8 || planes[c].type == WEFT_PLANE_UNORM16);
    }
    return halves  ? WEFT_PLANE_HALF
           : bytes ? WEFT_PLANE_UNORM8
           : codes ? WEFT_PLANE_UNORM16
                   : WEFT_PLANE_FLOAT;
}

static void spread_bytes(const struct weft_plane *plane, int32_t y, int32_t width, uint8_t *out)
{
    const uint8_t *row = weft_plane_line(plane, y, width);
    const size_t step = step_of(plane);
    for (size_t i = 0; i < (size_t)width; i++)
        out[i * WEFT_FRAME_GROUP] = row[i * step];
}

// Codes of 8 bits are 257 times as much in 16.
static void spread_words(const struct weft_plane *plane, int32_t y, int32_t width, uint16_t *out)
{
    const void *row = weft_plane_line(plane, y, width);
    const uint8_t *bytes = row;
    const uint16_t *words = row;
    const size_t step = step_of(plane);
    for (size_t i = 0; i < (size_t)width; i++)
        out[i * WEFT_FRAME_GROUP] =
            plane->type == WEFT_PLANE_UNORM8 ? (uint16_t)(257 * bytes[i * step]) : words[i * step];
}

void weft_frame_pack_row(const struct weft_plane *planes, int count, enum weft_plane_type type,
                         int32_t y, int32_t width, void *out)
{
    if (count < WEFT_FRAME_GROUP)
        memset(out, 0, (size_t)width * WEFT_FRAME_GROUP * weft_plane_type_size(type));
    for (int c = 0; c < count; c++) {
        if (type == WEFT_PLANE_UNORM8)
            spread_bytes(&planes[c], y, width, (uint8_t *)out + c);
        else if (type == WEFT_PLANE_FLOAT)
            weft_plane_row(&planes[c], y, width, (float *)out + c, WEFT_FRAME_GROUP);
        else
            spread_words(&planes[c], y, width, (uint16_t *)out + c);
    }
}
