// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "filter/check.h"
#include "passes/plan/range.h"

enum { MAX_PASSES = 400 };

static weft_kernel_tiles *make(const struct weft_kernel_tiles_params *params)
{
    weft_kernel_tiles *set = NULL;
    struct weft_kernel_tiles_params p = *params;
    p.log = &log_to_stderr;
    assert_int_equal(weft_kernel_tiles_create(&p, &set), WEFT_OK);
    return set;
}

static weft_kernel_tiles *make_unorm8(const char *kernel, int dims, int samples,
                                      enum weft_tile_rounding rounding)
{
    return make(weft_kernel_tiles_params(.kernel = kernel_named(kernel), .dims = dims,
                                         .samples = samples, .rounding = rounding,
                                         .scaling = WEFT_TILE_SCALE_SET));
}

static bool next(const weft_kernel_tiles *set, int at[3])
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    for (int a = 0; a < info->dims; a++) {
        if (++at[a] < info->samples)
            return true;
        at[a] = 0;
    }
    return false;
}

static int tile_count(const weft_kernel_tiles *set)
{
    return weft_kernel_tiles_get_info(set)->tile_count;
}

static uint64_t seed = 1;

static int random_below(int count)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (int)((seed >> 33) % (uint64_t)count);
}

// ---- lists made by hand -------------------------------------------------------------------------

struct list {
    struct weft_tap_group groups[MAX_PASSES];
    struct weft_pass passes[MAX_PASSES];
    struct weft_pass_list list;
};

static struct list *start(const weft_kernel_tiles *set, enum weft_target_format target)
{
    static struct list made;
    made = (struct list){.list = {.tiles = set,
                                  .target = target,
                                  .dims = weft_kernel_tiles_get_info(set)->dims,
                                  .exact_inside = true,
                                  .range = INFINITY,
                                  .slot_count = 4,
                                  .groups = made.groups,
                                  .passes = made.passes,
                                  .result_scale = 1.0}};
    return &made;
}

// A group of one tap, to the pass that was added last.
static void add_group(struct list *l, int tile)
{
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(l->list.tiles, tile);
    struct weft_tap_group *group = &l->groups[l->list.group_count++];
    assert_true(l->list.group_count <= MAX_PASSES);
    *group = (struct weft_tap_group){.tile = {tile, -1, -1, -1}, .sign = {t->negated ? -1 : 1}};
    memcpy(group->offset, t->tap, sizeof group->offset);
    l->passes[l->list.pass_count - 1].group_count++;
}

static struct weft_pass *add_pass(struct list *l, int slot)
{
    struct weft_pass *pass = &l->passes[l->list.pass_count++];
    assert_true(l->list.pass_count <= MAX_PASSES);
    *pass = (struct weft_pass){.target = slot,
                               .clears = true,
                               .reads_target = true,
                               .divisor = 255,
                               .group_first = l->list.group_count};
    for (const struct weft_pass *p = l->passes; p < pass; p++)
        pass->clears = pass->clears && p->target != slot;
    return pass;
}

static struct weft_pass *add_tile(struct list *l, int slot, int tile)
{
    struct weft_pass *pass = add_pass(l, slot);
    add_group(l, tile);
    pass->subtract = weft_kernel_tiles_get(l->list.tiles, tile)->negated;
    return pass;
}

static struct weft_pass *add_combine(struct list *l, int slot, int a, int numerator_a, int b,
                                     int numerator_b, int denominator)
{
    struct weft_pass *pass = add_pass(l, slot);
    pass->kind = WEFT_PASS_COMBINE;
    pass->input_count = 2;
    pass->input[0] = a;
    pass->input[1] = b;
    pass->numerator[0] = numerator_a;
    pass->numerator[1] = numerator_b;
    pass->denominator = denominator;
    l->list.result = slot;
    return pass;
}

// One tile a pass, in that order; NULL: as they are in the set.
static struct list *add_all(struct list *l, const int *order)
{
    for (int i = 0; i < tile_count(l->list.tiles); i++)
        add_tile(l, 0, order ? order[i] : i);
    return l;
}

static void shuffle(int *order, int count)
{
    for (int i = 0; i < count; i++)
        order[i] = i;
    for (int i = count - 1; i > 0; i--) {
        const int k = random_below(i + 1), kept = order[i];
        order[i] = order[k];
        order[k] = kept;
    }
}

static struct weft_range ranges[MAX_PASSES];

static struct weft_range_report simulate(const struct list *l, enum weft_worst_case worst_case)
{
    struct weft_range_report report;
    assert_int_equal(
        weft_range_simulate(&log_to_stderr, &l->list, worst_case, NULL, ranges, &report), WEFT_OK);
    return report;
}

// ---- whole parts against loops over weft_kernel_tiles_integer -----------------------------------

struct expected {
    double minimum, maximum; // of every pass
    double excursion, value;
    int position[3];
};

static void see(struct expected *e, double low, double high, const int at[3])
{
    const double excursion = -low > high - 1.0 ? -low : high - 1.0;
    e->minimum = low < e->minimum ? low : e->minimum;
    e->maximum = high > e->maximum ? high : e->maximum;
    if (excursion > e->excursion) {
        e->excursion = excursion;
        e->value = -low >= high - 1.0 ? low : high;
        memcpy(e->position, at, 3 * sizeof *at);
    }
}

static int64_t nearest(int64_t x, int64_t divisor) // halves away from zero
{
    const uint64_t twice = 2 * (uint64_t)llabs(x) + (uint64_t)divisor;
    const uint32_t by = 2 * (uint32_t)divisor;
    const int64_t size = (int64_t)(twice >> 32 ? twice / by : (uint32_t)twice / by);
    return x < 0 ? -size : size;
}

// Sums of a pass's integer weights, of either sign.
static void weigh(const struct list *l, const struct weft_pass *p, const int at[3], int64_t sum[2])
{
    sum[0] = sum[1] = 0;
    for (int g = p->group_first; g < p->group_first + p->group_count; g++) {
        const int64_t w = weft_kernel_tiles_integer(l->list.tiles, l->groups[g].tile[0], at);
        sum[w > 0] += w;
    }
}

// The integers of passes/plan/pass.h for one input: a constant of code s, or where s < 0 the one
// that makes every pass's n smallest, and the one that makes it largest.
static void follow(const struct list *l, const int64_t weights[MAX_PASSES][2], int64_t s,
                   const int at[3], struct expected *expected)
{
    const int64_t one = weft_target_one(l->list.target);
    int64_t y[2] = {0, 0};
    for (int i = 0; i < l->list.pass_count; i++) {
        const struct weft_pass *p = &l->passes[i];
        const int64_t sum = weights[i][0] + weights[i][1], bias = (int64_t)p->bias * p->divisor;
        for (int k = 0; k < 2; k++) {
            y[k] = p->clears ? p->initial : y[k];
            y[k] += nearest((s < 0 ? one * weights[i][k] : s * sum) + bias, p->divisor);
        }
        see(&expected[i], (double)y[0] / (double)one, (double)y[1] / (double)one, at);
    }
}

enum { SOME_LEVELS = 97 };

static void accumulate(const struct list *l, bool any, const int at[3], struct expected *expected)
{
    const int64_t one = weft_target_one(l->list.target);
    int64_t weights[MAX_PASSES][2];
    for (int i = 0; i < l->list.pass_count; i++)
        weigh(l, &l->passes[i], at, weights[i]);
    if (any)
        follow(l, weights, -1, at, expected);
    for (int64_t s = 0; !any && s <= one; s += one == 255 ? 1 : one / SOME_LEVELS)
        follow(l, weights, s, at, expected);
    if (!any)
        follow(l, weights, one, at, expected);
}

static double value_at(const struct list *l, bool any, int pass, const int at[3], bool highest)
{
    struct expected here[MAX_PASSES];
    for (int i = 0; i < l->list.pass_count; i++)
        here[i] = (struct expected){.minimum = INFINITY, .maximum = -INFINITY};
    accumulate(l, any, at, here);
    return highest ? here[pass].maximum : here[pass].minimum;
}

// Constants of 16 bits are bounded by the line between black and white, which is half a code for
// every pass off what is stored there, and half a code for every pass; all else to the code.
static void assert_enclosed_nearly(const struct weft_range *range, const struct expected *e,
                                   int pass, double one)
{
    const double slack = (pass + 1.0) / one + 1e-12;
    assert_true(range->minimum <= e->minimum + 1e-12 && range->minimum >= e->minimum - slack);
    assert_true(range->maximum >= e->maximum - 1e-12 && range->maximum <= e->maximum + slack);
}

static struct weft_range_report assert_as_expected(const struct list *l,
                                                   enum weft_worst_case worst_case)
{
    const double close = 1e-12, one = weft_target_one(l->list.target);
    const bool any = worst_case == WEFT_WORST_ANY;
    static struct expected expected[MAX_PASSES];
    const struct weft_range_report report = simulate(l, worst_case);
    int at[3] = {0}, first = -1;
    double overflow = 0.0;
    for (int i = 0; i < l->list.pass_count; i++)
        expected[i] = (struct expected){.minimum = INFINITY, .maximum = -INFINITY};
    do
        accumulate(l, any, at, expected);
    while (next(l->list.tiles, at));
    for (int i = 0; i < l->list.pass_count; i++) {
        first = first < 0 && expected[i].excursion > 1e-9 ? i : first;
        overflow = fmax(overflow, expected[i].excursion);
        if (!any && one > 255.0) {
            assert_enclosed_nearly(&ranges[i], &expected[i], i, one);
            continue;
        }
        assert_near(ranges[i].minimum, expected[i].minimum, close, "minimum");
        assert_near(ranges[i].maximum, expected[i].maximum, close, "maximum");
        if (i % 8 != 0) // positions of some
            continue;
        assert_near(value_at(l, any, i, ranges[i].minimum_at, false), ranges[i].minimum, close,
                    "value at the minimum's position");
        assert_near(value_at(l, any, i, ranges[i].maximum_at, true), ranges[i].maximum, close,
                    "value at the maximum's position");
    }
    if (!any && one > 255.0) {
        assert_true(first < 0 || !report.valid);
        assert_true(report.overflow >= overflow - close);
        return report;
    }
    assert_int_equal(report.valid, first < 0);
    assert_near(report.overflow, first < 0 ? 0.0 : overflow, close, "overflow");
    if (first >= 0) {
        assert_int_equal(report.pass, first);
        assert_near(report.value, expected[first].value, close, "value");
        assert_near(value_at(l, any, first, report.position, report.value > 1.0), report.value,
                    close, "value at the position");
    }
    return report;
}

static void the_natural_order_of_catmull_rom_clamps(void **state)
{
    (void)state;
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 2, 16, WEFT_TILE_SUM_PRESERVING);
    const struct weft_range_report r =
        assert_as_expected(add_all(start(set, WEFT_TARGET_UNORM8), NULL), WEFT_WORST_CONSTANT);
    print_message("catmull-rom, 2D, M 16, natural order: pass %d, (%d, %d), %.4f, overflow %.4f\n",
                  r.pass, r.position[0], r.position[1], r.value, r.overflow);
    assert_false(r.valid);
    // The tap (0, 0) is positive, the next one along x is negative and larger.
    assert_int_equal(r.pass, 1);
    assert_true(r.value < 0.0);
    weft_kernel_tiles_destroy(&set);
}

// All orders at once: what is in a target depends on which tiles are, so 2^16 sets are all there
// is.
struct search {
    double weight[16][16 * 16];
    bool seen[1 << 16];
    int order[16];
};

static bool fits(const struct search *s, int used)
{
    for (int i = 0; i < 16 * 16; i++) {
        double sum = 0.0;
        for (int t = 0; t < 16; t++)
            sum += used >> t & 1 ? s->weight[t][i] : 0.0;
        if (sum < -1e-9 || sum > 1.0 + 1e-9)
            return false;
    }
    return true;
}

static bool extend(struct search *s, int used, int depth)
{
    if (depth == 16)
        return true;
    for (int t = 0; t < 16; t++) {
        const int more = used | 1 << t;
        if (more == used || s->seen[more])
            continue;
        s->seen[more] = true;
        s->order[depth] = t;
        if (fits(s, more) && extend(s, more, depth + 1))
            return true;
    }
    return false;
}

static void find_order(const weft_kernel_tiles *set, int order[16])
{
    static struct search search;
    memset(&search, 0, sizeof search);
    assert_int_equal(tile_count(set), 16);
    int at[3] = {0}, i = 0;
    do {
        for (int t = 0; t < 16; t++)
            search.weight[t][i] = weft_kernel_tiles_value(set, t, at);
        i++;
    } while (next(set, at));
    assert_true(extend(&search, 0, 0));
    memcpy(order, search.order, sizeof search.order);
}

static void an_order_that_does_not_clamp_is_valid(void **state)
{
    (void)state;
    int order[16];
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 2, 16, WEFT_TILE_SUM_PRESERVING);
    find_order(set, order);
    struct list *l = add_all(start(set, WEFT_TARGET_UNORM8), order);
    assert_true(assert_as_expected(l, WEFT_WORST_CONSTANT).valid);
    assert_near(ranges[15].maximum, 1.0, 1e-12, "the sum of all weights");
    // The same sums by blending: what a pass adds or takes away is in range as well.
    for (int i = 0; i < 16; i++)
        l->passes[i].reads_target = false;
    assert_true(assert_as_expected(l, WEFT_WORST_CONSTANT).valid);
    weft_kernel_tiles_destroy(&set);
}

// Where sums leave half a code of the range for every pass.
static void any_order_of_the_bspline_is_valid(void **state)
{
    (void)state;
    int order[64];
    for (int dims = 2; dims <= 3; dims++) {
        weft_kernel_tiles *set = make_unorm8("bspline", dims, 8, WEFT_TILE_SUM_PRESERVING);
        for (int i = 0; i < 3; i++) {
            shuffle(order, tile_count(set));
            struct list *l = add_all(start(set, WEFT_TARGET_UNORM8), order);
            const double room = 1.0 - 0.5 * tile_count(set) / 255.0;
            for (int t = 0; t < tile_count(set); t++)
                l->passes[t].divisor = (int)ceil(255 * weft_kernel_tiles_get(set, t)->scale / room);
            assert_true(assert_as_expected(l, WEFT_WORST_CONSTANT).valid);
            assert_true(assert_as_expected(l, WEFT_WORST_ANY).valid);
        }
        weft_kernel_tiles_destroy(&set);
    }
}

static void random_orders_are_as_expected(void **state)
{
    (void)state;
    const char *const names[] = {"catmull-rom", "mitchell", "lanczos:3", "d-catmull-rom"};
    int order[2 * 6 * 6 * 6], valid = 0, lists = 0;
    for (size_t n = 0; n < WEFT_COUNT(names); n++) {
        for (int i = 0; i < 12; i++) {
            const int dims = 1 + i % 3;
            if (dims == 3 && n == 2)
                continue; // 216 tiles take long
            weft_kernel_tiles *set = make(
                weft_kernel_tiles_params(.kernel = kernel_named(names[n]), .dims = dims,
                                         .samples = dims == 3 ? 5 : 33 + i, .bits = i % 2 ? 8 : 12,
                                         .scaling = WEFT_TILE_SCALE_EACH, .store_all = !(i % 4)));
            struct list *l = start(set, i % 2 ? WEFT_TARGET_UNORM8 : WEFT_TARGET_UNORM16);
            shuffle(order, tile_count(set));
            for (int t = 0; t < tile_count(set); t++) {
                struct weft_pass *p = t % (1 + i / 3) && t ? NULL : add_pass(l, 0);
                if (!p)
                    add_group(l, order[t]);
                else {
                    p->bias = random_below(20) - 10;
                    p->divisor = i % 2 ? 400 : 7000;
                    p->initial = random_below(200);
                    add_group(l, order[t]);
                }
            }
            for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++, lists++)
                valid += assert_as_expected(l, (enum weft_worst_case)w).valid;
            weft_kernel_tiles_destroy(&set);
        }
    }
    print_message("%d of %d lists are valid\n", valid, lists);
    assert_int_equal(lists, 2 * (4 * 12 - 4));
    assert_in_range(valid, 1, lists - 1);
}

// ---- any input, bias and scale ------------------------------------------------------------------

// Sums of negative and of positive weights: the largest of all positions.
static void largest_sums(const weft_kernel_tiles *set, double *negative, double *positive)
{
    int at[3] = {0};
    *negative = *positive = 0.0;
    do {
        double n = 0.0, p = 0.0;
        for (int t = 0; t < tile_count(set); t++) {
            const double w = weft_kernel_tiles_value(set, t, at);
            n -= fmin(w, 0.0);
            p += fmax(w, 0.0);
        }
        *negative = fmax(*negative, n);
        *positive = fmax(*positive, p);
    } while (next(set, at));
}

static void any_input_takes_a_bias_and_a_scale(void **state)
{
    (void)state;
    int order[16];
    double negative, positive;
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 2, 16, WEFT_TILE_SUM_PRESERVING);
    largest_sums(set, &negative, &positive);
    find_order(set, order);
    assert_false(
        assert_as_expected(add_all(start(set, WEFT_TARGET_UNORM8), order), WEFT_WORST_ANY).valid);
    // Half a code for each of 16 passes at either end.
    const int divisor = (int)ceil(255.0 * 255.0 / (255 - 16) * (negative + positive)) + 1;
    const int initial = (int)ceil(255.0 * 255.0 * negative / divisor) + 8;
    for (int i = 0; i < 20; i++) {
        shuffle(order, 16);
        assert_false(
            assert_as_expected(add_all(start(set, WEFT_TARGET_UNORM8), order), WEFT_WORST_ANY)
                .valid);
        struct list *l = add_all(start(set, WEFT_TARGET_UNORM8), order);
        for (int t = 0; t < 16; t++)
            l->passes[t].divisor = divisor;
        l->passes[0].initial = initial;
        assert_true(assert_as_expected(l, WEFT_WORST_ANY).valid);
        assert_true(assert_as_expected(l, WEFT_WORST_CONSTANT).valid);
        l->passes[0].initial = initial - 17;
        assert_false(assert_as_expected(l, WEFT_WORST_ANY).valid);
        // A bias says the same as what the target starts from.
        l->passes[0].initial = 0;
        l->passes[0].bias = initial;
        assert_true(assert_as_expected(l, WEFT_WORST_ANY).valid);
    }
    weft_kernel_tiles_destroy(&set);
}

// Weights rounded one by one add up to as much as 267/255.
static void weights_rounded_one_by_one_overflow(void **state)
{
    (void)state;
    const struct {
        const char *name;
        int dims, samples, sum;
    } cases[] = {{"catmull-rom", 3, 16, 267}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_kernel_tiles *set =
            make_unorm8(cases[i].name, cases[i].dims, cases[i].samples, WEFT_TILE_NEAREST);
        struct list *l = add_all(start(set, WEFT_TARGET_UNORM8), NULL);
        assert_false(assert_as_expected(l, WEFT_WORST_CONSTANT).valid);
        assert_near(255.0 * ranges[l->list.pass_count - 1].maximum, cases[i].sum, 1e-9,
                    cases[i].name);
        weft_kernel_tiles_destroy(&set);
    }
}

// Positive tiles first; half of full range is 1.0.
static struct list *derivative_list(const weft_kernel_tiles *set)
{
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    for (int negative = 0; negative < 2; negative++)
        for (int t = 0; t < tile_count(set); t++)
            if (weft_kernel_tiles_get(set, t)->negated == (negative == 1))
                add_tile(l, 0, t)->divisor = (int)(2 * 255 * weft_kernel_tiles_get(set, t)->scale);
    return l;
}

// As much as every pass needs, 128 in all.
static void spread_bias(struct list *l)
{
    int given = 0;
    l->passes[0].bias = 0;
    simulate(l, WEFT_WORST_CONSTANT);
    for (int i = 0; i < l->list.pass_count; i++) {
        const int needed =
            i == l->list.pass_count - 1 ? 128 : (int)ceil(-255.0 * ranges[i].minimum);
        l->passes[i].bias = needed > given ? needed - given : 0;
        given += l->passes[i].bias;
    }
    assert_int_equal(given, 128);
}

// Section 5 of the paper.
static void a_spread_bias_keeps_gradients_in_range(void **state)
{
    (void)state;
    // In 3D with positive tiles first no bias at all is too much already.
    const struct {
        const char *name;
        int dims;
        bool single, spread;
    } cases[] = {{"catmull-rom", 2, false, true},
                 {"catmull-rom", 3, false, false},
                 {"bspline", 2, true, true},
                 {"bspline", 3, true, true}};
    for (size_t k = 0; k < WEFT_COUNT(cases); k++) {
        for (int axis = 1; axis <= cases[k].dims; axis++) {
            weft_kernel_tiles *set =
                make(weft_kernel_tiles_params(.kernel = kernel_named(cases[k].name),
                                              .dims = cases[k].dims, .samples = 8,
                                              .rounding = WEFT_TILE_SUM_PRESERVING,
                                              .scaling = WEFT_TILE_SCALE_SET,
                                              .derivative = {{axis == 1, axis == 2, axis == 3}}));
            struct list *l = derivative_list(set);
            l->passes[0].bias = 128;
            const struct weft_range_report single = assert_as_expected(l, WEFT_WORST_CONSTANT);
            spread_bias(l);
            const struct weft_range_report spread = assert_as_expected(l, WEFT_WORST_CONSTANT);
            print_message("d-%s, %dD, axis %d: overflow %.3f with one bias, %.3f spread\n",
                          cases[k].name, cases[k].dims, axis, single.overflow, spread.overflow);
            assert_int_equal(single.valid, cases[k].single);
            assert_int_equal(spread.valid, cases[k].spread);
            assert_true(spread.overflow < single.overflow || single.valid);
            weft_kernel_tiles_destroy(&set);
        }
    }
}

// ---- split precision ----------------------------------------------------------------------------

enum { EXTRA_BITS = 4, LOW_MASK = (1 << EXTRA_BITS) - 1 };

// 2N + 1 passes: high parts in slot 0, low ones in slot 1, the sum of both in slot 2.
static struct list *split_list(const weft_kernel_tiles *set, const int *order, int initial)
{
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    l->list.extra_bits = EXTRA_BITS;
    for (int slot = 0; slot < 2; slot++) {
        for (int i = 0; i < tile_count(set); i++) {
            struct weft_pass *p = add_tile(l, slot, order[i]);
            p->part = slot ? WEFT_PASS_LOW : WEFT_PASS_HIGH;
            p->divisor = (int)(255 * weft_kernel_tiles_get(set, order[i])->scale);
        }
    }
    l->passes[0].initial = initial;
    add_combine(l, 2, 0, 1 << EXTRA_BITS, 1, 1, 1 << EXTRA_BITS)->bias =
        -initial * (1 << EXTRA_BITS);
    return l;
}

static int rounded_sum(const struct list *l, const struct weft_pass *p, const int at[3],
                       const int *source)
{
    double n = 0.0;
    for (int g = p->group_first; g < p->group_first + p->group_count; g++) {
        const struct weft_tap_group *group = &l->groups[g];
        const int width = weft_kernel_tiles_get_info(l->list.tiles)->width;
        const int tap = (group->offset[2] * width + group->offset[1]) * width + group->offset[0];
        const double product = abs(weft_kernel_tiles_integer(l->list.tiles, group->tile[0], at)) *
                               (double)(source[tap] << l->list.extra_bits) / p->divisor;
        n += group->sign[0] * (l->list.exact_inside ? product : round(product));
    }
    return (int)round(n + p->bias) * (p->subtract ? -1 : 1);
}

// passes/plan/pass.h, in its own words.
static int stored(const struct weft_pass *p, int e, int y, int n)
{
    const int mask = (1 << e) - 1, half = (1 << e) / 2;
    switch (p->part) {
    case WEFT_PASS_WHOLE:
        return p->subtract ? y - ((n + half) >> e) : y + ((n + half) >> e);
    case WEFT_PASS_HIGH:
        return p->subtract ? y - ((n + mask) >> e) : y + (n >> e);
    case WEFT_PASS_LOW:
        break;
    }
    return p->subtract ? y + (-n & mask) : y + (n & mask);
}

struct seen {
    int minimum, maximum;
};

// Codes that the targets have after every pass, nothing clamped.
static void emulate(const struct list *l, const int at[3], const int *source, struct seen *seen)
{
    int y[4] = {0};
    for (int i = 0; i < l->list.pass_count; i++) {
        const struct weft_pass *p = &l->passes[i];
        if (p->kind == WEFT_PASS_TAPS) {
            const int before = p->clears ? p->initial : y[p->target];
            y[p->target] = stored(p, l->list.extra_bits, before, rounded_sum(l, p, at, source));
        } else {
            int sum = p->bias + p->denominator / 2;
            for (int k = 0; k < p->input_count; k++)
                sum += p->numerator[k] * y[p->input[k]];
            y[p->target] = (int)floor((double)sum / p->denominator);
        }
        seen[i].minimum = y[p->target] < seen[i].minimum ? y[p->target] : seen[i].minimum;
        seen[i].maximum = y[p->target] > seen[i].maximum ? y[p->target] : seen[i].maximum;
    }
}

static void emulate_inputs(const struct list *l, enum weft_worst_case worst_case, struct seen *seen)
{
    int at[3] = {0}, source[64];
    for (int i = 0; i < l->list.pass_count; i++)
        seen[i] = (struct seen){1 << 30, -(1 << 30)};
    do {
        for (int n = 0; n < 256; n++) {
            for (int t = 0; t < 64; t++)
                source[t] = worst_case == WEFT_WORST_CONSTANT ? n
                            : n == 0                          ? 255
                            : n % 2                           ? random_below(2) * 255
                                                              : random_below(256);
            emulate(l, at, source, seen);
        }
    } while (next(l->list.tiles, at));
}

// Constants: to the code.
static void assert_enclosed(const struct list *l, enum weft_worst_case worst_case)
{
    struct seen seen[MAX_PASSES];
    emulate_inputs(l, worst_case, seen);
    simulate(l, worst_case);
    for (int i = 0; i < l->list.pass_count; i++) {
        const bool exact = worst_case == WEFT_WORST_CONSTANT;
        const double low = seen[i].minimum - 255.0 * ranges[i].minimum;
        const double high = 255.0 * ranges[i].maximum - seen[i].maximum;
        if (!(low >= -1e-9 && high >= -1e-9) || (exact && !(low <= 1e-9 && high <= 1e-9)))
            fail_msg("pass %d: %d to %d outside %.3f to %.3f", i, seen[i].minimum, seen[i].maximum,
                     255.0 * ranges[i].minimum, 255.0 * ranges[i].maximum);
    }
}

static void what_integers_do_is_enclosed(void **state)
{
    (void)state;
    const char *const names[] = {"bspline", "catmull-rom", "mitchell", "d-catmull-rom"};
    int order[64];
    for (size_t n = 0; n < WEFT_COUNT(names); n++) {
        weft_kernel_tiles *set = make_unorm8(names[n], 2, 3, WEFT_TILE_NEAREST);
        for (int i = 0; i < 24; i++) {
            shuffle(order, tile_count(set));
            struct list *l = split_list(set, order, random_below(40));
            for (int k = 0; k < l->list.pass_count - 1; k++) {
                struct weft_pass *p = &l->passes[k];
                p->part = i % 3 == 2 ? WEFT_PASS_WHOLE : p->part;
                p->bias = i % 4 == 3 ? random_below(60) - 30 : 0;
                p->subtract = i % 5 == 4 ? random_below(2) : p->subtract;
                p->divisor += i % 7 >= 4 ? random_below(300) : 0;
            }
            l->list.exact_inside = i % 2;
            if (i % 6 == 4) {
                l->passes[l->list.pass_count - 1].numerator[0] = 3;
                l->passes[l->list.pass_count - 1].numerator[1] = -5;
            }
            assert_enclosed(l, WEFT_WORST_CONSTANT);
            assert_enclosed(l, WEFT_WORST_ANY);
        }
        weft_kernel_tiles_destroy(&set);
    }
}

// Below 2^e codes nothing wraps: a low part's most is what full sources give, to the code.
static void small_low_parts_are_bounded_exactly(void **state)
{
    (void)state;
    struct seen seen[1];
    weft_kernel_tiles *set = make_unorm8("bspline", 1, 4, WEFT_TILE_NEAREST);
    for (int i = 0; i < 200; i++) {
        struct list *l = start(set, WEFT_TARGET_UNORM8);
        l->list.extra_bits = EXTRA_BITS;
        l->list.exact_inside = i % 2;
        struct weft_pass *p = add_pass(l, 0);
        p->part = WEFT_PASS_LOW;
        p->divisor = 100000 + random_below(200000);
        p->bias = random_below(3);
        for (int t = 0; t < 4; t++)
            add_group(l, t);
        for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
            emulate_inputs(l, (enum weft_worst_case)w, seen);
            simulate(l, (enum weft_worst_case)w);
            assert_true(seen[0].maximum < LOW_MASK);
            assert_near(255.0 * ranges[0].maximum, seen[0].maximum, 1e-9, "low part");
        }
    }
    weft_kernel_tiles_destroy(&set);
}

// Floors of what is not negative are not negative: no room below is needed.
static void high_parts_that_only_add_need_no_room(void **state)
{
    (void)state;
    int order[16];
    struct seen seen[MAX_PASSES];
    weft_kernel_tiles *set = make_unorm8("bspline", 2, 4, WEFT_TILE_SUM_PRESERVING);
    shuffle(order, 16);
    const struct list *l = split_list(set, order, 0);
    for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
        const struct weft_range_report r = simulate(l, (enum weft_worst_case)w);
        assert_true(r.valid);
        assert_near(ranges[15].minimum, 0.0, 0.0, "high parts");
        assert_near(ranges[32].maximum, 1.0, 1e-12, "combined");
        emulate_inputs(l, (enum weft_worst_case)w, seen);
        print_message("bspline, high parts up to %d of %.2f, low parts up to %d of %.2f codes\n",
                      seen[15].maximum, 255.0 * ranges[15].maximum, seen[31].maximum,
                      255.0 * ranges[31].maximum);
        assert_true(seen[15].maximum <= 255.0 * ranges[15].maximum + 1e-9);
        assert_true(seen[31].maximum <= 255.0 * ranges[31].maximum + 1e-9);
        assert_true(255.0 * ranges[31].maximum <= 16.0 * LOW_MASK + 1e-9);
    }
    weft_kernel_tiles_destroy(&set);
}

static void high_parts_that_subtract_need_room(void **state)
{
    (void)state;
    int order[16];
    struct seen seen[MAX_PASSES];
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 2, 16, WEFT_TILE_SUM_PRESERVING);
    find_order(set, order);
    assert_false(simulate(split_list(set, order, 0), WEFT_WORST_CONSTANT).valid);
    double lowest = 0.0;
    for (int i = 0; i < 33; i++)
        lowest = fmin(lowest, ranges[i].minimum);
    const int initial = (int)ceil(-255.0 * lowest);
    const struct list *l = split_list(set, order, initial);
    simulate(l, WEFT_WORST_CONSTANT);
    emulate_inputs(l, WEFT_WORST_CONSTANT, seen);
    int taken = 0, left = 255;
    for (int i = 0; i < 33; i++) {
        assert_true(ranges[i].minimum >= -1e-9);
        taken = initial - seen[i].minimum > taken && i < 16 ? initial - seen[i].minimum : taken;
        left = i >= 16 && i < 32 && 255 - seen[i].maximum < left ? 255 - seen[i].maximum : left;
    }
    print_message("catmull-rom: %d codes of room for high parts, integers take %d; low parts leave "
                  "%d codes, by the bound %.2f\n",
                  initial, taken, left, 255.0 * (1.0 - ranges[31].maximum));
    assert_true(initial <= 16 && taken > 0);
    assert_true(taken <= initial && left >= 255.0 * (1.0 - ranges[31].maximum) - 1e-9);
    weft_kernel_tiles_destroy(&set);
}

static void parts_of_the_same_passes_make_whole_sums(void **state)
{
    (void)state;
    int order[16];
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 2, 8, WEFT_TILE_SUM_PRESERVING);
    find_order(set, order);
    for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
        simulate(add_all(start(set, WEFT_TARGET_UNORM8), order), (enum weft_worst_case)w);
        const struct weft_range whole = ranges[15];
        struct list *l = split_list(set, order, 20);
        const int last = l->list.pass_count - 1;
        simulate(l, (enum weft_worst_case)w);
        assert_near(ranges[last].minimum, whole.minimum, 1e-12, "least of the whole");
        assert_near(ranges[last].maximum, whole.maximum, 1e-12, "most of the whole");
        // A low part that is another one's, or of another sum, gives nothing back. Constants are
        // followed one by one, so that it is only some of them that show it.
        if (w == WEFT_WORST_CONSTANT)
            continue;
        l->groups[16].tile[0] = order[1];
        simulate(l, (enum weft_worst_case)w);
        assert_true(ranges[last].maximum > whole.maximum + 1e-3);
        l->groups[16].tile[0] = order[0];
        l->passes[16 + 15].bias = 1;
        simulate(l, (enum weft_worst_case)w);
        assert_true(ranges[last].maximum > whole.maximum + 1e-3);
        l->passes[16 + 15].bias = 0;
        l->passes[last].numerator[1] = 2;
        simulate(l, (enum weft_worst_case)w);
        assert_true(ranges[last].maximum > whole.maximum + 1e-3);
    }
    weft_kernel_tiles_destroy(&set);
}

// ---- combining ----------------------------------------------------------------------------------

static void combinations_are_linear(void **state)
{
    (void)state;
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 1, 16, WEFT_TILE_SUM_PRESERVING);
    // Inner taps less outer ones, which are negative: 3/5 (y0 - y1) + 10/5 codes.
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    add_tile(l, 0, 1)->divisor = 300;
    add_tile(l, 0, 2)->divisor = 300;
    add_tile(l, 1, 0)->initial = 100;
    add_tile(l, 1, 3);
    add_combine(l, 0, 0, 3, 1, -3, 5)->bias = 10;
    for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
        double low = INFINITY, high = -INFINITY;
        int at[3] = {0};
        do {
            double inner = 0.0, outer = 0.0;
            for (int t = 0; t < 4; t++)
                *(t == 1 || t == 2 ? &inner : &outer) += weft_kernel_tiles_value(set, t, at);
            const double base = (-3.0 * 100.0 + 10.0) / 5.0 / 255.0;
            // Both worst cases have their extremes at 0 and at 1, as signs do not mix.
            low = fmin(low, base);
            high = fmax(high, base + 0.6 * (0.85 * inner - outer));
        } while (next(set, at));
        const struct weft_range_report r = simulate(l, (enum weft_worst_case)w);
        // Half a code for each of four passes, times 3/5, and half a one for the sum.
        const double rounding = (4.0 * 0.6 + 1.0) * 0.5 / 255.0;
        assert_near(ranges[4].minimum, low, rounding, "least of the combination");
        assert_near(ranges[4].maximum, high, rounding, "most of the combination");
        assert_false(r.valid);
        assert_int_equal(r.pass, 4);
        assert_near(r.value, ranges[4].minimum, 1e-12, "value");
    }
    // Where both are added, constants cancel what any input does not.
    l->passes[0].divisor = l->passes[1].divisor = 255;
    l->passes[4].numerator[1] = 3;
    l->passes[4].bias = -300;
    simulate(l, WEFT_WORST_CONSTANT);
    assert_near(ranges[4].minimum, 0.0, 1.7 / 255.0, "constant");
    assert_near(ranges[4].maximum, 0.6, 1.7 / 255.0, "constant");
    simulate(l, WEFT_WORST_ANY);
    assert_true(ranges[4].minimum < -0.05 && ranges[4].maximum > 0.65);
    weft_kernel_tiles_destroy(&set);
}

// Tiles at twice their weight in two slots, halved when they are added up.
static void scaled_groups_add_up(void **state)
{
    (void)state;
    weft_kernel_tiles *set = make_unorm8("bspline", 2, 8, WEFT_TILE_SUM_PRESERVING);
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    // Every second column: half of the sum, twice.
    for (int t = 0; t < 16; t++)
        add_tile(l, t % 2, t)->divisor = (int)(255 * weft_kernel_tiles_get(set, t)->scale / 2);
    add_combine(l, 0, 0, 1, 1, 1, 2);
    const struct weft_range_report r = simulate(l, WEFT_WORST_CONSTANT);
    assert_near(ranges[16].maximum, 1.0, 1e-12, "the sum of all weights");
    assert_near(ranges[16].minimum, 0.0, 1e-12, "nothing");
    // Columns 1 and 3 have up to 2/3 + 1/48 of it near the edge of a sample.
    assert_false(r.valid);
    assert_near(r.overflow, fmax(ranges[14].maximum, ranges[15].maximum) - 1.0, 1e-12, "overflow");
    weft_kernel_tiles_destroy(&set);
}

// ---- what happens inside a pass -----------------------------------------------------------------

static void blending_fragments_stay_in_range(void **state)
{
    (void)state;
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 1, 16, WEFT_TILE_SUM_PRESERVING);
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    add_tile(l, 0, 1)->initial = 20;
    add_tile(l, 0, 0)->subtract = false;
    l->passes[0].divisor = 400;
    l->list.result = 0;
    assert_true(simulate(l, WEFT_WORST_CONSTANT).valid);
    l->passes[1].reads_target = false;
    for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
        const struct weft_range_report r = simulate(l, (enum weft_worst_case)w);
        assert_false(r.valid);
        assert_int_equal(r.pass, 1);
        assert_near(r.value, weft_kernel_tiles_value(set, 0, r.position), 1e-12, "fragment");
        assert_near(r.value, weft_kernel_tiles_get(set, 0)->minimum, 1e-12, "furthest fragment");
        assert_near(r.overflow, -r.value, 1e-12, "overflow");
        assert_true(ranges[1].minimum >= 0.0);
    }
    // Taken away, it is positive; so it is with a bias, which adds to the target in either case.
    l->passes[1].subtract = true;
    assert_true(simulate(l, WEFT_WORST_ANY).valid);
    l->passes[1].subtract = false;
    l->passes[1].bias = 20;
    assert_true(simulate(l, WEFT_WORST_ANY).valid);
    l->passes[1].subtract = true;
    assert_false(simulate(l, WEFT_WORST_ANY).valid);
    l->passes[1].bias = -1;
    assert_true(simulate(l, WEFT_WORST_ANY).valid);
    weft_kernel_tiles_destroy(&set);
}

static void sums_inside_saturate(void **state)
{
    (void)state;
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 1, 16, WEFT_TILE_SUM_PRESERVING);
    static const int order[4] = {1, 2, 0, 3}; // 17/16 after two or three at 1/2, 1 in the end
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    struct weft_pass *p = add_pass(l, 0);
    for (int i = 0; i < 4; i++)
        add_group(l, order[i]);
    l->list.range = 1.0;
    assert_true(simulate(l, WEFT_WORST_CONSTANT).valid);
    l->list.exact_inside = false;
    struct weft_range_report r = simulate(l, WEFT_WORST_CONSTANT);
    assert_false(r.valid);
    double most = 0.0;
    int at[3] = {0};
    do
        most =
            fmax(most, weft_kernel_tiles_value(set, 1, at) + weft_kernel_tiles_value(set, 2, at));
    while (next(set, at));
    assert_near(r.value, most, 1e-12, "value");
    assert_near(r.overflow, most - 1.0, 1e-12, "overflow");
    assert_near(ranges[0].maximum, 1.0, 1e-12, "target");
    l->list.range = 2.0;
    assert_true(simulate(l, WEFT_WORST_CONSTANT).valid);
    // A bias may be there before the products are.
    l->list.range = 1.0;
    p->divisor = 300;
    assert_true(simulate(l, WEFT_WORST_CONSTANT).valid);
    p->bias = 30;
    r = simulate(l, WEFT_WORST_CONSTANT);
    // Each of up to three products is rounded.
    assert_near(r.value, most * 255.0 / 300.0 + 30.0 / 255.0, 1.5 / 255.0, "value");
    assert_true(r.value > 1.0 && ranges[0].maximum < 1.0);
    p->divisor = 255;
    p->bias = 0;
    // In one dot product nothing is over; in one of three and a fourth, it is.
    l->list.range = 1.0;
    l->list.dot4 = true;
    l->list.dot_width = 4;
    p->group_count = 1;
    for (int c = 0; c < 4; c++) {
        l->groups[0].tile[c] = order[c];
        l->groups[0].sign[c] = l->groups[c].sign[0];
    }
    assert_true(simulate(l, WEFT_WORST_CONSTANT).valid);
    assert_near(ranges[0].maximum, 1.0, 1e-12, "dot4");
    l->list.dot_width = 3;
    r = simulate(l, WEFT_WORST_CONSTANT);
    assert_false(r.valid);
    assert_true(r.value > 1.0 && r.value < most);
    weft_kernel_tiles_destroy(&set);
}

// Where in an order the tile with the largest weight is.
static int find_largest(const weft_kernel_tiles *set, const int *order)
{
    int at = 0;
    for (int i = 0; i < tile_count(set); i++)
        if (weft_kernel_tiles_get(set, order[i])->maximum >
            weft_kernel_tiles_get(set, order[at])->maximum)
            at = i;
    return at;
}

static void dot4_sums_four_taps(void **state)
{
    (void)state;
    int order[64];
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 3, 6, WEFT_TILE_SUM_PRESERVING);
    shuffle(order, 64);
    for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
        struct weft_range kept[16];
        struct list *l = start(set, WEFT_TARGET_UNORM8);
        for (int i = 0; i < 64; i++) {
            if (i % 4 == 0)
                add_pass(l, 0);
            add_group(l, order[i]);
        }
        const struct weft_range_report four = assert_as_expected(l, (enum weft_worst_case)w);
        memcpy(kept, ranges, sizeof kept);
        l->list.dot4 = true;
        l->list.dot_width = 4;
        for (int i = 0; i < 16; i++) {
            l->passes[i].group_first = i;
            l->passes[i].group_count = 1;
            for (int c = 0; c < 4; c++) {
                const int tile = order[4 * i + c];
                l->groups[i].tile[c] = tile;
                l->groups[i].sign[c] = weft_kernel_tiles_get(set, tile)->negated ? -1 : 1;
            }
        }
        const struct weft_range_report one = simulate(l, (enum weft_worst_case)w);
        assert_memory_equal(kept, ranges, sizeof kept);
        assert_int_equal(one.valid, four.valid);
        assert_int_equal(one.pass, four.pass);
        assert_near(one.value, four.value, 0.0, "value");
        // Without the largest tap its pass is another one, and those before it are not.
        const int largest = find_largest(set, order), g = largest / 4;
        l->groups[g].tile[largest % 4] = -1;
        l->groups[g].sign[largest % 4] = 0;
        simulate(l, (enum weft_worst_case)w);
        assert_true(g == 0 || memcmp(kept, ranges, (size_t)g * sizeof *kept) == 0);
        assert_true(ranges[g].maximum < kept[g].maximum - 0.1);
    }
    weft_kernel_tiles_destroy(&set);
}

// ---- floats and logarithms ----------------------------------------------------------------------

static void floats_never_leave_their_range(void **state)
{
    (void)state;
    for (int target = WEFT_TARGET_HALF; target <= WEFT_TARGET_FLOAT; target++) {
        weft_kernel_tiles *set = make(
            weft_kernel_tiles_params(.kernel = kernel_named("catmull-rom"), .dims = 2, .samples = 9,
                                     .format = target == WEFT_TARGET_HALF ? WEFT_TILE_HALF
                                                                          : WEFT_TILE_FLOAT,
                                     .derivative = {{0, 1, 0}}));
        struct list *l = start(set, (enum weft_target_format)target);
        double low = 0.0, high = 0.0;
        for (int t = 0; t < tile_count(set); t++)
            add_tile(l, 0, t)->divisor = 1;
        // One tile per tap, of either sign: it is the sign of mirrored ones that groups turn.
        for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
            const struct weft_range_report r = simulate(l, (enum weft_worst_case)w);
            int at[3] = {0};
            low = high = 0.0;
            do {
                double negative = 0.0, positive = 0.0;
                for (int t = 0; t < tile_count(set); t++) {
                    const double v = weft_kernel_tiles_value(set, t, at);
                    negative += fmin(v, 0.0);
                    positive += fmax(v, 0.0);
                }
                const double sum = negative + positive;
                low = fmin(low, w == WEFT_WORST_ANY ? negative : sum);
                high = fmax(high, w == WEFT_WORST_ANY ? positive : sum);
            } while (next(set, at));
            assert_true(r.valid);
            assert_near(r.overflow, 0.0, 0.0, "overflow");
            assert_near(ranges[15].minimum, low, 1e-12, "least");
            assert_near(ranges[15].maximum, high, 1e-12, "most");
        }
        assert_true(high > 1.0);
        weft_kernel_tiles_destroy(&set);
    }
}

// The weight of a tile is what the table has for it: off by half a step of the logarithm, and by a
// 2^-e code where it is rounded or too small for a logarithm.
static void logarithms_are_looked_up(void **state)
{
    (void)state;
    const double octaves = 12.0, step = octaves / 254.0;
    uint32_t table[2 * 255 + 1];
    weft_kernel_tiles *set =
        make(weft_kernel_tiles_params(.kernel = kernel_named("catmull-rom"), .samples = 16,
                                      .format = WEFT_TILE_FLOAT, .signs = WEFT_TILE_SEPARATE));
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    for (int k = 0; k <= 2 * 255; k++)
        table[k] = (uint32_t)floor(exp2(-k * step) * (255 << EXTRA_BITS) + 0.5);
    l->list.extra_bits = EXTRA_BITS;
    l->list.log_table = table;
    l->list.log_octaves = octaves;
    for (int t = 0; t < 16; t++) {
        add_tile(l, t % 4, t);
        simulate(l, WEFT_WORST_CONSTANT);
        int at[3] = {0};
        double sum = 0.0, low = 0.0, high = 0.0;
        do {
            sum = 0.0;
            for (int k = t % 4; k <= t; k += 4) {
                const double w = weft_kernel_tiles_value(set, k, at), x = fabs(w);
                const int code = x < exp2(-octaves) ? 255 : (int)round(-log2(x) / step);
                const double product = code == 255 ? 0.0 : table[code] / (255.0 * 16.0);
                assert_near(product, x, x * (exp2(step / 2.0) - 1.0) + 1.0 / (255.0 * 16.0),
                            "product");
                sum += w < 0.0 ? -product : product;
            }
            low = fmin(low, sum);
            high = fmax(high, sum);
        } while (next(set, at));
        // Every pass so far into the slot rounds to whole codes.
        const double rounding = 0.5 * (t / 4 + 1) / 255.0;
        assert_near(ranges[t].minimum, low, rounding, "least");
        assert_near(ranges[t].maximum, high, rounding, "most");
    }
    weft_kernel_tiles_destroy(&set);
}

// ---- requests -----------------------------------------------------------------------------------

static void break_list(struct list *l, int how)
{
    struct weft_pass *taps = &l->passes[1], *sum = &l->passes[l->list.pass_count - 1];
    // clang-format off
    switch (how) {
    case 0: l->groups[1].tile[0] = tile_count(l->list.tiles); break;
    case 1: l->groups[1].tile[0] = -2; break;
    case 2: l->groups[1].sign[0] = 0; break;
    case 3: l->groups[1].shift[0] = 40; break;
    case 4: taps->target = 4; break;
    case 5: taps->target = -1; break;
    case 6: taps->divisor = 0; break;
    case 7: taps->group_count = 17; break;
    case 8: taps->group_first = l->list.group_count; break;
    case 9: taps->part = (enum weft_pass_part)3; break;
    case 10: taps->kind = (enum weft_pass_kind)2; break;
    case 11: taps->target = 3; break; // holds nothing
    case 12: taps->clears = true; taps->initial = 256; break;
    case 13: sum->input[1] = 4; break;
    case 14: sum->input[1] = 3; break; // holds nothing
    case 15: sum->numerator[1] = 0; break;
    case 16: sum->denominator = 0; break;
    case 17: sum->input_count = 0; break;
    case 18: sum->input_count = 17; break;
    case 19: l->list.result = 0; break; // was read
    case 20: l->list.result = 4; break;
    case 21: l->list.dims = 3; break;
    case 22: l->list.pass_count = 0; break;
    case 23: l->list.groups = NULL; break;
    case 24: l->list.extra_bits = 25; break;
    case 25: l->list.exact_inside = false; l->list.range = 0.5; break;
    case 26: l->list.log_table = (const uint32_t *)l; break; // tiles hold no logarithms
    case 27: l->list.tiles = NULL; break;
    }
    // clang-format on
}

static void bad_lists_are_refused(void **state)
{
    (void)state;
    const struct {
        int first, last;
        const char *text;
    } cases[] = {{0, 3, "group 01"},
                 {4, 12, "pass 01"},
                 {13, 18, "pass 33"},
                 {19, 19, "slot 0, the result"},
                 {20, 27, "required"}};
    int order[16];
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 2, 4, WEFT_TILE_NEAREST);
    shuffle(order, 16);
    for (size_t c = 0; c < WEFT_COUNT(cases); c++) {
        for (int how = cases[c].first; how <= cases[c].last; how++) {
            struct message message = {"", 0};
            const struct weft_log log = {keep_message, &message};
            struct list *l = split_list(set, order, 20);
            struct weft_range_report report = {.pass = 77};
            add_combine(l, 2, 2, 1, 2, 1, 2);
            l->passes[33].input_count = 1;
            l->passes[33].numerator[1] = 1;
            l->passes[33].input[1] = 2;
            l->passes[33].input_count = 2;
            assert_int_equal(
                weft_range_simulate(&log, &l->list, WEFT_WORST_ANY, NULL, ranges, &report),
                WEFT_OK);
            report.pass = 77;
            break_list(l, how);
            if (weft_range_simulate(&log, &l->list, WEFT_WORST_ANY, NULL, ranges, &report) !=
                    WEFT_ERR_ARGUMENT ||
                message.count != 1 || !strstr(message.text, cases[c].text) || report.pass != 77)
                fail_msg("case %d: %d messages, %s", how, message.count, message.text);
        }
    }
    weft_kernel_tiles_destroy(&set);
}

static void a_slot_that_was_read_is_free(void **state)
{
    (void)state;
    struct message message = {"", 0};
    const struct weft_log log = {keep_message, &message};
    weft_kernel_tiles *set = make_unorm8("linear", 1, 4, WEFT_TILE_NEAREST);
    struct list *l = start(set, WEFT_TARGET_UNORM8);
    struct weft_range_report report;
    add_tile(l, 0, 0);
    add_tile(l, 1, 1);
    add_combine(l, 2, 0, 1, 1, 1, 1);
    add_combine(l, 2, 2, 1, 0, 1, 1);
    assert_int_equal(weft_range_simulate(&log, &l->list, WEFT_WORST_ANY, NULL, NULL, &report),
                     WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(message.text, "pass 03 reads slot 0"));
    weft_kernel_tiles_destroy(&set);
}

struct watch {
    int calls, stop_at;
    double last;
};

static bool watch(void *priv, double fraction)
{
    struct watch *w = priv;
    assert_true(fraction >= w->last && fraction <= 1.0);
    w->last = fraction;
    return ++w->calls != w->stop_at;
}

static void progress_is_told_and_can_stop(void **state)
{
    (void)state;
    struct watch seen = {0, 0, 0.0};
    const struct weft_progress progress = {watch, &seen};
    weft_kernel_tiles *set = make_unorm8("bspline", 2, 64, WEFT_TILE_NEAREST);
    struct list *l = add_all(start(set, WEFT_TARGET_UNORM8), NULL);
    struct weft_range_report report = {.pass = 77};
    assert_int_equal(weft_range_simulate(NULL, &l->list, WEFT_WORST_ANY, &progress, NULL, &report),
                     WEFT_OK);
    assert_near(seen.last, 1.0, 0.0, "fraction");
    assert_true(seen.calls > 1);
    report.pass = 77;
    seen = (struct watch){0, 2, 0.0};
    assert_int_equal(weft_range_simulate(NULL, &l->list, WEFT_WORST_ANY, &progress, NULL, &report),
                     WEFT_ERR_CANCELLED);
    assert_int_equal(seen.calls, 2);
    assert_int_equal(report.pass, 77);
    weft_kernel_tiles_destroy(&set);
}

static void a_tricubic_plan_takes_little_time(void **state)
{
    (void)state;
    weft_kernel_tiles *set = make_unorm8("catmull-rom", 3, 32, WEFT_TILE_SUM_PRESERVING);
    struct list *l = add_all(start(set, WEFT_TARGET_UNORM8), NULL);
    for (int w = WEFT_WORST_CONSTANT; w <= WEFT_WORST_ANY; w++) {
        const double begin = weft_now_seconds();
        simulate(l, (enum weft_worst_case)w);
        const double seconds = weft_now_seconds() - begin;
        print_message("64 tiles of 32^3: %.1f ms\n", 1e3 * seconds);
        // 0.1 s was measured; position by position and level by level it would be minutes.
        assert_true(seconds < 20.0);
    }
    weft_kernel_tiles_destroy(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_natural_order_of_catmull_rom_clamps),
        cmocka_unit_test(an_order_that_does_not_clamp_is_valid),
        cmocka_unit_test(any_order_of_the_bspline_is_valid),
        cmocka_unit_test(random_orders_are_as_expected),
        cmocka_unit_test(any_input_takes_a_bias_and_a_scale),
        cmocka_unit_test(weights_rounded_one_by_one_overflow),
        cmocka_unit_test(a_spread_bias_keeps_gradients_in_range),
        cmocka_unit_test(what_integers_do_is_enclosed),
        cmocka_unit_test(small_low_parts_are_bounded_exactly),
        cmocka_unit_test(high_parts_that_only_add_need_no_room),
        cmocka_unit_test(high_parts_that_subtract_need_room),
        cmocka_unit_test(parts_of_the_same_passes_make_whole_sums),
        cmocka_unit_test(combinations_are_linear),
        cmocka_unit_test(scaled_groups_add_up),
        cmocka_unit_test(blending_fragments_stay_in_range),
        cmocka_unit_test(sums_inside_saturate),
        cmocka_unit_test(dot4_sums_four_taps),
        cmocka_unit_test(floats_never_leave_their_range),
        cmocka_unit_test(logarithms_are_looked_up),
        cmocka_unit_test(bad_lists_are_refused),
        cmocka_unit_test(a_slot_that_was_read_is_free),
        cmocka_unit_test(progress_is_told_and_can_stop),
        cmocka_unit_test(a_tricubic_plan_takes_little_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
