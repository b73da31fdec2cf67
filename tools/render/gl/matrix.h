// SPDX-License-Identifier: BSD-3-Clause
// tools/render/gl/matrix.h - what matrices show, and rounding them for OpenGL; inside of
// tools/render. They are 16 numbers in columns, as passes/jitter/camera.h has them.
#ifndef WEFT_TOOLS_RENDER_GL_MATRIX_H
#define WEFT_TOOLS_RENDER_GL_MATRIX_H

#include <stdbool.h>

// Rounds numbers to floats.
void scene_round(const double *from, float *to, int count);

// The box of an object's triangles, as modelled.
struct scene_extent {
    double low[3], high[3];
};
// Whether a part of it can be within the sides of what a matrix shows, and before its eye.
bool scene_extent_seen(const struct scene_extent *extent, const double clip[16]);

#endif
