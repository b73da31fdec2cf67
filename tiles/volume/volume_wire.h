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

// A volume to be written. Followed by brick_count origins (int32_t[3]), tile_count struct
// weft_volume_tile, and brick_count * 512 floats.
struct weft_wire_volume {
    char name[256], grid_class[32];
    double index_to_world[3][4];
    uint64_t brick_count, tile_count;
    float background;
    uint32_t boxed; // exactly the voxels in the box are active, instead of those that
    int32_t box_min[3], box_max[3]; // volume.h calls active; all others get the background
};

WEFT_END_DECLS
#endif
