// SPDX-License-Identifier: BSD-3-Clause
#include "passes/range.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"

enum { CHUNK = 1024, MAX_EXTRA_BITS = 24, MAX_SHIFT = 31 };

static const double TOLERANCE = 1e-9;

// What a slot may hold at the positions of a chunk, in units of full range.
struct slot {
    // Before floors. Constant: where the source is 0, and where it is 1; it is linear between them.
    // Any: the least and the most.
    double end[2][CHUNK];
    double loss[CHUNK], gain[CHUNK]; // the most that floors took from it, or low parts left in it
    // A second bound from below: each pass at its own worst. It is the better one where all passes
    // add, as floors of what is positive are not negative.
    double floors[CHUNK];
};

// Whether a slot holds something, and which floors took from it what has to be given back.
struct ledger {
    bool written;
    uint64_t owed;
};

// A pass, over all chunks so far. Positions are numbered, x fastest.
struct observed {
    bool settled; // combining: nothing is owed any more, the sums are whole again
    double minimum, maximum;
    double excursion, value;
    size_t minimum_at, maximum_at, excursion_at;
};

struct simulation {
    const struct weft_log *log;
    const struct weft_pass_list *list;
    const struct weft_kernel_tiles_info *tiles;
    bool any, unorm, saturates;
    double one, unit; // T, and T 2^e; half and float: 1
    int mask;         // 2^e - 1
    struct observed *observed;
    struct ledger *ledgers;
    struct slot *slots;
    size_t first; // position of the chunk
    int count;
    double value[CHUNK];
    // Of a pass's products: the negative ones and the positive ones, in units of 1 / divisor; then
    // what they and the bias may change, as in struct slot.
    double sum[2][CHUNK];
    double rounded[2][CHUNK]; // split parts: least and most of the pass's integer, in 2^-e codes
    double peak[CHUNK];       // largest magnitude inside the pass, in units of 1 / divisor
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

static int components(const struct weft_pass_list *list)
{
    return list->dot4 ? 4 : 1;
}

// ---- what is given ------------------------------------------------------------------------------

static bool within(const struct simulation *s, int pass, const char *what, int value, int low,
                   int high)
{
    if (value >= low && value <= high)
        return true;
    weft_error(s->log, "range: pass %d: %s %d, not %d to %d", pass, what, value, low, high);
    return false;
}

static bool check_group(const struct simulation *s, int pass, const struct weft_tap_group *group)
{
    for (int c = 0; c < components(s->list); c++) {
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

static bool check_taps(const struct simulation *s, int pass)
{
    const struct weft_pass_list *list = s->list;
    const struct weft_pass *p = &list->passes[pass];
    if (!within(s, pass, "part", (int)p->part, WEFT_PASS_WHOLE, WEFT_PASS_LOW) ||
        !within(s, pass, "divisor", p->divisor, 1, INT_MAX) ||
        !within(s, pass, "group count", p->group_count, 0, WEFT_PASS_MAX_GROUPS) ||
        !within(s, pass, "first group", p->group_first, 0, list->group_count - p->group_count))
        return false;
    if (s->unorm && p->clears && !within(s, pass, "initial", p->initial, 0, (int)s->one))
        return false;
    for (int g = 0; g < p->group_count; g++)
        if (!check_group(s, pass, &list->groups[p->group_first + g]))
            return false;
    return true;
}

static bool check_written(const struct simulation *s, int pass, int slot)
{
    if (!within(s, pass, "slot", slot, 0, s->list->slot_count - 1))
        return false;
    if (s->ledgers[slot].written)
        return true;
    weft_error(s->log, "range: pass %d: slot %d is read but holds nothing", pass, slot);
    return false;
}

static bool check_combine(const struct simulation *s, int pass)
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

static bool check_pass(const struct simulation *s, int pass)
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
        for (int c = 0; c < components(list); c++) {
            const bool used = group->tile[c] >= 0;
            hash = mix(hash, group->tile[c]);
            hash = mix(hash, used ? group->sign[c] : 0);
            hash = mix(hash, used ? group->shift[c] : 0);
        }
    }
    return hash;
}

static void enter_taps(struct simulation *s, const struct weft_pass *p)
{
    struct ledger *target = &s->ledgers[p->target];
    if (p->clears)
        target->owed = 0;
    target->written = true;
    if (p->part == WEFT_PASS_WHOLE || s->mask == 0)
        return;
    // In units of 2^-e codes.
    const uint64_t hash = remainder_hash(s->list, p);
    target->owed += p->part == WEFT_PASS_LOW ? hash << s->list->extra_bits : 0 - hash;
}

static void enter_combine(struct simulation *s, int pass)
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

static enum weft_result enter_passes(struct simulation *s)
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

// ---- sums of products ---------------------------------------------------------------------------

static void load_row(const struct simulation *s, const struct weft_kernel_tile *tile, size_t from,
                     ptrdiff_t step, int count, double *out)
{
    switch (s->tiles->format) {
    case WEFT_TILE_UNORM: {
        const uint16_t *q = (const uint16_t *)tile->data + from;
        for (int i = 0; i < count; i++)
            out[i] = q[i * step];
        return;
    }
    case WEFT_TILE_SNORM: {
        const int16_t *q = (const int16_t *)tile->data + from;
        for (int i = 0; i < count; i++)
            out[i] = q[i * step];
        return;
    }
    case WEFT_TILE_HALF:
    case WEFT_TILE_FLOAT:
        break;
    }
    const float *q = (const float *)tile->data + from;
    for (int i = 0; i < count; i++)
        out[i] = (double)q[i * step];
}

// What the tile stores at the chunk's positions. Along axes past dims, index and mirrored are 0.
static void load(struct simulation *s, int number)
{
    const struct weft_kernel_tile *tile = weft_kernel_tiles_get(s->list->tiles, number);
    const size_t m = (size_t)s->tiles->samples;
    int count;
    for (int done = 0; done < s->count; done += count) {
        const size_t at = s->first + (size_t)done;
        size_t index[3] = {at % m, at / m % m, at / m / m};
        const size_t left = m - index[0];
        count = left < (size_t)(s->count - done) ? (int)left : s->count - done;
        for (int a = 0; a < 3; a++)
            index[a] = tile->mirrored[a] ? m - 1 - index[a] : index[a];
        load_row(s, tile, (index[2] * m + index[1]) * m + index[0], tile->mirrored[0] ? -1 : 1,
                 count, &s->value[done]);
    }
}

static void look_up_products(struct simulation *s)
{
    const double octaves = s->list->log_octaves, least_weight = exp2(-octaves);
    for (int i = 0; i < s->count; i++) {
        const double weight = fabs(s->value[i]);
        const double code = round(-log2(weight) * (s->one - 1.0) / octaves);
        s->value[i] = weight < least_weight ? 0.0 : s->list->log_table[code > 0.0 ? (int)code : 0];
    }
}

static void add_products(struct simulation *s, double factor)
{
    for (int i = 0; i < s->count; i++) {
        const double product = factor * s->value[i];
        s->sum[product > 0.0][i] += product;
    }
}

static void add_rounded(struct simulation *s, double factor, double divisor)
{
    for (int i = 0; i < s->count; i++) {
        const double product = factor * s->value[i];
        s->rounded[product > 0.0][i] += round(product * s->unit / divisor);
    }
}

// The bias may be there from the start or come last.
static void note_inside(struct simulation *s, double bias)
{
    for (int i = 0; i < s->count; i++) {
        const double total = s->sum[0][i] + s->sum[1][i];
        const double low = s->any ? s->sum[0][i] : total, high = s->any ? s->sum[1][i] : total;
        const double below = least(low, low + bias), above = most(high, high + bias);
        s->peak[i] = most(s->peak[i], most(-below, above));
    }
}

static double divisor_of(const struct simulation *s, const struct weft_pass *p)
{
    return s->list->log_table ? s->unit : p->divisor;
}

static void sum_group(struct simulation *s, const struct weft_pass *p,
                      const struct weft_tap_group *group)
{
    const double divisor = divisor_of(s, p), bias = p->bias * divisor / s->unit;
    const bool rounds = p->part != WEFT_PASS_WHOLE && !s->list->exact_inside;
    for (int c = 0; c < components(s->list); c++) {
        if (group->tile[c] >= 0) {
            const double factor = s->list->log_table ? 1.0 : ldexp(1.0, group->shift[c]);
            load(s, group->tile[c]);
            if (s->list->log_table)
                look_up_products(s);
            add_products(s, group->sign[c] * factor);
            if (rounds)
                add_rounded(s, group->sign[c] * factor, divisor);
        }
        if (s->saturates && c == 2 && s->list->dot_width == 3)
            note_inside(s, bias);
    }
    if (s->saturates)
        note_inside(s, bias);
}

static void sum_products(struct simulation *s, const struct weft_pass *p)
{
    for (int i = 0; i < s->count; i++) {
        s->sum[0][i] = s->sum[1][i] = 0.0;
        s->rounded[0][i] = s->rounded[1][i] = 0.0;
        s->peak[i] = 0.0;
    }
    for (int g = 0; g < p->group_count; g++)
        sum_group(s, p, &s->list->groups[p->group_first + g]);
}

// ---- passes -------------------------------------------------------------------------------------

static void clear(struct simulation *s, struct slot *slot, double initial)
{
    for (int i = 0; i < s->count; i++) {
        slot->end[0][i] = slot->end[1][i] = slot->floors[i] = initial;
        slot->loss[i] = slot->gain[i] = 0.0;
    }
}

static void round_sums(struct simulation *s, const struct weft_pass *p)
{
    const double divisor = divisor_of(s, p);
    for (int i = 0; i < s->count; i++) {
        const double total = s->sum[0][i] + s->sum[1][i];
        const double end[2] = {s->any ? s->sum[0][i] : least(0.0, total),
                               s->any ? s->sum[1][i] : most(0.0, total)};
        for (int k = 0; k < 2; k++)
            s->rounded[k][i] = s->list->exact_inside ? round(end[k] * s->unit / divisor + p->bias)
                                                     : s->rounded[k][i] + p->bias;
    }
}

static void take_floors(struct simulation *s, const struct weft_pass *p, struct slot *slot)
{
    round_sums(s, p);
    for (int i = 0; i < s->count; i++) {
        const bool touched = s->sum[0][i] < 0.0 || s->sum[1][i] > 0.0;
        slot->floors[i] += floor(s->rounded[0][i] / (s->mask + 1)) / s->one;
        slot->loss[i] += (touched ? s->mask : p->bias & s->mask) / s->unit;
    }
}

// What is below 0 leaves anything: -1 has all bits set.
static void leave_remainders(struct simulation *s, const struct weft_pass *p, struct slot *slot)
{
    round_sums(s, p);
    for (int i = 0; i < s->count; i++) {
        const bool below = s->rounded[0][i] < 0.0;
        slot->gain[i] += (below ? s->mask : least(s->mask, s->rounded[1][i])) / s->one;
    }
}

static void form_changes(struct simulation *s, const struct weft_pass *p)
{
    const double divisor = divisor_of(s, p), bias = p->bias / s->unit;
    for (int i = 0; i < s->count; i++) {
        const double low = s->sum[0][i], high = s->sum[1][i];
        s->sum[0][i] = bias + (s->any ? low / divisor : 0.0);
        s->sum[1][i] = bias + (s->any ? high : low + high) / divisor;
    }
}

static void add_changes(struct simulation *s, const struct weft_pass *p, struct slot *slot)
{
    for (int i = 0; i < s->count; i++) {
        slot->end[0][i] += s->sum[0][i];
        slot->end[1][i] += s->sum[1][i];
        if (p->part == WEFT_PASS_WHOLE)
            slot->floors[i] += least(s->sum[0][i], s->sum[1][i]);
    }
}

static double lower(const struct slot *slot, int i)
{
    return most(least(slot->end[0][i], slot->end[1][i]) - slot->loss[i], slot->floors[i]);
}

static double upper(const struct slot *slot, int i)
{
    return most(slot->end[0][i], slot->end[1][i]) + slot->gain[i];
}

// Adds a share of an input's ends and, as intervals, of what it may hold.
static void add_input(struct simulation *s, struct slot *out, const struct slot *in, double share)
{
    const bool turned = share < 0.0;
    for (int i = 0; i < s->count; i++) {
        const double low = share * lower(in, i), high = share * upper(in, i);
        out->end[0][i] += share * in->end[turned && s->any][i];
        out->end[1][i] += share * in->end[!(turned && s->any)][i];
        out->floors[i] += turned ? high : low;
        out->gain[i] += turned ? low : high;
    }
}

static void combine(struct simulation *s, const struct weft_pass *p, bool settled)
{
    struct slot *out = &s->combined;
    const double denominator = p->denominator;
    clear(s, out, p->bias / denominator / s->one);
    for (int i = 0; i < s->count; i++)
        out->gain[i] = out->floors[i];
    for (int k = 0; k < p->input_count; k++)
        add_input(s, out, &s->slots[p->input[k]], p->numerator[k] / denominator);
    for (int i = 0; i < s->count; i++) {
        const double low = least(out->end[0][i], out->end[1][i]);
        const double high = most(out->end[0][i], out->end[1][i]);
        out->floors[i] = settled ? low : out->floors[i];
        out->loss[i] = low - out->floors[i];
        out->gain[i] = settled ? 0.0 : out->gain[i] - high;
    }
    s->slots[p->target] = *out;
}

// ---- observation --------------------------------------------------------------------------------

static void note(struct observed *o, double value, double excursion, size_t at)
{
    if (excursion <= o->excursion)
        return;
    o->excursion = excursion;
    o->value = value;
    o->excursion_at = at;
}

static void observe_inside(struct simulation *s, const struct weft_pass *p, struct observed *o)
{
    const double divisor = divisor_of(s, p);
    for (int i = 0; i < s->count; i++)
        note(o, s->peak[i] / divisor, s->peak[i] / divisor - s->list->range, s->first + (size_t)i);
}

static void observe_fragment(struct simulation *s, const struct weft_pass *p, struct observed *o)
{
    for (int i = 0; i < s->count; i++) {
        for (int k = 0; k < 2; k++) {
            const double n = p->subtract ? -s->sum[k][i] : s->sum[k][i];
            note(o, n, most(-n, n - 1.0), s->first + (size_t)i);
        }
    }
}

static void observe_target(struct simulation *s, const struct slot *slot, struct observed *o)
{
    for (int i = 0; i < s->count; i++) {
        const double low = lower(slot, i), high = upper(slot, i);
        const size_t at = s->first + (size_t)i;
        if (low < o->minimum) {
            o->minimum = low;
            o->minimum_at = at;
        }
        if (high > o->maximum) {
            o->maximum = high;
            o->maximum_at = at;
        }
        if (s->unorm) {
            note(o, low, -low, at);
            note(o, high, high - 1.0, at);
        }
    }
}

static void run_taps(struct simulation *s, const struct weft_pass *p, struct observed *o)
{
    struct slot *slot = &s->slots[p->target];
    if (p->clears)
        clear(s, slot, p->initial / s->one);
    sum_products(s, p);
    if (s->saturates)
        observe_inside(s, p, o);
    if (p->part == WEFT_PASS_LOW) {
        leave_remainders(s, p, slot);
        return;
    }
    if (p->part == WEFT_PASS_HIGH)
        take_floors(s, p, slot);
    form_changes(s, p);
    add_changes(s, p, slot);
    if (s->unorm && !p->reads_target)
        observe_fragment(s, p, o);
}

static void run_chunk(struct simulation *s)
{
    for (int i = 0; i < s->list->pass_count; i++) {
        const struct weft_pass *p = &s->list->passes[i];
        if (p->kind == WEFT_PASS_TAPS)
            run_taps(s, p, &s->observed[i]);
        else
            combine(s, p, s->observed[i].settled);
        observe_target(s, &s->slots[p->target], &s->observed[i]);
    }
}

static enum weft_result run_chunks(struct simulation *s, const struct weft_progress *progress)
{
    const size_t positions = s->tiles->tile_values;
    for (s->first = 0; s->first < positions; s->first += (size_t)s->count) {
        s->count = positions - s->first < CHUNK ? (int)(positions - s->first) : CHUNK;
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
        const struct observed *o = &s->observed[i];
        ranges[i].minimum = o->minimum;
        ranges[i].maximum = o->maximum;
        locate(s, o->minimum_at, ranges[i].minimum_at);
        locate(s, o->maximum_at, ranges[i].maximum_at);
    }
}

static void report_validity(const struct simulation *s, struct weft_range_report *report)
{
    *report = (struct weft_range_report){.valid = true};
    for (int i = 0; i < s->list->pass_count; i++) {
        const struct observed *o = &s->observed[i];
        if (o->excursion <= TOLERANCE)
            continue;
        report->overflow = most(report->overflow, o->excursion);
        if (!report->valid)
            continue;
        report->valid = false;
        report->pass = i;
        report->value = o->value;
        locate(s, o->excursion_at, report->position);
    }
}

static void destroy(struct simulation *s)
{
    if (s) {
        free(s->observed);
        free(s->ledgers);
        free(s->slots);
    }
    free(s);
}

static struct simulation *create(const struct weft_log *log, const struct weft_pass_list *list)
{
    struct simulation *s = calloc(1, sizeof *s);
    if (!s)
        goto fail;
    s->log = log;
    s->list = list;
    s->tiles = weft_kernel_tiles_get_info(list->tiles);
    s->unorm = list->target == WEFT_TARGET_UNORM8 || list->target == WEFT_TARGET_UNORM16;
    s->one = s->unorm ? weft_target_one(list->target) : 1.0;
    s->unit = ldexp(s->one, list->extra_bits);
    s->mask = (1 << list->extra_bits) - 1;
    s->saturates = s->unorm && !list->exact_inside && isfinite(list->range);
    s->observed = calloc((size_t)list->pass_count, sizeof *s->observed);
    s->ledgers = calloc((size_t)list->slot_count, sizeof *s->ledgers);
    s->slots = calloc((size_t)list->slot_count, sizeof *s->slots);
    if (!s->observed || !s->ledgers || !s->slots)
        goto fail;
    for (int i = 0; i < list->pass_count; i++) {
        s->observed[i].minimum = INFINITY;
        s->observed[i].maximum = -INFINITY;
    }
    return s;
fail:
    weft_error(log, "range: not enough memory for %d passes and %d slots", list->pass_count,
               list->slot_count);
    destroy(s);
    return NULL;
}

enum weft_result weft_range_simulate(const struct weft_log *log,
                                     const struct weft_pass_list *passes,
                                     enum weft_worst_case worst_case,
                                     const struct weft_progress *progress,
                                     struct weft_range *ranges, struct weft_range_report *report)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct simulation *s = NULL;
    weft_require(log, passes && report);
    weft_require(log, worst_case == WEFT_WORST_CONSTANT || worst_case == WEFT_WORST_ANY);
    res = check_list(log, passes);
    if (res != WEFT_OK)
        goto fail;
    res = WEFT_ERR_MEMORY;
    s = create(log, passes);
    if (!s)
        goto fail;
    s->any = worst_case == WEFT_WORST_ANY;
    res = enter_passes(s);
    if (res == WEFT_OK)
        res = run_chunks(s, progress);
    if (res != WEFT_OK)
        goto fail;
    report_validity(s, report);
    if (ranges)
        report_ranges(s, ranges);
fail:
    destroy(s);
    return res;
}
