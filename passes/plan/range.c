// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/range.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/range_impl.h"

enum { CHUNK = 1024, FEW = 64 };

static const double TOLERANCE = 1e-9;

// What a slot may hold at the positions of a chunk, in codes.
struct slot {
    // Each pass at its own worst: of integers, to the code.
    double low[CHUNK], high[CHUNK];
    // Before floors. Constant: where the source is 0, and where it is 1, before roundings; it is
    // linear between them. Any: the least and the most of what the passes compute.
    double end[2][CHUNK];
    double slack[CHUNK];             // how far roundings may be off the line between the ends
    double loss[CHUNK], gain[CHUNK]; // the most that floors took from it, or low parts left in it
};

struct simulation {
    const struct weft_pass_list *list;
    const struct weft_kernel_tiles_info *tiles;
    bool any, unorm, saturates;
    double one, unit; // T, and T 2^e; half and float: 1
    double step;      // 2^e
    double table_error;
    const double *largest_after; // of the log table, from an entry on
    struct weft_range_observed *observed;
    struct slot *slots;
    weft_levels *levels;
    size_t first; // position of the chunk
    int count;
    double value[CHUNK];
    // Of a pass's products: the negative ones and the positive ones, in units of 1 / divisor.
    double sum[2][CHUNK];
    double rounded[2][CHUNK]; // the same once every product is rounded, in 2^-e codes
    double least_n[CHUNK], most_n[CHUNK];
    double low_change[CHUNK], high_change[CHUNK];
    double inside[CHUNK]; // how far n may be off its exact value, in codes
    double peak[CHUNK];   // largest magnitude inside the pass, in 2^-e codes
    struct slot combined;
};

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double most(double a, double b)
{
    return a > b ? a : b;
}

// Halves away from zero: sums of 32 bits by divisors are far from half-way, or on it.
static double nearest(double x)
{
    return fabs(x) < 0x1p52 ? (double)(int64_t)(x < 0.0 ? x - 0.5 : x + 0.5) : x;
}

// ---- sums of products ---------------------------------------------------------------------------

// In 2^-e codes, what a source of 1 gives; of any source, if its entries do not fall, the most.
static void look_up_products(struct simulation *s)
{
    for (int i = 0; i < s->count; i++) {
        const int code = (int)s->value[i];
        s->value[i] = code >= (int)s->one ? 0.0
                      : s->any            ? s->largest_after[code]
                                          : s->list->log_table[code];
    }
}

static double divisor_of(const struct simulation *s, const struct weft_pass *p)
{
    return s->list->log_table ? s->unit : p->divisor;
}

// Below a half, what is rounded away is itself.
static double rounding_of(double magnitude)
{
    return magnitude < 0.5 ? magnitude : 0.5;
}

static void add_rounded(struct simulation *s, double factor, double divisor)
{
    for (int i = 0; i < s->count; i++) {
        const double product = factor * s->value[i];
        const double codes = product * s->unit / divisor;
        s->rounded[product > 0.0][i] += nearest(codes);
        s->inside[i] += s->list->log_table ? (product != 0.0 ? s->table_error : 0.0)
                                           : rounding_of(fabs(codes)) / s->step;
    }
}

static void add_products(struct simulation *s, double factor, double divisor)
{
    if (s->unorm && (!s->list->exact_inside || s->list->log_table))
        add_rounded(s, factor, divisor);
    for (int i = 0; i < s->count; i++) {
        const double product = factor * s->value[i];
        s->sum[0][i] += product > 0.0 ? 0.0 : product;
        s->sum[1][i] += product > 0.0 ? product : 0.0;
    }
}

// The bias may be there from the start or come last.
static void note_inside(struct simulation *s, double bias)
{
    for (int i = 0; i < s->count; i++) {
        const double total = s->rounded[0][i] + s->rounded[1][i];
        const double slack = s->any ? 0.0 : s->inside[i] * s->step;
        const double low = s->any ? s->rounded[0][i] : least(0.0, total) - slack;
        const double high = s->any ? s->rounded[1][i] : most(0.0, total) + slack;
        const double below = least(low, low + bias), above = most(high, high + bias);
        s->peak[i] = most(s->peak[i], most(-below, above));
    }
}

static void sum_group(struct simulation *s, const struct weft_pass *p,
                      const struct weft_tap_group *group)
{
    for (int c = 0; c < weft_range_components(s->list); c++) {
        if (group->tile[c] >= 0) {
            const double factor = s->list->log_table ? 1.0 : ldexp(1.0, group->shift[c]);
            if (s->list->log_table) {
                weft_range_load_codes(s->list, group->tile[c], s->first, s->count, s->value);
                look_up_products(s);
            } else {
                weft_range_load(s->list, group->tile[c], s->first, s->count, s->value);
            }
            add_products(s, group->sign[c] * factor, divisor_of(s, p));
        }
        if (s->saturates && c == 2 && s->list->dot_width == 3)
            note_inside(s, p->bias);
    }
    if (s->saturates)
        note_inside(s, p->bias);
}

// The least and the most of the pass's integer, at a source of 0 or of 1 for constants: n rises or
// falls with them.
static void bound_n(struct simulation *s, const struct weft_pass *p)
{
    const double divisor = divisor_of(s, p);
    const bool sums = s->list->exact_inside && !s->list->log_table;
    for (int i = 0; i < s->count; i++) {
        const double total = s->sum[0][i] + s->sum[1][i];
        const double rounded = s->rounded[0][i] + s->rounded[1][i];
        const double low = s->any ? s->sum[0][i] : least(0.0, total);
        const double high = s->any ? s->sum[1][i] : most(0.0, total);
        if (sums) {
            s->least_n[i] = nearest((low * s->unit + p->bias * divisor) / divisor);
            s->most_n[i] = nearest((high * s->unit + p->bias * divisor) / divisor);
            s->inside[i] = rounding_of(fabs(total) * s->unit / divisor) / s->step;
        } else if (s->any) {
            s->least_n[i] = s->rounded[0][i] + p->bias;
            s->most_n[i] = s->rounded[1][i] + p->bias;
        } else {
            // Products of both signs are rounded by themselves: their sum need not rise steadily.
            const bool steady = !s->list->log_table && s->sum[0][i] * s->sum[1][i] == 0.0;
            const double slack = steady ? 0.0 : floor(2.0 * s->inside[i] * s->step);
            s->least_n[i] = least(0.0, rounded) + p->bias - slack;
            s->most_n[i] = most(0.0, rounded) + p->bias + slack;
        }
    }
}

static void sum_products(struct simulation *s, const struct weft_pass *p)
{
    for (int i = 0; i < s->count; i++) {
        s->sum[0][i] = s->sum[1][i] = 0.0;
        s->rounded[0][i] = s->rounded[1][i] = 0.0;
        s->peak[i] = s->inside[i] = 0.0;
    }
    for (int g = 0; g < p->group_count; g++)
        sum_group(s, p, &s->list->groups[p->group_first + g]);
    if (s->unorm)
        bound_n(s, p);
}

// ---- passes -------------------------------------------------------------------------------------

static void clear(struct simulation *s, struct slot *slot, double initial)
{
    for (int i = 0; i < s->count; i++) {
        slot->low[i] = slot->high[i] = slot->end[0][i] = slot->end[1][i] = initial;
        slot->slack[i] = slot->loss[i] = slot->gain[i] = 0.0;
    }
}

// What n makes of the target, passes/plan/pass.h: rises with n.
static double change_by(const struct simulation *s, const struct weft_pass *p, double n)
{
    if (s->step == 1.0)
        return n;
    if (p->part == WEFT_PASS_HIGH)
        return floor(n / s->step);
    const double half = floor(s->step / 2.0);
    return p->subtract ? -floor((half - n) / s->step) : floor((n + half) / s->step);
}

static void find_changes(struct simulation *s, const struct weft_pass *p)
{
    for (int i = 0; i < s->count; i++) {
        const double low = s->least_n[i], high = s->most_n[i];
        if (p->part != WEFT_PASS_LOW) {
            s->low_change[i] = change_by(s, p, low);
            s->high_change[i] = change_by(s, p, high);
            continue;
        }
        const double below = s->step * floor(low / s->step);
        const bool wraps = high - below >= s->step;
        s->low_change[i] = wraps ? 0.0 : low - below;
        s->high_change[i] = wraps ? s->step - 1.0 : high - below;
    }
}

// Ends of what is linear in the source; high parts count with what their floors leave.
static void move_ends(struct simulation *s, const struct weft_pass *p, struct slot *slot)
{
    const double divisor = divisor_of(s, p), bias = p->bias / s->step;
    const bool whole = p->part == WEFT_PASS_WHOLE;
    for (int i = 0; i < s->count; i++) {
        if (s->any) {
            slot->end[0][i] += whole ? s->low_change[i] : s->least_n[i] / s->step;
            slot->end[1][i] += whole ? s->high_change[i] : s->most_n[i] / s->step;
            continue;
        }
        slot->end[0][i] += bias;
        slot->end[1][i] += bias + (s->sum[0][i] + s->sum[1][i]) * s->one / divisor;
        slot->slack[i] += s->inside[i];
        if (whole && s->step > 1.0)
            slot->slack[i] +=
                s->high_change[i] > s->low_change[i] ? 0.5 : fabs(s->low_change[i] - bias);
    }
}

static void change_target(struct simulation *s, const struct weft_pass *p, struct slot *slot)
{
    find_changes(s, p);
    if (p->part != WEFT_PASS_LOW)
        move_ends(s, p, slot);
    for (int i = 0; i < s->count; i++) {
        slot->low[i] += s->low_change[i];
        slot->high[i] += s->high_change[i];
        if (p->part == WEFT_PASS_LOW)
            slot->gain[i] += s->high_change[i];
        const bool floors = s->most_n[i] > s->least_n[i] || fmod(s->least_n[i], s->step) != 0.0;
        if (p->part == WEFT_PASS_HIGH && floors)
            slot->loss[i] += (s->step - 1.0) / s->step;
    }
}

static void change_real(struct simulation *s, const struct weft_pass *p, struct slot *slot)
{
    const double divisor = divisor_of(s, p);
    for (int i = 0; i < s->count; i++) {
        const double low = s->sum[0][i], high = s->sum[1][i];
        slot->end[0][i] += p->bias + (s->any ? low / divisor : 0.0);
        slot->end[1][i] += p->bias + (s->any ? high : low + high) / divisor;
    }
}

// Stored codes are whole numbers.
static double lower(const struct simulation *s, const struct slot *slot, int i)
{
    const double end = least(slot->end[0][i], slot->end[1][i]);
    if (!s->unorm)
        return end;
    return s->any ? slot->low[i]
                  : most(slot->low[i], ceil(end - slot->slack[i] - slot->loss[i] - 1e-6));
}

static double upper(const struct simulation *s, const struct slot *slot, int i)
{
    const double end = most(slot->end[0][i], slot->end[1][i]);
    if (!s->unorm)
        return end;
    return s->any ? slot->high[i]
                  : least(slot->high[i], floor(end + slot->slack[i] + slot->gain[i] + 1e-6));
}

// ---- combining ----------------------------------------------------------------------------------

// Of a code's share of the sum, in units of the result: where products are rounded inside, to 2^-e.
static double share_of(const struct simulation *s, const struct weft_pass *p, double numerator,
                       double code)
{
    const double share = numerator * code / p->denominator;
    return s->unorm && !s->list->exact_inside ? nearest(share * s->step) / s->step : share;
}

static void add_input(struct simulation *s, const struct weft_pass *p, int k)
{
    struct slot *out = &s->combined;
    const struct slot *in = &s->slots[p->input[k]];
    const double numerator = p->numerator[k], share = numerator / p->denominator;
    const double size = fabs(share);
    const bool turned = share < 0.0;
    const bool rounds = s->unorm && !s->list->exact_inside && fmod(share * s->step, 1.0) != 0.0;
    const double rounding = rounds ? 0.5 / s->step : 0.0;
    for (int i = 0; i < s->count; i++) {
        const double low = lower(s, in, i), high = upper(s, in, i);
        out->low[i] += share_of(s, p, numerator, turned ? high : low);
        out->high[i] += share_of(s, p, numerator, turned ? low : high);
        out->end[0][i] += share * in->end[turned && s->any][i];
        out->end[1][i] += share * in->end[!(turned && s->any)][i];
        out->slack[i] += size * in->slack[i] + rounding;
        out->loss[i] += size * (turned ? in->gain[i] : in->loss[i]);
        out->gain[i] += size * (turned ? in->loss[i] : in->gain[i]);
    }
}

// floor((sum + denominator / 2) / denominator), of a sum that is given in codes.
static double nearest_code(const struct simulation *s, const struct weft_pass *p, double codes)
{
    const double denominator = s->list->exact_inside ? (double)p->denominator : s->step;
    const double half = floor(denominator / 2.0) / denominator;
    // Sums are multiples of 1 / denominator: what division leaves below one is none.
    return floor(codes + half + 0.25 / denominator);
}

static void combine(struct simulation *s, const struct weft_pass *p, bool settled)
{
    struct slot *out = &s->combined;
    clear(s, out, share_of(s, p, 1.0, p->bias));
    for (int k = 0; k < p->input_count; k++)
        add_input(s, p, k);
    for (int i = 0; s->unorm && i < s->count; i++) {
        const double slack = out->slack[i];
        out->low[i] = nearest_code(s, p, out->low[i]);
        out->high[i] = nearest_code(s, p, out->high[i]);
        out->slack[i] += 0.5;
        if (settled) {
            out->loss[i] = out->gain[i] = 0.0;
            out->low[i] = most(out->low[i],
                               nearest_code(s, p, least(out->end[0][i], out->end[1][i]) - slack));
            out->high[i] = least(out->high[i],
                                 nearest_code(s, p, most(out->end[0][i], out->end[1][i]) + slack));
        }
        if (s->any) {
            out->end[0][i] = out->low[i];
            out->end[1][i] = out->high[i];
        }
    }
    s->slots[p->target] = *out;
}

// ---- observation --------------------------------------------------------------------------------

static void observe_inside(struct simulation *s, struct weft_range_observed *o)
{
    const double limit = weft_range_limit(s->list);
    for (int i = 0; i < s->count; i++)
        weft_range_note(o, s->peak[i] / s->step, (s->peak[i] - limit) / s->step,
                        s->first + (size_t)i);
}

static void observe_fragment(struct simulation *s, const struct weft_pass *p,
                             struct weft_range_observed *o)
{
    for (int i = 0; i < s->count; i++) {
        const double change[2] = {s->low_change[i], s->high_change[i]};
        for (int k = 0; k < 2; k++) {
            const double n = p->subtract ? -change[k] : change[k];
            weft_range_note(o, n, most(-n, n - s->one), s->first + (size_t)i);
        }
    }
}

static void observe_target(struct simulation *s, const struct slot *slot,
                           struct weft_range_observed *o)
{
    for (int i = 0; i < s->count; i++) {
        const double low = lower(s, slot, i), high = upper(s, slot, i);
        const size_t at = s->first + (size_t)i;
        weft_range_note_stored(o, low, high, at);
        if (s->unorm) {
            weft_range_note(o, low, -low, at);
            weft_range_note(o, high, high - s->one, at);
        }
    }
}

static void run_taps(struct simulation *s, const struct weft_pass *p, struct weft_range_observed *o)
{
    struct slot *slot = &s->slots[p->target];
    if (p->clears)
        clear(s, slot, p->initial);
    sum_products(s, p);
    if (s->saturates)
        observe_inside(s, o);
    if (s->unorm)
        change_target(s, p, slot);
    else
        change_real(s, p, slot);
    if (s->unorm && !p->reads_target && p->part != WEFT_PASS_LOW)
        observe_fragment(s, p, o);
}

static void run_chunk(struct simulation *s)
{
    if (s->levels && weft_levels_run(s->levels, s->first, s->count, s->observed))
        return;
    for (int i = 0; i < s->list->pass_count; i++) {
        const struct weft_pass *p = &s->list->passes[i];
        if (p->kind == WEFT_PASS_TAPS)
            run_taps(s, p, &s->observed[i]);
        else
            combine(s, p, s->observed[i].settled);
        observe_target(s, &s->slots[p->target], &s->observed[i]);
    }
}

static enum weft_result run_chunks(struct simulation *s, size_t every,
                                   const struct weft_progress *progress)
{
    const size_t positions = s->tiles->tile_values, size = every > 1 ? FEW : CHUNK;
    for (s->first = 0; s->first < positions; s->first += size * every) {
        s->count = (int)(positions - s->first < size ? positions - s->first : size);
        run_chunk(s);
        const double fraction = (double)(s->first + (size_t)s->count) / (double)positions;
        if (progress && progress->report && !progress->report(progress->priv, fraction))
            return WEFT_ERR_CANCELLED;
    }
    return WEFT_OK;
}

// ---- the whole ----------------------------------------------------------------------------------

static void locate(const struct simulation *s, size_t at, int position[3])
{
    const size_t m = (size_t)s->tiles->samples;
    position[0] = (int)(at % m);
    position[1] = (int)(at / m % m);
    position[2] = (int)(at / m / m);
}

static void report_ranges(const struct simulation *s, struct weft_range *ranges)
{
    for (int i = 0; i < s->list->pass_count; i++) {
        const struct weft_range_observed *o = &s->observed[i];
        ranges[i].minimum = o->minimum / s->one;
        ranges[i].maximum = o->maximum / s->one;
        locate(s, o->minimum_at, ranges[i].minimum_at);
        locate(s, o->maximum_at, ranges[i].maximum_at);
    }
}

static void report_validity(const struct simulation *s, struct weft_range_report *report)
{
    *report = (struct weft_range_report){.valid = true};
    for (int i = 0; i < s->list->pass_count; i++) {
        const struct weft_range_observed *o = &s->observed[i];
        if (o->excursion <= TOLERANCE)
            continue;
        report->overflow = most(report->overflow, o->excursion / s->one);
        if (!report->valid)
            continue;
        report->valid = false;
        report->pass = i;
        report->value = o->value / s->one;
        locate(s, o->excursion_at, report->position);
    }
}

static void destroy(struct simulation *s)
{
    if (s) {
        weft_levels_destroy(&s->levels);
        free(s->observed);
        free(s->slots);
        free((double *)s->largest_after);
    }
    free(s);
}

// Where entries do not fall as powers of two do, by up to so much: twice, as both ends have it.
static enum weft_result measure_table(struct simulation *s)
{
    const int one = (int)s->one, last = 2 * one;
    const uint32_t *table = s->list->log_table;
    double *largest = malloc(((size_t)last + 1) * sizeof *largest), off = 0.0;
    if (!largest)
        return WEFT_ERR_MEMORY;
    for (int i = last; i >= 0; i--)
        largest[i] = i < last ? most(largest[i + 1], table[i]) : table[i];
    for (int i = 0; i <= 2 * (one - 1); i++) {
        const double exact = table[0] * exp2(-i * s->list->log_octaves / (one - 1.0));
        off = most(off, fabs(table[i] - exact));
    }
    s->largest_after = largest;
    s->table_error = 2.0 * off / s->step;
    return WEFT_OK;
}

static enum weft_result create(const struct weft_log *log, const struct weft_pass_list *list,
                               enum weft_worst_case worst_case, struct simulation **out)
{
    enum weft_result res = WEFT_ERR_MEMORY;
    struct simulation *s = *out = calloc(1, sizeof *s);
    if (!s)
        goto fail;
    s->list = list;
    s->tiles = weft_kernel_tiles_get_info(list->tiles);
    s->any = worst_case == WEFT_WORST_ANY;
    s->observed = calloc((size_t)list->pass_count, sizeof *s->observed);
    s->slots = calloc((size_t)list->slot_count, sizeof *s->slots);
    if (!s->observed || !s->slots)
        goto fail;
    res = weft_range_check(log, list, s->observed);
    if (res != WEFT_OK)
        return res;
    s->unorm = weft_target_bits(list->target) > 0;
    s->one = s->unorm ? weft_target_one(list->target) : 1.0;
    s->step = s->unorm ? ldexp(1.0, list->extra_bits) : 1.0;
    s->unit = s->one * s->step;
    s->saturates = isfinite(weft_range_limit(list));
    for (int i = 0; i < list->pass_count; i++) {
        s->observed[i].minimum = INFINITY;
        s->observed[i].maximum = -INFINITY;
    }
    if (list->log_table && measure_table(s) != WEFT_OK) {
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    return s->any ? WEFT_OK : weft_levels_create(log, list, &s->levels);
fail:
    weft_error(log, "range: not enough memory for %d passes and %d slots", list->pass_count,
               list->slot_count);
    return res;
}

enum weft_result weft_range_simulate_some(const struct weft_log *log,
                                          const struct weft_pass_list *passes,
                                          enum weft_worst_case worst_case, size_t every,
                                          const struct weft_progress *progress,
                                          struct weft_range *ranges,
                                          struct weft_range_report *report)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct simulation *s = NULL;
    weft_require(log, passes && report);
    weft_require(log, worst_case == WEFT_WORST_CONSTANT || worst_case == WEFT_WORST_ANY);
    weft_require(log, passes->tiles && passes->pass_count > 0 && passes->slot_count > 0);
    res = create(log, passes, worst_case, &s);
    if (res == WEFT_OK)
        res = run_chunks(s, every, progress);
    if (res != WEFT_OK)
        goto fail;
    report_validity(s, report);
    if (ranges)
        report_ranges(s, ranges);
fail:
    destroy(s);
    return res;
}

enum weft_result weft_range_simulate(const struct weft_log *log,
                                     const struct weft_pass_list *passes,
                                     enum weft_worst_case worst_case,
                                     const struct weft_progress *progress,
                                     struct weft_range *ranges, struct weft_range_report *report)
{
    return weft_range_simulate_some(log, passes, worst_case, 1, progress, ranges, report);
}
