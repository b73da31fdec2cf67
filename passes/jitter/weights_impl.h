// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/weights_impl.h - what kinds of weights have in common (not installed).
#ifndef WEFT_PASSES_JITTER_WEIGHTS_IMPL_H
#define WEFT_PASSES_JITTER_WEIGHTS_IMPL_H

#include "passes/jitter/weights.h"

WEFT_BEGIN_DECLS

// What a report is before there are weights.
#define WEFT_WEIGHTS_NONE                                                                          \
    (struct weft_weights_report)                                                                   \
    {                                                                                              \
        NAN, NAN, NAN, NAN, NAN, 0                                                                 \
    }

// Checks a pixel's filter and makes it nearest where it is all zero; *scale: what its support is
// scaled by to be `width` pixels (0: 1). On failure *scale is as before. Returns what
// weft_weights_kernel does of both, with a line in the log.
enum weft_result weft_weights_resolve(const struct weft_log *log, double width,
                                      struct weft_kernel *kernel, double *scale);

WEFT_END_DECLS
#endif
