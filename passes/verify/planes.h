// SPDX-License-Identifier: BSD-3-Clause
// passes/verify/planes.h - what a prefiltered kernel makes of an image's own samples, without
// coefficients: the truth for images (not installed).
#ifndef WEFT_PASSES_VERIFY_PLANES_H
#define WEFT_PASSES_VERIFY_PLANES_H

#include "passes/verify/verify.h"

// A value of a plane, counted from its first one.
static inline double weft_verify_value(const struct weft_verify_plane *plane, int64_t at)
{
    return plane->type == WEFT_VERIFY_UINT32 ? (double)((const uint32_t *)plane->values)[at]
                                             : (double)((const float *)plane->values)[at];
}

typedef struct weft_cardinal weft_cardinal;

// Of a prefiltered kernel along each of two axes, for `channels` (1 to 4) planes of size[0] x
// size[1] samples with strides, borrowed. Returns WEFT_ERR_ARGUMENT for kernels that have no
// prefilter and WEFT_ERR_MEMORY.
enum weft_result weft_cardinal_create(const struct weft_log *log,
                                      const struct weft_kernel kernel[2], int channels,
                                      const struct weft_verify_plane *planes, const int size[2],
                                      weft_cardinal **out);
void weft_cardinal_destroy(weft_cardinal **cardinal); // accepts &NULL

// The sum over samples at a position, those that are not finite counting as 0; NAN where it is
// missing (weft_prefilter_is_missing; `finite`: whether what it is compared with is there).
// Positions with the same y, one after another, share what they can.
struct weft_reference_value weft_cardinal_compute(weft_cardinal *cardinal, int channel,
                                                  const double position[2], bool finite);

// About how long one takes.
double weft_cardinal_seconds(const weft_cardinal *cardinal);

#endif
