// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/layout.h - how a volume's bricks lie in a texture buffer, and in which format. Plain
// values and pure functions, thread-safe.
#ifndef WEFT_TILES_VOLUME_LAYOUT_H
#define WEFT_TILES_VOLUME_LAYOUT_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// How samples are grouped into texels. A pixel fetches a row of taps in fewer texels where a texel
// holds four samples (dot4; Hadwiger, Hauser, Moeller 2003, section 6). Default: auto.
enum weft_layout {
    WEFT_LAYOUT_AUTO,        // interleaved, unless the memory budget would cut it into tiny tiles
    WEFT_LAYOUT_INTERLEAVED, // RGBA: texel i holds samples i to i + 3 of a row (4x memory, fastest)
    WEFT_LAYOUT_ALIGNED,     // RGBA: texel i holds samples 4i to 4i + 3, weights shifted to match
    WEFT_LAYOUT_PLAIN,       // R: one sample per texel
};

// NULL-ended, in the order of the enum: "auto", "interleaved", "aligned", "plain".
WEFT_API extern const char *const weft_layout_names[];
// Returns one of them; "unknown" for other values. Static storage.
WEFT_API const char *weft_layout_name(enum weft_layout layout);

// How one sample is stored. Formats other than float hold a range of values mapped to [0, 1]
// (unorm) or [-1, 1] (half), and clamp what lies outside it. They take less memory; a software GL
// gains no time from them. Default: float.
enum weft_source_format {
    WEFT_SOURCE_FLOAT,   // as it is
    WEFT_SOURCE_HALF,    // 16 bits, 11 of them significant
    WEFT_SOURCE_UNORM16, // codes 0 to 65535; voxels that are not finite have no code
    WEFT_SOURCE_UNORM8,  // codes 0 to 255, likewise
};
enum { WEFT_SOURCE_FORMATS = 4 }; // how many there are

// NULL-ended, in the order of the enum: "32f", "16f", "unorm16", "unorm8".
WEFT_API extern const char *const weft_source_format_names[];
// Returns one of them; "unknown" for other values. Static storage.
WEFT_API const char *weft_source_format_name(enum weft_source_format format);
// Returns the bytes of one sample: 4, 2, 2, 1; 0 for other values.
WEFT_API int weft_source_format_bytes(enum weft_source_format format);

// Returns the largest |stored - given| of values in a range, relative to the range's width: what
// rounding to the format loses, and rounding in single precision when the range is mapped. NAN for
// values that are no format.
WEFT_API double weft_source_format_error(enum weft_source_format format);

WEFT_END_DECLS
#endif
