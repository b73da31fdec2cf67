// SPDX-License-Identifier: BSD-3-Clause
// Hierarchical summation (WSCG 2003, section 3.2): tiles of like size are summed in a target of
// their own, multiplied by 2^level so that they use its range, and a rounding there counts 2^-level
// of one at the end. Each target has weights of one sign, so that nothing in it needs an order.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/accumulate/tree/tree.h"
#include "passes/plan/plan_impl.h"

enum {
    CHUNK = WEFT_PLANNER_CHUNK,
    MAX_LEAVES = 16,
    SAMPLED = 600,
    LEAST_LEVEL = -8,
    MAX_UNITS = 4096
};

// Items in a row of planner->items that share a target.
struct leaf {
    int first, count;
    bool subtracts;
    int level;
};

struct hierarchy {
    struct weft_planner *planner;
    int leaf_count;
    struct leaf leaf[MAX_LEAVES];
    int64_t full;   // values that fill a group's target
    int most_level; // the largest scale of a tile: divisors stay whole numbers
    size_t sampled;
    int32_t *value; // [item][sampled]
};

static void sort_items(struct weft_planner *planner)
{
    struct weft_pass_plan_item *items = planner->items;
    for (int i = 1; i < planner->item_count; i++) {
        const struct weft_pass_plan_item moved = items[i];
        int j = i;
        for (;
             j > 0 && (items[j - 1].signs > moved.signs ||
                       (items[j - 1].signs == moved.signs && items[j - 1].largest < moved.largest));
             j--)
            items[j] = items[j - 1];
        items[j] = moved;
    }
}

// Rounded up.
static int64_t scaled(int64_t value, int level)
{
    return level < 0 ? (value + (INT64_C(1) << -level) - 1) >> -level : value << level;
}

static int level_of(const struct hierarchy *h, int64_t largest)
{
    int level = LEAST_LEVEL;
    while (largest > 0 && scaled(largest, level + 1) <= h->full && level < h->most_level)
        level++;
    return level;
}

// Of the sums of some items, at the sampled positions.
static int32_t largest_sum(const struct hierarchy *h, int first, int count)
{
    int32_t largest = 0;
    for (size_t k = 0; k < h->sampled; k++) {
        int32_t sum = 0;
        for (int i = first; i < first + count; i++)
            sum += h->value[(size_t)i * h->sampled + k];
        sum = abs(sum);
        largest = sum > largest ? sum : largest;
    }
    return largest;
}

// Half a code for each pass, as it counts in the end.
static double cost_of(const struct hierarchy *h, int first, int count)
{
    const int taps = h->planner->p.taps_per_pass;
    return 0.5 * ((count + taps - 1) / taps) * exp2(-level_of(h, largest_sum(h, first, count)));
}

// A leaf in several: at one place, or in parts of like size.
struct cut {
    int leaf, parts, at;
    double gain; // of cost, for each leaf more
};

static int part_end(const struct leaf *leaf, const struct cut *cut, int part)
{
    return cut->at && part == 0 ? cut->at : leaf->count * (part + 1) / cut->parts;
}

static void try_cut(const struct hierarchy *h, struct cut cut, struct cut *best)
{
    const struct leaf *leaf = &h->leaf[cut.leaf];
    cut.gain = cost_of(h, leaf->first, leaf->count);
    for (int part = 0, first = 0; part < cut.parts; first = part_end(leaf, &cut, part++))
        cut.gain -= cost_of(h, leaf->first + first, part_end(leaf, &cut, part) - first);
    cut.gain /= cut.parts - 1;
    if (cut.gain > best->gain)
        *best = cut;
}

static void apply_cut(struct hierarchy *h, const struct cut *cut)
{
    struct leaf *old = &h->leaf[cut->leaf];
    const struct leaf whole = *old;
    memmove(old + cut->parts, old + 1, (size_t)(h->leaf_count - cut->leaf - 1) * sizeof *old);
    h->leaf_count += cut->parts - 1;
    for (int part = 0, first = 0; part < cut->parts; first = part_end(&whole, cut, part++)) {
        old[part] = whole;
        old[part].first = whole.first + first;
        old[part].count = part_end(&whole, cut, part) - first;
    }
}

// Cuts as long as each leaf more saves a sixteenth of a code.
static void cut_leaves(struct hierarchy *h, int most)
{
    for (;;) {
        struct cut best = {.gain = 0.0625};
        for (int i = 0; i < h->leaf_count; i++) {
            const int count = h->leaf[i].count;
            for (int at = 1; h->leaf_count < most && at < count; at++)
                try_cut(h, (struct cut){i, 2, at, 0.0}, &best);
            for (int parts = 3; h->leaf_count + parts - 1 <= most && parts <= count; parts++)
                try_cut(h, (struct cut){i, parts, 0, 0.0}, &best);
        }
        if (!best.parts)
            return;
        apply_cut(h, &best);
    }
}

// The first leaves: one for each sign.
static void start_leaves(struct hierarchy *h)
{
    const struct weft_planner *planner = h->planner;
    for (int first = 0, end; first < planner->item_count; first = end) {
        for (end = first;
             end < planner->item_count && planner->items[end].signs == planner->items[first].signs;)
            end++;
        h->leaf[h->leaf_count++] = (struct leaf){
            first, end - first, planner->items[first].signs & WEFT_PASS_PLAN_SUBTRACTS, 0};
    }
}

// By the sums at all positions.
static void find_levels(struct hierarchy *h)
{
    uint32_t position[CHUNK];
    int32_t most[MAX_LEAVES] = {0};
    size_t count;
    for (size_t first = 0; (count = weft_planner_chunk(h->planner, first, position));
         first += count) {
        for (int l = 0; l < h->leaf_count; l++) {
            int32_t sum[CHUNK] = {0};
            for (int i = 0; i < h->leaf[l].count; i++)
                weft_planner_add_values(h->planner, &h->planner->items[h->leaf[l].first + i], count,
                                        position, sum);
            for (size_t i = 0; i < count; i++)
                most[l] = abs(sum[i]) > most[l] ? abs(sum[i]) : most[l];
        }
    }
    for (int l = 0; l < h->leaf_count; l++)
        h->leaf[l].level = level_of(h, most[l]);
}

static enum weft_result sample(struct hierarchy *h)
{
    const size_t all = weft_planner_positions(h->planner), step = all / SAMPLED + 1;
    uint32_t position[SAMPLED + 1];
    for (size_t at = 0; at < all; at += step)
        position[h->sampled++] = (uint32_t)at;
    h->value = calloc((size_t)h->planner->item_count * h->sampled + 1, sizeof *h->value);
    if (!h->value) {
        weft_error(h->planner->p.log, "plan: not enough memory for the groups of %d taps",
                   h->planner->item_count);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < h->planner->item_count; i++)
        weft_planner_add_values(h->planner, &h->planner->items[i], h->sampled, position,
                                h->value + (size_t)i * h->sampled);
    return WEFT_OK;
}

// ---- passes -------------------------------------------------------------------------------------

static int least_shift(const struct hierarchy *h, const struct leaf *leaf)
{
    int least = INT32_MAX;
    for (int i = 0; i < leaf->count; i++) {
        const int shift = h->planner->items[leaf->first + i].group.shift[0];
        least = shift < least ? shift : least;
    }
    return least;
}

static enum weft_result emit_leaf(struct hierarchy *h, const struct leaf *leaf, int slot)
{
    const int taps = h->planner->p.taps_per_pass, shift = least_shift(h, leaf);
    for (int at = 0; at < leaf->count; at += taps) {
        const struct weft_pass pass = {
            .kind = WEFT_PASS_TAPS,
            .target = slot,
            .clears = at == 0,
            .divisor = (int)scaled(h->full, -(leaf->level + shift)),
            .group_first = h->planner->plan->list.group_count,
            .group_count = leaf->count - at < taps ? leaf->count - at : taps,
        };
        for (int i = at; i < at + pass.group_count; i++) {
            struct weft_tap_group group = h->planner->items[leaf->first + i].group;
            group.shift[0] -= shift;
            group.sign[0] = 1; // a leaf that is subtracted is so by its numerator
            if (weft_planner_add_group(h->planner, &group) != WEFT_OK)
                return WEFT_ERR_MEMORY;
        }
        if (!weft_planner_add_pass(h->planner, pass))
            return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

static int most_inputs(const struct hierarchy *h)
{
    const int textures = 2 * h->planner->p.profile.taps_per_pass;
    return textures < WEFT_PASS_MAX_INPUTS ? textures : WEFT_PASS_MAX_INPUTS;
}

static int deepest(const struct hierarchy *h)
{
    int deepest = 0;
    for (int l = 0; l < h->leaf_count; l++)
        deepest = h->leaf[l].level > deepest ? h->leaf[l].level : deepest;
    return deepest;
}

// The last pass: its denominator scales the result and its bias is the result's. A margin asks for
// finer denominators, as far as sums of 32 bits allow.
static enum weft_result emit_last(struct hierarchy *h, struct weft_pass pass)
{
    struct weft_planner *planner = h->planner;
    const int bias = planner->bias + planner->margin.low;
    const int divisor = weft_planner_margin_divisor(planner, bias, 0);
    const bool exact = !planner->margin.low && !planner->margin.high && !planner->margin.leaf;
    const int inside = planner->full << planner->plan->list.extra_bits;
    int64_t units = INT64_C(1) << deepest(h), sum = 0;
    if (!divisor)
        return WEFT_ERR_UNSUPPORTED;
    for (int i = 0; i < pass.input_count; i++)
        sum += abs(pass.numerator[i]);
    for (; !exact && units < MAX_UNITS && 8 * sum * inside < INT32_MAX; units *= 2, sum *= 2)
        for (int i = 0; i < pass.input_count; i++)
            pass.numerator[i] *= 2;
    pass.kind = WEFT_PASS_COMBINE;
    pass.clears = true;
    pass.denominator = (int)((units * divisor + h->full - 1) / h->full);
    pass.bias = bias * pass.denominator;
    planner->plan->list.result_scale =
        (double)units / planner->unit / (double)h->full / pass.denominator;
    planner->plan->list.result_bias = (double)bias / planner->full;
    return weft_planner_add_pass(planner, pass) ? WEFT_OK : WEFT_ERR_MEMORY;
}

static enum weft_result emit_flat(struct hierarchy *h)
{
    struct weft_pass last = {.input_count = h->leaf_count};
    enum weft_result res = WEFT_OK;
    for (int l = 0; res == WEFT_OK && l < h->leaf_count; l++) {
        last.input[l] = l;
        last.numerator[l] =
            (h->leaf[l].subtracts ? -1 : 1) * (1 << (deepest(h) - h->leaf[l].level));
        res = emit_leaf(h, &h->leaf[l], l);
    }
    h->planner->plan->list.slot_count = h->leaf_count;
    return res == WEFT_OK ? emit_last(h, last) : res;
}

static enum weft_result emit_node(struct hierarchy *h, const struct weft_tree_step *step, int base)
{
    struct weft_pass pass = {.kind = WEFT_PASS_COMBINE,
                             .target = base + step->slot,
                             .clears = true,
                             .input_count = step->input_count,
                             .denominator = (int)step->denominator};
    for (int i = 0; i < step->input_count; i++) {
        pass.input[i] = base + step->slot + i;
        pass.numerator[i] = (int)step->numerator[i];
    }
    return weft_planner_add_pass(h->planner, pass) ? WEFT_OK : WEFT_ERR_MEMORY;
}

// All leaves of one sign, averaged into slot `base` by their shares.
static enum weft_result emit_tree(struct hierarchy *h, bool subtracts, int base, int *share)
{
    uint32_t weight[MAX_LEAVES];
    int leaf[MAX_LEAVES], count = 0;
    for (int l = 0; l < h->leaf_count; l++) {
        if (h->leaf[l].subtracts != subtracts)
            continue;
        leaf[count] = l;
        weight[count++] = UINT32_C(1) << (deepest(h) - h->leaf[l].level);
    }
    *share = 0;
    if (!count)
        return WEFT_OK;
    weft_tree *tree = NULL;
    const struct weft_tree_params params = {.leaf_count = count,
                                            .weight = weight,
                                            .branching = most_inputs(h),
                                            .log = h->planner->p.log};
    enum weft_result res = weft_tree_create(&params, &tree);
    for (int i = 0; res == WEFT_OK && i < weft_tree_get_info(tree)->step_count; i++) {
        const struct weft_tree_step *step = &weft_tree_get_info(tree)->steps[i];
        res = step->leaf >= 0 ? emit_leaf(h, &h->leaf[leaf[step->leaf]], base + step->slot)
                              : emit_node(h, step, base);
    }
    if (res == WEFT_OK) {
        struct weft_pass_list *list = &h->planner->plan->list;
        *share = (int)weft_tree_get_info(tree)->total_weight;
        if (base + weft_tree_get_info(tree)->stack_size > list->slot_count)
            list->slot_count = base + weft_tree_get_info(tree)->stack_size;
    }
    weft_tree_destroy(&tree);
    return res;
}

static enum weft_result emit_trees(struct hierarchy *h)
{
    struct weft_pass last = {0};
    enum weft_result res = WEFT_OK;
    for (int sign = 0; res == WEFT_OK && sign < 2; sign++) {
        int share;
        res = emit_tree(h, sign, last.input_count, &share);
        if (!share)
            continue;
        last.input[last.input_count] = last.input_count;
        last.numerator[last.input_count++] = sign ? -share : share;
    }
    return res == WEFT_OK ? emit_last(h, last) : res;
}

// In codes: what passes into leaves and, of more leaves than one pass combines, nodes can lose. A
// node holds an average, so that what it loses counts by the leaves' shares together.
static double cost_of_all(const struct hierarchy *h)
{
    double cost = 0.0, shares = 0.0;
    for (int l = 0; l < h->leaf_count; l++) {
        const struct leaf *leaf = &h->leaf[l];
        cost += cost_of(h, leaf->first, leaf->count);
        shares += exp2(-level_of(h, largest_sum(h, leaf->first, leaf->count)));
    }
    const double levels = ceil(log(h->leaf_count) / log(most_inputs(h)));
    return h->leaf_count <= most_inputs(h) ? cost : cost + 0.5 * levels * shares;
}

// As many leaves as one pass combines, or more where that loses less.
static void choose_leaves(struct hierarchy *h)
{
    struct hierarchy deep = *h;
    start_leaves(h);
    start_leaves(&deep);
    cut_leaves(h, most_inputs(h));
    cut_leaves(&deep, MAX_LEAVES);
    if (cost_of_all(&deep) < cost_of_all(h))
        *h = deep;
}

enum weft_result weft_planner_emit_hierarchy(struct weft_planner *planner)
{
    const double one = weft_kernel_tiles_get_info(planner->plan->tiles)->one;
    const double room = (double)(planner->full - planner->margin.leaf) / planner->full;
    struct hierarchy h = {.planner = planner};
    h.most_level = (int)lround(-log2(planner->unit * one));
    // Divisors of all levels are whole numbers.
    h.full = h.most_level > 0 ? (int64_t)ceil(one / room) << h.most_level
                              : (int64_t)ceil(ldexp(one / room, h.most_level));
    sort_items(planner);
    enum weft_result res = sample(&h);
    if (res == WEFT_OK) {
        choose_leaves(&h);
        find_levels(&h);
        res = h.leaf_count <= most_inputs(&h) ? emit_flat(&h) : emit_trees(&h);
        planner->plan->list.scratch_count = 1;
    }
    free(h.value);
    return res;
}
