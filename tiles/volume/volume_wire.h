// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume_wire.h - volumes in messages to and from reader programs (not installed).
#ifndef WEFT_TILES_VOLUME_VOLUME_WIRE_H
#define WEFT_TILES_VOLUME_VOLUME_WIRE_H

#include "tiles/process/wire.h"
#include "tiles/volume/volume.h"

WEFT_BEGIN_DECLS

// struct weft_volume_info without its pointers; metadata_count entries of struct weft_metadata
// follow.
struct weft_wire_grid {
    struct weft_volume_info info; // info.metadata is meaningless here
};

// A grid to be written: struct weft_volume_grid without its pointers. Followed by metadata_count
// entries of struct weft_metadata.
struct weft_wire_volume {
    char name[256 + 64], grid_class[32], vector_type[32];
    double index_to_world[3][4];
    uint64_t metadata_count;
    uint32_t components;
    float background;
    uint32_t boxed;
    int32_t box_min[3], box_max[3];
};

// Bricks and tiles of a grid. Followed by brick_count origins (int32_t[3]), tile_count struct
// weft_volume_tile, and brick_count * components * 512 floats.
struct weft_wire_lot {
    uint64_t brick_count, tile_count;
};

WEFT_END_DECLS
#endif
