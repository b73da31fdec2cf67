// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/plan_impl.h"

enum { CHUNK = WEFT_PLANNER_CHUNK, MAX_EXTRA_BITS = 8 };

// ---- lists that grow ----------------------------------------------------------------------------

static void *grown(const struct weft_log *log, void *array, int count, int *room, size_t size)
{
    if (count < *room)
        return array;
    const int wanted = *room ? 2 * *room : 64;
    void *new = realloc(array, (size_t)wanted * size);
    if (!new)
        weft_error(log, "plan: not enough memory for %d passes", wanted);
    else
        *room = wanted;
    return new;
}

struct weft_pass *weft_planner_add_pass(struct weft_planner *planner, struct weft_pass pass)
{
    struct weft_pass_plan *plan = planner->plan;
    struct weft_pass *passes = grown(planner->p.log, plan->passes, plan->list.pass_count,
                                     &planner->pass_room, sizeof *passes);
    if (!passes)
        return NULL;
    plan->list.passes = plan->passes = passes;
    passes[plan->list.pass_count] = pass;
    return &passes[plan->list.pass_count++];
}

enum weft_result weft_planner_add_group(struct weft_planner *planner,
                                        const struct weft_tap_group *group)
{
    struct weft_pass_plan *plan = planner->plan;
    struct weft_tap_group *groups = grown(planner->p.log, plan->groups, plan->list.group_count,
                                          &planner->group_room, sizeof *groups);
    if (!groups)
        return WEFT_ERR_MEMORY;
    plan->list.groups = plan->groups = groups;
    groups[plan->list.group_count++] = *group;
    return WEFT_OK;
}

int32_t weft_planner_pass_magnitude(const struct weft_planner *planner,
                                    const struct weft_pass *pass)
{
    uint32_t position[CHUNK];
    int32_t largest = 0;
    size_t count;
    for (size_t first = 0; (count = weft_planner_chunk(planner, first, position)); first += count) {
        int32_t sum[CHUNK] = {0};
        for (int g = 0; g < pass->group_count; g++) {
            struct weft_pass_plan_item item = {planner->plan->groups[pass->group_first + g], 0, 0};
            for (int c = 0; c < 4; c++)
                item.group.sign[c] = 1;
            weft_planner_add_values(planner, &item, count, position, sum);
        }
        for (size_t i = 0; i < count; i++)
            largest = sum[i] > largest ? sum[i] : largest;
    }
    return largest;
}

// ---- passes over an order -----------------------------------------------------------------------

// What a sequence of passes into one slot has in common.
struct sequence {
    int slot, initial, divisor;
    enum weft_pass_part part;
    int bias_factor; // from codes to units inside a pass
};

static bool only_subtracts(const struct weft_planner *planner,
                           const struct weft_pass_plan_order *order, int first, int end)
{
    for (int i = first; i < end; i++)
        if (planner->items[order->item[i]].signs & WEFT_PASS_PLAN_ADDS)
            return false;
    return !planner->real;
}

static bool has_both_signs(const struct weft_planner *planner,
                           const struct weft_pass_plan_order *order, int first, int end)
{
    int signs = 0;
    for (int i = first; i < end; i++)
        signs |= planner->items[order->item[i]].signs;
    return !planner->real && signs == (WEFT_PASS_PLAN_ADDS | WEFT_PASS_PLAN_SUBTRACTS);
}

static enum weft_result emit_sequence(struct weft_planner *planner,
                                      const struct weft_pass_plan_order *order,
                                      const struct sequence *sequence)
{
    for (int n = 0, first = 0; n < order->pass_count; first = order->pass_end[n++]) {
        const int end = order->pass_end[n];
        // A bias makes a subtracted sum's sign uncertain, too.
        const bool subtracts = only_subtracts(planner, order, first, end);
        const bool mixed =
            has_both_signs(planner, order, first, end) || (subtracts && order->bias[n]);
        const struct weft_pass pass = {
            .kind = WEFT_PASS_TAPS,
            .target = sequence->slot,
            .clears = n == 0,
            .initial = n == 0 ? sequence->initial : 0,
            .part = sequence->part,
            .subtract = subtracts && !mixed,
            .reads_target = mixed,
            .bias = order->bias[n] * sequence->bias_factor,
            .divisor = sequence->divisor,
            .group_first = planner->plan->list.group_count,
            .group_count = end - first,
        };
        for (int i = first; i < end; i++)
            if (weft_planner_add_group(planner, &planner->items[order->item[i]].group) != WEFT_OK)
                return WEFT_ERR_MEMORY;
        if (!weft_planner_add_pass(planner, pass))
            return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

static bool any_reads(const struct weft_pass_list *list)
{
    for (int i = 0; i < list->pass_count; i++)
        if (list->passes[i].reads_target || list->passes[i].kind == WEFT_PASS_COMBINE)
            return true;
    return false;
}

static int bias_codes(const struct weft_pass_plan_order *order)
{
    int sum = order->initial;
    for (int i = 0; i < order->pass_count; i++)
        sum += order->bias[i];
    return sum;
}

// Exact sums B_n + x_n of codes, B_n <= B being what the passes so far have of the bias, stay
// within [0, T]. With x_n made smaller by k, they stay within [0, T - (1 - k) (T - B)]: so much can
// be given to the margin, and what lies below it is added to the first B.
static bool margin_factor(const struct weft_planner *planner, int bias, int more, double *out)
{
    const int own = bias - planner->margin.low, room = planner->full - own;
    const int given = planner->margin.low + planner->margin.high + more;
    *out = room > 0 ? 1.0 - (double)given / room : 0.0;
    if (*out >= 0.02)
        return true;
    weft_error(planner->p.log,
               "plan: roundings take sums %d codes below and %d above their exact range, which "
               "leaves no room for them",
               planner->margin.low, planner->margin.high + more);
    return false;
}

int32_t weft_planner_margin_divisor(const struct weft_planner *planner, int bias, int more)
{
    double k;
    return margin_factor(planner, bias, more, &k) ? (int32_t)ceil(planner->divisor / k - 1e-9) : 0;
}

static enum weft_result scale_log_table(struct weft_planner *planner, int bias)
{
    double k;
    if (!margin_factor(planner, bias, 0, &k))
        return WEFT_ERR_UNSUPPORTED;
    planner->plan->list.result_scale = planner->log_scale * k;
    return weft_planner_make_log_table(planner, planner->plan->list.result_scale);
}

enum weft_result weft_planner_emit(struct weft_planner *planner,
                                   const struct weft_pass_plan_order *order)
{
    struct weft_pass_list *list = &planner->plan->list;
    const int bias = bias_codes(order) + planner->margin.low;
    const struct sequence whole = {
        .initial = order->initial + planner->margin.low,
        // Entries of the log table are scaled already.
        .divisor = planner->logarithms ? 1 : weft_planner_margin_divisor(planner, bias, 0),
        .bias_factor = 1 << list->extra_bits,
    };
    enum weft_result res = WEFT_OK;
    if (planner->logarithms)
        res = scale_log_table(planner, bias);
    else if (!whole.divisor)
        res = WEFT_ERR_UNSUPPORTED;
    else
        list->result_scale = 1.0 / (planner->unit * whole.divisor);
    if (res == WEFT_OK)
        res = emit_sequence(planner, order, &whole);
    list->slot_count = 1;
    list->scratch_count = any_reads(list);
    list->result_bias = (double)bias / planner->full;
    return res;
}

// ---- high and low parts -------------------------------------------------------------------------

// Largest magnitude of a pass's weights at each of some positions.
static void pass_magnitudes(const struct weft_planner *planner,
                            const struct weft_pass_plan_order *order, int first, int end,
                            size_t count, const uint32_t *position, int32_t *out)
{
    memset(out, 0, count * sizeof *out);
    for (int i = first; i < end; i++) {
        struct weft_pass_plan_item item = planner->items[order->item[i]];
        for (int c = 0; c < 4; c++)
            item.group.sign[c] = 1;
        weft_planner_add_values(planner, &item, count, position, out);
    }
}

// At the worst position: what low parts can add up to, in codes of the low target, and what high
// parts can lose, in those of the high one.
struct split_need {
    int64_t low;
    double lost;
    int32_t magnitude; // of a pass's weights
};

static void add_need(const struct weft_planner *planner, const struct weft_pass_plan_order *order,
                     int bits, size_t count, const uint32_t *position, struct split_need *need)
{
    const int64_t mask = (1 << bits) - 1;
    const double unit = (double)planner->full * (1 << bits) / planner->divisor;
    int32_t magnitude[CHUNK];
    int64_t low[CHUNK] = {0};
    int passes[CHUNK] = {0};
    for (int n = 0, first = 0; n < order->pass_count; first = order->pass_end[n++]) {
        pass_magnitudes(planner, order, first, order->pass_end[n], count, position, magnitude);
        const bool one_sign = !has_both_signs(planner, order, first, order->pass_end[n]) &&
                              !only_subtracts(planner, order, first, order->pass_end[n]) &&
                              !order->bias[n];
        for (size_t i = 0; i < count; i++) {
            const int64_t largest = (int64_t)ceil(magnitude[i] * unit);
            need->magnitude = magnitude[i] > need->magnitude ? magnitude[i] : need->magnitude;
            passes[i] += magnitude[i] > 0;
            if (magnitude[i] > 0 || order->bias[n])
                low[i] += one_sign && largest < mask ? largest : mask;
        }
    }
    for (size_t i = 0; i < count; i++) {
        need->low = low[i] > need->low ? low[i] : need->low;
        need->lost = fmax(need->lost, passes[i] * (double)mask / (double)(mask + 1));
    }
}

static void find_need(const struct weft_planner *planner, const struct weft_pass_plan_order *order,
                      int bits, struct split_need *need)
{
    uint32_t position[CHUNK];
    size_t count;
    *need = (struct split_need){0, 0.0, 0};
    for (size_t first = 0; (count = weft_planner_chunk(planner, first, position)); first += count)
        add_need(planner, order, bits, count, position, need);
}

static bool subtracts(const struct weft_planner *planner)
{
    for (int i = 0; i < planner->item_count; i++)
        if (planner->items[i].signs & WEFT_PASS_PLAN_SUBTRACTS)
            return true;
    return false;
}

static double largest_bias(const struct weft_pass_plan_order *order)
{
    int largest = 0;
    for (int i = 0; i < order->pass_count; i++)
        largest = order->bias[i] > largest ? order->bias[i] : largest;
    return largest;
}

// The most bits that the low target holds, carries included; 0: none. *head: codes that the high
// target starts with, so that floors cannot take it below 0.
static int choose_bits(const struct weft_planner *planner, const struct weft_pass_plan_order *order,
                       int *head)
{
    const int internal = planner->p.profile.internal_bits;
    const int target_bits = weft_target_bits(planner->p.profile.target);
    int bits = internal ? internal - target_bits : MAX_EXTRA_BITS;
    // More than this the carries of so many passes do not leave, unless most weights are tiny.
    const int likely = (int)log2((double)planner->full / order->pass_count + 1.0) + 2;
    bits = (bits < likely ? bits : likely) - planner->margin.fewer_bits;
    for (; bits > 0; bits--) {
        struct split_need need;
        find_need(planner, order, bits, &need);
        *head = subtracts(planner) ? (int)ceil(need.lost) + 1 : 0;
        // The divisor grows by what the head takes.
        const double bias = largest_bias(order) * 2.0 * planner->divisor;
        const double sum = ((double)need.magnitude * planner->full + bias) * (1 << bits);
        if (need.low <= planner->full && *head <= planner->full / 4 && sum < 0x1p31 - 0x1p20)
            break;
    }
    return bits;
}

static enum weft_result emit_parts(struct weft_planner *planner,
                                   const struct weft_pass_plan_order *order, int head, int divisor)
{
    struct sequence sequence = {.slot = 0,
                                .initial = order->initial + head,
                                .divisor = divisor,
                                .part = WEFT_PASS_HIGH,
                                .bias_factor = 1 << planner->plan->list.extra_bits};
    enum weft_result res = emit_sequence(planner, order, &sequence);
    sequence.slot = 1;
    sequence.initial = 0;
    sequence.part = WEFT_PASS_LOW;
    if (res == WEFT_OK)
        res = emit_sequence(planner, order, &sequence);
    return res;
}

enum weft_result weft_planner_emit_split(struct weft_planner *planner,
                                         const struct weft_pass_plan_order *order)
{
    struct weft_pass_list *list = &planner->plan->list;
    int head = 0;
    list->extra_bits = choose_bits(planner, order, &head);
    if (!list->extra_bits) {
        weft_error(
            planner->p.log,
            "plan: the low parts of %d passes, with their carries, do not fit into %d bits, or "
            "sums not into 32",
            order->pass_count, weft_target_bits(planner->p.profile.target));
        return WEFT_ERR_UNSUPPORTED;
    }
    const int bias = bias_codes(order) + planner->margin.low;
    const int divisor = weft_planner_margin_divisor(planner, bias, head);
    if (!divisor)
        return WEFT_ERR_UNSUPPORTED;
    enum weft_result res = emit_parts(planner, order, head + planner->margin.low, divisor);
    const struct weft_pass combine = {.kind = WEFT_PASS_COMBINE,
                                      .target = 0,
                                      .clears = true,
                                      .input_count = 2,
                                      .input = {0, 1},
                                      .numerator = {1 << list->extra_bits, 1},
                                      .denominator = 1 << list->extra_bits};
    if (res == WEFT_OK && !weft_planner_add_pass(planner, combine))
        res = WEFT_ERR_MEMORY;
    list->slot_count = 2;
    list->scratch_count = 1;
    list->result_bias = (double)(bias + head) / planner->full;
    list->result_scale = 1.0 / (planner->unit * divisor);
    return res;
}
