// SPDX-License-Identifier: BSD-3-Clause
// tools/curve/curve.h - positions of pixels that lie on no plane: from an image of them, or across
// a line from point to point.
#ifndef WEFT_TOOLS_CURVE_CURVE_H
#define WEFT_TOOLS_CURVE_CURVE_H

#include "weft.h"

// Positions of width * height pixels, rows one after the other. All zero: none.
struct curve {
    int width, height;
    double (*position)[3]; // owned; curve_clear frees it
    double length;         // of a line; 0 of images
};
void curve_clear(struct curve *curve);

// Reads the channels X, Y and Z of an image. width, height: what its size must be, 0: any. Returns
// WEFT_ERR_ARGUMENT (another size), WEFT_ERR_FORMAT (no such channels, or halves of them
// subsampled), WEFT_ERR_MEMORY and what weft_image_load returns, after an error line.
enum weft_result curve_load_positions(const char *path, int threads, int width, int height,
                                      struct curve *out);

// Reads points, a line each: X,Y,Z or X Y Z; empty lines and such as start with # do not count. The
// pixels are those of weft_polyline_positions, `across` wide; what is 0 of width and height is
// chosen so that pixels are square, and 1024 along the longer side. Returns WEFT_ERR_OPEN,
// WEFT_ERR_FORMAT (a line that is no point), WEFT_ERR_LIMIT (over 2^20 points), WEFT_ERR_MEMORY and
// what weft_polyline_positions returns, after an error line.
enum weft_result curve_load_line(const char *path, double across, int width, int height,
                                 struct curve *out);

#endif
