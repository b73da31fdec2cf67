// SPDX-License-Identifier: BSD-3-Clause
// tests/support/samples.h - walks over the samples, or taps, of kernel tiles, and single
// voxels of brick stores.
#ifndef WEFT_TESTS_SUPPORT_SAMPLES_H
#define WEFT_TESTS_SUPPORT_SAMPLES_H

#include <stdbool.h>

#include "tiles/volume/brick_store.h"

// The next of count^dims positions, x fastest, from 0 on; false after the last, which is 0 again.
static inline bool next_position(int dims, int count, int at[3])
{
    for (int a = 0; a < dims; a++) {
        if (++at[a] < count)
            return true;
        at[a] = 0;
    }
    return false;
}

// One voxel, anywhere.
static inline float brick_voxel(const weft_brick_store *store, int32_t i, int32_t j, int32_t k)
{
    struct weft_brick_cursor cursor = {.store = store};
    return weft_brick_cursor_voxel(&cursor, i, j, k);
}

#endif
