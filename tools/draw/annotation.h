// SPDX-License-Identifier: BSD-3-Clause
// tools/draw/annotation.h - what --annotate puts around a preview: title and caption, a legend of
// its colours, what lies along its edges, and a scale bar. All is outside of the picture, whose
// pixels stay as they are, and grows with it.
#ifndef WEFT_TOOLS_DRAW_ANNOTATION_H
#define WEFT_TOOLS_DRAW_ANNOTATION_H

#include "tools/draw/marks.h"

// Coordinates from a picture's left edge to its right one, or from its upper to its lower one.
struct annotation_axis {
    char name[32]; // "x"; "": nothing is told
    double start, end;
};

enum { ANNOTATION_TEXT = 400 };

// All zero: nothing but a margin.
struct annotation {
    char title[ANNOTATION_TEXT], caption[ANNOTATION_TEXT]; // cut where there is no room
    // With a legend.
    const struct weft_colour_map *colour_map; // NULL: there is none
    double low, high;                         // values of its first and last colour
    char quantity[64];                        // what they are of
    struct annotation_axis across, down;
    double length; // of the picture's width, for the scale bar; 0: there is none
    char unit[32]; // of that
};

// Lays it out around a picture. *frame draws *list, which is to be destroyed after it. Returns as
// text_font_create; on failure *list is NULL.
enum weft_result annotation_create(const struct annotation *annotation, int32_t width,
                                   int32_t height, marks **list, struct weft_preview_frame *frame);

#endif
