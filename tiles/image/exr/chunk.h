// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/exr/chunk.h - blocks of EXR lines, packed and unpacked (not installed).
// Readers take a block for raw exactly where it is as long as the lines themselves; a packed one of
// that length would be read as garbage, so packing that does not shorten is left out.
#ifndef WEFT_TILES_IMAGE_EXR_CHUNK_H
#define WEFT_TILES_IMAGE_EXR_CHUNK_H

#include "tiles/image/image.h"
#include "tiles/image/exr/piz.h"

WEFT_BEGIN_DECLS

typedef struct weft_chunk_packer weft_chunk_packer; // Thread-safety: one thread at a time.

// For blocks of a shape and any compression that weft writes. Returns WEFT_ERR_MEMORY, without a
// log line.
enum weft_result weft_chunk_packer_create(enum weft_image_compression compression,
                                          const struct weft_chunk_shape *shape,
                                          weft_chunk_packer **out);
void weft_chunk_packer_destroy(weft_chunk_packer **packer);

struct weft_chunk {
    const void *data; // to be stored: packed, or the raw lines
    size_t size;      // at most that of the raw lines
    bool packed;      // shorter than the raw lines; otherwise the same bytes
    size_t shortest;  // what packing alone would have made of it; 0: far more than the raw lines
};

// Packs `lines` lines into `room`, of their bytes and WEFT_CHUNK_SLACK more, unpacks them again and
// compares. Returns WEFT_ERR_WRITE where they differ, or WEFT_ERR_MEMORY, without a log line.
enum { WEFT_CHUNK_SLACK = 64 }; // libdeflate gives up some bytes before the end of its room
enum weft_result weft_chunk_pack(weft_chunk_packer *packer, const void *raw, int lines,
                                 unsigned char *room, struct weft_chunk *out);

// Lines of one chunk.
int weft_chunk_lines(enum weft_image_compression compression);

WEFT_END_DECLS
#endif
