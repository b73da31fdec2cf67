// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/region.h - whether a cube of voxels meets a region; the same test in libweft and its
// readers (not installed).
#ifndef WEFT_TILES_VOLUME_REGION_H
#define WEFT_TILES_VOLUME_REGION_H

#include "tiles/volume/volume.h"

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

// What meets a region after moving by up to `voxels` along every axis meets the widened one.
static inline struct weft_region weft_region_widen(const struct weft_region *region, int voxels)
{
    struct weft_region out = *region;
    for (int i = 0; i < 3; i++) {
        out.min[i] = region->min[i] > -WEFT_INDEX_LIMIT + voxels ? region->min[i] - voxels
                                                                 : -WEFT_INDEX_LIMIT;
        out.max[i] =
            region->max[i] < WEFT_INDEX_LIMIT - voxels ? region->max[i] + voxels : WEFT_INDEX_LIMIT;
    }
    for (int s = 0; s < out.slab_count; s++) {
        const double *n = out.slab[s].normal;
        const double margin = voxels * (fabs(n[0]) + fabs(n[1]) + fabs(n[2]));
        out.slab[s].lower -= margin;
        out.slab[s].upper += margin;
    }
    return out;
}

WEFT_END_DECLS
#endif
