// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/text.h - texts as pixels: by FreeType, in the font that fontconfig has for "DejaVu
// Sans" or, without that, for any text. No shaping: a character is a glyph, from left to right.
#ifndef WEFT_TOOLS_DRAW_TEXT_H
#define WEFT_TOOLS_DRAW_TEXT_H

#include "weft.h"

typedef struct text_font text_font; // Thread-safety: one thread at a time.

// Opens the font. Returns WEFT_ERR_MEMORY after an error line, also where there is none: the
// command fails then as without gnuplot, and no input is at fault.
enum weft_result text_font_create(text_font **out);
void text_font_destroy(text_font **font); // accepts &NULL, leaves NULL behind

// A glyph's pixels: coverage[y * width + x], 255 where all of the pixel is.
struct text_glyph {
    int x, y; // of its first pixel, from the pen, which is on the base line; y grows downwards
    int width, height, stride;
    const uint8_t *coverage; // until the next call
};

// Gives each glyph of a UTF-8 text of `size` pixels an em, with the pen's position from the text's
// start. Returns the width of all; glyph NULL: only that. What has no glyph is a box; bytes that
// are not UTF-8 are question marks.
double text_lay_out(text_font *font, const char *text, int size,
                    void (*glyph)(void *priv, int pen, const struct text_glyph *glyph), void *priv);

#endif
