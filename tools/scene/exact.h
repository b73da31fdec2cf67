// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/exact.h - a scene's picture without samples: each pixel is the exact integral of what
// is seen in it, by clipping of polygons in double. What anti-aliasing is measured against.
#ifndef WEFT_TOOLS_SCENE_EXACT_H
#define WEFT_TOOLS_SCENE_EXACT_H

#include "tools/scene/scene.h"

struct scene_exact_params {
    const struct scene *scene;  // whose materials are all unlit, without a pattern, with one colour
                                // a triangle (required)
    int size[2];                // of the picture in pixels (required)
    double time;                // of the scene
    struct weft_kernel filter;  // of a pixel (default nearest, a box)
    double filter_width;        // pixels that its support is scaled to (default: as it is)
    const struct weft_log *log; // may be NULL
    const struct weft_progress *progress; // may be NULL
};
#define SCENE_EXACT_DEFAULTS
#define scene_exact_params(...) (&(struct scene_exact_params){SCENE_EXACT_DEFAULTS __VA_ARGS__})

// Writes linear light with associated alpha over the scene's background, out[y][x][4], rows upwards
// as OpenGL's. *error: of any value, estimated. Returns WEFT_ERR_UNSUPPORTED after a line (what is
// not of one colour; kernels that are radial or prefiltered), WEFT_ERR_ARGUMENT,
// WEFT_ERR_CANCELLED or WEFT_ERR_MEMORY.
enum weft_result scene_exact_draw(const struct scene_exact_params *params, double *out,
                                  double *error);

#endif
