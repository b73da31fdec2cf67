// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/frame.h"

#include "filter/half.h"

void weft_frame_source_destroy(weft_accumulator *a)
{
    (void)a;
}

enum weft_result weft_frame_planes(weft_accumulator *a, const struct weft_frame *frame,
                                   const struct weft_plane **out)
{
    *out = frame->plane;
    if (*out)
        return WEFT_OK;
    weft_error(a->params.log, "accumulate: reading frames back is not built yet");
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_frame_textures(weft_accumulator *a, const struct weft_frame *frame,
                                     const GLuint **out)
{
    (void)frame;
    *out = NULL;
    weft_error(a->params.log, "accumulate: textures of frames are not built yet");
    return WEFT_ERR_UNSUPPORTED;
}

// A plane's row y; stride and step may be left to their defaults.
static const char *row_of(const struct weft_plane *plane, int32_t y, int32_t width)
{
    const size_t step = plane->step ? plane->step : 1;
    const size_t stride = plane->stride ? plane->stride : (size_t)width * step;
    return (const char *)plane->values + (size_t)y * stride * weft_plane_type_size(plane->type);
}

void weft_frame_row(const struct weft_plane *plane, int32_t y, int32_t width, float *out)
{
    const size_t step = plane->step ? plane->step : 1, end = (size_t)width * step;
    const void *row = row_of(plane, y, width);
    const float *floats = row;
    const uint8_t *bytes = row;
    const uint16_t *words = row;
    const uint32_t *integers = row;
    switch (plane->type) {
    case WEFT_PLANE_HALF:
        for (size_t i = 0; i < end; i += step)
            *out++ = weft_half_to_float(words[i]);
        return;
    case WEFT_PLANE_UNORM8:
        for (size_t i = 0; i < end; i += step)
            *out++ = (float)bytes[i] / 255.0f;
        return;
    case WEFT_PLANE_UNORM16:
        for (size_t i = 0; i < end; i += step)
            *out++ = (float)words[i] / 65535.0f;
        return;
    case WEFT_PLANE_UINT:
        for (size_t i = 0; i < end; i += step)
            *out++ = (float)integers[i];
        return;
    default:
        for (size_t i = 0; i < end; i += step)
            *out++ = floats[i];
        return;
    }
}
