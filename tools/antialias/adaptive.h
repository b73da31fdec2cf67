// SPDX-License-Identifier: BSD-3-Clause
// tools/antialias/adaptive.h - adaptive supersampling (Lin, Lau, Lin, Cheung 1997): the picture of
// one sample, and in pixels with an edge the supersampled one.
#ifndef WEFT_TOOLS_ANTIALIAS_ADAPTIVE_H
#define WEFT_TOOLS_ANTIALIAS_ADAPTIVE_H

#include "weft.h"

// What marks, what supersamples, and the last picture's marks. All zero: none.
struct antialias_adaptive {
    weft_marker *marker;
    weft_supersample *supersample;
    struct weft_marks marks;    // all zero: no picture was drawn yet
    int picture;                // that they are of
    struct weft_rectangle part; // that was drawn last (all 0: all of it)
    bool supersampled;          // anything of it
    bool by_share;              // marks are of whole pictures only
    int size[2];
};

// Both must be of one size and format; the marker's reach is set here. On failure *out is all zero.
// Returns weft_marker_create's or weft_supersample_create's.
enum weft_result antialias_adaptive_create(const struct weft_marker_params *marker,
                                           const struct weft_supersample_params *supersample,
                                           struct antialias_adaptive *out);
void antialias_adaptive_clear(struct antialias_adaptive *adaptive); // leaves zeros behind

// Draws and marks the picture of one sample, and supersamples what is marked; where nothing is, it
// draws no more. picture: its number: parts of one have its marks in common where these are a share
// of the whole. On failure there is no picture. Returns weft_marker_run's or
// weft_supersample_run's.
enum weft_result antialias_adaptive_run(struct antialias_adaptive *adaptive,
                                        const struct weft_antialias_drawing *drawing, int picture,
                                        const struct weft_progress *progress);

// Writes a channel (0 to 3) of the last picture, or of its part, rows upwards and tightly packed:
// bit for bit that of one sample, and in pixels that were supersampled that of full supersampling.
// Returns weft_marker_read's or weft_supersample_read's.
enum weft_result antialias_adaptive_read(const struct antialias_adaptive *adaptive, int channel,
                                         float *out);

#endif
