// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/plane.h - one channel of an image where it lies in memory, in the type that it has.
// Pixel (x, y) is values[y * stride + x * step], row 0 on top. Codes stand for code / largest code.
#ifndef WEFT_TILES_IMAGE_PLANE_H
#define WEFT_TILES_IMAGE_PLANE_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// What a value is. Default: float.
enum weft_plane_type {
    WEFT_PLANE_FLOAT,   // float
    WEFT_PLANE_HALF,    // uint16_t, the bits of an IEEE 754 binary16
    WEFT_PLANE_UNORM8,  // uint8_t, 0 to 255 for 0 to 1
    WEFT_PLANE_UNORM16, // uint16_t, 0 to 65535 for 0 to 1
    WEFT_PLANE_UINT,    // uint32_t, which stands for itself
    WEFT_PLANE_TYPE_COUNT
};
// NULL-ended, in the order of the enum: "float", "half", "unorm8", "unorm16", "uint".
WEFT_API extern const char *const weft_plane_type_names[];

// Returns the bytes of one value; 0 for what is no type. Pure.
WEFT_API size_t weft_plane_type_size(enum weft_plane_type type);

// Where a channel's values lie. They are borrowed for as long as whoever takes the plane says, and
// are not written to. What lies between rows and between pixels is never looked at. Values beyond
// the last pixel of the last row need not be there.
struct weft_plane {
    const void *values; // required; aligned to its values
    enum weft_plane_type type;
    size_t stride; // values from row to row, >= width * step (default: width * step)
    size_t step;   // values from pixel to pixel (default 1; 4: one channel of interleaved RGBA)
};

// Returns where row y of a plane of rows of `width` pixels begins. Pure.
WEFT_API const void *weft_plane_line(const struct weft_plane *plane, int32_t y, int32_t width);

// Writes row y of a plane of rows of `width` pixels as floats: out[x * out_step]. Halves are exact,
// codes are code / largest code rounded once, integers beyond 2^24 the nearest float. Pure.
WEFT_API void weft_plane_row(const struct weft_plane *plane, int32_t y, int32_t width, float *out,
                             size_t out_step);

WEFT_END_DECLS
#endif
