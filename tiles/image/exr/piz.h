// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/exr/piz.h - blocks of EXR lines, packed and unpacked as PIZ by OpenEXRCore (not
// installed).
#ifndef WEFT_TILES_IMAGE_EXR_PIZ_H
#define WEFT_TILES_IMAGE_EXR_PIZ_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// A block: in each line one channel after the other, in each of which one value after the other.
struct weft_chunk_shape {
    size_t width, channel_count;
    const unsigned char *words; // of each channel: 16-bit words in a value, 1 or 2
    int lines;                  // at most so many
};

// Bytes of one line.
size_t weft_chunk_line_bytes(const struct weft_chunk_shape *shape);

// OpenEXRCore's pipelines and what they work on, of nobody else: several of these run at once.
// Thread-safety: one thread at a time.
typedef struct weft_piz weft_piz;

// For blocks of a shape. Returns WEFT_ERR_MEMORY, without a log line.
enum weft_result weft_piz_create(const struct weft_chunk_shape *shape, weft_piz **out);
void weft_piz_destroy(weft_piz **piz);

// Packs `lines` lines. `size` is set to the bytes that makes, which are put in `out` where they are
// fewer than the lines' own. Returns WEFT_ERR_MEMORY, or WEFT_ERR_WRITE where OpenEXRCore cannot,
// without a log line.
enum weft_result weft_piz_pack(weft_piz *piz, const void *raw, int lines, void *out, size_t *size);

// Unpacks what weft_piz_pack put out and compares it with the lines. Returns WEFT_ERR_MEMORY, or
// WEFT_ERR_WRITE where it is not what they were, without a log line.
enum weft_result weft_piz_check(weft_piz *piz, const void *packed, size_t size, const void *raw,
                                int lines);

WEFT_END_DECLS
#endif
