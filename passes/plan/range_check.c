// SPDX-License-Identifier: BSD-3-Clause
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "passes/plan/range_impl.h"

enum { MAX_EXTRA_BITS = 24, MAX_SHIFT = 31 };

// Whether a slot holds something, and which floors took from it what has to be given back.
struct ledger {
    bool written;
    uint64_t owed;
};

struct checker {
    const struct weft_log *log;
    const struct weft_pass_list *list;
    const struct weft_kernel_tiles_info *tiles;
    bool unorm;
    int one;
    struct weft_range_observed *observed;
    struct ledger *ledgers;
};

static bool within(const struct checker *s, int pass, const char *what, int value, int low,
                   int high)
{
    if (value >= low && value <= high)
        return true;
    weft_error(s->log, "range: pass %d: %s %d, not %d to %d", pass, what, value, low, high);
    return false;
}

static bool check_group(const struct checker *s, int pass, const struct weft_tap_group *group)
{
    for (int c = 0; c < weft_range_components(s->list); c++) {
        if (!within(s, pass, "tile", group->tile[c], -1, s->tiles->tile_count - 1))
            return false;
        if (group->tile[c] < 0)
            continue;
        if (group->sign[c] != 1 && group->sign[c] != -1) {
            weft_error(s->log, "range: pass %d: sign %d, neither 1 nor -1", pass, group->sign[c]);
            return false;
        }
        if (!within(s, pass, "shift", group->shift[c], -MAX_SHIFT, MAX_SHIFT))
            return false;
    }
    return true;
}

static bool check_taps(const struct checker *s, int pass)
{
    const struct weft_pass_list *list = s->list;
    const struct weft_pass *p = &list->passes[pass];
    if (!within(s, pass, "part", (int)p->part, WEFT_PASS_WHOLE, WEFT_PASS_LOW) ||
        !within(s, pass, "divisor", p->divisor, 1, INT_MAX) ||
        !within(s, pass, "group count", p->group_count, 0, WEFT_PASS_MAX_GROUPS) ||
        !within(s, pass, "first group", p->group_first, 0, list->group_count - p->group_count))
        return false;
    if (s->unorm && p->clears && !within(s, pass, "initial", p->initial, 0, s->one))
        return false;
    for (int g = 0; g < p->group_count; g++)
        if (!check_group(s, pass, &list->groups[p->group_first + g]))
            return false;
    return true;
}

static bool check_written(const struct checker *s, int pass, int slot)
{
    if (!within(s, pass, "slot", slot, 0, s->list->slot_count - 1))
        return false;
    if (s->ledgers[slot].written)
        return true;
    weft_error(s->log, "range: pass %d: slot %d is read but holds nothing", pass, slot);
    return false;
}

static bool check_combine(const struct checker *s, int pass)
{
    const struct weft_pass *p = &s->list->passes[pass];
    if (!within(s, pass, "denominator", p->denominator, 1, INT_MAX) ||
        !within(s, pass, "input count", p->input_count, 1, WEFT_PASS_MAX_INPUTS))
        return false;
    for (int i = 0; i < p->input_count; i++) {
        if (!check_written(s, pass, p->input[i]))
            return false;
        if (p->numerator[i] == 0) {
            weft_error(s->log, "range: pass %d: numerator %d is 0", pass, i);
            return false;
        }
    }
    return true;
}

static bool check_pass(const struct checker *s, int pass)
{
    const struct weft_pass *p = &s->list->passes[pass];
    if (!within(s, pass, "target", p->target, 0, s->list->slot_count - 1) ||
        !within(s, pass, "kind", (int)p->kind, WEFT_PASS_TAPS, WEFT_PASS_COMBINE))
        return false;
    if (p->kind == WEFT_PASS_COMBINE)
        return check_combine(s, pass);
    return check_taps(s, pass) && (p->clears || check_written(s, pass, p->target));
}

static enum weft_result check_list(const struct weft_log *log, const struct weft_pass_list *list)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, list->tiles && list->passes && (list->groups || list->group_count == 0));
    const struct weft_kernel_tiles_info *tiles = weft_kernel_tiles_get_info(list->tiles);
    weft_require(log, list->dims == tiles->dims);
    weft_require(log, list->target >= WEFT_TARGET_UNORM8 && list->target <= WEFT_TARGET_FLOAT);
    weft_require(log, list->pass_count > 0 && list->group_count >= 0 && list->slot_count > 0);
    weft_require(log, list->extra_bits >= 0 && list->extra_bits <= MAX_EXTRA_BITS);
    weft_require(log, list->exact_inside || list->range >= 1.0);
    weft_require(log, list->result >= 0 && list->result < list->slot_count);
    weft_require(log, !list->log_table ||
                          (list->log_octaves > 0.0 && list->target <= WEFT_TARGET_UNORM16 &&
                           tiles->format >= WEFT_TILE_HALF));
    res = WEFT_OK;
fail:
    return res;
}

// ---- what floors took and low parts gave --------------------------------------------------------

static uint64_t mix(uint64_t hash, int value)
{
    hash = (hash ^ (uint32_t)value) * UINT64_C(0x9e3779b97f4a7c15);
    return hash ^ hash >> 29;
}

// Stands for what the floor of a pass's integer leaves, which is the same for high and low parts of
// the same products.
static uint64_t remainder_hash(const struct weft_pass_list *list, const struct weft_pass *p)
{
    uint64_t hash = mix(mix(1, p->bias), p->divisor);
    for (int g = 0; g < p->group_count; g++) {
        const struct weft_tap_group *group = &list->groups[p->group_first + g];
        for (int a = 0; a < 3; a++)
            hash = mix(hash, group->offset[a]);
        for (int c = 0; c < weft_range_components(list); c++) {
            const bool used = group->tile[c] >= 0;
            hash = mix(hash, group->tile[c]);
            hash = mix(hash, used ? group->sign[c] : 0);
            hash = mix(hash, used ? group->shift[c] : 0);
        }
    }
    return hash;
}

static void enter_taps(struct checker *s, const struct weft_pass *p)
{
    struct ledger *target = &s->ledgers[p->target];
    if (p->clears)
        target->owed = 0;
    target->written = true;
    if (p->part == WEFT_PASS_WHOLE || s->list->extra_bits == 0)
        return;
    // In units of 2^-e codes.
    const uint64_t hash = remainder_hash(s->list, p);
    target->owed += p->part == WEFT_PASS_LOW ? hash << s->list->extra_bits : 0 - hash;
}

static void enter_combine(struct checker *s, int pass)
{
    const struct weft_pass *p = &s->list->passes[pass];
    uint64_t owed = 0;
    for (int i = 0; i < p->input_count; i++)
        owed += (uint64_t)(int64_t)p->numerator[i] * s->ledgers[p->input[i]].owed;
    for (int i = 0; i < p->input_count; i++)
        s->ledgers[p->input[i]].written = false;
    s->observed[pass].settled = owed == 0;
    // What is left is a fraction of what it was, which nothing gives back.
    s->ledgers[p->target] = (struct ledger){true, owed ? mix(2, pass) | 1 : 0};
}

static enum weft_result enter_passes(struct checker *s)
{
    const struct weft_pass_list *list = s->list;
    for (int i = 0; i < list->pass_count; i++) {
        if (!check_pass(s, i))
            return WEFT_ERR_ARGUMENT;
        if (list->passes[i].kind == WEFT_PASS_TAPS)
            enter_taps(s, &list->passes[i]);
        else
            enter_combine(s, i);
    }
    return check_written(s, list->pass_count - 1, list->result) ? WEFT_OK : WEFT_ERR_ARGUMENT;
}

enum weft_result weft_range_check(const struct weft_log *log, const struct weft_pass_list *list,
                                  struct weft_range_observed *observed)
{
    enum weft_result res = check_list(log, list);
    if (res != WEFT_OK)
        return res;
    struct checker s = {.log = log,
                        .list = list,
                        .tiles = weft_kernel_tiles_get_info(list->tiles),
                        .unorm = weft_target_bits(list->target) > 0,
                        .one = weft_target_one(list->target),
                        .observed = observed,
                        .ledgers = calloc((size_t)list->slot_count, sizeof *s.ledgers)};
    if (!s.ledgers) {
        weft_error(log, "range: not enough memory for %d slots", list->slot_count);
        return WEFT_ERR_MEMORY;
    }
    res = enter_passes(&s);
    free(s.ledgers);
    return res;
}
