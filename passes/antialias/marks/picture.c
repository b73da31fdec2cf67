// SPDX-License-Identifier: BSD-3-Clause
// The picture of one sample and its parts, in memory.
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/half.h"
#include "passes/antialias/marks/marks_impl.h"

bool weft_marker_counts(const weft_marker *m, int32_t x, int32_t y)
{
    const int32_t from[2] = {m->found.x - m->part.x + x, m->found.y - m->part.y + y};
    return from[0] >= 0 && from[0] < m->part.width && from[1] >= 0 && from[1] < m->part.height;
}

struct weft_rectangle weft_marks_part(const struct weft_marks *marks)
{
    return marks->part.width ? marks->part
                             : (struct weft_rectangle){0, 0, marks->width, marks->height};
}

void weft_marker_row(const weft_marker *marker, int32_t y, float *out)
{
    const size_t count = 4 * (size_t)marker->seen.width, first = (size_t)y * count;
    if (marker->params.format == WEFT_ANTIALIAS_RGBA32F)
        memcpy(out, (const float *)marker->picture + first, count * sizeof *out);
    else if (marker->params.format == WEFT_ANTIALIAS_RGBA16F)
        weft_half_to_floats((const uint16_t *)marker->picture + first, count, out);
    else
        for (size_t i = 0; i < count; i++)
            out[i] = (float)((const uint8_t *)marker->picture)[first + i] / 255.0f;
}

enum weft_result weft_marker_read(const weft_marker *marker, int channel, float *out, size_t stride)
{
    const size_t width = (size_t)marker->part.width;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    float *row = NULL;
    weft_require(marker->params.log, marker->drawn);
    weft_require(marker->params.log, channel >= 0 && channel < 4);
    weft_require(marker->params.log, out && (stride == 0 || stride >= width));
    row = malloc(4 * (size_t)marker->seen.width * sizeof *row);
    res = row ? WEFT_OK : WEFT_ERR_MEMORY;
    if (!row)
        weft_error(marker->params.log, "antialias: not enough memory for a row of %zu pixels",
                   (size_t)marker->seen.width);
    const int32_t first[2] = {marker->part.x - marker->seen.x, marker->part.y - marker->seen.y};
    for (int32_t y = 0; y < marker->part.height && row; y++) {
        weft_marker_row(marker, first[1] + y, row);
        for (size_t x = 0; x < width; x++)
            out[(size_t)y * (stride ? stride : width) + x] =
                row[4 * ((size_t)first[0] + x) + (size_t)channel];
    }
fail:
    free(row);
    return res;
}
