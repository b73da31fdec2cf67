// SPDX-License-Identifier: BSD-3-Clause
// filter/boundary.h - what holds beyond the samples: one rule for images, lattices and prefilters.
// Pure functions, thread-safe.
#ifndef WEFT_FILTER_BOUNDARY_H
#define WEFT_FILTER_BOUNDARY_H

#include "base.h"

WEFT_BEGIN_DECLS

// Names are those of the command line; samples are a b c d.
enum weft_boundary {
    WEFT_BOUNDARY_CLAMP,  // the nearest sample: a a a|a b c d|d d d (the default)
    WEFT_BOUNDARY_MIRROR, // mirrored at the first and at the last sample: d c b|a b c d|c b a
    WEFT_BOUNDARY_WRAP,   // periodic: b c d|a b c d|a b c
    WEFT_BOUNDARY_BORDER, // one value, which stands beside this in params
    WEFT_BOUNDARY_COUNT
};
// NULL-ended, in the order of the enum: "clamp", "mirror", "wrap", "border".
WEFT_API extern const char *const weft_boundary_names[];

// Returns the sample, 0 to size - 1, that stands at an index, whatever the index is; -1 where the
// border's value does, for an unknown boundary and where there are no samples. One sample is
// mirrored into itself.
WEFT_API int64_t weft_boundary_index(enum weft_boundary boundary, int64_t index, int64_t size);

WEFT_END_DECLS
#endif
