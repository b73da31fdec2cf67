// SPDX-License-Identifier: BSD-3-Clause
#include <stdlib.h>

#include "passes/plan/range_impl.h"

struct checker {
    const struct weft_pass_list *list;
    struct weft_range_observed *observed;
    uint64_t *owed; // by slot: what floors took from it that has to be given back
};

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
    uint64_t *owed = &s->owed[p->target];
    if (p->clears)
        *owed = 0;
    if (p->part == WEFT_PASS_WHOLE || s->list->extra_bits == 0)
        return;
    // In units of 2^-e codes.
    const uint64_t hash = remainder_hash(s->list, p);
    *owed += p->part == WEFT_PASS_LOW ? hash << s->list->extra_bits : 0 - hash;
}

static void enter_combine(struct checker *s, int pass)
{
    const struct weft_pass *p = &s->list->passes[pass];
    uint64_t owed = 0;
    for (int i = 0; i < p->input_count; i++)
        owed += (uint64_t)(int64_t)p->numerator[i] * s->owed[p->input[i]];
    s->observed[pass].settled = owed == 0;
    // What is left is a fraction of what it was, which nothing gives back.
    s->owed[p->target] = owed ? mix(2, pass) | 1 : 0;
}

enum weft_result weft_range_check(const struct weft_log *log, const struct weft_pass_list *list,
                                  struct weft_range_observed *observed)
{
    enum weft_result res = weft_pass_list_check(log, list);
    if (res != WEFT_OK)
        return res;
    struct checker s = {.list = list,
                        .observed = observed,
                        .owed = calloc((size_t)list->slot_count, sizeof *s.owed)};
    if (!s.owed) {
        weft_error(log, "range: not enough memory for %d slots", list->slot_count);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < list->pass_count; i++) {
        if (list->passes[i].kind == WEFT_PASS_TAPS)
            enter_taps(&s, &list->passes[i]);
        else
            enter_combine(&s, i);
    }
    free(s.owed);
    return WEFT_OK;
}
