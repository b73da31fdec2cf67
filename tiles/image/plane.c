// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/plane.h"

#include "filter/half.h"

const char *const weft_plane_type_names[] = {"float", "half", "unorm8", "unorm16", "uint", NULL};

size_t weft_plane_type_size(enum weft_plane_type type)
{
    static const size_t sizes[] = {4, 2, 1, 2, 4};
    return (unsigned)type < WEFT_PLANE_TYPE_COUNT ? sizes[type] : 0;
}

static size_t step_of(const struct weft_plane *plane)
{
    return plane->step ? plane->step : 1;
}

const void *weft_plane_line(const struct weft_plane *plane, int32_t y, int32_t width)
{
    const size_t stride = plane->stride ? plane->stride : (size_t)width * step_of(plane);
    return (const char *)plane->values + (size_t)y * stride * weft_plane_type_size(plane->type);
}

// Value x of a row that begins at `row`.
static float value_at(const void *row, enum weft_plane_type type, size_t x)
{
    switch (type) {
    case WEFT_PLANE_HALF:
        return weft_half_to_float(((const uint16_t *)row)[x]);
    case WEFT_PLANE_UNORM8:
        return (float)((const uint8_t *)row)[x] / 255.0f;
    case WEFT_PLANE_UNORM16:
        return (float)((const uint16_t *)row)[x] / 65535.0f;
    case WEFT_PLANE_UINT:
        return (float)((const uint32_t *)row)[x];
    default:
        return ((const float *)row)[x];
    }
}

// Inlined with a constant type each: the switch is outside of the loop then.
static inline __attribute__((always_inline)) void spread(const struct weft_plane *plane,
                                                         enum weft_plane_type type, int32_t y,
                                                         int32_t width, float *out, size_t out_step)
{
    const void *row = weft_plane_line(plane, y, width);
    const size_t step = step_of(plane);
    for (size_t i = 0; i < (size_t)width; i++)
        out[i * out_step] = value_at(row, type, i * step);
}

void weft_plane_row(const struct weft_plane *plane, int32_t y, int32_t width, float *out,
                    size_t out_step)
{
    switch (plane->type) {
    case WEFT_PLANE_HALF:
        spread(plane, WEFT_PLANE_HALF, y, width, out, out_step);
        return;
    case WEFT_PLANE_UNORM8:
        spread(plane, WEFT_PLANE_UNORM8, y, width, out, out_step);
        return;
    case WEFT_PLANE_UNORM16:
        spread(plane, WEFT_PLANE_UNORM16, y, width, out, out_step);
        return;
    case WEFT_PLANE_UINT:
        spread(plane, WEFT_PLANE_UINT, y, width, out, out_step);
        return;
    default:
        spread(plane, WEFT_PLANE_FLOAT, y, width, out, out_step);
    }
}
