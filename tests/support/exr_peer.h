// SPDX-License-Identifier: BSD-3-Clause
// tests/support/exr_peer.h - OpenEXR's C++ library as a second opinion on files, and as the writer
// of what weft only reads.
#ifndef WEFT_TESTS_SUPPORT_EXR_PEER_H
#define WEFT_TESTS_SUPPORT_EXR_PEER_H

#include <stdbool.h>
#include <stddef.h>

#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

// Whether the library finds in a part of a file exactly the image's windows, channels, types and
// values: floats by their bits, halves as filter/half.h rounds them, uints as they are. If
// not, `why` says what is wrong.
bool exr_peer_agrees(const char *path, const struct weft_image *image, char *why, size_t size);

// Writes channels of their types, as one part or several; of deep parts no more than the header.
// tile: side of tiles; 0: lines. false: `why` says what the library said.
bool exr_peer_write(const char *path, const struct weft_image *parts, size_t count, int tile,
                    char *why, size_t size);

// The values that the library reads from a channel, as floats, in a buffer to be freed; NULL: why.
float *exr_peer_values(const char *path, const char *channel, char *why, size_t size);

// Those of a mip level of a tiled file, and how large it is; levels[0]: how many there are.
float *exr_peer_level(const char *path, const char *channel, int level, int size[2], int *levels,
                      char *why, size_t why_size);

// Seconds that the library takes to write an image as lines, and to read the first part of a file,
// with so many threads in its pool (0: on the caller's alone); values are in memory as they are in
// the file. < 0: `why` says what it said.
double exr_peer_write_seconds(const char *path, const struct weft_image *image, int threads,
                              char *why, size_t size);
double exr_peer_read_seconds(const char *path, int threads, char *why, size_t size);

WEFT_END_DECLS
#endif
