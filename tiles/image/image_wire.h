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

WEFT_END_DECLS
#endif
