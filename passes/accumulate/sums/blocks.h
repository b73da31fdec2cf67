// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/blocks.h - all values of a frame in memory, some thousand at once, on all
// threads (not installed).
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_BLOCKS_H
#define WEFT_PASSES_ACCUMULATE_SUMS_BLOCKS_H

#include "tiles/image/plane.h"

WEFT_BEGIN_DECLS

enum { WEFT_BLOCK_VALUES = 1024 };

// What a frame is.
struct weft_frame_shape {
    int32_t width, height;
    int channel_count;
    int threads; // that work on it
};

// What is known of a frame's channel before it is added.
struct weft_scan {
    double largest;     // of its finite |values|; codes: 1
    uint64_t nonfinite; // values that are not
};

// Values that follow each other in a row of a channel.
struct weft_block {
    int channel;
    enum weft_plane_type type;
    const void *values;  // one after another; in the place of those that are not finite, 0
    size_t at, count;    // pixels at, at + 1, ... of [y][x]
    const uint16_t *bad; // which values were not finite, ascending: empty for a scan
    size_t bad_count;
};

// Calls use() for all values, the channels of a row one after another, rows on several threads; a
// pixel's values come to one thread. Where `scan` (of each channel) says that there are values that
// are not finite, these are told. Returns false once use() did.
bool weft_blocks_run(const struct weft_frame_shape *shape, const struct weft_plane *planes,
                     const struct weft_scan *scan,
                     bool (*use)(void *priv, int thread, const struct weft_block *block),
                     void *priv);

// Returns a block's values as floats, in `memory` (of WEFT_BLOCK_VALUES) unless they are: halves
// are exact, codes are code / largest code rounded once, integers beyond 2^24 the nearest float.
const float *weft_block_floats(const struct weft_block *block, float *memory);

// Calls use() for pixels first ... end - 1 of [y][x], on several threads; of every channel.
bool weft_pixels_run(const struct weft_frame_shape *shape,
                     bool (*use)(void *priv, int thread, size_t first, size_t end), void *priv);

// Fills in what is known, of each channel. False: no memory.
bool weft_scan_frame(const struct weft_frame_shape *shape, const struct weft_plane *planes,
                     struct weft_scan *scan);

// A value and where it lies.
struct weft_place {
    int channel;
    int32_t x, y;
    double value;
};
// Finds the first value of a channel that is not finite or whose size is above a limit. There is
// one. Codes count as 1.
struct weft_place weft_scan_find(const struct weft_frame_shape *shape,
                                 const struct weft_plane *planes, int channel, double limit);

WEFT_END_DECLS
#endif
