// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/window_map.h - where the columns and the rows of a scaled image lie, in whole
// numbers: one map along x and one along y make a grid of pixels.
// An image's display window of `from` pixels along an axis becomes one of `to` pixels. Pixel x of
// the new window, centred at x + 0.5, lies at (x + 0.5) from / to - 0.5 in pixels of the old one,
// counted from the centre of its first. Samples and pixels need not fill those windows: data
// windows may be smaller, or reach beyond them (overscan).
// Pure arithmetic, thread-safe.
#ifndef WEFT_PASSES_POSITIONS_WINDOW_MAP_H
#define WEFT_PASSES_POSITIONS_WINDOW_MAP_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// Sizes and distances along an axis at most, in pixels: as EXR has them.
enum { WEFT_WINDOW_MAX = 1 << 30 };

// Pixels along an axis from `first` to before `end`; first < end.
struct weft_window {
    int64_t first, end;
};

// A map along one axis. No default: all is required, and within WEFT_WINDOW_MAX of 0.
struct weft_window_map {
    int64_t from, to; // pixels along the display windows of the samples and of the result, >= 1
    int64_t pixel;    // the first pixel of the result, counted from its display window's first
    int64_t sample;   // the display window's first pixel, counted from the first sample
};

// Returns the map from all of `samples` samples to all of `pixels` pixels: windows without an
// offset.
WEFT_API struct weft_window_map weft_window_map_plain(int samples, int pixels);

// Scales an image's windows along an axis to a display window of `to` pixels. The display window's
// first edge stays on a whole pixel, the nearest (half-way down), and all edges are counted from
// it; the data window grows to whole pixels. new_data is what the map's pixels fill, from new_data.
// first on. Returns WEFT_ERR_ARGUMENT (an empty window, `to` below 1, numbers beyond
// WEFT_WINDOW_MAX; *out is then all zero) or WEFT_ERR_LIMIT (new windows beyond it: the log has
// both ends, and the windows are set).
WEFT_API enum weft_result weft_window_map_scale(const struct weft_log *log, struct weft_window data,
                                                struct weft_window display, int64_t to,
                                                struct weft_window *new_data,
                                                struct weft_window *new_display,
                                                struct weft_window_map *out);

// Returns where pixel number `pixel` of the result lies, in samples, counted from the first sample,
// plus `shift`: one division of whole numbers, so that what is whole, or half-way between two
// samples, is so here. NAN for a map, a pixel or a shift that is beyond its range.
WEFT_API double weft_window_map_position(const struct weft_window_map *map, int pixel, int shift);

// The same of `count` pixels from `first` on: at[i] is that of first + i.
WEFT_API void weft_window_map_positions(const struct weft_window_map *map, int first, int count,
                                        int shift, double *at);

// Returns the sample in whose unit square a pixel's centre lies, of two that meet there the later
// one, counted from the first sample; it may lie before that or past the last one. INT64_MIN for a
// map or a pixel that is beyond its range.
WEFT_API int64_t weft_window_map_square(const struct weft_window_map *map, int pixel);

WEFT_END_DECLS
#endif
