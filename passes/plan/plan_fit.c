// SPDX-License-Identifier: BSD-3-Clause
// Scale, bias and order of a plan, so that its sums fit into the target.
#include <math.h>
#include <stdlib.h>

#include "passes/plan/plan_impl.h"

enum { MAX_SPLITS = 16 };

// ---- units --------------------------------------------------------------------------------------

enum weft_result weft_planner_make_log_table(struct weft_planner *planner, double scale)
{
    struct weft_pass_list *list = &planner->plan->list;
    const int full = planner->full;
    const double one = (double)full * (1 << list->extra_bits) * scale;
    if (!planner->plan->log_table)
        planner->plan->log_table = malloc((2 * (size_t)full + 1) * sizeof(uint32_t));
    if (!planner->plan->log_table) {
        weft_error(planner->p.log, "plan: not enough memory for a table of %d logarithms", full);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i <= 2 * full; i++)
        planner->plan->log_table[i] =
            (uint32_t)round(one * exp2(-i * list->log_octaves / (full - 1)));
    list->log_table = planner->plan->log_table;
    return WEFT_OK;
}

// Value 1 of a tile in weight, and what a target holds. Tiles of a hierarchy have scales of their
// own, and the largest one's unit.
static void set_units(struct weft_planner *planner)
{
    const weft_kernel_tiles *tiles = planner->plan->tiles;
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(tiles);
    double scale = 0.0;
    for (int i = 0; i < info->tile_count; i++)
        scale = fmax(scale, weft_kernel_tiles_get(tiles, i)->scale);
    planner->unit = 1.0 / (info->one * scale);
    if (planner->logarithms)
        planner->unit = 1.0 / ((double)planner->full * (1 << planner->plan->list.extra_bits));
    if (planner->real)
        planner->unit = 1.0;
}

static void shift_items(struct weft_planner *planner)
{
    const weft_kernel_tiles *tiles = planner->plan->tiles;
    const double one = weft_kernel_tiles_get_info(tiles)->one;
    for (int i = 0; i < planner->item_count; i++)
        for (int c = 0; c < 4; c++) {
            struct weft_tap_group *group = &planner->items[i].group;
            const struct weft_kernel_tile *tile = weft_kernel_tiles_get(tiles, group->tile[c]);
            if (tile)
                group->shift[c] = (int)lround(-log2(planner->unit * one * tile->scale));
        }
}

static int64_t most_of(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t common_divisor(int64_t a, int64_t b)
{
    return b ? common_divisor(b, a % b) : a;
}

// The least divisor from this one on that leaves room for sums from -down to up. Biases are whole
// codes; with 16 bits they come in steps, so that the search has whole numbers of 32 bits.
static void set_bias(struct weft_planner *planner, int64_t divisor, int64_t down, int64_t up)
{
    const int64_t full = planner->full, unit = full == 255 ? 1 : 255;
    for (divisor = (divisor + unit - 1) / unit * unit;; divisor += unit) {
        const int64_t step = full == 255 ? 1 : full / common_divisor(divisor, full);
        const int64_t bias = ((down * full + divisor - 1) / divisor + step - 1) / step * step;
        planner->divisor = (int32_t)divisor;
        planner->bias = (int32_t)bias;
        planner->bias_step = (int32_t)step;
        if (up * full <= (full - bias) * divisor)
            return;
    }
}

// Scale and bias for sums as they are, with so much of the range to spare, INFINITY: as much as any
// order needs. Derivatives are stored as 0.5 + 0.5 g (section 5), with less than 0.5 where their
// weights need it.
static void set_scale(struct weft_planner *planner, const struct weft_pass_plan_sums *sums,
                      double spare)
{
    const bool any = planner->p.worst_case == WEFT_WORST_ANY || isinf(spare);
    const int64_t one = llround(1.0 / planner->unit);
    // Scaled logarithms are rounded anew.
    const int64_t rounding = planner->logarithms ? planner->item_count : 0;
    int64_t up = any ? sums->positive : most_of(sums->most, 0);
    int64_t down = any ? sums->negative : most_of(-(int64_t)sums->least, 0);
    up += up > one - rounding ? rounding : 0;
    down += down ? rounding : 0;
    const double room = isinf(spare) ? 0.0 : ceil(spare * (double)one);
    planner->bias = 0;
    planner->bias_step = 1;
    if (planner->real || planner->p.order > WEFT_ORDER_GREEDY || planner->p.no_scale) {
        planner->divisor = (int32_t)one;
        if (planner->derives && !planner->real)
            set_bias(planner, 2 * one, one, one);
        return;
    }
    if (planner->derives) {
        const int64_t side = most_of(one, most_of(up, down)) + (int64_t)room;
        set_bias(planner, 2 * side, side, side);
    } else if (down > 0 || room > 0.0) {
        const int64_t half = (int64_t)room / 2;
        set_bias(planner, most_of(one, up + down), down + half, up + (int64_t)room - half);
    } else {
        planner->divisor = (int32_t)most_of(one, up);
    }
}

// Entries of the log table carry the scale, so that a target is full at T.
static enum weft_result scale_log_table(struct weft_planner *planner)
{
    const double one = 1.0 / planner->unit;
    planner->log_scale = one / planner->divisor;
    planner->divisor = (int32_t)one;
    return weft_planner_make_log_table(planner, planner->log_scale);
}

// ---- finding an order ---------------------------------------------------------------------------

static bool negative_weights(const struct weft_planner *planner)
{
    const weft_kernel_tiles *tiles = planner->plan->tiles;
    for (int i = 0; i < weft_kernel_tiles_get_info(tiles)->tile_count; i++)
        if (weft_kernel_tiles_get(tiles, i)->minimum < 0.0)
            return true;
    return false;
}

// Whether a pass may hold both signs: only by reading what it adds to.
static bool mixes_signs(const struct weft_planner *planner)
{
    const struct weft_pass_plan_params *p = &planner->p;
    return !planner->real && p->profile.ping_pong && !p->blend_only && negative_weights(planner) &&
           (p->taps_per_pass > 1 || p->technique == WEFT_TECHNIQUE_DOT4);
}

enum weft_result weft_planner_prepare(struct weft_planner *planner, double spare)
{
    struct weft_pass_plan_sums sums = {0};
    enum weft_result res = weft_planner_make_tiles(planner);
    if (res != WEFT_OK)
        return res;
    set_units(planner);
    if (planner->logarithms)
        res = weft_planner_make_log_table(planner, 1.0);
    if (res == WEFT_OK)
        res = weft_planner_make_items(planner, mixes_signs(planner) || planner->real);
    if (res != WEFT_OK)
        return res;
    if (planner->p.technique == WEFT_TECHNIQUE_HIERARCHICAL)
        shift_items(planner);
    if (!planner->real)
        res = weft_planner_sums(planner, &sums);
    if (res != WEFT_OK)
        return res;
    set_scale(planner, &sums, spare);
    return planner->logarithms ? scale_log_table(planner) : WEFT_OK;
}

// Splits what could not be placed; returns how many splits there were.
static int split_stuck(struct weft_planner *planner, const struct weft_pass_plan_order *order,
                       int placed, int most, enum weft_result *res)
{
    int splits = 0;
    for (int i = placed; *res == WEFT_OK && i < order->item_count && splits < most; i++)
        splits += weft_planner_split_item(planner, order->item[i], res);
    planner->plan->info.split_count += splits;
    return splits;
}

// Tries with splits, up to so many; at first with a wide search, perhaps. *found: an order was.
static enum weft_result order_items(struct weft_planner *planner, int splits, bool wide,
                                    struct weft_pass_plan_order *order, bool *found)
{
    for (;;) {
        int placed = 0;
        weft_pass_plan_order_destroy(order);
        enum weft_result res =
            weft_pass_plan_order_create(planner->p.log, planner->item_count, order);
        if (res == WEFT_OK)
            res = weft_planner_order(planner, mixes_signs(planner) || planner->real, wide, order,
                                     &placed);
        *found = placed == order->item_count;
        if (res != WEFT_OK || *found)
            return res;
        const int made = split_stuck(planner, order, placed, splits, &res);
        if (res != WEFT_OK || !made)
            return res;
        splits -= made;
    }
}

static enum weft_result no_order(const struct weft_planner *planner)
{
    struct weft_pass_plan_sums sums = {0};
    const double one = 1.0 / planner->unit;
    enum weft_result res = weft_planner_sums(planner, &sums);
    if (res != WEFT_OK)
        return res;
    if (sums.most > planner->divisor)
        weft_error(planner->p.log,
                   "plan: no order of passes helps: the weights at a sample position add up to "
                   "%.6g (%d/%.0f) where 1.0 is full",
                   sums.most / one, sums.most, one);
    else
        weft_error(planner->p.log,
                   "plan: no order of %d groups of taps was found that stays within [0, 1]",
                   planner->item_count);
    return WEFT_ERR_UNSUPPORTED;
}

// Orders first, then splits, then less and less of the range.
static enum weft_result find_order(struct weft_planner *planner, struct weft_pass_plan_order *order)
{
    static const double spares[] = {0.0,  0.008, 0.016, 0.03, 0.0625, 0.125,
                                    0.25, 0.5,   1.0,   2.0,  4.0,    INFINITY};
    // Passes of four taps, and of derivatives, are saved by a little of the range.
    const bool scales =
        !planner->p.no_scale && (planner->p.technique == WEFT_TECHNIQUE_DOT4 || planner->derives);
    const bool splits = !planner->p.no_splits && !scales;
    bool found = false;
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < WEFT_COUNT(spares); i++) {
        if (i)
            res = weft_planner_prepare(planner, spares[i]);
        if (res == WEFT_OK)
            res = order_items(planner, splits && i == 0 ? MAX_SPLITS : 0, i == 0, order, &found);
        if (res != WEFT_OK || found)
            return res;
        if (planner->p.no_scale)
            break;
    }
    return no_order(planner);
}

enum weft_result weft_planner_fit(struct weft_planner *planner, struct weft_pass_plan_order *order)
{
    if (planner->p.order == WEFT_ORDER_PLANNED && !planner->real)
        return find_order(planner, order);
    bool found; // or not: the simulator will tell
    enum weft_result res = WEFT_OK;
    if (planner->p.order == WEFT_ORDER_GIVEN)
        res = weft_planner_apply_order(planner);
    return res == WEFT_OK ? order_items(planner, 0, false, order, &found) : res;
}
