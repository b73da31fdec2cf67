// SPDX-License-Identifier: BSD-3-Clause
// All constants at once: 256 levels of the source, side by side. What a pass changes at a sample
// position depends on the sum of its weights there (or, where products are rounded one by one, on
// the weights), and neighbours have the same ones: the changes at all levels are rows that are
// kept.
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/range_impl.h"

enum {
    LEVELS = 256,
    AT_ONCE = 32, // positions
    ROWS = 4096,
    MOST = 32000, // codes that 16 bits hold
    MOST_INSIDE = 1 << 29,
};

struct row {
    int pass; // the first with the same numbers; -1: none
    int64_t weight;
    bool fits;
    int low, high; // of the changes
};

// What a slot holds at one position: the least and the most of all levels.
struct bounds {
    int low, high;
};

// Integers at all levels. 16 bits hold sums inside, but those of logarithms' products.
union levels {
    int32_t wide[LEVELS];
    int16_t narrow[LEVELS];
};

struct weft_levels {
    const struct weft_pass_list *list;
    int one, extra_bits;
    bool sums; // of a pass are exact: one row for all its taps
    double limit;
    int *twin; // of a pass: the first one with the same numbers
    struct row *rows;
    int16_t (*changes)[LEVELS]; // [row]
    union levels *products;     // [row], of single taps
    bool narrow;                // and `inside`
    int16_t (*slots)[AT_ONCE][LEVELS];
    struct bounds (*bounds)[AT_ONCE];
    int64_t weights[AT_ONCE], reach[AT_ONCE]; // sums of weights, largest sums of products
    double value[AT_ONCE];
    union levels *inside; // [position]: n
    int peak[AT_ONCE];
    bool cleared[AT_ONCE];
    struct weft_range_observed *seen; // of the positions at hand
    int16_t own[LEVELS];
};

// ---- rows ---------------------------------------------------------------------------------------

// To the nearest, halves away from zero. Exact: sums of 32 bits are far from half-way, or on it.
static int32_t nearest(double x, double divisor)
{
    const double quotient = x / divisor;
    return (int32_t)(quotient + (quotient < 0.0 ? -0.5 : 0.5));
}

static bool same_numbers(const struct weft_pass *a, const struct weft_pass *b)
{
    return a->kind == b->kind && a->divisor == b->divisor && a->bias == b->bias &&
           a->part == b->part && a->subtract == b->subtract;
}

static struct row *find_row(struct weft_levels *l, int pass, int64_t weight, bool *found)
{
    const uint64_t hash = (uint64_t)weight + (uint64_t)l->twin[pass] * 977;
    struct row *row = &l->rows[hash % ROWS];
    *found = row->pass == l->twin[pass] && row->weight == weight;
    if (!*found)
        *row = (struct row){.pass = l->twin[pass], .weight = weight};
    return row;
}

// passes/plan/pass.h: n has all signs turned where the pass subtracts.
static inline int32_t change_by(const struct weft_levels *l, const struct weft_pass *p, int32_t n)
{
    const int e = l->extra_bits;
    const int32_t mask = (1 << e) - 1, turned = p->subtract ? -n : n;
    if (p->part == WEFT_PASS_LOW)
        return n & mask;
    const int32_t added = p->part == WEFT_PASS_WHOLE ? (1 << e) / 2 : p->subtract ? mask : 0;
    const int32_t size = (turned + added) >> e;
    return p->subtract ? -size : size;
}

// From n to what the target changes by; false where that is more than 16 bits hold.
static bool take_changes(const struct weft_levels *l, const struct weft_pass *p, const int32_t *n,
                         int16_t *out, int *low, int *high)
{
    int32_t change[LEVELS];
    int out_of_range = 0;
    for (int s = 0; s < LEVELS; s++)
        change[s] = change_by(l, p, n[s]);
    for (int s = 0; s < LEVELS; s++)
        out_of_range |= (change[s] + MOST) | (MOST - change[s]);
    for (int s = 0; s < LEVELS; s++)
        out[s] = (int16_t)change[s];
    int16_t least = INT16_MAX, most = INT16_MIN;
    for (int s = 0; s < LEVELS; s++) {
        least = out[s] < least ? out[s] : least;
        most = out[s] > most ? out[s] : most;
    }
    *low = least;
    *high = most;
    return out_of_range >= 0; // no sign is set
}

// n is odd in its signs, so that turning them can wait.
static void make_sums(const struct weft_levels *l, const struct weft_pass *p, int64_t weight,
                      int32_t *out)
{
    const double factor = ldexp((double)weight, l->extra_bits), divisor = p->divisor;
    for (int s = 0; s < LEVELS; s++)
        out[s] = nearest(factor * s + p->bias * divisor, divisor);
}

static const struct row *sum_row(struct weft_levels *l, int pass, int64_t weight)
{
    const struct weft_pass *p = &l->list->passes[pass];
    bool found;
    struct row *row = find_row(l, pass, weight, &found);
    if (found)
        return row;
    const double largest =
        fabs(ldexp((double)weight * l->one, l->extra_bits)) / p->divisor + fabs((double)p->bias);
    int32_t n[LEVELS];
    if (!(largest < MOST_INSIDE))
        return row;
    make_sums(l, p, weight, n);
    row->fits = take_changes(l, p, n, l->changes[row - l->rows], &row->low, &row->high);
    return row;
}

static int most_inside(const struct weft_levels *l)
{
    return l->narrow ? MOST : MOST_INSIDE;
}

static void look_up(const struct weft_levels *l, int64_t code, int32_t out[LEVELS])
{
    for (int s = 0; s < LEVELS; s++) {
        const uint32_t entry = s < l->one && code < l->one ? l->list->log_table[s + code] : 0;
        out[s] = entry < MOST_INSIDE ? (int32_t)entry : MOST_INSIDE;
    }
}

// Of one tap: its products at all levels, by its weight (with its shift) or the logarithm's code.
static const struct row *product_row(struct weft_levels *l, int pass, int64_t weight)
{
    const struct weft_pass *p = &l->list->passes[pass];
    bool found;
    struct row *row = find_row(l, pass, weight, &found);
    if (found)
        return row;
    int32_t products[LEVELS];
    const double factor = ldexp((double)weight, l->extra_bits);
    if (l->list->log_table)
        look_up(l, weight, products);
    else if (factor * l->one / p->divisor < MOST_INSIDE)
        for (int s = 0; s < LEVELS; s++)
            products[s] = nearest(factor * s, p->divisor);
    else
        return row;
    for (int s = 0; s < LEVELS; s++)
        row->high = products[s] > row->high ? products[s] : row->high;
    row->fits = row->high <= most_inside(l);
    union levels *out = &l->products[row - l->rows];
    for (int s = 0; s < LEVELS; s++)
        if (l->narrow)
            out->narrow[s] = (int16_t)products[s];
        else
            out->wide[s] = products[s];
    return row;
}

// ---- sums of a pass -----------------------------------------------------------------------------

// With signs and shifts; false where shifts are none that passes have.
static bool load_weights(struct weft_levels *l, const struct weft_tap_group *group, int c,
                         size_t first, int count, int64_t *out)
{
    if (l->list->log_table)
        weft_range_load_codes(l->list, group->tile[c], first, count, l->value);
    else
        weft_range_load(l->list, group->tile[c], first, count, l->value);
    const int shift = l->list->log_table ? 0 : group->shift[c];
    if (shift < 0 || shift > 16)
        return false;
    for (int i = 0; i < count; i++)
        out[i] = (int64_t)l->value[i] << shift;
    return true;
}

static bool sum_weights(struct weft_levels *l, const struct weft_pass *p, size_t first, int count)
{
    int64_t weights[AT_ONCE];
    memset(l->weights, 0, sizeof l->weights);
    for (int g = p->group_first; g < p->group_first + p->group_count; g++) {
        const struct weft_tap_group *group = &l->list->groups[g];
        for (int c = 0; c < weft_range_components(l->list); c++) {
            if (group->tile[c] < 0)
                continue;
            if (!load_weights(l, group, c, first, count, weights))
                return false;
            for (int i = 0; i < count; i++)
                l->weights[i] += group->sign[c] * weights[i];
        }
    }
    return true;
}

static void add_wide(int32_t *restrict n, const int32_t *restrict product, bool negative)
{
    if (negative)
        for (int s = 0; s < LEVELS; s++)
            n[s] -= product[s];
    else
        for (int s = 0; s < LEVELS; s++)
            n[s] += product[s];
}

static void add_narrow(int16_t *restrict n, const int16_t *restrict product, bool negative)
{
    if (negative)
        for (int s = 0; s < LEVELS; s++)
            n[s] = (int16_t)(n[s] - product[s]);
    else
        for (int s = 0; s < LEVELS; s++)
            n[s] = (int16_t)(n[s] + product[s]);
}

static int32_t inside_at(const struct weft_levels *l, int i, int s)
{
    return l->narrow ? l->inside[i].narrow[s] : l->inside[i].wide[s];
}

static bool add_products(struct weft_levels *l, int pass, const struct weft_tap_group *group, int c,
                         size_t first, int count)
{
    int64_t weights[AT_ONCE];
    if (!load_weights(l, group, c, first, count, weights))
        return false;
    for (int i = 0; i < count; i++) {
        const struct row *row = product_row(l, pass, weights[i]);
        l->reach[i] += row->high;
        if (!row->fits || l->reach[i] > most_inside(l))
            return false;
        const union levels *product = &l->products[row - l->rows];
        if (row->high && l->narrow)
            add_narrow(l->inside[i].narrow, product->narrow, group->sign[c] < 0);
        else if (row->high)
            add_wide(l->inside[i].wide, product->wide, group->sign[c] < 0);
    }
    return true;
}

// The bias may be there from the start, as it is here, or come last. What is below the limit in sum
// of magnitudes is looked at no closer.
static void note_peaks(struct weft_levels *l, const struct weft_pass *p, int count)
{
    for (int i = 0; isfinite(l->limit) && i < count; i++) {
        int low = 0, high = 0;
        for (int s = 0; (double)l->reach[i] > l->limit && s < LEVELS; s++) {
            const int n = inside_at(l, i, s);
            low = n < low ? n : low;
            low = n - p->bias < low ? n - p->bias : low;
            high = n > high ? n : high;
            high = n - p->bias > high ? n - p->bias : high;
        }
        const int peak = -low > high ? -low : high;
        l->peak[i] = peak > l->peak[i] ? peak : l->peak[i];
    }
}

// False where sums may pass 32 bits.
static bool sum_products(struct weft_levels *l, int pass, size_t first, int count)
{
    const struct weft_pass *p = &l->list->passes[pass];
    const int components = weft_range_components(l->list);
    if (abs(p->bias) > most_inside(l))
        return false;
    for (int i = 0; i < count; i++) {
        l->peak[i] = 0;
        l->reach[i] = abs(p->bias);
        for (int s = 0; s < LEVELS; s++)
            if (l->narrow)
                l->inside[i].narrow[s] = (int16_t)p->bias;
            else
                l->inside[i].wide[s] = p->bias;
    }
    for (int g = p->group_first; g < p->group_first + p->group_count; g++) {
        const struct weft_tap_group *group = &l->list->groups[g];
        for (int c = 0; c < components; c++) {
            if (group->tile[c] >= 0 && !add_products(l, pass, group, c, first, count))
                return false;
            if (c == 2 && l->list->dot_width == 3)
                note_peaks(l, p, count);
        }
        note_peaks(l, p, count);
    }
    return true;
}

// ---- targets ------------------------------------------------------------------------------------

static struct bounds add_row(int16_t *restrict slot, const int16_t *restrict changes)
{
    int16_t low = INT16_MAX, high = INT16_MIN;
    for (int s = 0; s < LEVELS; s++) {
        const int16_t y = (int16_t)(slot[s] + changes[s]);
        slot[s] = y;
        low = y < low ? y : low;
        high = y > high ? y : high;
    }
    return (struct bounds){low, high};
}

static bool change_slot(struct weft_levels *l, int target, int i, const int16_t *changes, int low,
                        int high)
{
    struct bounds *b = &l->bounds[target][i];
    if (b->low + low < -MOST || b->high + high > MOST)
        return false;
    if (low || high)
        *b = add_row(l->slots[target][i], changes);
    return true;
}

static void clear_slots(struct weft_levels *l, const struct weft_pass *p, int count)
{
    for (int i = 0; i < count; i++) {
        for (int s = 0; s < LEVELS; s++)
            l->slots[p->target][i][s] = (int16_t)p->initial;
        l->bounds[p->target][i] = (struct bounds){p->initial, p->initial};
    }
}

static void note_fragment(struct weft_levels *l, const struct weft_pass *p, int low, int high,
                          size_t at, struct weft_range_observed *o)
{
    const int least = p->subtract ? -high : low, most = p->subtract ? -low : high;
    if (p->reads_target || p->part == WEFT_PASS_LOW)
        return;
    weft_range_note(o, least, -least, at);
    weft_range_note(o, most, most - l->one, at);
}

static bool run_taps(struct weft_levels *l, int pass, size_t first, int count,
                     struct weft_range_observed *o)
{
    const struct weft_pass *p = &l->list->passes[pass];
    if (p->clears)
        clear_slots(l, p, count);
    if (l->sums ? !sum_weights(l, p, first, count) : !sum_products(l, pass, first, count))
        return false;
    for (int i = 0; i < count; i++) {
        const int16_t *changes = l->own;
        int low, high;
        if (l->sums) {
            const struct row *row = sum_row(l, pass, l->weights[i]);
            if (!row->fits)
                return false;
            changes = l->changes[row - l->rows];
            low = row->low;
            high = row->high;
        } else {
            int32_t n[LEVELS];
            for (int s = 0; s < LEVELS; s++)
                n[s] = inside_at(l, i, s);
            if (!take_changes(l, p, n, l->own, &low, &high))
                return false;
            if (isfinite(l->limit))
                weft_range_note(o, ldexp(l->peak[i], -l->extra_bits),
                                ldexp(l->peak[i] - l->limit, -l->extra_bits), first + (size_t)i);
        }
        if (!change_slot(l, p->target, i, changes, low, high))
            return false;
        note_fragment(l, p, low, high, first + (size_t)i, o);
    }
    return true;
}

static int64_t divided(int64_t x, int64_t divisor) // halves away from zero
{
    const int64_t size = (2 * llabs(x) + divisor) / (2 * divisor);
    return x < 0 ? -size : size;
}

static int64_t combined(const struct weft_levels *l, const struct weft_pass *p, int i, int s)
{
    const bool rounds = !l->list->exact_inside;
    const int64_t unit = INT64_C(1) << l->extra_bits;
    const int64_t denominator = rounds ? unit : p->denominator;
    int64_t sum = rounds ? divided(p->bias * unit, p->denominator) : p->bias;
    for (int k = 0; k < p->input_count; k++) {
        const int64_t term = (int64_t)p->numerator[k] * l->slots[p->input[k]][i][s];
        sum += rounds ? divided(term * unit, p->denominator) : term;
    }
    sum += denominator / 2;
    return sum / denominator - (sum % denominator < 0);
}

static bool run_combine(struct weft_levels *l, const struct weft_pass *p, int count)
{
    for (int i = 0; i < count; i++) {
        int64_t low = INT64_MAX, high = INT64_MIN;
        for (int s = 0; s < LEVELS; s++) {
            const int64_t y = combined(l, p, i, s);
            low = y < low ? y : low;
            high = y > high ? y : high;
            l->own[s] = (int16_t)y;
        }
        if (low < -MOST || high > MOST)
            return false;
        memcpy(l->slots[p->target][i], l->own, sizeof l->own);
        l->bounds[p->target][i] = (struct bounds){(int)low, (int)high};
    }
    return true;
}

static void note_target(struct weft_levels *l, const struct weft_pass *p, size_t first, int count,
                        struct weft_range_observed *o)
{
    for (int i = 0; i < count; i++) {
        const struct bounds b = l->bounds[p->target][i];
        const size_t at = first + (size_t)i;
        weft_range_note_stored(o, b.low, b.high, at);
        weft_range_note(o, b.low, -b.low, at);
        weft_range_note(o, b.high, b.high - l->one, at);
    }
}

static bool run_some(struct weft_levels *l, size_t first, int count)
{
    for (int n = 0; n < l->list->pass_count; n++) {
        const struct weft_pass *p = &l->list->passes[n];
        if (p->kind == WEFT_PASS_TAPS ? !run_taps(l, n, first, count, &l->seen[n])
                                      : !run_combine(l, p, count))
            return false;
        note_target(l, p, first, count, &l->seen[n]);
    }
    return true;
}

bool weft_levels_run(weft_levels *levels, size_t first, int count,
                     struct weft_range_observed *observed)
{
    const size_t bytes = (size_t)levels->list->pass_count * sizeof *observed;
    memcpy(levels->seen, observed, bytes);
    for (int done = 0; done < count; done += AT_ONCE) {
        const int some = count - done < AT_ONCE ? count - done : AT_ONCE;
        if (!run_some(levels, first + (size_t)done, some))
            return false;
    }
    memcpy(observed, levels->seen, bytes);
    return true;
}

// ---- creation -----------------------------------------------------------------------------------

static bool can_follow(const struct weft_pass_list *list)
{
    const enum weft_tile_format format = weft_kernel_tiles_get_info(list->tiles)->format;
    return list->target == WEFT_TARGET_UNORM8 && list->extra_bits <= 16 &&
           (list->log_table || format == WEFT_TILE_UNORM);
}

static void find_twins(weft_levels *l)
{
    for (int i = 0; i < l->list->pass_count; i++) {
        const struct weft_pass *p = &l->list->passes[i];
        l->twin[i] = i;
        for (int k = 0; k < 64 && k < i && l->twin[i] == i; k++)
            if (same_numbers(&l->list->passes[k], p))
                l->twin[i] = k;
    }
}

enum weft_result weft_levels_create(const struct weft_log *log, const struct weft_pass_list *list,
                                    weft_levels **out)
{
    const size_t passes = (size_t)list->pass_count, slots = (size_t)list->slot_count;
    *out = NULL;
    if (!can_follow(list))
        return WEFT_OK;
    weft_levels *l = calloc(1, sizeof *l);
    if (!l)
        goto fail;
    l->list = list;
    l->one = weft_target_one(list->target);
    l->extra_bits = list->extra_bits;
    l->sums = list->exact_inside && !list->log_table;
    l->narrow = !list->log_table;
    l->limit = weft_range_limit(list);
    l->twin = calloc(passes, sizeof *l->twin);
    l->rows = malloc(ROWS * sizeof *l->rows);
    l->slots = calloc(slots, sizeof *l->slots);
    l->bounds = calloc(slots, sizeof *l->bounds);
    l->seen = calloc(passes, sizeof *l->seen);
    if (l->sums) {
        l->changes = malloc(ROWS * sizeof *l->changes);
    } else {
        l->products = malloc(ROWS * sizeof *l->products);
        l->inside = malloc(AT_ONCE * sizeof *l->inside);
    }
    if (!l->twin || !l->rows || !l->slots || !l->bounds || !l->seen ||
        !(l->sums ? (void *)l->changes : (void *)l->products) || !(l->sums || l->inside))
        goto fail;
    for (int i = 0; i < ROWS; i++)
        l->rows[i].pass = -1;
    find_twins(l);
    *out = l;
    return WEFT_OK;
fail:
    weft_error(log, "range: not enough memory for the levels of %zu passes and %zu slots", passes,
               slots);
    weft_levels_destroy(&l);
    return WEFT_ERR_MEMORY;
}

void weft_levels_destroy(weft_levels **levels)
{
    weft_levels *l = *levels;
    if (!l)
        return;
    free(l->twin);
    free(l->rows);
    free(l->changes);
    free(l->products);
    free(l->slots);
    free(l->bounds);
    free(l->inside);
    free(l->seen);
    free(l);
    *levels = NULL;
}
