// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_wire.h - images in messages from reader programs (not installed).
#ifndef WEFT_TILES_IMAGE_IMAGE_WIRE_H
#define WEFT_TILES_IMAGE_IMAGE_WIRE_H

#include "tiles/image/image.h"
#include "tiles/process/wire.h"

WEFT_BEGIN_DECLS

// struct weft_image without its pointers. channel_count struct weft_wire_channel follow, then
// header_bytes of the part's header as tiles/image/image_attribute.h takes it.
struct weft_wire_image {
    int32_t x, y, width, height;
    int32_t display_min[2], display_max[2];
    uint32_t compression; // enum weft_image_compression
    uint32_t tiled, deep; // 0 or 1
    uint32_t part_count;
    uint64_t channel_count, header_bytes;
};

struct weft_wire_channel {
    char name[256];
    uint32_t type;   // enum weft_pixel_type
    uint32_t linear; // 0 or 1
    int32_t sampling[2];
};

// What a FRAME's payload starts with. info_bytes of the image follow (struct weft_wire_image and
// what follows that), then, at planes_offset, its values in the types that the file has: one plane
// after another, each from a multiple of WEFT_WIRE_ALIGN; of PNG one block of interleaved codes, of
// 8 bits, or of 16 where png_bits is 16. Without values planes_offset is the payload's end.
struct weft_wire_frame {
    uint64_t info_bytes, planes_offset;
    double png_gamma;  // as in struct weft_png_info
    uint32_t png_bits; // likewise; 0: it is an EXR file
    uint32_t png_flags;
    uint8_t png_cicp[4];
    uint32_t reserved;
};
enum weft_wire_png_flag {
    WEFT_WIRE_PNG_PALETTE = 1,
    WEFT_WIRE_PNG_ALPHA = 2,
    WEFT_WIRE_PNG_INTERLACED = 4,
    WEFT_WIRE_PNG_SRGB = 8,
    WEFT_WIRE_PNG_ICC = 16,
};

enum { WEFT_WIRE_ALIGN = 64 };
// false on overflow.
static inline bool weft_wire_align(size_t size, size_t *out)
{
    *out = (size + WEFT_WIRE_ALIGN - 1) / WEFT_WIRE_ALIGN * WEFT_WIRE_ALIGN;
    return *out >= size;
}

// Bytes of a value of a channel.
static inline size_t weft_wire_pixel_size(uint32_t type)
{
    return type == WEFT_PIXEL_HALF ? 2 : 4;
}

WEFT_END_DECLS
#endif
