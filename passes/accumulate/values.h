// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/values.h - what the values of frames are checked for, and where they lie in
// the range of a target of codes (not installed).
#ifndef WEFT_PASSES_ACCUMULATE_VALUES_H
#define WEFT_PASSES_ACCUMULATE_VALUES_H

#include "passes/accumulate/accumulate_impl.h"

WEFT_BEGIN_DECLS

// What values may be.
struct weft_value_limits {
    double low, high;
};
// Checks a frame that lies in memory, on params.cpu.threads: values beyond the limits (NULL: none)
// are refused, and so are those that are not finite, unless params.nonfinite is to propagate. What
// is not finite counts in a->nonfinite, unless a->scan has counted it. *largest (may be NULL) is
// the largest |finite value|, or 1 where codes need no check. Returns WEFT_ERR_FORMAT: the log
// names the first such value's frame, channel, pixel and itself.
enum weft_result weft_frame_check(weft_accumulator *a, const struct weft_plane *planes,
                                  const struct weft_value_limits *limits, double *largest);

// The place t of a value v in params.low to params.high: t = (v - low) * scale, both operations
// and both numbers in single precision, as shaders do it; t = v for 0 to 1.
struct weft_value_range {
    float low, scale;
    bool whole;    // 0 to 1
    double size;   // high - low
    double error;  // of |t - exact|, for v in the range
    double extent; // largest |v| in the range
};
struct weft_value_range weft_value_range_of(const struct weft_accumulator_params *params);
// v to t, in place.
void weft_value_range_apply(const struct weft_value_range *range, float *values, size_t count);

WEFT_END_DECLS
#endif
