// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/counts.h - how many frames an effect needs, from what is to be seen in the picture.
// Too few leave copies: an edge that is drawn n times over w pixels is a staircase of n steps, w /
// n pixels apart. Steps of one pixel or less are averaged by the pixels themselves and cannot be
// told apart; nor can steps that are smaller than what the picture tells apart in brightness.
//
// Everything is pure and may be called from any thread. Each function returns 1 at least, and -1
// where a figure is NAN, negative or so large that the count is beyond 2^53.
#ifndef WEFT_PASSES_JITTER_COUNTS_H
#define WEFT_PASSES_JITTER_COUNTS_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// Motion of `pixels` on the screen while the shutter is open: ceil(pixels), so that copies are a
// pixel apart at most. The longest motion of anything in sight decides. Shutters that are not boxes
// leave frames at their ends little weight: the same distance holds for them.
WEFT_API int64_t weft_frames_for_motion(double pixels);

// A circle of confusion `pixels` in diameter: ceil(pi / 4 pixels^2), its area, so that each frame's
// copy of a point, one pixel, has a pixel of the disc to itself: the least that a disc without gaps
// can do. The largest circle in sight decides: weft_camera_circle of the nearest and farthest
// depth.
WEFT_API int64_t weft_frames_for_circle(double pixels);

// A penumbra `pixels` wide, across its edge, of a light whose samples all lie at different places
// along that direction (halton, hammersley, sobol, r2 and the tables do; a grid has only
// sqrt(count) along its sides): ceil(pixels), or where that is less ceil(1 / step), so that no step
// is larger than `step`, as a share of the light. Step: 1 / 255 is that of 8 bits; 0 stands for it.
WEFT_API int64_t weft_frames_for_penumbra(double pixels, double step);

WEFT_END_DECLS
#endif
