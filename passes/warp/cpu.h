// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/cpu.h - filtering at any positions without OpenGL (not installed).
//
// A pixel's taps along x are the lanes of a vector: rows of samples are loaded from the first tap
// on, multiplied by the weights along y and added up; the sum is multiplied by the weights along x
// and its lanes are added up. All channels have the same weights. Vectors are as long as the taps
// need, whatever the set of instructions; lanes past the last tap have a weight of 0, and read
// samples that are there. Pixels for which they are not, near the borders of the samples, and all
// where a sample is not finite or sums might leave the range of floats, are summed in double by one
// piece of C (weft_warp_careful).
#ifndef WEFT_PASSES_WARP_CPU_H
#define WEFT_PASSES_WARP_CPU_H

#include "passes/warp/warp_impl.h"

// A kernel as the loops look it up.
struct weft_warp_taps {
    int width, degree, segments;
    int lanes;                // 4, 8 or 16: the width, rounded up
    const void *coefficients; // floats or doubles, [segment][power][lanes]
};

// A row of pixels, of up to WEFT_WARP_ROW.
struct weft_warp_line {
    const struct weft_warp_taps *taps;
    int count, channels;
    int32_t size[2]; // of the values
    const float *values[WEFT_RESAMPLE_MAX_CHANNELS];
    const struct weft_warp_row *row;
    float *out[WEFT_RESAMPLE_MAX_CHANNELS];
};

// A pixel of a stretched kernel, all of whose taps are within the values. Weights are floats or
// doubles, those along x padded with zeros to whole vectors of WEFT_WARP_LANES.
enum { WEFT_WARP_LANES = 8 };
struct weft_warp_box {
    int channels, columns, rows; // taps, columns rounded up to whole vectors
    int64_t pitch, start;        // values from row to row, and the first tap's
    const float *values[WEFT_RESAMPLE_MAX_CHANNELS];
    const void *weights[2];
    float *out[WEFT_RESAMPLE_MAX_CHANNELS];
};

// The loops of one set of instructions and one kind of sums.
struct weft_warp_lines {
    size_t bytes; // of a number
    // Makes the pixels for which weft_warp_is_inside, and leaves the others.
    void (*line)(const struct weft_warp_line *line);
    void (*box)(const struct weft_warp_box *box);
};
const struct weft_warp_lines *weft_warp_lines_plain(enum weft_sums sums);
#ifdef __x86_64__
const struct weft_warp_lines *weft_warp_lines_sse2(enum weft_sums sums);
const struct weft_warp_lines *weft_warp_lines_avx2(enum weft_sums sums);
const struct weft_warp_lines *weft_warp_lines_avx512(enum weft_sums sums);
#endif

// Whether all that is read for a pixel lies within the values.
static inline bool weft_warp_is_inside(int32_t x, int32_t y, int columns, int rows,
                                       const int32_t size[2])
{
    return x >= 0 && y >= 0 && x <= size[0] - columns && y <= size[1] - rows;
}

#endif
