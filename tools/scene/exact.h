// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/exact.h - a scene's picture without samples: each pixel is the exact integral of what
// is seen in it, by clipping of polygons in double. What anti-aliasing is measured against.
#ifndef WEFT_TOOLS_SCENE_EXACT_H
#define WEFT_TOOLS_SCENE_EXACT_H

#include "tools/scene/scene.h"

struct scene_exact_params {
    const struct scene *scene; // whose materials are all unlit, without a pattern, with one colour
                               // a triangle (required)
    int size[2];               // of the picture in pixels (required)
    double time;               // of the scene
    struct weft_kernel filter; // of a pixel (default nearest, a box)
    double filter_width;       // pixels that its support is scaled to, up to 16 (default: as it is)
    const struct weft_log *log;           // may be NULL
    const struct weft_progress *progress; // may be NULL
};
#define SCENE_EXACT_DEFAULTS
#define scene_exact_params(...) (&(struct scene_exact_params){SCENE_EXACT_DEFAULTS __VA_ARGS__})

// Writes linear light with associated alpha over the scene's background, out[y][x][4], rows upwards
// as OpenGL's. Every visible part of a triangle counts with its exact shape: triangles are cut
// where they hide one another and where they go through one another, at the near and the far plane;
// of triangles in one place (depths of normalised device coordinates within 1e-13) the first is
// seen. Backs of one-sided materials are not there, fronts emit. *error: of any value, estimated;
// about 1e-13 of the largest colour but for kernels that are not smooth between half integers.
// 4,000 polygons of 50 pixels on 512 x 512 take a second. Returns WEFT_ERR_UNSUPPORTED after a line
// (what is not of one colour; kernels that are radial or prefiltered), WEFT_ERR_ARGUMENT (the
// camera; a width; derivatives), WEFT_ERR_LIMIT (a kernel that reaches more than 8 pixels),
// WEFT_ERR_CANCELLED or WEFT_ERR_MEMORY; `out` is then of no use.
enum weft_result scene_exact_draw(const struct scene_exact_params *params, double *out,
                                  double *error);

#endif
