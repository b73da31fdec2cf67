// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/plan_impl.h"

// How far scaled tiles of a hierarchy go: deep enough for a tri-cubic kernel's corners.
enum { HIERARCHY_SCALE_8 = 128, HIERARCHY_SCALE_16 = 8 };

static enum weft_result make_set(struct weft_planner *planner)
{
    const struct weft_pass_plan_params *p = &planner->p;
    struct weft_kernel_tiles_params *tiles =
        weft_kernel_tiles_params(.kernel = p->kernel, .dims = p->dims, .derivative = p->derivative,
                                 .samples = p->samples, .bits = p->bits,
                                 .memory_bytes = p->memory_bytes, .log = p->log);
    if (planner->logarithms) {
        tiles->format = WEFT_TILE_FLOAT;
        tiles->signs = WEFT_TILE_SEPARATE;
    } else if (planner->real) {
        tiles->format = p->profile.target == WEFT_TARGET_HALF ? WEFT_TILE_HALF : WEFT_TILE_FLOAT;
    } else if (p->technique == WEFT_TECHNIQUE_HIERARCHICAL) {
        tiles->scaling = WEFT_TILE_SCALE_EACH;
        tiles->max_scale =
            p->profile.target == WEFT_TARGET_UNORM16 ? HIERARCHY_SCALE_16 : HIERARCHY_SCALE_8;
    } else {
        tiles->scaling = WEFT_TILE_SCALE_SET;
        tiles->rounding = p->round_singly ? WEFT_TILE_NEAREST : WEFT_TILE_SUM_PRESERVING;
    }
    weft_kernel_tiles_destroy(&planner->plan->tiles);
    planner->plan->info.tile_params = *tiles;
    planner->plan->info.tile_split_count = 0;
    enum weft_result res = weft_kernel_tiles_create(tiles, &planner->plan->tiles);
    planner->plan->list.tiles = planner->plan->tiles;
    return res;
}

static enum weft_result no_such_tile(const struct weft_planner *planner,
                                     const struct weft_tile_name *name)
{
    char text[WEFT_TILE_NAME_TEXT];
    weft_error(planner->p.log, "plan: there is no tile %s of kernel %s",
               weft_tile_name_format(name, planner->p.dims, text), planner->p.kernel.info->name);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_planner_split_tile(struct weft_planner *planner, int tile, double threshold)
{
    struct weft_pass_plan *plan = planner->plan;
    if (plan->info.tile_split_count == plan->split_room) {
        const int room = plan->split_room ? 2 * plan->split_room : 16;
        struct weft_pass_plan_split *splits = realloc(plan->splits, (size_t)room * sizeof *splits);
        if (!splits) {
            weft_error(planner->p.log, "plan: not enough memory for %d splits", room);
            return WEFT_ERR_MEMORY;
        }
        plan->splits = splits;
        plan->split_room = room;
    }
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(plan->tiles, tile);
    const struct weft_pass_plan_split split = {
        .tile = weft_tile_name_of(plan->tiles, tile, false),
        .threshold = isnan(threshold) ? 0.5 * (t->minimum + t->maximum) : threshold};
    enum weft_result res = weft_kernel_tiles_split(plan->tiles, tile, threshold);
    if (res == WEFT_OK)
        plan->splits[plan->info.tile_split_count++] = split;
    return res;
}

static enum weft_result make_given_splits(struct weft_planner *planner)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; res == WEFT_OK && i < planner->p.split_count; i++) {
        const struct weft_pass_plan_split *split = &planner->p.splits[i];
        const int tile = weft_tile_name_find(planner->plan->tiles, &split->tile);
        if (tile < 0)
            return no_such_tile(planner, &split->tile);
        res = weft_planner_split_tile(planner, tile, split->threshold);
        planner->plan->info.split_count++;
    }
    return res;
}

enum weft_result weft_planner_make_tiles(struct weft_planner *planner)
{
    enum weft_result res = make_set(planner);
    planner->plan->info.split_count = 0;
    return res == WEFT_OK ? make_given_splits(planner) : res;
}

// ---- orders that are given ----------------------------------------------------------------------

enum weft_result weft_planner_apply_order(struct weft_planner *planner)
{
    const struct weft_pass_plan_params *p = &planner->p;
    struct weft_pass_plan_item *items = planner->items;
    char text[WEFT_TILE_NAME_TEXT];
    for (size_t n = 0; n < p->tile_order_count; n++) {
        const int tile = weft_tile_name_find(planner->plan->tiles, &p->tile_order[n]);
        int at = 0;
        if (tile < 0)
            return no_such_tile(planner, &p->tile_order[n]);
        while (at < planner->item_count && items[at].group.tile[0] != tile)
            at++;
        if (at < (int)n || at == planner->item_count) {
            weft_error(p->log, "plan: tile %s comes twice",
                       weft_tile_name_format(&p->tile_order[n], p->dims, text));
            return WEFT_ERR_ARGUMENT;
        }
        const struct weft_pass_plan_item moved = items[at];
        items[at] = items[n];
        items[n] = moved;
    }
    if (p->tile_order_count == (size_t)planner->item_count)
        return WEFT_OK;
    const struct weft_tile_name missing =
        weft_tile_name_of(planner->plan->tiles, items[p->tile_order_count].group.tile[0], false);
    weft_error(p->log, "plan: %zu tiles in the order of %d; tile %s is missing",
               p->tile_order_count, planner->item_count,
               weft_tile_name_format(&missing, p->dims, text));
    return WEFT_ERR_ARGUMENT;
}
