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

// The tile of a step, -1 if there is none.
static int find_step(const weft_kernel_tiles *tiles, const struct weft_tile_name *step)
{
    const int count = weft_kernel_tiles_get_info(tiles)->tile_count;
    int piece = 0;
    for (int i = 0; i < count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(tiles, i);
        if (memcmp(tile->tap, step->tap, sizeof tile->tap) != 0)
            continue;
        if (step->part != WEFT_TILE_WHOLE && tile->part != step->part)
            continue;
        if (piece++ == step->piece)
            return i;
    }
    return -1;
}

static const char *part_text(enum weft_tile_part part)
{
    return part == WEFT_TILE_POSITIVE ? "+" : part == WEFT_TILE_NEGATIVE ? "-" : "";
}

static enum weft_result no_such_step(const struct weft_planner *planner,
                                     const struct weft_tile_name *step)
{
    weft_error(planner->p.log, "plan: there is no tile (%d,%d,%d)%s piece %d of kernel %s",
               step->tap[0], step->tap[1], step->tap[2], part_text(step->part), step->piece,
               planner->p.kernel.info->name);
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
        .tile = weft_pass_plan_tile_name(plan, tile),
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
        const int tile = find_step(planner->plan->tiles, &split->tile);
        if (tile < 0)
            return no_such_step(planner, &split->tile);
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

enum weft_result weft_planner_apply_steps(struct weft_planner *planner)
{
    const struct weft_pass_plan_params *p = &planner->p;
    struct weft_pass_plan_item *items = planner->items;
    for (size_t n = 0; n < p->step_count; n++) {
        const int tile = find_step(planner->plan->tiles, &p->steps[n]);
        int at = 0;
        if (tile < 0)
            return no_such_step(planner, &p->steps[n]);
        while (at < planner->item_count && items[at].group.tile[0] != tile)
            at++;
        if (at < (int)n || at == planner->item_count) {
            weft_error(p->log, "plan: tile (%d,%d,%d)%s piece %d comes twice", p->steps[n].tap[0],
                       p->steps[n].tap[1], p->steps[n].tap[2], part_text(p->steps[n].part),
                       p->steps[n].piece);
            return WEFT_ERR_ARGUMENT;
        }
        const struct weft_pass_plan_item moved = items[at];
        items[at] = items[n];
        items[n] = moved;
    }
    if (p->step_count == (size_t)planner->item_count)
        return WEFT_OK;
    const struct weft_kernel_tile *missing =
        weft_kernel_tiles_get(planner->plan->tiles, items[p->step_count].group.tile[0]);
    weft_error(p->log, "plan: %zu tiles in the order of %d; tap (%d,%d,%d)%s is missing",
               p->step_count, planner->item_count, missing->tap[0], missing->tap[1],
               missing->tap[2], part_text(missing->part));
    return WEFT_ERR_ARGUMENT;
}
