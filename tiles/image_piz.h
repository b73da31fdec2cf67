// SPDX-License-Identifier: BSD-3-Clause
// tiles/image_piz.h - blocks of EXR lines packed by PIZ (not installed).
// 16-bit words that are renumbered densely, a two-dimensional Haar wavelet of each channel's words,
// and one canonical Huffman code: the format of OpenEXR's ImfPizCompressor, ImfWav and ImfHuf.
#ifndef WEFT_TILES_IMAGE_PIZ_H
#define WEFT_TILES_IMAGE_PIZ_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// What a line consists of: of each channel in turn, `width` values of 1 (half) or 2 words.
struct weft_chunk_shape {
    size_t width, channel_count;
    const unsigned char *words; // borrowed
};

typedef struct weft_piz weft_piz; // Thread-safety: one thread at a time.

// For blocks of up to `lines` lines. NULL: out of memory.
weft_piz *weft_piz_create(const struct weft_chunk_shape *shape, int lines);
void weft_piz_destroy(weft_piz **piz);

// Packs `size` bytes, which are whole lines, into out. Returns how many bytes that takes; 0: more
// than there is room for.
size_t weft_piz_pack(weft_piz *piz, const void *raw, size_t size, unsigned char *out, size_t room);

WEFT_END_DECLS
#endif
