// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/marks/marks_impl.h - inside of markers (not installed).
#ifndef WEFT_PASSES_ANTIALIAS_MARKS_MARKS_IMPL_H
#define WEFT_PASSES_ANTIALIAS_MARKS_MARKS_IMPL_H

#include "passes/antialias/drawing/run.h"
#include "passes/antialias/marks/marks.h"
#include "passes/gl/target.h"

struct weft_marker {
    struct weft_marker_params params;
    // The picture of one sample: colours, then surfaces as a second attachment, and depths.
    struct weft_gl_target colours;
    GLuint surfaces, depths;
    // What is marked, with a rim, and how far back an edge may lie that marks.
    struct weft_gl_target marked;
    struct weft_depth_buffer limits;
    GLuint program; // which fills these two; held
    uint64_t bytes;
    // Of 2 and 3 pixels, what GL draws: where it draws less, they are drawn several times, moved.
    float line_width, point_size;
    GLfloat background[4]; // as the format keeps it
    bool drawn;
    // The last picture: what was asked for, what is marked, and what was drawn for that.
    struct weft_rectangle part, found, seen;
    void *picture; // colours of `seen`, 4 a pixel, in the format's own type
};

// A row of `seen` in memory, from 0 on, 4 floats a pixel.
void weft_marker_row(const weft_marker *marker, int32_t y, float *out);

// Whether a pixel of what is marked, from 0 on, is of the part that was asked for.
bool weft_marker_counts(const weft_marker *marker, int32_t x, int32_t y);
// marks->part, or all of the picture.
struct weft_rectangle weft_marks_part(const struct weft_marks *marks);

// Marks what contrast finds and leaves out what is too much, as the params say: marks->count is
// that of marks by edges before. Returns WEFT_ERR_MEMORY.
enum weft_result weft_marks_choose(const weft_marker *marker, struct weft_marks *marks);

#endif
