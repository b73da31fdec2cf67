// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/exr_unzip.h - blocks of lines that ZIP packed, through libdeflate instead of zlib,
// which OpenEXRCore uses: half the time of reading such files (not installed).
#ifndef WEFT_TILES_READERS_EXR_UNZIP_H
#define WEFT_TILES_READERS_EXR_UNZIP_H

#include <openexr.h>

#include "filter/base.h"

WEFT_BEGIN_DECLS

// What one pipeline unpacks with. Starts as {0}.
struct weft_exr_unzip {
    struct libdeflate_decompressor *decompressor;
    unsigned char *split; // a block's bytes as ZIP has them
    size_t size;
    exr_result_t (*default_fn)(exr_decode_pipeline_t *decode);
};

// Gives a pipeline whose routines are chosen, of a part that ZIP or ZIPS packs, this one for
// unpacking. What it cannot unpack, OpenEXRCore tries: its errors stay what they are. Without
// memory the pipeline stays as it is.
void weft_exr_unzip_install(struct weft_exr_unzip *unzip, exr_decode_pipeline_t *decode);
void weft_exr_unzip_clear(struct weft_exr_unzip *unzip);

WEFT_END_DECLS
#endif
