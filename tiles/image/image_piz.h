// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_piz.h - blocks of EXR lines as PIZ packs them (not installed).
// The values are taken for 16-bit words: those that occur are numbered, a wavelet (Haar, in
// integers) runs over the words of each channel, and what it leaves is Huffman-coded, with a code
// for repetitions. Source of the format: OpenEXR 3.1, ImfPizCompressor, ImfWav and ImfHuf.
#ifndef WEFT_TILES_IMAGE_IMAGE_PIZ_H
#define WEFT_TILES_IMAGE_IMAGE_PIZ_H

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

// Memory to pack and unpack with. Thread-safety: one thread at a time.
typedef struct weft_piz weft_piz;

// For blocks of a shape, which is borrowed as long as it lives. Returns WEFT_ERR_MEMORY, without a
// log line.
enum weft_result weft_piz_create(const struct weft_chunk_shape *shape, weft_piz **out);
void weft_piz_destroy(weft_piz **piz);

// Packs `lines` lines. Returns the bytes put in out, or 0 where they are not fewer than the lines'
// own. out has room for these and for what is written before that is known.
enum { WEFT_PIZ_SLACK = 16384 };
size_t weft_piz_pack(weft_piz *piz, const void *raw, int lines, unsigned char *out);

// Unpacks `size` bytes into `lines` lines; false where they are none that were packed so. Any bytes
// may be handed in.
bool weft_piz_unpack(weft_piz *piz, const unsigned char *packed, size_t size, int lines, void *raw);

WEFT_END_DECLS
#endif
