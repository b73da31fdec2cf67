// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/colour_tables.h - the published colours that maps are made of (not installed).
#ifndef WEFT_TILES_IMAGE_COLOUR_TABLES_H
#define WEFT_TILES_IMAGE_COLOUR_TABLES_H

#include <stdint.h>

enum { WEFT_COLOURS = 256, WEFT_COLOURS_COOL_WARM = 33 };

// From the first colour to the last, evenly spaced; 0xrrggbb.
extern const uint32_t weft_colours_viridis[WEFT_COLOURS], weft_colours_magma[WEFT_COLOURS],
    weft_colours_cividis[WEFT_COLOURS], weft_colours_turbo[WEFT_COLOURS],
    weft_colours_cool_warm[WEFT_COLOURS_COOL_WARM];

#endif
