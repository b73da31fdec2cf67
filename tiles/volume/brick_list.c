// SPDX-License-Identifier: BSD-3-Clause
// Lists of bricks: their order, and which bricks a region asks for.
#include <stdlib.h>

#include "tiles/volume/region.h"
#include "tiles/volume/volume_impl.h"

int weft_compare_origins(const int32_t a[3], const int32_t b[3])
{
    for (int i = 2; i >= 0; i--)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

bool weft_volume_brick_meets(const struct weft_volume_info *info, const struct weft_region *region,
                             const int32_t origin[3])
{
    int64_t first[3], last[3];
    for (int i = 0; i < 3; i++) {
        first[i] = origin[i];
        last[i] = first[i] + WEFT_BRICK_SIZE - 1;
        if (info->clamp_to_edge && first[i] <= info->active_min[i] && region->min[i] < first[i])
            first[i] = region->min[i];
        if (info->clamp_to_edge && last[i] >= info->active_max[i] && region->max[i] > last[i])
            last[i] = region->max[i];
    }
    return weft_region_meets_box(region, first, last);
}

void weft_brick_list_clear(struct weft_brick_list *list)
{
    if (!list)
        return;
    free(list->brick_origin);
    free(list->tiles);
    *list = (struct weft_brick_list){0};
}
