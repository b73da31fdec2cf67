// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_huffman.h - the Huffman code of PIZ (not installed).
// Symbols are 16-bit words; one more symbol, the one past the largest, is followed by 8 bits: how
// often the word before it comes again. Codes are canonical, longer ones before shorter ones. The
// format: first and last symbol, bytes of the table of lengths, bits of the data, 0, as five
// 32-bit little-endian numbers; the table; the data, high bits first.
#ifndef WEFT_TILES_IMAGE_IMAGE_HUFFMAN_H
#define WEFT_TILES_IMAGE_IMAGE_HUFFMAN_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

typedef struct weft_huffman weft_huffman; // Thread-safety: one thread at a time.

// Returns NULL where there is no memory.
weft_huffman *weft_huffman_create(void);
void weft_huffman_destroy(weft_huffman **huffman);

// Codes `count` words, at least 1 and fewer than 2^31. Returns the bytes put in out, or 0 where
// `room` bytes do not hold them.
size_t weft_huffman_pack(weft_huffman *huffman, const uint16_t *words, size_t count,
                         unsigned char *out, size_t room);

// Returns whether `size` bytes are the code of exactly `count` words, which are then in words. Any
// bytes may be handed in.
bool weft_huffman_unpack(weft_huffman *huffman, const unsigned char *packed, size_t size,
                         uint16_t *words, size_t count);

WEFT_END_DECLS
#endif
