// SPDX-License-Identifier: BSD-3-Clause
// passes/verify/pixel_error.h - a pixel beside its value in double (not installed).
#ifndef WEFT_PASSES_VERIFY_PIXEL_ERROR_H
#define WEFT_PASSES_VERIFY_PIXEL_ERROR_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

// |pixel - exact|, NAN where one of them is not finite; *mismatch tells that the other is. Where
// `exact` is beyond the range of floats the pixel may be that range's end, or infinite.
static inline double weft_pixel_error(float pixel, double exact, bool *mismatch)
{
    const double nearest = fabs(exact) > FLT_MAX ? copysign(FLT_MAX, exact) : exact;
    const bool overflows = isinf(pixel) && fabs(exact) > FLT_MAX && (pixel > 0.0f) == (exact > 0.0);
    *mismatch = isfinite(pixel) != isfinite(exact) && !overflows;
    return isfinite(pixel) && isfinite(exact) ? fabs((double)pixel - nearest) : NAN;
}

#endif
