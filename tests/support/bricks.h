// SPDX-License-Identifier: BSD-3-Clause
// tests/support/bricks.h - single voxels of brick stores.
#ifndef WEFT_TESTS_SUPPORT_BRICKS_H
#define WEFT_TESTS_SUPPORT_BRICKS_H

#include "tiles/volume/brick_store.h"

static inline float brick_voxel(const weft_brick_store *store, int32_t i, int32_t j, int32_t k)
{
    struct weft_brick_cursor cursor = {.store = store};
    return weft_brick_cursor_voxel(&cursor, i, j, k);
}

#endif
