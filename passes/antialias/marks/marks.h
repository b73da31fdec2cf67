// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/marks/marks.h - which pixels of a picture have an edge in them, for adaptive
// supersampling: Lin, Lau, Lin, Cheung, "A Parallel Rendering Approach to the Adaptive
// Supersampling Method", 1997.
//
// A picture of one sample is drawn first, with each pixel's surface, depth and slope of depth. A
// pixel is marked where lines of two pixels' width along the edges, or points at their ends, pass
// that are not certainly behind what it shows; and where a neighbour shows another surface that may
// intersect its own. In a pixel that is not marked one surface, and no other, is seen: marks.c says
// under which conditions that is certain.
#ifndef WEFT_PASSES_ANTIALIAS_MARKS_MARKS_H
#define WEFT_PASSES_ANTIALIAS_MARKS_MARKS_H

#include "../drawing/drawing.h"
#include "../pattern/bytes.h"

WEFT_BEGIN_DECLS

// Which edges count. Default: complete.
enum weft_mark {
    WEFT_MARK_COMPLETE, // all that can be in sight in any part of a pixel: no mixed pixel is missed
    WEFT_MARK_VISIBLE,  // those whose lines and points are in front of what the pixel shows in its
                        // middle: fewer marks, and some edges of less than a pixel are missed
    WEFT_MARK_COUNT
};
// NULL-ended, in the order of the enum: "complete", "visible".
WEFT_API extern const char *const weft_mark_names[];

struct weft_marker_params {
    int32_t width, height;             // of the picture, each > 0 (required)
    enum weft_antialias_format format; // of colours (default 8 bits)
    enum weft_mark mark;               // default complete
    // Shading edges: pixels are marked, too, whose largest |difference| of a component to one of
    // the 3 x 3 neighbours is above it (default 0: none are).
    double contrast;
    // Largest share of pixels that are marked (default 0: any). If more were, those with the
    // largest difference stay, of equal ones those that come first, row by row from the lowest.
    // Which those are is known of the whole picture only: parts of it are not marked.
    double max_share;
    // Of parts of the picture: pixels around them that marks are found for, too, 0 to
    // WEFT_MARKS_MAX_RADIUS: the radius of a filter, by which they are dilated (default 0).
    int reach;
    double background[4];       // linear, associated alpha
    weft_context *context;      // borrowed for the object's life (required)
    const struct weft_log *log; // likewise; may be NULL
};
#define WEFT_MARKER_DEFAULTS
#define weft_marker_params(...) (&(struct weft_marker_params){WEFT_MARKER_DEFAULTS __VA_ARGS__})

// Thread-safety: one thread at a time, with its context.
typedef struct weft_marker weft_marker;

// On failure *out is NULL. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT, WEFT_ERR_MEMORY or
// WEFT_ERR_GL.
WEFT_API enum weft_result weft_marker_create(const struct weft_marker_params *params,
                                             weft_marker **out);
WEFT_API void weft_marker_destroy(weft_marker **marker); // accepts &NULL, leaves NULL behind

// Marks. All zero: none.
struct weft_marks {
    int32_t width, height;      // of the picture
    struct weft_rectangle part; // of it, that is marked (all 0: all of it)
    uint8_t *marked;            // [y][x] of the part, rows upwards: 1 or 0; owned
    // Pixels without those that params.reach adds around what was drawn:
    int64_t count;       // of those that are 1
    int64_t by_edges;    // found by surfaces, lines and points, before max_share
    int64_t by_contrast; // found by contrast alone, likewise
    int64_t left;        // that max_share left out
    // What these may be wrong by, estimated: the root of the mean over all pixels of the left ones'
    // (difference^2 / 12), as if an edge of that contrast lay anywhere in them. Where they
    // show less than an edge through the whole pixel, it is too much: 1.4 times of random
    // triangles.
    double left_error;
};
WEFT_API void weft_marks_clear(struct weft_marks *marks); // accepts NULL, leaves zeros behind

// Draws the picture of one sample and its lines and points, and marks: passes of stage colour,
// lines and points. Of a part of the picture the marks have params.reach pixels around it, as far
// as these are within the picture. On failure *out is all zero. Returns WEFT_ERR_ARGUMENT (nothing
// to draw, a part), WEFT_ERR_UNSUPPORTED (a part and max_share), what `draw` returned,
// WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_marker_run(weft_marker *marker,
                                          const struct weft_antialias_drawing *drawing,
                                          struct weft_marks *out);

// Writes a channel (0 to 3) of the last picture of one sample, or of the part that was drawn, out[y
// * stride + x], rows upwards; stride 0: its width. Returns WEFT_ERR_ARGUMENT (no picture, a
// channel, a stride) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_marker_read(const weft_marker *marker, int channel, float *out,
                                           size_t stride);
WEFT_API uint64_t weft_marker_bytes(const weft_marker *marker); // of all that GL holds for it

enum { WEFT_MARKS_MAX_RADIUS = 64 };
// Marks all pixels of the part within `radius` (0 to WEFT_MARKS_MAX_RADIUS) of a marked one along
// both axes, and counts all that are marked.
// Returns WEFT_ERR_ARGUMENT (a radius; no marks) or WEFT_ERR_MEMORY; the marks are then as before.
WEFT_API enum weft_result weft_marks_dilate(struct weft_marks *marks, int radius);

WEFT_END_DECLS
#endif
