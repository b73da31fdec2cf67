// SPDX-License-Identifier: BSD-3-Clause
// tools/framing/framing.h - how pictures are framed: sizes, where on an axis they lie, what is up,
// which box they show, as options say it, and the box of a sequence of volumes.
#ifndef WEFT_TOOLS_FRAMING_FRAMING_H
#define WEFT_TOOLS_FRAMING_FRAMING_H

#include "weft.h"

// Pixels: sides, of which 0 are to be chosen so that pixels are square; or the longer one alone.
struct framing_size {
    int side[2];
    int longer; // 0: the sides say it
};

// A place on an axis, or the way from one to another: coordinates, or parts of a box there.
struct framing_span {
    bool moves;
    double at[2]; // again where it does not move
    bool part[2]; // 0: its low end, 1: its high end
};

// Which box the planes across an axis show.
enum framing_box { FRAMING_BOX_ALL, FRAMING_BOX_FIRST, FRAMING_BOX_GIVEN };

struct framing {
    struct framing_size size;
    bool is_at;
    struct framing_span at;
    bool is_up;
    double up[3];
    bool columns, rows; // mirrored
    enum framing_box box;
    double low[3], high[3]; // of FRAMING_BOX_GIVEN
};

// What options say. Each returns WEFT_ERR_ARGUMENT after an error line.

// WxH, Wx0, 0xH or N, the longer side; sides of `most` at most.
enum weft_result framing_read_size(const char *text, int most, int64_t most_pixels,
                                   struct framing_size *out);
// A, A% or A..B.
enum weft_result framing_read_at(const char *text, struct framing_span *out);
// x, -x, y, -y, z, -z or X,Y,Z.
enum weft_result framing_read_up(const char *text, double out[3]);
// first, all or X0,Y0,Z0,X1,Y1,Z1.
enum weft_result framing_read_box(const char *text, struct framing *out);

// Chooses a cut's pixels. That there are too many is an error line, WEFT_ERR_ARGUMENT.
enum weft_result framing_choose_size(const struct framing_size *size, const weft_volume *volume,
                                     enum weft_space space, struct weft_slice_geometry *geometry);
enum { FRAMING_TEXT = 160 };
// Writes by how much pixels are not square, "" where that is what whole pixels make it. `lengths`:
// of the picture's sides, in one unit; `where`: " in world space", or "".
void framing_format_aspect(const double lengths[2], int width, int height, const char *where,
                           char out[FRAMING_TEXT]);
// The same of a cut.
void framing_format_cut(const weft_volume *volume, enum weft_space space,
                        const struct weft_slice_geometry *geometry, char out[FRAMING_TEXT]);

// Files of a sequence, and which grid of each.
struct framing_files {
    const char *name; // with a number in it
    int64_t first, step;
    int count;
    const char *grid;                  // "": the first one of numbers
    const struct weft_raw_layout *raw; // NULL: they are what they are by content
};
// Widens a box to those of all files' active voxels, by what their headers tell; where one does not
// tell, its grid is opened. Files that cannot be read are passed over: making their frames tells.
void framing_widen_box(const struct framing_files *files, enum weft_space space, double low[3],
                       double high[3]);

#endif
