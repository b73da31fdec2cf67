// SPDX-License-Identifier: BSD-3-Clause
// tiles/region.h - whether a cube of voxels meets a region; the same test in libweft and its readers
// (not installed).
#ifndef WEFT_TILES_REGION_H
#define WEFT_TILES_REGION_H

#include "tiles/volume.h"

WEFT_BEGIN_DECLS

// The cube [origin, origin + size - 1]. Rounding is monotone, so a cube that fails holds no smaller
// cube that would pass: whole nodes can be left out.
static inline bool weft_region_meets(const struct weft_region *region, const int32_t origin[3],
                                     int32_t size)
{
    int64_t last[3];
    for (int i = 0; i < 3; i++) {
        last[i] = (int64_t)origin[i] + size - 1;
        if (last[i] < region->min[i] || origin[i] > region->max[i])
            return false;
    }
    for (int s = 0; s < region->slab_count; s++) {
        const struct weft_slab *slab = &region->slab[s];
        double low = 0, high = 0;
        for (int i = 0; i < 3; i++) {
            double a = slab->normal[i] * (double)origin[i], b = slab->normal[i] * (double)last[i];
            low += a < b ? a : b;
            high += a < b ? b : a;
        }
        if (low > slab->upper || high < slab->lower)
            return false;
    }
    return true;
}

WEFT_END_DECLS
#endif
