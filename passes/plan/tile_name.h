// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/tile_name.h - what tiles are called, whatever their numbers in a set.
// Numbers change when tiles are split or a set is made with other parameters; a tap, the sign of
// its weights and the piece stay. Users write "1,2-/1": the tap (1, 2), its negative part, of that
// the second piece. All is pure and thread-safe.
#ifndef WEFT_PASSES_PLAN_TILE_NAME_H
#define WEFT_PASSES_PLAN_TILE_NAME_H

#include "../../tiles/kernel/kernel_tiles.h"

WEFT_BEGIN_DECLS

// One tile of a tap. A tile that was split has several pieces, numbered from 0 in the order in
// which the splits were made.
struct weft_tile_name {
    int tap[3];               // from 0 along x, y, z; 0 along axes past the set's
    enum weft_tile_part part; // WHOLE: the only part that the tap has
    int piece;
};

enum { WEFT_TILE_NAME_TEXT = 64 }; // with its NUL

// Names a tile of a set by its number. `brief` leaves out the part of a tap that has no other, as
// people write it. All -1 where there is no such tile.
WEFT_API struct weft_tile_name weft_tile_name_of(const weft_kernel_tiles *tiles, int tile,
                                                 bool brief);

// Returns the number of the tile of a name, brief or not; -1 where there is none.
WEFT_API int weft_tile_name_find(const weft_kernel_tiles *tiles, const struct weft_tile_name *name);

// Writes "(1,2)-/1" of so many dimensions (1 to 3); returns the text.
WEFT_API const char *weft_tile_name_format(const struct weft_tile_name *name, int dims,
                                           char text[WEFT_TILE_NAME_TEXT]);

// Reads "1,2-/1" of so many dimensions at the start of a text: whole numbers to 99999, "+" or "-"
// for one part, "/N" for a piece. Returns where it ends, NULL where it is none.
WEFT_API const char *weft_tile_name_parse(const char *text, int dims, struct weft_tile_name *out);

WEFT_END_DECLS
#endif
