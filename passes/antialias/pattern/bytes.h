// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/pattern/bytes.h - how many bytes the ways of anti-aliasing take, by formula.
// Reports of the ways themselves have beside it what GL says that it took. Everything is pure.
#ifndef WEFT_PASSES_ANTIALIAS_PATTERN_BYTES_H
#define WEFT_PASSES_ANTIALIAS_PATTERN_BYTES_H

#include "../../../filter/base.h"

WEFT_BEGIN_DECLS

// Of what colours are kept in.
enum weft_antialias_format {
    WEFT_ANTIALIAS_RGBA8,   // 4 bytes, values of 0 to 1
    WEFT_ANTIALIAS_RGBA16F, // 8
    WEFT_ANTIALIAS_RGBA32F, // 16
    WEFT_ANTIALIAS_FORMAT_COUNT
};
// NULL-ended, in the order of the enum: "8", "16f", "32f".
WEFT_API extern const char *const weft_antialias_format_names[];
WEFT_API int weft_antialias_format_bytes(enum weft_antialias_format format); // 0: there is none

// MSAA: width height samples (colour + depth).
WEFT_API uint64_t weft_bytes_multisample(int32_t width, int32_t height, int samples,
                                         int colour_bytes, int depth_bytes);
// Accumulative anti-aliasing (Enderton and others 2015): width height (samples depth + sums); its
// 316 MB are 8 samples of 4 bytes and sums of 8 bytes at 3840 x 2160, MSAA's 759 MB colours of 8.
WEFT_API uint64_t weft_bytes_accumulative(int32_t width, int32_t height, int samples, int sum_bytes,
                                          int depth_bytes);
// Adaptive supersampling (Lin and others 1997): width height (colour + depth + 4) + edge_pixels
// samples (colour + depth), 4 bytes being a pointer; with 3 and 4 bytes and 16 samples width height
// 11 + 112 edge_pixels. Full supersampling: width height samples (colour + depth).
WEFT_API uint64_t weft_bytes_adaptive(int32_t width, int32_t height, int64_t edge_pixels,
                                      int samples, int colour_bytes, int depth_bytes);

WEFT_END_DECLS
#endif
