// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/distribute/cover.h - whether regions cover a picture. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_DISTRIBUTE_COVER_H
#define WEFT_TESTS_PASSES_DISTRIBUTE_COVER_H

#include "passes/distribute/schedule/schedule.h"

// Regions are in rows: each row begins where the last one ended, at x = 0, has regions of its own
// height side by side up to the width, and the last one ends at the height. So every pixel is
// covered once. No side but those at the right and lower ends is below `least`.
static inline void assert_covers(const weft_regions *regions, int32_t width, int32_t height,
                                 int32_t least)
{
    const int64_t count = weft_regions_count(regions);
    int64_t x = 0, y = 0, row_height = 0;
    for (int64_t i = 0; i < count; i++) {
        const struct weft_rectangle r = weft_regions_get(regions, i);
        if (x == 0)
            row_height = r.height;
        if (r.x != x || r.y != y || r.height != row_height || r.width < 1 || r.height < 1 ||
            (r.width < least && r.x + (int64_t)r.width < width) ||
            (r.height < least && r.y + (int64_t)r.height < height))
            fail_msg("region %lld of %lld, %d x %d: %d, %d: %d x %d", (long long)i,
                     (long long)count, width, height, r.x, r.y, r.width, r.height);
        x += r.width;
        if (x == width)
            x = 0, y += r.height;
    }
    assert_int_equal(x, 0);
    assert_int_equal(y, height);
}

#endif
