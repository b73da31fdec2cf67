// SPDX-License-Identifier: BSD-3-Clause
#include <string.h>

#include "passes/antialias/drawing/run.h"
#include "passes/jitter/camera.h"

// Clip coordinates of the picture, -1 to 1 over its own pixels, shrink to the middle of the larger
// target; a move of one pixel is 2 / size of it.
void weft_drawing_place(int32_t width, int32_t height, int rim, const double sample[2],
                        double out[16])
{
    const double size[2] = {(double)width + 2.0 * rim, (double)height + 2.0 * rim};
    double move[2];
    weft_camera_move_to(sample, move);
    memset(out, 0, 16 * sizeof *out);
    out[0] = (double)width / size[0];
    out[5] = (double)height / size[1];
    out[10] = 1.0;
    out[12] = 2.0 * move[0] / size[0] + 0.0; // no -0
    out[13] = 2.0 * move[1] / size[1] + 0.0;
    out[15] = 1.0;
}
