// SPDX-License-Identifier: BSD-3-Clause
// Whether a list of passes is one, whoever made it: what simulator, emulator and GL take for
// granted.
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/plan/pass.h"

enum { MAX_EXTRA_BITS = 24, MAX_SHIFT = 31 };

struct checker {
    const struct weft_log *log;
    const struct weft_pass_list *list;
    const struct weft_kernel_tiles_info *tiles;
    bool *written; // by slot: it holds something
};

static bool lies_within(const struct checker *s, const char *where, int number, const char *what,
                        int value, int low, int high)
{
    if (value >= low && value <= high)
        return true;
    weft_error(s->log, "%s %02d: %s %d, not %d to %d", where, number, what, value, low, high);
    return false;
}

static bool within(const struct checker *s, int pass, const char *what, int value, int low,
                   int high)
{
    return lies_within(s, "pass", pass, what, value, low, high);
}

static bool check_group(const struct checker *s, int number)
{
    const struct weft_tap_group *group = &s->list->groups[number];
    for (int a = 0; a < 3; a++) {
        const int most = a < s->list->dims ? WEFT_KERNEL_MAX_WIDTH : 0;
        if (!lies_within(s, "group", number, "offset", group->offset[a], -most, most))
            return false;
    }
    for (int c = 0; c < (s->list->dot4 ? 4 : 1); c++) {
        const int last = s->tiles->tile_count - 1;
        if (!lies_within(s, "group", number, "tile", group->tile[c], -1, last))
            return false;
        if (group->tile[c] < 0)
            continue;
        if (group->sign[c] != 1 && group->sign[c] != -1) {
            weft_error(s->log, "group %02d: sign %d, neither 1 nor -1", number, group->sign[c]);
            return false;
        }
        if (!lies_within(s, "group", number, "shift", group->shift[c], -MAX_SHIFT, MAX_SHIFT))
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
    return !weft_target_bits(list->target) || !p->clears ||
           within(s, pass, "initial", p->initial, 0, weft_target_one(list->target));
}

static bool check_written(const struct checker *s, int pass, int slot)
{
    if (!within(s, pass, "slot", slot, 0, s->list->slot_count - 1))
        return false;
    if (s->written[slot])
        return true;
    weft_error(s->log, "pass %02d reads slot %d, which holds nothing", pass, slot);
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
            weft_error(s->log, "pass %02d: numerator %d is 0", pass, i);
            return false;
        }
    }
    for (int i = 0; i < p->input_count; i++)
        s->written[p->input[i]] = false;
    return true;
}

static bool check_pass(const struct checker *s, int pass)
{
    const struct weft_pass *p = &s->list->passes[pass];
    if (!within(s, pass, "target", p->target, 0, s->list->slot_count - 1) ||
        !within(s, pass, "kind", (int)p->kind, WEFT_PASS_TAPS, WEFT_PASS_COMBINE))
        return false;
    if (p->kind == WEFT_PASS_COMBINE ? !check_combine(s, pass) : !check_taps(s, pass))
        return false;
    if (p->kind == WEFT_PASS_TAPS && !p->clears && !check_written(s, pass, p->target))
        return false;
    s->written[p->target] = true;
    return true;
}

static bool check_list(const struct checker *s)
{
    for (int i = 0; i < s->list->group_count; i++)
        if (!check_group(s, i))
            return false;
    for (int i = 0; i < s->list->pass_count; i++)
        if (!check_pass(s, i))
            return false;
    if (s->written[s->list->result])
        return true;
    weft_error(s->log, "slot %d, the result, holds nothing", s->list->result);
    return false;
}

enum weft_result weft_pass_list_check(const struct weft_log *log, const struct weft_pass_list *list)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, list && list->tiles && list->passes);
    struct checker s = {.log = log, .list = list, .tiles = weft_kernel_tiles_get_info(list->tiles)};
    weft_require(log, list->dims == s.tiles->dims);
    weft_require_enum(log, list->target, WEFT_TARGET_FLOAT);
    weft_require(log, list->pass_count > 0 && list->group_count >= 0 && list->slot_count > 0);
    weft_require(log, list->groups || list->group_count == 0);
    weft_require(log, list->extra_bits >= 0 && list->extra_bits <= MAX_EXTRA_BITS);
    weft_require(log, list->exact_inside || list->range >= 1.0);
    weft_require(log, list->result >= 0 && list->result < list->slot_count);
    weft_require(log, !list->log_table ||
                          (list->log_octaves > 0.0 && list->target <= WEFT_TARGET_UNORM16 &&
                           s.tiles->format >= WEFT_TILE_HALF));
    s.written = calloc((size_t)list->slot_count, sizeof *s.written);
    if (!s.written) {
        weft_error(log, "not enough memory for %d slots of passes", list->slot_count);
        return WEFT_ERR_MEMORY;
    }
    res = check_list(&s) ? WEFT_OK : WEFT_ERR_ARGUMENT;
    free(s.written);
fail:
    return res;
}
