// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_wire.h - images in messages from reader programs (not installed).
#ifndef WEFT_TILES_IMAGE_IMAGE_WIRE_H
#define WEFT_TILES_IMAGE_IMAGE_WIRE_H

#include "tiles/image/image.h"
#include "tiles/process/wire.h"

WEFT_BEGIN_DECLS

// struct weft_image without its pointers. channel_count struct weft_wire_channel follow, then
// header_bytes of the part's header as tiles/image/image_attribute.h takes it. PNG and TIFF
// files have a header likewise, of attributes that say what the file does, under EXR's names.
struct weft_wire_image {
    int32_t x, y, width, height;
    int32_t display_min[2], display_max[2];
    uint32_t compression; // enum weft_image_compression
    uint32_t tiled, deep; // 0 or 1
    int32_t tile[2];      // of what is tiled
    uint32_t levels;      // enum weft_image_levels, of what is tiled
    uint32_t reserved;
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
// after another, each from a multiple of WEFT_WIRE_ALIGN; of PNG and TIFF one block of interleaved
// values of one type. Without values planes_offset is the payload's end.
struct weft_wire_frame {
    uint64_t info_bytes, planes_offset;
    double gamma;  // as in struct weft_code_info
    uint32_t bits; // likewise; 0: it is an EXR file
    uint32_t flags;
    uint8_t cicp[4];
    uint32_t reserved;
};
enum weft_wire_codes_flag {
    WEFT_WIRE_CODES_PALETTE = 1,
    WEFT_WIRE_CODES_ALPHA = 2,
    WEFT_WIRE_CODES_INTERLACED = 4,
    WEFT_WIRE_CODES_SRGB = 8,
    WEFT_WIRE_CODES_ICC = 16,
    WEFT_WIRE_CODES_ASSOCIATED = 32,
    WEFT_WIRE_CODES_FLAGS = 63 // all of them
};

// A part for IMAGE_WRITE: header_bytes of attributes (texts, an ICC profile) follow it, then
// value_bytes of interleaved values, and then the next of `part` parts.
struct weft_wire_tiff {
    uint32_t width, height;
    uint32_t type;              // enum weft_pixel_type
    uint32_t channels, colours; // of a pixel; the first 1 or 3 of them
    uint32_t alpha, associated; // 0 or 1: alpha follows the colours, which are multiplied by it
    uint32_t compression;       // enum weft_image_compression
    uint32_t tile[2];           // {0, 0}: lines
    float density, aspect;      // pixels per inch along x, 0: none; how high a wide pixel is
    uint64_t header_bytes, value_bytes;
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
    return type == WEFT_PIXEL_UNORM8                               ? 1
           : type == WEFT_PIXEL_HALF || type == WEFT_PIXEL_UNORM16 ? 2
                                                                   : 4;
}

WEFT_END_DECLS
#endif
