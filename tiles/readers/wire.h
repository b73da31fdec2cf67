// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/wire.h - messages between libweft and its reader programs (not installed).
// One SOCK_SEQPACKET socket pair per reader, descriptor 3 in the reader. The caller sends a request
// with a memfd for the answer's payload (and, for WRITE, one with the request's payload); the
// reader fills it and answers. The reader ends when the socket closes, whatever it is doing. Both
// ends are built together; a version that differs is refused.
#ifndef WEFT_TILES_READERS_WIRE_H
#define WEFT_TILES_READERS_WIRE_H

#include "tiles/image/image.h"
#include "tiles/volume/volume.h"

WEFT_BEGIN_DECLS

enum { WEFT_WIRE_MAGIC = 0x77656674, WEFT_WIRE_VERSION = 4, WEFT_WIRE_FD = 3 };

enum weft_wire_op {
    WEFT_WIRE_LIST,  // VDB: all grids.  -> struct weft_wire_grid, its metadata; again for each grid
    WEFT_WIRE_OPEN,  // VDB: payload of the grid's name and a NUL (none = the first supported one).
                     // -> one struct weft_wire_grid, metadata
    WEFT_WIRE_FIND,  // VDB: `region`.   -> brick origins, then tiles (counts in the answer)
    WEFT_WIRE_READ,  // VDB: payload of brick origins. -> count * 512 floats
    WEFT_WIRE_WRITE, // VDB writer: payload of struct weft_wire_volume etc. -> nothing; the file is
                     // written, count[0] bytes of it
    WEFT_WIRE_IMAGE_INFO,   // EXR: `part`.  -> struct weft_wire_image, channels, the part's header
    WEFT_WIRE_IMAGE_PIXELS, // EXR: `part`. -> planes of float or, for uint channels, uint32_t, in
                            // the order of the channels
};

struct weft_wire_request {
    uint32_t magic, version;
    uint32_t op;
    uint32_t rest;          // OPEN: as in struct weft_volume_open_params
    uint32_t part;          // of an image, from 0
    uint32_t reserved;
    uint64_t payload_bytes; // in the request's payload memfd, 0 = none
    struct weft_region region;
};

struct weft_wire_answer {
    uint32_t magic, version;
    int32_t result; // enum weft_result; payload and counts are valid only with WEFT_OK
    uint32_t reserved;
    uint64_t payload_bytes; // size of the answer's payload memfd
    uint64_t count[2];      // as the op says
    char message[512];      // one line for the log, why it failed
};

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
