// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/layout.h - how a volume's bricks lie in a texture buffer, and in which format.
#ifndef WEFT_TILES_VOLUME_LAYOUT_H
#define WEFT_TILES_VOLUME_LAYOUT_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

enum weft_layout {
    WEFT_LAYOUT_AUTO,        // interleaved, unless the memory budget would cut it into tiny tiles
    WEFT_LAYOUT_INTERLEAVED, // RGBA: texel i holds samples i to i + 3 of a row (4x memory, fastest)
    WEFT_LAYOUT_ALIGNED,     // RGBA: texel i holds samples 4i to 4i + 3, weights shifted to match
    WEFT_LAYOUT_PLAIN,       // R: one sample per texel
};

// "interleaved"; static storage, never NULL.
WEFT_API const char *weft_layout_name(enum weft_layout layout);

// Returns WEFT_ERR_ARGUMENT, with the list of names in the log.
WEFT_API enum weft_result weft_layout_parse(const struct weft_log *log, const char *text,
                                            enum weft_layout *out);

// Formats other than float hold a range mapped to [0, 1] (unorm) or [-1, 1] (half). They take less
// memory; a software GL gains no time from them.
enum weft_source_format {
    WEFT_SOURCE_FLOAT,
    WEFT_SOURCE_HALF,
    WEFT_SOURCE_UNORM16,
    WEFT_SOURCE_UNORM8,
};
enum { WEFT_SOURCE_FORMATS = 4 };

// "32f", "16f", "unorm16", "unorm8"; static storage, never NULL.
WEFT_API const char *weft_source_format_name(enum weft_source_format format);
WEFT_API int weft_source_format_bytes(enum weft_source_format format); // of one sample

// Largest |stored - given| of values in a range, relative to its width.
WEFT_API double weft_source_format_error(enum weft_source_format format);

WEFT_END_DECLS
#endif
