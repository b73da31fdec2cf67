// SPDX-License-Identifier: BSD-3-Clause
#include "passes/jitter/counts.h"

#include <math.h>

static int64_t count_up(double frames)
{
    if (!(frames >= 0.0 && frames <= 0x1p53))
        return -1;
    return frames < 1.0 ? 1 : (int64_t)ceil(frames);
}

int64_t weft_frames_for_motion(double pixels)
{
    return count_up(pixels);
}

int64_t weft_frames_for_circle(double pixels)
{
    return pixels >= 0.0 ? count_up(M_PI_4 * pixels * pixels) : -1;
}

int64_t weft_frames_for_penumbra(double pixels, double step)
{
    const double least = step == 0.0 ? 1.0 / 255.0 : step;
    if (!(pixels >= 0.0) || !(least > 0.0))
        return -1;
    // 1 / (1 / 255) is to be 255, whatever rounding makes of it.
    const double steps = 1.0 / least;
    return count_up(fmin(pixels, fabs(steps - rint(steps)) < 1e-9 ? rint(steps) : steps));
}
