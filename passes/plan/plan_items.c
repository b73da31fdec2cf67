// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/plan_impl.h"

enum { MAX_WIDTH = WEFT_KERNEL_MAX_WIDTH };

static const struct weft_tap_group empty_group = {.tile = {-1, -1, -1, -1}};

static int signs_of(const struct weft_tap_group *group)
{
    int signs = 0;
    for (int c = 0; c < 4; c++)
        if (group->tile[c] >= 0)
            signs |= group->sign[c] < 0 ? WEFT_PASS_PLAN_SUBTRACTS : WEFT_PASS_PLAN_ADDS;
    return signs;
}

// What the item can reach at most: its tiles' largest values need not meet.
static int32_t largest_of(const struct weft_planner *planner, const struct weft_tap_group *group)
{
    double sum = 0.0;
    for (int c = 0; c < 4; c++) {
        const struct weft_kernel_tile *tile =
            weft_kernel_tiles_get(planner->plan->tiles, group->tile[c]);
        if (tile)
            sum += fmax(fabs(tile->minimum), fabs(tile->maximum)) / planner->unit;
    }
    return sum < INT32_MAX / 2 ? (int32_t)ceil(sum) : INT32_MAX / 2;
}

static enum weft_result make_room(struct weft_planner *planner)
{
    if (planner->item_count < planner->item_room)
        return WEFT_OK;
    const int room = planner->item_room ? 2 * planner->item_room : 64;
    struct weft_pass_plan_item *items = realloc(planner->items, (size_t)room * sizeof *items);
    if (!items) {
        weft_error(planner->p.log, "plan: not enough memory for %d groups of taps", room);
        return WEFT_ERR_MEMORY;
    }
    planner->items = items;
    planner->item_room = room;
    return WEFT_OK;
}

static enum weft_result add_item(struct weft_planner *planner, const struct weft_tap_group *group)
{
    enum weft_result res = make_room(planner);
    if (res == WEFT_OK)
        planner->items[planner->item_count++] = (struct weft_pass_plan_item){
            .group = *group, .signs = signs_of(group), .largest = largest_of(planner, group)};
    return res;
}

// ---- a tile each --------------------------------------------------------------------------------

static void put(struct weft_tap_group *group, int component, const struct weft_kernel_tile *tile,
                int index)
{
    group->tile[component] = index;
    group->sign[component] = tile->negated ? -1 : 1;
}

// Quantisation can leave nothing of small weights.
static bool is_zero(const struct weft_kernel_tile *tile)
{
    return tile->minimum == 0.0 && tile->maximum == 0.0;
}

static enum weft_result make_plain(struct weft_planner *planner)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(planner->plan->tiles);
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < info->tile_count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(planner->plan->tiles, i);
        struct weft_tap_group group = empty_group;
        if (is_zero(tile))
            continue;
        memcpy(group.offset, tile->tap, sizeof group.offset);
        put(&group, 0, tile, i);
        res = add_item(planner, &group);
    }
    return res;
}

// ---- four taps each -----------------------------------------------------------------------------

struct cover {
    int pattern[4][3];
    int count;
    int (*offset)[3]; // of each group, room for one per tap
};

static int tap_number(const struct weft_planner *planner, const int tap[3])
{
    const int w = planner->p.kernel.width;
    for (int a = 0; a < 3; a++)
        if (tap[a] < 0 || tap[a] >= (a < planner->p.dims ? w : 1))
            return -1;
    return (tap[2] * w + tap[1]) * w + tap[0];
}

static int taps_met(const struct weft_planner *planner, const struct cover *cover,
                    const int offset[3], const bool *covered, int number[4])
{
    int met = 0;
    for (int c = 0; c < 4; c++) {
        const int tap[3] = {offset[0] + cover->pattern[c][0], offset[1] + cover->pattern[c][1],
                            offset[2] + cover->pattern[c][2]};
        number[c] = tap_number(planner, tap);
        if (number[c] >= 0 && covered[number[c]])
            number[c] = -1;
        met += number[c] >= 0;
    }
    return met;
}

// The place of the pattern that has the tap in one of its components, and the most others that are
// not covered yet. The source's texel is then never before the first tap.
static void place_pattern(const struct weft_planner *planner, struct cover *cover, const int tap[3],
                          bool *covered)
{
    int best = 0, best_offset[3] = {0}, number[4];
    for (int c = 0; c < 4; c++) {
        const int offset[3] = {tap[0] - cover->pattern[c][0], tap[1] - cover->pattern[c][1],
                               tap[2] - cover->pattern[c][2]};
        if (offset[0] < 0 || offset[1] < 0 || offset[2] < 0)
            continue;
        const int met = taps_met(planner, cover, offset, covered, number);
        if (met > best) {
            best = met;
            memcpy(best_offset, offset, sizeof best_offset);
        }
    }
    taps_met(planner, cover, best_offset, covered, number);
    for (int c = 0; c < 4; c++)
        if (number[c] >= 0)
            covered[number[c]] = true;
    memcpy(cover->offset[cover->count++], best_offset, sizeof best_offset);
}

static void cover_taps(const struct weft_planner *planner, struct cover *cover, bool *covered)
{
    const int w = planner->p.kernel.width, depth = planner->p.dims > 2 ? w : 1;
    memset(covered, 0, (size_t)(w * w * depth) * sizeof *covered);
    cover->count = 0;
    for (int z = 0; z < depth; z++)
        for (int y = 0; y < w; y++)
            for (int x = 0; x < w; x++)
                if (!covered[(z * w + y) * w + x])
                    place_pattern(planner, cover, (int[3]){x, y, z}, covered);
}

// Pattern n of those tried: four in a row along an axis, or two by two along two axes, with all
// strides; false after the last.
static bool pattern_number(const struct weft_planner *planner, int n, int pattern[4][3])
{
    const int dims = planner->p.dims,
              strides = planner->p.kernel.width > 1 ? planner->p.kernel.width - 1 : 1;
    memset(pattern, 0, 4 * sizeof *pattern);
    if (n < dims * strides) {
        for (int c = 0; c < 4; c++)
            pattern[c][n / strides] = c * (n % strides + 1);
        return true;
    }
    n -= dims * strides;
    const int pair = n / (strides * strides), s = n / strides % strides + 1, t = n % strides + 1;
    if (pair >= dims * (dims - 1) / 2)
        return false;
    const int a = pair == 2 ? 1 : 0, b = pair == 0 ? 1 : 2;
    for (int c = 0; c < 4; c++) {
        pattern[c][a] = c & 1 ? s : 0;
        pattern[c][b] = c & 2 ? t : 0;
    }
    return true;
}

static int other_part(const struct weft_planner *planner, const int tap[3],
                      enum weft_tile_part part)
{
    const int tile = weft_kernel_tiles_find(planner->plan->tiles, tap, part);
    return tile >= 0 && !is_zero(weft_kernel_tiles_get(planner->plan->tiles, tile)) ? tile : -1;
}

// The groups of one place of the pattern: those parts of its taps that can go together. Mixed: the
// positive part, or where there is none the negative one, of each tap; then what is left.
static int make_groups(const struct weft_planner *planner, const struct cover *cover, int place,
                       const int number[4], bool mixed, struct weft_tap_group group[2])
{
    static const enum weft_tile_part parts[] = {WEFT_TILE_WHOLE, WEFT_TILE_POSITIVE,
                                                WEFT_TILE_NEGATIVE};
    group[0] = group[1] = empty_group;
    for (int g = 0; g < 2; g++)
        memcpy(group[g].offset, cover->offset[place], sizeof group[g].offset);
    for (int c = 0; c < 4; c++) {
        int tap[3], used = 0;
        for (int a = 0; a < 3; a++)
            tap[a] = cover->offset[place][a] + cover->pattern[c][a];
        for (size_t i = 0; number[c] >= 0 && i < WEFT_COUNT(parts); i++) {
            const int tile = other_part(planner, tap, parts[i]);
            if (tile < 0)
                continue;
            const struct weft_kernel_tile *t = weft_kernel_tiles_get(planner->plan->tiles, tile);
            put(&group[mixed ? used++ : t->negated], c, t, tile);
        }
    }
    return (signs_of(&group[0]) != 0) + (signs_of(&group[1]) != 0);
}

// Adds the items of a cover, or counts them.
static enum weft_result use_cover(struct weft_planner *planner, struct cover *cover, bool mixed,
                                  bool *covered, int *count)
{
    enum weft_result res = WEFT_OK;
    const int taps = planner->plan->info.tap_count;
    memset(covered, 0, (size_t)taps * sizeof *covered);
    *count = 0;
    for (int i = 0; res == WEFT_OK && i < cover->count; i++) {
        struct weft_tap_group group[2];
        int number[4];
        taps_met(planner, cover, cover->offset[i], covered, number);
        for (int c = 0; c < 4; c++)
            if (number[c] >= 0)
                covered[number[c]] = true;
        *count += make_groups(planner, cover, i, number, mixed, group);
        for (int g = 0; planner->plan->list.dot4 && g < 2 && res == WEFT_OK; g++)
            if (signs_of(&group[g]))
                res = add_item(planner, &group[g]);
    }
    return res;
}

static enum weft_result make_dot4(struct weft_planner *planner, bool mixed)
{
    const size_t taps = (size_t)planner->plan->info.tap_count;
    enum weft_result res = WEFT_ERR_MEMORY;
    struct weft_pass_list *list = &planner->plan->list;
    struct cover cover = {.offset = malloc(taps * sizeof *cover.offset)};
    bool *covered = malloc(taps * sizeof *covered);
    int best = -1, fewest = INT32_MAX, count;
    if (!cover.offset || !covered) {
        weft_error(planner->p.log, "plan: not enough memory for %zu taps", taps);
        goto fail;
    }
    list->dot4 = false; // only counted
    for (int n = 0; pattern_number(planner, n, cover.pattern); n++) {
        cover_taps(planner, &cover, covered);
        use_cover(planner, &cover, mixed, covered, &count);
        if (count < fewest) {
            fewest = count;
            best = n;
        }
    }
    list->dot4 = true;
    pattern_number(planner, best, cover.pattern);
    memcpy(list->pattern, cover.pattern, sizeof list->pattern);
    cover_taps(planner, &cover, covered);
    res = use_cover(planner, &cover, mixed, covered, &count);
fail:
    free(cover.offset);
    free(covered);
    return res;
}

enum weft_result weft_planner_make_items(struct weft_planner *planner, bool mixed)
{
    planner->item_count = 0;
    return planner->p.technique == WEFT_TECHNIQUE_DOT4 ? make_dot4(planner, mixed)
                                                       : make_plain(planner);
}

// ---- in two -------------------------------------------------------------------------------------

static int tiles_in(const struct weft_tap_group *group)
{
    int count = 0;
    for (int c = 0; c < 4; c++)
        count += group->tile[c] >= 0;
    return count;
}

// Mixed groups by sign, others every second tap.
static enum weft_result split_group(struct weft_planner *planner, int index)
{
    struct weft_tap_group kept = planner->items[index].group, moved = kept;
    const bool by_sign =
        planner->items[index].signs == (WEFT_PASS_PLAN_ADDS | WEFT_PASS_PLAN_SUBTRACTS);
    for (int c = 0, seen = 0; c < 4; c++) {
        if (kept.tile[c] < 0)
            continue;
        const bool moves = by_sign ? kept.sign[c] < 0 : seen++ % 2;
        struct weft_tap_group *loser = moves ? &kept : &moved;
        loser->tile[c] = -1;
        loser->sign[c] = loser->shift[c] = 0;
    }
    enum weft_result res = add_item(planner, &moved);
    if (res != WEFT_OK)
        return res;
    planner->items[index] = (struct weft_pass_plan_item){
        .group = kept, .signs = signs_of(&kept), .largest = largest_of(planner, &kept)};
    return WEFT_OK;
}

static enum weft_result split_tile(struct weft_planner *planner, int index)
{
    struct weft_pass_plan_item *item = &planner->items[index];
    int c = 0;
    while (item->group.tile[c] < 0)
        c++;
    enum weft_result res = weft_planner_split_tile(planner, item->group.tile[c], NAN);
    if (res != WEFT_OK)
        return res;
    struct weft_tap_group piece = item->group;
    piece.tile[c] = weft_kernel_tiles_get_info(planner->plan->tiles)->tile_count - 1;
    item->largest = largest_of(planner, &item->group);
    return add_item(planner, &piece);
}

bool weft_planner_split_item(struct weft_planner *planner, int item, enum weft_result *res)
{
    const struct weft_pass_plan_item *a = &planner->items[item];
    const bool group = tiles_in(&a->group) > 1;
    // Two values that differ by one step are not worth a pass. Log tiles cannot be split.
    if (!group && (a->largest < 4 || planner->logarithms))
        return false;
    *res = group ? split_group(planner, item) : split_tile(planner, item);
    return *res == WEFT_OK;
}
