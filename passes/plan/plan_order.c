// SPDX-License-Identifier: BSD-3-Clause
// A sum at a sample position must never leave [0, divisor] (WSCG 2003, section 4). What has been
// summed depends on which bundles were placed, not on their order, so the search goes through sets:
// a beam of sets of equal size, grown by one bundle at a time. It looks at a few positions; what it
// finds is checked at all of them, and positions that fail join the few.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/plan_impl.h"

enum { CHUNK = WEFT_PLANNER_CHUNK, MAX_POSITIONS = 6000, JOIN_AT_ONCE = 96 };
static const int beam_widths[] = {12, 96}, most_rounds[] = {24, 8};

enum weft_result weft_pass_plan_order_create(const struct weft_log *log, int items,
                                             struct weft_pass_plan_order *out)
{
    const size_t n = (size_t)items + 1;
    *out = (struct weft_pass_plan_order){.item_count = items,
                                         .item = calloc(n, sizeof(int)),
                                         .pass_end = calloc(n, sizeof(int)),
                                         .bias = calloc(n, sizeof(int))};
    if (out->item && out->pass_end && out->bias)
        return WEFT_OK;
    weft_error(log, "plan: not enough memory to order %d groups of taps", items);
    weft_pass_plan_order_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_pass_plan_order_destroy(struct weft_pass_plan_order *order)
{
    free(order->item);
    free(order->pass_end);
    free(order->bias);
    *order = (struct weft_pass_plan_order){0};
}

// What is placed at once: neighbours in `item`.
struct bundle {
    int first, count;
    bool subtracts; // has a weight below 0
};

// A set of placed bundles. Sums and what is left to subtract follow it in memory.
struct state {
    int parent, bundle; // in the history
    int steps, at;      // of bias, and the place that carries it: -1 is before the first
    int steps_left, last_adding;
    int32_t peak; // largest sum since the last place that can carry bias
    uint64_t hash;
    double score;
};

struct step {
    int parent, bundle, steps, at;
};

struct search {
    const struct weft_planner *planner;
    bool mixed;
    int bundle_count, positions, limit;
    int *item; // of bundles
    struct bundle *bundles;
    uint32_t *position;
    int32_t *value; // [bundle][position]
    int beam;
    int factor;                        // of values
    int quantum, quantum_codes, steps; // bias: its step in values and codes, how many
    struct state *now, *next;
    int32_t *sums[2], *left[2]; // [state][position]
    uint64_t *used[2];          // [state][words]
    int words;
    struct step *history; // [bundle][state]
    int best_place;       // deepest reached; its best set is the first
};

// ---- bundles
// --------------------------------------------------------------------------------------

static void sort_by_largest(const struct weft_planner *planner, int *item, int count)
{
    for (int i = 1; i < count; i++) {
        const int moved = item[i];
        int j = i;
        for (; j > 0 && planner->items[item[j - 1]].largest < planner->items[moved].largest; j--)
            item[j] = item[j - 1];
        item[j] = moved;
    }
}

// Deals the items of one sign to as many bundles as are needed for `size` each, large and small
// ones together, so that the bundles are alike.
static void deal(struct search *s, int first, int count, int size, bool subtracts)
{
    int dealt[count ? count : 1];
    const int bundles = (count + size - 1) / size;
    memcpy(dealt, s->item + first, (size_t)count * sizeof *dealt);
    for (int i = 0, at = first; i < bundles; i++) {
        const int start = at;
        for (int round = 0; round * bundles < count; round++) {
            const int from = round * bundles + (round % 2 ? bundles - 1 - i : i);
            if (from < count)
                s->item[at++] = dealt[from];
        }
        s->bundles[s->bundle_count++] = (struct bundle){start, at - start, subtracts};
    }
}

// With passes of one sign, up to `size` items of it make an bundle.
static void make_bundles(struct search *s, int size)
{
    const struct weft_planner *planner = s->planner;
    int adding = 0, subtracting = 0;
    s->bundle_count = 0;
    for (int sign = 0; sign < 2; sign++)
        for (int i = 0; i < planner->item_count; i++)
            if (!(planner->items[i].signs & WEFT_PASS_PLAN_SUBTRACTS) == !sign)
                s->item[sign ? adding + subtracting++ : adding++] = i;
    sort_by_largest(planner, s->item, adding);
    sort_by_largest(planner, s->item + adding, subtracting);
    deal(s, 0, adding, size, false);
    deal(s, adding, subtracting, size, true);
}

static void find_values(struct search *s, const uint32_t *position, size_t count, int bundle,
                        int32_t *out)
{
    memset(out, 0, count * sizeof *out);
    for (int i = 0; i < s->bundles[bundle].count; i++)
        weft_planner_add_values(s->planner,
                                &s->planner->items[s->item[s->bundles[bundle].first + i]], count,
                                position, out);
    for (size_t i = 0; s->factor > 1 && i < count; i++)
        out[i] *= s->factor;
}

// ---- positions ----------------------------------------------------------------------------------

static void choose_positions(struct search *s)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(s->planner->plan->tiles);
    const int m = info->samples, most = info->dims > 2 ? 7 : 20, n = m < most ? m : most;
    int at[3] = {0};
    s->positions = 0;
    for (at[2] = 0; at[2] < (info->dims > 2 ? n : 1); at[2]++)
        for (at[1] = 0; at[1] < n; at[1]++)
            for (at[0] = 0; at[0] < n; at[0]++) {
                size_t index = 0;
                for (int a = info->dims - 1; a >= 0; a--)
                    index = index * (size_t)m + (size_t)(n > 1 ? at[a] * (m - 1) / (n - 1) : 0);
                s->position[s->positions++] = (uint32_t)index;
            }
}

// ---- a beam of sets -----------------------------------------------------------------------------

// What is added to the hash of a set with an bundle (splitmix64).
static uint64_t item_hash(int bundle)
{
    uint64_t h = (uint64_t)(bundle + 1) * UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    return h ^ h >> 31;
}

struct trial {
    struct state state;
    int32_t bias;
};

// Of sums with an bundle's values added.
static void find_bounds(const int32_t *sum, const int32_t *value, size_t count, int32_t *least,
                        int32_t *most)
{
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (size_t k = 0; k < count; k++) {
        const int32_t x = sum[k] + value[k];
        low = x < low ? x : low;
        high = x > high ? x : high;
    }
    *least = low;
    *most = high;
}

// How bad a set is: what is still to be subtracted should be little, and sums low but enough for
// it.
static double find_score(const int32_t *sum, const int32_t *left, const int32_t *value,
                         size_t count)
{
    int64_t to_subtract = 0, missing = 0, high = 0;
    for (size_t k = 0; k < count; k++) {
        const int32_t x = sum[k] + value[k], l = left[k] + (value[k] < 0 ? value[k] : 0);
        to_subtract += l;
        missing += l > x ? l - x : 0;
        high += l > 0 ? x : 0;
    }
    return 4.0 * (double)to_subtract + (double)missing + 0.25 * (double)high;
}

// Whether an bundle can come next, what it needs in bias, and how good the set is then.
static bool try_bundle(const struct search *s, int place, int from, int bundle, struct trial *out)
{
    const struct state *state = &s->now[from];
    const size_t n = (size_t)s->positions;
    const int32_t *sum = s->sums[0] + (size_t)from * n, *value = s->value + (size_t)bundle * n;
    const bool adds = s->mixed || !s->bundles[bundle].subtracts;
    int32_t least, most;
    find_bounds(sum, value, n, &least, &most);
    const int steps = least < 0 ? (-least + s->quantum - 1) / s->quantum : 0;
    const int32_t bias = steps * s->quantum;
    // At the end, all of the bias must be somewhere: see spend_bias.
    const int32_t more = place + 1 < s->bundle_count ? bias : state->steps_left * s->quantum;
    if (steps > state->steps_left || most + (adds ? more : bias) > s->limit ||
        (!adds && more && state->peak + more > s->limit))
        return false;
    const double score = find_score(sum, s->left[0] + (size_t)from * n, value, n);
    *out = (struct trial){{.parent = from,
                           .bundle = bundle,
                           .steps = steps,
                           .at = state->last_adding,
                           .steps_left = state->steps_left - steps,
                           .last_adding = state->last_adding,
                           .peak = state->peak + (adds ? 0 : bias),
                           .hash = state->hash + item_hash(bundle),
                           .score = score + (double)n * bias},
                          bias};
    return true;
}

static bool is_used(const struct search *s, int state, int bundle)
{
    return s->used[0][(size_t)state * (size_t)s->words + (size_t)bundle / 64] >> bundle % 64 & 1;
}

// Keeps the best `beam` of different sets, sorted.
static void keep(const struct search *s, struct trial *kept, int *count, const struct trial *new)
{
    int at = *count;
    for (int i = 0; i < *count; i++) {
        if (kept[i].state.hash != new->state.hash)
            continue;
        if (kept[i].state.score <= new->state.score)
            return;
        memmove(kept + i, kept + i + 1, (size_t)(--*count - i) * sizeof *kept);
        at = *count;
        break;
    }
    if (at == s->beam && kept[at - 1].state.score <= new->state.score)
        return;
    at -= at == s->beam;
    for (; at > 0 && kept[at - 1].state.score > new->state.score; at--)
        kept[at] = kept[at - 1];
    kept[at] = *new;
    *count += *count < s->beam;
}

static void apply(struct search *s, int place, int to, const struct trial *t)
{
    const size_t n = (size_t)s->positions, words = (size_t)s->words;
    const size_t from = (size_t)t->state.parent, bundle = (size_t)t->state.bundle;
    int32_t *sum = s->sums[1] + (size_t)to * n, *left = s->left[1] + (size_t)to * n;
    const int32_t *value = s->value + bundle * n;
    struct state *state = &s->next[to];
    *state = t->state;
    memcpy(s->used[1] + (size_t)to * words, s->used[0] + from * words, words * sizeof(uint64_t));
    s->used[1][(size_t)to * words + bundle / 64] |= UINT64_C(1) << bundle % 64;
    int32_t most = 0;
    for (size_t k = 0; k < n; k++) {
        sum[k] = s->sums[0][from * n + k] + value[k] + t->bias;
        left[k] = s->left[0][from * n + k] + (value[k] < 0 ? value[k] : 0);
        most = sum[k] > most ? sum[k] : most;
    }
    if (s->mixed || !s->bundles[bundle].subtracts) {
        state->last_adding = state->at = place;
        state->peak = most;
    }
    s->history[(size_t)place * (size_t)s->beam + (size_t)to] =
        (struct step){t->state.parent, (int)bundle, state->steps, state->at};
}

static void swap_generations(struct search *s)
{
    struct state *states = s->now;
    s->now = s->next;
    s->next = states;
    int32_t *array = s->sums[0];
    s->sums[0] = s->sums[1];
    s->sums[1] = array;
    array = s->left[0];
    s->left[0] = s->left[1];
    s->left[1] = array;
    uint64_t *used = s->used[0];
    s->used[0] = s->used[1];
    s->used[1] = used;
}

static void start(struct search *s)
{
    const size_t n = (size_t)s->positions;
    memset(s->sums[0], 0, n * sizeof(int32_t));
    memset(s->left[0], 0, n * sizeof(int32_t));
    memset(s->used[0], 0, (size_t)s->words * sizeof(uint64_t));
    for (int i = 0; i < s->bundle_count; i++)
        for (size_t k = 0; k < n; k++)
            s->left[0][k] -= s->value[(size_t)i * n + k] < 0 ? s->value[(size_t)i * n + k] : 0;
    s->now[0] = (struct state){.parent = -1, .last_adding = -1, .steps_left = s->steps};
    s->best_place = -1;
}

// All bundles placed? The deepest set reached is kept either way.
static bool grow(struct search *s, struct trial *kept)
{
    int states = 1;
    start(s);
    for (int place = 0; place < s->bundle_count; place++) {
        int count = 0;
        for (int from = 0; from < states; from++) {
            for (int bundle = 0; bundle < s->bundle_count; bundle++) {
                struct trial t;
                if (!is_used(s, from, bundle) && try_bundle(s, place, from, bundle, &t))
                    keep(s, kept, &count, &t);
            }
        }
        if (!count)
            return false;
        for (int i = 0; i < count; i++)
            apply(s, place, i, &kept[i]);
        swap_generations(s);
        states = count;
        s->best_place = place;
    }
    return true;
}

// ---- what was found -----------------------------------------------------------------------------

// Items by place, and bias steps by place (0: before the first).
static void trace_back(const struct search *s, int *bundle, int *steps)
{
    int state = 0;
    memset(steps, 0, ((size_t)s->bundle_count + 1) * sizeof *steps);
    for (int place = s->best_place; place >= 0; place--) {
        const struct step *step = &s->history[(size_t)place * (size_t)s->beam + (size_t)state];
        bundle[place] = step->bundle;
        steps[step->at + 1] += step->steps;
        state = step->parent;
    }
}

// Bias that nothing asked for goes where the sums are final, or as late as it can.
static void spend_bias(const struct search *s, const int *bundle, int *steps)
{
    int left = s->steps, last = 0;
    for (int i = 0; i <= s->bundle_count; i++)
        left -= steps[i];
    for (int i = 0; i < s->bundle_count; i++)
        if (s->mixed || !s->bundles[bundle[i]].subtracts)
            last = i + 1;
    steps[last] += left;
}

// Adds up everything at all positions; those that fail join the search. false when there are any.
static bool check_all(struct search *s, const int *bundle, const int *steps)
{
    uint32_t position[CHUNK];
    int32_t sum[CHUNK], value[CHUNK];
    int joined = 0;
    size_t count;
    for (size_t first = 0;
         joined < JOIN_AT_ONCE && (count = weft_planner_chunk(s->planner, first, position));
         first += count) {
        bool bad[CHUNK] = {false};
        for (size_t i = 0; i < count; i++)
            sum[i] = steps[0] * s->quantum;
        for (int place = 0; place < s->bundle_count; place++) {
            find_values(s, position, count, bundle[place], value);
            for (size_t i = 0; i < count; i++) {
                sum[i] += value[i] + steps[place + 1] * s->quantum;
                bad[i] = bad[i] || sum[i] < 0 || sum[i] > s->limit;
            }
        }
        for (size_t i = 0; i < count && joined < JOIN_AT_ONCE; i++)
            if (bad[i] && s->positions < MAX_POSITIONS) {
                s->position[s->positions++] = position[i];
                joined++;
            }
    }
    return joined == 0;
}

// ---- searching ----------------------------------------------------------------------------------

static enum weft_result allocate(struct search *s)
{
    const size_t n = MAX_POSITIONS, beam = (size_t)beam_widths[WEFT_COUNT(beam_widths) - 1];
    const size_t items = (size_t)s->planner->item_count + 1;
    s->words = (int)(items / 64 + 1);
    s->item = malloc(items * sizeof *s->item);
    s->bundles = malloc(items * sizeof *s->bundles);
    s->position = malloc(n * sizeof *s->position);
    s->value = malloc(items * n * sizeof *s->value);
    s->now = malloc(beam * sizeof *s->now);
    s->next = malloc(beam * sizeof *s->next);
    s->history = malloc(items * beam * sizeof *s->history);
    for (int i = 0; i < 2; i++) {
        s->sums[i] = malloc(beam * n * sizeof(int32_t));
        s->left[i] = malloc(beam * n * sizeof(int32_t));
        s->used[i] = malloc(beam * (size_t)s->words * sizeof(uint64_t));
    }
    if (s->item && s->bundles && s->position && s->value && s->now && s->next && s->history &&
        s->sums[0] && s->sums[1] && s->left[0] && s->left[1] && s->used[0] && s->used[1])
        return WEFT_OK;
    weft_error(s->planner->p.log, "plan: not enough memory to order %zu groups of taps", items);
    return WEFT_ERR_MEMORY;
}

static void release(struct search *s)
{
    free(s->item);
    free(s->bundles);
    free(s->position);
    free(s->value);
    free(s->now);
    free(s->next);
    free(s->history);
    for (int i = 0; i < 2; i++) {
        free(s->sums[i]);
        free(s->left[i]);
        free(s->used[i]);
    }
}

// One way of making bundles, with wider and wider beams; *found, or not.
static enum weft_result search_bundles(struct search *s, int beams, int *bundle, int *steps,
                                       bool *found)
{
    struct trial kept[beam_widths[WEFT_COUNT(beam_widths) - 1] + 1];
    *found = false;
    choose_positions(s);
    for (int b = 0; b < beams; b++) {
        s->beam = beam_widths[b];
        for (int round = 0; round < most_rounds[b]; round++) {
            if (weft_planner_cancelled(s->planner))
                return WEFT_ERR_CANCELLED;
            for (int i = 0; i < s->bundle_count; i++)
                find_values(s, s->position, (size_t)s->positions, i,
                            s->value + (size_t)i * (size_t)s->positions);
            if (!grow(s, kept))
                break;
            trace_back(s, bundle, steps);
            spend_bias(s, bundle, steps);
            if (check_all(s, bundle, steps)) {
                *found = true;
                return WEFT_OK;
            }
        }
    }
    return WEFT_OK;
}

// ---- passes -------------------------------------------------------------------------------------

// Items in a row become passes: up to taps_per_pass items, of one sign unless mixed.
static void write_order(const struct search *s, const int *bundle, const int *steps,
                        struct weft_pass_plan_order *out)
{
    int at = 0, passes = 0, held = 0;
    bool subtracts = false;
    out->initial = steps[0] * s->quantum_codes;
    for (int place = 0; place < s->bundle_count; place++) {
        const struct bundle *i = &s->bundles[bundle[place]];
        const bool joins = passes && held + i->count <= s->planner->p.taps_per_pass &&
                           (s->mixed || i->subtracts == subtracts);
        passes += !joins;
        held = joins ? held + i->count : i->count;
        subtracts = i->subtracts;
        for (int a = 0; a < i->count; a++)
            out->item[at++] = s->item[i->first + a];
        if (!joins)
            out->bias[passes - 1] = 0;
        out->pass_end[passes - 1] = at;
        out->bias[passes - 1] += steps[place + 1] * s->quantum_codes;
    }
    out->pass_count = passes;
}

// The items that could not be placed come last; returns how many were.
static int write_stuck(struct search *s, int *bundle, int *steps, struct weft_pass_plan_order *out)
{
    int placed = s->best_place + 1, items = 0;
    trace_back(s, bundle, steps);
    for (int place = 0; place <= s->best_place; place++)
        items += s->bundles[bundle[place]].count;
    for (int i = 0; i < s->bundle_count; i++) {
        bool there = false;
        for (int place = 0; place <= s->best_place; place++)
            there = there || bundle[place] == i;
        if (!there)
            bundle[placed++] = i;
    }
    spend_bias(s, bundle, steps);
    write_order(s, bundle, steps, out);
    // All in a row, but not at all positions: nothing tells which are in the way.
    return items < s->planner->item_count ? items : 0;
}

// Where a code is no whole value, all values are counted in finer units.
static void set_bias(struct search *s)
{
    const struct weft_planner *planner = s->planner;
    const int64_t step = (int64_t)planner->divisor * planner->bias_step;
    s->factor = planner->bias && step % planner->full ? planner->full : 1;
    s->limit = planner->divisor * s->factor;
    s->quantum = planner->bias ? (int)(step * s->factor / planner->full) : 1;
    s->quantum_codes = planner->bias_step;
    s->steps = planner->bias / planner->bias_step;
}

static enum weft_result search(struct search *s, bool wide, struct weft_pass_plan_order *order,
                               int *placed)
{
    const size_t items = (size_t)s->planner->item_count + 1;
    int *bundle = malloc(items * sizeof *bundle), *steps = malloc((items + 1) * sizeof *steps);
    enum weft_result res = allocate(s);
    bool found = false;
    if (res == WEFT_OK && (!bundle || !steps)) {
        weft_error(s->planner->p.log, "plan: not enough memory for %zu places", items);
        res = WEFT_ERR_MEMORY;
    }
    set_bias(s);
    // Passes of one sign are best made before they are ordered.
    for (int size = s->mixed ? 1 : s->planner->p.taps_per_pass; res == WEFT_OK && !found && size;
         size--) {
        make_bundles(s, size);
        res = search_bundles(s, wide ? WEFT_COUNT(beam_widths) : 1, bundle, steps, &found);
        if (found)
            write_order(s, bundle, steps, order);
    }
    if (res == WEFT_OK && !found)
        *placed = write_stuck(s, bundle, steps, order);
    free(bundle);
    free(steps);
    return res;
}

// ---- orders that are not searched for -----------------------------------------------------------

static void write_natural(struct search *s, struct weft_pass_plan_order *order)
{
    int bundle[s->bundle_count + 1], steps[s->bundle_count + 1];
    for (int i = 0; i < s->bundle_count; i++) {
        bundle[i] = i;
        steps[i + 1] = 0;
    }
    steps[0] = 0;
    spend_bias(s, bundle, steps);
    if (s->planner->p.single_bias || s->planner->p.worst_case == WEFT_WORST_ANY) {
        memset(steps, 0, sizeof steps);
        steps[0] = s->steps;
    }
    write_order(s, bundle, steps, order);
}

static void make_natural_bundles(struct search *s)
{
    s->bundle_count = s->planner->item_count;
    for (int i = 0; i < s->bundle_count; i++) {
        s->item[i] = i;
        s->bundles[i] =
            (struct bundle){i, 1, s->planner->items[i].signs & WEFT_PASS_PLAN_SUBTRACTS};
    }
}

// The first that fits, as long as one does; then the rest as it comes.
static void sort_greedily(struct search *s)
{
    choose_positions(s);
    s->beam = 1;
    for (int i = 0; i < s->bundle_count; i++)
        find_values(s, s->position, (size_t)s->positions, i,
                    s->value + (size_t)i * (size_t)s->positions);
    start(s);
    for (int place = 0; place < s->bundle_count; place++) {
        struct trial t;
        int next = place;
        while (next < s->bundle_count && !try_bundle(s, place, 0, s->bundles[next].first, &t))
            next++;
        if (next == s->bundle_count)
            return;
        const struct bundle chosen = s->bundles[next];
        memmove(s->bundles + place + 1, s->bundles + place,
                (size_t)(next - place) * sizeof *s->bundles);
        s->bundles[place] = chosen;
        apply(s, place, 0, &t);
        swap_generations(s);
    }
}

enum weft_result weft_planner_order(const struct weft_planner *planner, bool mixed, bool wide,
                                    struct weft_pass_plan_order *order, int *placed)
{
    struct search s = {.planner = planner, .mixed = mixed};
    const bool any = planner->p.worst_case == WEFT_WORST_ANY; // no order is better than another
    *placed = planner->item_count;
    if (!planner->real && planner->p.order == WEFT_ORDER_PLANNED && !any) {
        enum weft_result res = search(&s, wide, order, placed);
        release(&s);
        return res;
    }
    enum weft_result res = allocate(&s);
    if (res == WEFT_OK) {
        set_bias(&s);
        if (planner->p.order == WEFT_ORDER_PLANNED && !planner->real)
            make_bundles(&s, mixed ? 1 : planner->p.taps_per_pass);
        else
            make_natural_bundles(&s);
        if (planner->p.order == WEFT_ORDER_GREEDY && !planner->real)
            sort_greedily(&s);
        write_natural(&s, order);
    }
    release(&s);
    return res;
}
