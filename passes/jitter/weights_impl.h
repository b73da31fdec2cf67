// SPDX-License-Identifier: BSD-3-Clause
// passes/jitter/weights_impl.h - what every kind of weights begins with (not installed).
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

WEFT_END_DECLS
#endif
