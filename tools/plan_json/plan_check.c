// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plan_json/plan_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

// What a target holds is linear in the products s q of the tiles and in the biases, but for
// rounding: for each of them one factor for what high parts have of it, one for low parts.
struct terms {
    double part[2];
};

struct check {
    const struct weft_pass_list *list;
    int count;           // of terms of a slot: the tiles, and behind them the constant 1
    struct terms *slots; // [slot_count][count]
    struct terms *sum;   // of one combining pass
};

static const double tolerance = 1e-9;

static struct terms *slot_of(const struct check *check, int slot)
{
    return check->slots + (size_t)slot * (size_t)check->count;
}

static void add(struct terms *to, enum weft_pass_part part, double factor, int extra_bits)
{
    if (part != WEFT_PASS_LOW)
        to->part[0] += factor;
    if (part != WEFT_PASS_HIGH) // low targets count in 2^-e codes
        to->part[1] += part == WEFT_PASS_LOW ? ldexp(factor, extra_bits) : factor;
}

static void add_taps(const struct check *check, const struct weft_pass *pass)
{
    const struct weft_pass_list *list = check->list;
    struct terms *slot = slot_of(check, pass->target), *constant = &slot[check->count - 1];
    if (pass->clears) {
        memset(slot, 0, (size_t)check->count * sizeof *slot);
        constant->part[0] = constant->part[1] = pass->initial;
    }
    add(constant, pass->part, ldexp(pass->bias, -list->extra_bits), list->extra_bits);
    for (int i = 0; i < pass->group_count; i++) {
        const struct weft_tap_group *group = &list->groups[pass->group_first + i];
        for (int c = 0; c < (list->dot4 ? 4 : 1); c++) {
            const double factor = list->log_table
                                      ? ldexp(group->sign[c], -list->extra_bits)
                                      : ldexp(group->sign[c], group->shift[c]) / pass->divisor;
            if (group->tile[c] >= 0)
                add(&slot[group->tile[c]], pass->part, factor, list->extra_bits);
        }
    }
}

static void combine(const struct check *check, const struct weft_pass *pass)
{
    const double share = 1.0 / pass->denominator;
    struct terms *sum = check->sum;
    memset(sum, 0, (size_t)check->count * sizeof *sum);
    for (int i = 0; i < pass->input_count; i++) {
        const struct terms *input = slot_of(check, pass->input[i]);
        for (int k = 0; k < check->count; k++)
            for (int p = 0; p < 2; p++)
                sum[k].part[p] += share * pass->numerator[i] * input[k].part[p];
    }
    for (int p = 0; p < 2; p++)
        sum[check->count - 1].part[p] += share * pass->bias;
    memcpy(slot_of(check, pass->target), sum, (size_t)check->count * sizeof *sum);
}

static void run_passes(const struct check *check)
{
    for (int i = 0; i < check->list->pass_count; i++) {
        const struct weft_pass *pass = &check->list->passes[i];
        if (pass->kind == WEFT_PASS_TAPS)
            add_taps(check, pass);
        else
            combine(check, pass);
    }
}

static bool is_wrong(const struct terms *terms, double expected, double margin, double *found)
{
    for (int p = 0; p < 2; p++) {
        *found = terms->part[p];
        if (!(fabs(*found - expected) <= margin))
            return true;
    }
    return false;
}

// By the list's promise value = (y / T - bias) / scale, a product s q counts scale / (one * the
// tile's scale) codes.
static double expected_factor(const struct check *check, int tile)
{
    const struct weft_pass_list *list = check->list;
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(list->tiles, tile);
    const double one = weft_kernel_tiles_get_info(list->tiles)->one;
    return (t->negated ? -1.0 : 1.0) * (list->log_table ? ldexp(1.0, -list->extra_bits)
                                                        : list->result_scale / (one * t->scale));
}

// The first tile that does not count `times` times, -1 if none. Tiles that are zero everywhere need
// not be there.
static int find_tile(const struct check *check, double times, double *found)
{
    const struct terms *result = slot_of(check, check->list->result);
    for (int i = 0; i < check->count - 1; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(check->list->tiles, i);
        const double factor = expected_factor(check, i), expected = times * factor;
        if (tile->minimum == 0.0 && tile->maximum == 0.0)
            continue;
        if (!is_wrong(&result[i], expected, tolerance * fabs(expected), found))
            continue;
        *found /= factor;
        return i;
    }
    return -1;
}

static void find_fault(const struct check *check, struct plan_fault *out)
{
    const struct weft_pass_list *list = check->list;
    double found, other;
    *out = (struct plan_fault){.kind = PLAN_FAULT_NONE, .times = 1.0};
    const int tile = find_tile(check, 1.0, &found);
    if (tile >= 0) {
        const bool all = found > 0.0 && find_tile(check, found, &other) < 0;
        *out = (struct plan_fault){all ? PLAN_FAULT_SCALE : PLAN_FAULT_TILE, tile, found};
        return;
    }
    const int full = weft_target_bits(list->target) ? weft_target_one(list->target) : 1;
    const double expected = full * list->result_bias;
    if (is_wrong(&slot_of(check, list->result)[check->count - 1], expected, tolerance * full,
                 &found))
        *out = (struct plan_fault){PLAN_FAULT_BIAS, -1, found / full};
}

enum weft_result plan_check(const struct weft_pass_list *list, struct plan_fault *out)
{
    enum weft_result res = weft_pass_list_check(report_log(), list);
    if (res != WEFT_OK)
        return res == WEFT_ERR_ARGUMENT ? WEFT_ERR_FORMAT : res;
    struct check check = {.list = list};
    check.count = weft_kernel_tiles_get_info(list->tiles)->tile_count + 1;
    check.slots = calloc((size_t)list->slot_count * (size_t)check.count, sizeof *check.slots);
    check.sum = calloc((size_t)check.count, sizeof *check.sum);
    if (check.slots && check.sum) {
        run_passes(&check);
        find_fault(&check, out);
    } else {
        report_error("out of memory for %d slots of %d tiles", list->slot_count, check.count);
        res = WEFT_ERR_MEMORY;
    }
    free(check.slots);
    free(check.sum);
    return res;
}
