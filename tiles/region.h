// SPDX-License-Identifier: BSD-3-Clause
// tiles/region.h - whether a cube of voxels meets a region; the same test in libweft and its
// readers (not installed).
#ifndef WEFT_TILES_REGION_H
#define WEFT_TILES_REGION_H

#include "tiles/volume.h"

WEFT_BEGIN_DECLS

// The box of voxels [first, last]. Rounding is monotone, so a box that fails holds no smaller box
// that would pass: whole nodes can be left out.
static inline bool weft_region_meets_box(const struct weft_region *region, const int64_t first[3],
                                         const int64_t last[3])
{
    for (int i = 0; i < 3; i++)
        if (last[i] < region->min[i] || first[i] > region->max[i])
            return false;
    for (int s = 0; s < region->slab_count; s++) {
        const struct weft_slab *slab = &region->slab[s];
        double low = 0, high = 0;
        for (int i = 0; i < 3; i++) {
            double a = slab->normal[i] * (double)first[i], b = slab->normal[i] * (double)last[i];
            low += a < b ? a : b;
            high += a < b ? b : a;
        }
        if (low > slab->upper || high < slab->lower)
            return false;
    }
    return true;
}

// The cube [origin, origin + size - 1].
static inline bool weft_region_meets(const struct weft_region *region, const int32_t origin[3],
                                     int32_t size)
{
    int64_t first[3], last[3];
    for (int i = 0; i < 3; i++) {
        first[i] = origin[i];
        last[i] = first[i] + size - 1;
    }
    return weft_region_meets_box(region, first, last);
}

WEFT_END_DECLS
#endif
