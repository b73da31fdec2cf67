// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/marks.h - what is drawn over the rows of a picture: rectangles, colour ramps, texts.
// They are kept as a list and drawn row by row, so that a picture of any size costs no memory for
// what is around it.
#ifndef WEFT_TOOLS_DRAW_MARKS_H
#define WEFT_TOOLS_DRAW_MARKS_H

#include "tools/draw/text.h"

typedef struct marks marks; // Thread-safety: one thread at a time, but for marks_draw.

// Empty. Returns as text_font_create.
enum weft_result marks_create(marks **out);
void marks_destroy(marks **list);                 // accepts &NULL, leaves NULL behind
void marks_set_width(marks *list, int32_t width); // of rows: what is beyond is cut

// Pixels from x, y on.
void marks_add_rectangle(marks *list, int32_t x, int32_t y, int32_t width, int32_t height,
                         uint8_t grey);
// The map's last colour on top.
void marks_add_ramp(marks *list, int32_t x, int32_t y, int32_t width, int32_t height,
                    const struct weft_colour_map *map);

// A text of that size, from x on, its base line at y.
void marks_add_text(marks *list, int32_t x, int32_t y, int size, uint8_t grey, const char *text);
int marks_text_width(const marks *list, int size, const char *text);

// Whether all of it could be kept; else memory was out, and something is missing.
bool marks_are_whole(const marks *list);

// Draws row y over an RGB row; `list` is a marks. Any number of threads.
void marks_draw(const void *list, int32_t y, uint8_t *rgb);

#endif
