// SPDX-License-Identifier: BSD-3-Clause
// What tiles are called, whatever their numbers in a set.
#include <string.h>

#include "passes/plan/plan_impl.h"

struct weft_tile_name weft_pass_plan_tile_name(const weft_pass_plan *plan, int tile)
{
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(plan->tiles, tile);
    if (!t)
        return (struct weft_tile_name){{-1, -1, -1}, WEFT_TILE_WHOLE, -1};
    struct weft_tile_name name = {.part = t->part};
    memcpy(name.tap, t->tap, sizeof name.tap);
    for (int i = 0; i < tile; i++) {
        const struct weft_kernel_tile *other = weft_kernel_tiles_get(plan->tiles, i);
        name.piece += other->part == t->part && memcmp(other->tap, t->tap, sizeof t->tap) == 0;
    }
    return name;
}
