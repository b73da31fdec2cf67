// SPDX-License-Identifier: BSD-3-Clause
// filter/statistics.h - what numbers are: their range, how many are not finite, how they change.
// One description of samples, voxels and pixels alike. It grows by whatever is added, in any order
// and any portions, with the same result.
#ifndef WEFT_FILTER_STATISTICS_H
#define WEFT_FILTER_STATISTICS_H

#include <math.h>

#include "base.h"

WEFT_BEGIN_DECLS

// Orders of differences that are kept: enough for kernels of order 4.
enum { WEFT_STATISTICS_DIFFERENCES = 4 };

// Starts as WEFT_STATISTICS_NONE. Thread-safety: one thread at a time may add to a struct.
struct weft_statistics {
    double minimum, maximum; // of the finite values; NAN both while there are none
    uint64_t count;          // values that were added, finite or not
    uint64_t not_finite;     // of those, how many are NAN or infinite
    // Largest |n-th difference| of neighbours in the lines that were added, at index n - 1; 0 while
    // there are none. It stands for the signal's n-th derivative, per sample distance to the n-th
    // power, as far as the signal is sampled well.
    double difference[WEFT_STATISTICS_DIFFERENCES];
};
// The initialiser of a struct to which no values were added yet.
#define WEFT_STATISTICS_NONE                                                                       \
    {                                                                                              \
        .minimum = NAN, .maximum = NAN                                                             \
    }

// Adds `count` values to the range and to the counts; leaves the differences alone.
WEFT_API void weft_statistics_add(struct weft_statistics *statistics, const float *values,
                                  size_t count);

// Adds all that was added to another struct, differences too.
WEFT_API void weft_statistics_join(struct weft_statistics *statistics,
                                   const struct weft_statistics *other);

// Adds the differences of neighbours in a line of `count` values that lie `stride` floats apart;
// those that take in a value that is not finite do not count. Leaves range and counts alone.
WEFT_API void weft_statistics_add_differences(struct weft_statistics *statistics,
                                              const float *values, size_t count, size_t stride);

// A plane of values: [y * stride + x].
struct weft_statistics_plane {
    const float *values;
    size_t width, height, stride;
};

// Returns the largest |n-th difference| of neighbours along rows, and along columns, of those that
// begin in rows `from` to `to`, exclusive; n from 1 to WEFT_STATISTICS_DIFFERENCES, or the result
// is 0. Those that take in a value that is not finite do not count; 0 where there are none. Pure
// and thread-safe.
WEFT_API double weft_statistics_plane_difference(const struct weft_statistics_plane *plane, int n,
                                                 size_t from, size_t to);

// Returns the larger of |minimum| and |maximum|; 0 where there are no finite values.
WEFT_API double weft_statistics_magnitude(const struct weft_statistics *statistics);

WEFT_END_DECLS
#endif
