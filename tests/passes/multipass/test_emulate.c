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
#include "filter/analysis/reference.h"
#include "tests/support/pass_lists.h"

// ---- passes/plan/pass.h once more, a pixel at a time and in 64 bits
// ----------------------------------

static int64_t floored(int64_t x, int64_t divisor)
{
    return x / divisor - (x % divisor < 0);
}

static int64_t nearest(int64_t x, int64_t divisor) // halves away from zero
{
    return x < 0 ? -nearest(-x, divisor) : (2 * x + divisor) / (2 * divisor);
}

static int64_t clamp_to(int64_t x, int64_t low, int64_t high)
{
    return x < low ? low : x > high ? high : x;
}

struct pixel {
    const struct hand_list *h;
    const struct hand_request *r;
    int64_t first[3];
    int k[3];
};

static struct pixel locate(const struct hand_list *h, const struct hand_request *r, int x, int y)
{
    struct pixel p = {h, r, {0}, {0}};
    const int m = weft_kernel_tiles_get_info(h->tiles)->samples;
    for (int a = 0; a < h->list.dims; a++) {
        double fraction;
        const double at = r->grid.origin[a] + x * r->grid.du[a] + y * r->grid.dv[a];
        p.first[a] = weft_kernel_first_tap(&h->work.kernel, at, &fraction);
        p.k[a] = (int)clamp_to((int64_t)floor(fraction * m), 0, m - 1);
    }
    return p;
}

static double sample(const struct pixel *p, int channel, const int offset[3], const int shift[3])
{
    int64_t at[3];
    for (int a = 0; a < 3; a++) {
        const int size = p->r->source.size[a];
        // First taps beyond the samples by more than the kernel's reach count as just there.
        const int64_t first = clamp_to(p->first[a], 1 - p->h->work.kernel.width, size - 1);
        at[a] = clamp_to((a < p->h->list.dims ? first : 0) + offset[a] + shift[a], 0, size - 1);
    }
    const int *size = p->r->source.size;
    return (double)p->r->samples[channel][(at[2] * size[1] + at[1]) * size[0] + at[0]];
}

static int log_code(const struct hand_list *h, double x)
{
    const int one = weft_target_one(h->list.target);
    if (x < exp2(-h->list.log_octaves))
        return one;
    return (int)fmax(0.0, round(-log2(x) * (one - 1) / h->list.log_octaves));
}

// sign s q 2^shift 2^e (unrounded), or of logarithms the product itself.
static int64_t product(const struct pixel *p, int channel, const struct weft_tap_group *g, int c)
{
    const struct weft_pass_list *l = &p->h->list;
    const int one = weft_target_one(l->target);
    static const int none[3] = {0};
    if (g->tile[c] < 0)
        return 0;
    const double f = sample(p, channel, g->offset, l->dot4 ? l->pattern[c] : none);
    if (l->log_table) {
        const double weight = weft_kernel_tiles_value(p->h->tiles, g->tile[c], p->k);
        const int s = log_code(p->h, f), q = log_code(p->h, fabs(weight));
        return s == one || q == one ? 0 : (int64_t)l->log_table[s + q] * g->sign[c];
    }
    const int64_t s = (int64_t)floor(f * one + 0.5);
    const int64_t q = llabs(weft_kernel_tiles_integer(p->h->tiles, g->tile[c], p->k));
    return g->sign[c] * s * q * (INT64_C(1) << (g->shift[c] + l->extra_bits));
}

static int64_t saturated(const struct weft_pass_list *l, int64_t sum)
{
    const double limit = l->range * weft_target_one(l->target) * exp2(l->extra_bits);
    return l->exact_inside || isinf(limit) ? sum : clamp_to(sum, -(int64_t)limit, (int64_t)limit);
}

static int64_t sum_up(const struct pixel *p, int channel, const struct weft_pass *pass)
{
    const struct weft_pass_list *l = &p->h->list;
    const int64_t sign = pass->subtract ? -1 : 1, divisor = l->log_table ? 1 : pass->divisor;
    int64_t sum = sign * pass->bias * (l->exact_inside ? divisor : 1);
    for (int g = pass->group_first; g < pass->group_first + pass->group_count; g++) {
        for (int c = 0; c < (l->dot4 ? 4 : 1); c++) {
            const int64_t term = sign * product(p, channel, &l->groups[g], c);
            sum += l->exact_inside ? term : nearest(term, divisor);
            if (c == 2 && l->dot_width == 3)
                sum = saturated(l, sum);
        }
        sum = saturated(l, sum);
    }
    return l->exact_inside ? nearest(sum, divisor) : sum;
}

struct tally {
    uint64_t clamps;
    int64_t largest;
};

static int64_t tallied(struct tally *t, int64_t y, int one)
{
    const int64_t inside = clamp_to(y, 0, one);
    t->clamps += inside != y;
    t->largest = llabs(y - inside) > t->largest ? llabs(y - inside) : t->largest;
    return inside;
}

static int64_t after_taps(const struct pixel *p, int channel, const struct weft_pass *pass,
                          int64_t y, struct tally *t)
{
    const int64_t n = sum_up(p, channel, pass), unit = INT64_C(1) << p->h->list.extra_bits;
    const int one = weft_target_one(p->h->list.target);
    y = pass->clears ? pass->initial : y;
    if (pass->part == WEFT_PASS_LOW)
        return tallied(t, y + ((pass->subtract ? -n : n) & (unit - 1)), one);
    int64_t change = pass->part == WEFT_PASS_WHOLE ? floored(n + unit / 2, unit)
                     : pass->subtract              ? floored(n + unit - 1, unit)
                                                   : floored(n, unit);
    if (!pass->reads_target)
        assert_true(n >= 0); // the list is to blame
    return tallied(t, pass->subtract ? y - change : y + change, one);
}

static int64_t combined(const struct weft_pass_list *l, const struct weft_pass *pass,
                        const int64_t *slots, struct tally *t)
{
    const int64_t unit = INT64_C(1) << l->extra_bits;
    int64_t sum = l->exact_inside ? pass->bias : nearest(pass->bias * unit, pass->denominator);
    for (int i = 0; i < pass->input_count; i++) {
        const int64_t term = pass->numerator[i] * slots[pass->input[i]];
        sum += l->exact_inside ? term : nearest(term * unit, pass->denominator);
    }
    const int64_t denominator = l->exact_inside ? pass->denominator : unit;
    return tallied(t, floored(sum + denominator / 2, denominator), weft_target_one(l->target));
}

static int64_t result_code(const struct hand_list *h, const struct hand_request *r, int x, int y,
                           int channel, struct tally *t)
{
    const struct pixel p = locate(h, r, x, y);
    int64_t slots[16] = {0};
    for (int n = 0; n < h->list.pass_count; n++) {
        const struct weft_pass *pass = &h->passes[n];
        int64_t *slot = &slots[pass->target];
        *slot = pass->kind == WEFT_PASS_COMBINE ? combined(&h->list, pass, slots, t)
                                                : after_taps(&p, channel, pass, *slot, t);
    }
    return slots[h->list.result];
}

static int code_of(const struct hand_list *h, float pixel)
{
    return (int)lround((double)pixel * weft_target_one(h->list.target));
}

// Runs the request and compares all with the above. False where 32 bits were too few.
static bool agrees(const struct hand_list *h, struct hand_request *r)
{
    struct weft_multipass_report report;
    struct tally tally = {0};
    struct message refusal = {0};
    const struct weft_log log = {keep_message, &refusal};
    r->params.log = &log;
    const enum weft_result res = hand_run(NULL, h, r, &report);
    if (res == WEFT_ERR_LIMIT && strstr(refusal.text, "32 bits"))
        return false;
    assert_string_equal(refusal.text, "");
    assert_int_equal(res, WEFT_OK);
    for (int c = 0; c < h->work.channels; c++)
        for (int y = 0; y < r->grid.height; y++)
            for (int x = 0; x < r->grid.width; x++)
                assert_int_equal(code_of(h, r->pixels[c][y * r->grid.width + x]),
                                 result_code(h, r, x, y, c, &tally));
    assert_int_equal(report.clamps, tally.clamps);
    assert_true(report.largest_clamp == (double)tally.largest);
    return true;
}

static void random_lists_agree_with_the_rules(void **state)
{
    (void)state;
    int refused = 0;
    enum { CASES = 400 };
    for (int i = 0; i < CASES; i++) {
        start_case(i);
        struct hand_list *h = hand_random_list(i % 2 ? WEFT_TARGET_UNORM16 : WEFT_TARGET_UNORM8);
        struct hand_request *r = hand_random_request(h);
        refused += !agrees(h, r);
        free(r);
        hand_list_destroy(h);
    }
    print_message("%d of %d lists need more than 32 bits\n", refused, (int)CASES);
    assert_true(refused < CASES / 4);
}

// ---- by hand ------------------------------------------------------------------------------------

// The tent on one sample position: M = 1 samples it at 1/2, so that both taps weigh 1/2 everywhere:
// q = 128 of 255 (127.5, halves away from zero).
static struct hand_list *tent(int extra_bits, double range)
{
    return hand_list_create(&(struct hand_params){HAND_DEFAULTS.kernel = "linear", .samples = 1,
                                                  .extra_bits = extra_bits, .range = range,
                                                  .scaling = WEFT_TILE_UNSCALED, .dims = 1});
}

// What one sample of code s becomes.
static int run_code(struct hand_list *h, int s, struct weft_multipass_report *report)
{
    struct hand_request *r = hand_request_create(h, 1, 1, 1, 1, 1);
    struct weft_multipass_report unused;
    r->samples[0][0] = (float)s / 255.0f;
    assert_int_equal(hand_run(NULL, h, r, report ? report : &unused), WEFT_OK);
    const int code = code_of(h, r->pixels[0][0]);
    free(r);
    return code;
}

static struct weft_tap_group tap(int sign, int shift)
{
    return (struct weft_tap_group){.tile = {0, -1, -1, -1}, .sign = {sign}, .shift = {shift}};
}

struct hand_case {
    int extra_bits;
    double range;
    int part;
    bool subtract, reads_target;
    int initial, sample, divisor, bias, taps, sign, shift, expected;
};
enum { WHOLE = WEFT_PASS_WHOLE, HIGH = WEFT_PASS_HIGH, LOW = WEFT_PASS_LOW };

static void parts_and_signs_by_hand(void **state)
{
    (void)state;
    static const struct hand_case cases[] = {
        // 101 * 128 / 255 = 50.69..., rounded once.
        {0, 0, WHOLE, false, false, 0, 101, 255, 0, 1, 1, 0, 51},
        // Twice that is 101.39; rounded one by one 102.
        {0, 0, WHOLE, false, false, 0, 101, 255, 0, 2, 1, 0, 101},
        {0, 8, WHOLE, false, false, 0, 101, 255, 0, 2, 1, 0, 102},
        // A half goes away from zero: 1 * 128 / 256.
        {0, 0, WHOLE, false, false, 0, 1, 256, 0, 1, 1, 0, 1},
        {0, 0, WHOLE, false, true, 10, 1, 256, 0, 1, -1, 0, 9},
        {0, 0, WHOLE, true, false, 10, 1, 256, 0, 1, -1, 0, 9},
        // A shift is a factor of two: 101 * 512 / 255 = 202.79.
        {0, 0, WHOLE, false, false, 0, 101, 255, 0, 1, 1, 2, 203},
        // Bias in 2^-e codes: with e = 4, 811 (of 50.69) + 20 = 831, 51.94.
        {4, 0, WHOLE, false, false, 0, 101, 255, 20, 1, 1, 0, 52},
        // High and low parts of 811: 50 * 16 + 11.
        {4, 0, HIGH, false, false, 0, 101, 255, 0, 1, 1, 0, 50},
        {4, 0, LOW, false, false, 0, 101, 255, 0, 1, 1, 0, 11},
        // -811 = -51 * 16 + 5.
        {4, 0, HIGH, true, false, 100, 101, 255, 0, 1, -1, 0, 49},
        {4, 0, LOW, true, false, 100, 101, 255, 0, 1, -1, 0, 105},
        {4, 0, HIGH, false, true, 100, 101, 255, 0, 1, -1, 0, 49},
        {4, 0, LOW, false, true, 100, 101, 255, 0, 1, -1, 0, 105},
        // A pass that subtracts turns its bias as well: 100 - (51 - 10).
        {0, 0, WHOLE, true, false, 100, 101, 255, 10, 1, -1, 0, 59},
        // Saturation at 255 inside: four times 128, and three times on top of -500.
        {0, 1, WHOLE, false, true, 0, 255, 255, 0, 4, 1, 0, 255},
        {0, 1, WHOLE, false, true, 0, 255, 255, -500, 3, 1, 0, 1},
        // Nothing but a bias.
        {0, 0, WHOLE, false, false, 5, 0, 7, 33, 0, 1, 0, 38},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct hand_case *k = &cases[i];
        struct hand_list *h = tent(k->extra_bits, k->range);
        hand_add_pass(h, (struct weft_pass){.clears = true,
                                            .initial = k->initial,
                                            .part = (enum weft_pass_part)k->part,
                                            .subtract = k->subtract,
                                            .reads_target = k->reads_target,
                                            .bias = k->bias,
                                            .divisor = k->divisor});
        for (int t = 0; t < k->taps; t++)
            hand_add_group(h, tap(k->sign, k->shift));
        const int code = run_code(h, k->sample, NULL);
        if (code != k->expected)
            fail_msg("case %zu: %d instead of %d", i, code, k->expected);
        hand_list_destroy(h);
    }
}

// Four taps of 128 in one group, saturating at 255: with three and one apart, R + G + B saturate
// first, which shows where A pulls back.
static void three_and_one_saturate_apart(void **state)
{
    (void)state;
    for (int width = 3; width <= 4; width++) {
        struct hand_list *h = tent(0, 1.0);
        h->list.dot4 = true;
        h->list.dot_width = width;
        hand_add_pass(h, (struct weft_pass){.clears = true, .reads_target = true, .divisor = 255});
        hand_add_group(h, (struct weft_tap_group){.tile = {0, 0, 0, 0}, .sign = {1, 1, 1, -1}});
        assert_int_equal(run_code(h, 255, NULL), width == 3 ? 127 : 255);
        hand_list_destroy(h);
    }
}

static void targets_combine(void **state)
{
    (void)state;
    static const struct {
        int extra_bits;
        double range;
        int numerator[2], denominator, bias, expected;
    } cases[] = {
        {0, 0.0, {1, 1}, 1, 0, 150},   // of 100 and 50
        {0, 0.0, {1, -1}, 1, 0, 50},   //
        {0, 0.0, {1, -3}, 1, 0, 0},    // clamps
        {0, 0.0, {3, -2}, 16, 0, 13},  // 200 / 16 = 12.5, a half goes up
        {0, 0.0, {16, 1}, 16, 0, 103}, // a low part of 50 / 16
        {0, 0.0, {-1, 3}, 3, 5, 18},   // 55 / 3
        {4, 8.0, {1, 1}, 3, 0, 50},    // 33 5/16 + 16 11/16
        {4, 8.0, {1, -1}, 3, -3, 16},  // 33 5/16 - 16 11/16 - 1 = 15 10/16
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct hand_list *h = tent(cases[i].extra_bits, cases[i].range);
        h->list.slot_count = 3;
        h->list.result = 2;
        for (int s = 0; s < 2; s++)
            hand_add_pass(h,
                          (struct weft_pass){
                              .target = s, .clears = true, .initial = s ? 50 : 100, .divisor = 1});
        hand_add_pass(
            h, (struct weft_pass){.kind = WEFT_PASS_COMBINE,
                                  .target = 2,
                                  .input_count = 2,
                                  .input = {0, 1},
                                  .numerator = {cases[i].numerator[0], cases[i].numerator[1]},
                                  .denominator = cases[i].denominator,
                                  .bias = cases[i].bias});
        const int code = run_code(h, 0, NULL);
        if (code != cases[i].expected)
            fail_msg("case %zu: %d instead of %d", i, code, cases[i].expected);
        hand_list_destroy(h);
    }
}

// The tent's weight 1/2 and a source of 1/2: a quarter, off by the codes' steps of 2^(10 / 254).
static void logarithms_multiply(void **state)
{
    (void)state;
    struct hand_list *h = hand_list_create(&(struct hand_params){
        HAND_DEFAULTS.kernel = "linear", .samples = 1, .dims = 1, .logarithms = true});
    hand_add_pass(h, (struct weft_pass){.clears = true, .divisor = 1});
    hand_add_group(h, tap(1, 0));
    // 1/2 is the code round(25.4) = 25, twice: 255 * 2^(-50 * 10 / 254) = 65.15.
    struct hand_request *r = hand_request_create(h, 1, 1, 1, 1, 1);
    r->samples[0][0] = 0.5f;
    assert_int_equal(hand_run(NULL, h, r, NULL), WEFT_OK);
    assert_int_equal(code_of(h, r->pixels[0][0]), 65);
    r->samples[0][0] = 0.0f; // has no logarithm
    assert_int_equal(hand_run(NULL, h, r, NULL), WEFT_OK);
    assert_int_equal(code_of(h, r->pixels[0][0]), 0);
    r->source.low = -1.0;
    r->params.log = NULL;
    assert_int_equal(hand_run(NULL, h, r, NULL), WEFT_ERR_UNSUPPORTED);
    free(r);
    hand_list_destroy(h);
}

static void clamps_are_counted(void **state)
{
    (void)state;
    struct hand_list *h = tent(0, 0.0);
    struct weft_multipass_report report;
    for (int n = 0; n < 4; n++) {
        hand_add_pass(h, (struct weft_pass){.clears = n == 0, .divisor = 255});
        hand_add_group(h, tap(1, 0)); // 128 more: 128, 256, 383 and so on
    }
    assert_int_equal(run_code(h, 255, &report), 255);
    assert_int_equal(report.clamps, 3);
    assert_true(report.largest_clamp == 128.0);
    hand_list_destroy(h);
}

static void halves_truncate(void **state)
{
    (void)state;
    static const float cases[][2] = {
        {1.0f, 1.0f},
        {0x1.ffffp-1f, 0x1.ffcp-1f},
        {-0x1.ffffp-1f, -0x1.ffcp-1f},
        {65519.0f, 65504.0f},
        {1e6f, 65504.0f},
        {0x1p-14f, 0x1p-14f},
        {0x1.fffp-15f, 0x1.ff8p-15f},
        {0x1.8p-24f, 0x1p-24f},
        {0x1.fp-25f, 0.0f},
        {-0x1.fp-25f, -0.0f},
        {0.0f, 0.0f},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        assert_true(weft_half_truncate(cases[i][0]) == cases[i][1]);
    assert_true(isinf(weft_half_truncate(INFINITY)) && isnan(weft_half_truncate(NAN)));
}

// ---- floats against the reference ---------------------------------------------------------------

struct plane {
    const struct hand_request *r;
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct hand_request *r = ((const struct plane *)priv)->r;
    int64_t at[3];
    for (int a = 0; a < 3; a++)
        at[a] = clamp_to(index[a], 0, r->source.size[a] - 1);
    return (double)r->samples[0][(at[2] * r->source.size[1] + at[1]) * r->source.size[0] + at[0]];
}

// At positions that are sample positions of the tiles nothing is left but roundings: of each weight
// and sample, product and sum to 2^-24, of n terms whose magnitudes add up to at most `magnitude`;
// halves have 2^-11 for weights and samples (nearest), and 2^-10 of every store, of at most
// `magnitude` each.
static double tolerance(const struct hand_list *h, double magnitude)
{
    const double n = h->list.pass_count;
    if (h->list.target == WEFT_TARGET_HALF)
        return magnitude * (2.0 * 0x1p-11 + n * 0x1p-10 + (n + 4.0) * 0x1p-23);
    return magnitude * (n + 4.0) * 0x1p-23;
}

static void floats_reconstruct(void **state)
{
    (void)state;
    static const char *const kernels[] = {"linear", "catmull-rom", "bspline", "gaussian:1.5"};
    for (int i = 0; i < 16; i++) {
        const int m = 4;
        struct hand_list *h = hand_list_create(&(struct hand_params){
            HAND_DEFAULTS.kernel = kernels[i % 4], .samples = m, .dims = 2 + i / 8,
            .target = i % 8 < 4 ? WEFT_TARGET_FLOAT : WEFT_TARGET_HALF});
        hand_add_all_tiles(h, i % 2);
        struct hand_request *r = hand_request_create(h, 11, 13, 5, 6, i / 8 ? 4 : 1);
        double largest = 0.0;
        for (int a = 0; a < h->list.dims; a++) {
            r->grid.origin[a] = random_below(12) / 4.0 - 2.0 + 0.5 / m;
            r->grid.du[a] = random_below(4) / 4.0;
            r->grid.dv[a] = random_below(5) / 4.0 - 0.25;
        }
        assert_int_equal(hand_run(NULL, h, r, NULL), WEFT_OK);
        for (int p = 0; p < 11 * 13; p++) {
            double at[3];
            struct plane plane = {r};
            weft_multipass_position(&r->grid, p % 11, p / 11, at);
            const double expected =
                weft_reference_compute(&h->work.kernel, h->list.dims, at, fetch, &plane).value;
            largest = larger(largest, fabs((double)r->pixels[0][p] - expected));
        }
        // Magnitudes of the weights of these add up to no more than 1.25 an axis.
        const double bound = tolerance(h, pow(1.25, h->list.dims));
        print_message("%-12s %dD %s: %.3g from the reference, bound %.3g\n", kernels[i % 4],
                      h->list.dims, weft_target_name(h->list.target), largest, bound);
        assert_true(largest <= bound);
        struct weft_verify_report error;
        assert_int_equal(hand_verify(h, r, &error), WEFT_OK);
        assert_true(error.maximum == largest && error.rms <= largest);
        assert_int_equal(error.not_finite_mismatches, 0);
        free(r);
        hand_list_destroy(h);
    }
}

// ---- ranges -------------------------------------------------------------------------------------

// A constant outside [0, 1]: kernels whose weights add up to something else scale it by just that.
static void constants_keep_their_range(void **state)
{
    (void)state;
    static const char *const kernels[] = {"catmull-rom", "gaussian:1.5", "d-catmull-rom"};
    for (size_t n = 0; n < WEFT_COUNT(kernels); n++) {
        struct hand_list *h = hand_list_create(&(struct hand_params){
            HAND_DEFAULTS.kernel = kernels[n], .target = WEFT_TARGET_FLOAT, .dims = 2});
        hand_add_all_tiles(h, true);
        struct hand_request *r = hand_request_create(h, 9, 7, 4, 4, 1);
        r->grid.du[0] = r->grid.dv[1] = 0.37;
        r->source.low = -3000.0;
        r->source.high = -2000.0;
        for (int i = 0; i < 16; i++)
            r->samples[0][i] = -3000.0f;
        assert_int_equal(hand_run(NULL, h, r, NULL), WEFT_OK);
        struct weft_verify_report error;
        assert_int_equal(hand_verify(h, r, &error), WEFT_OK);
        // The mapped source is 0: only the value itself is rounded, to a float.
        assert_true(error.maximum <= 3000.0 * 0x1p-23 && error.not_finite_mismatches == 0);
        // No range at all: all samples are one value.
        r->source.low = r->source.high = NAN;
        struct weft_multipass_report report;
        assert_int_equal(hand_run(NULL, h, r, &report), WEFT_OK);
        assert_true(report.low == -3000.0 && report.high == -3000.0 && report.clamped == 0);
        assert_int_equal(hand_verify(h, r, &error), WEFT_OK);
        assert_true(error.maximum <= 3000.0 * 0x1p-23 && error.not_finite_mismatches == 0);
        free(r);
        hand_list_destroy(h);
    }
}

static void the_range_is_measured(void **state)
{
    (void)state;
    struct hand_list *h = tent(0, 0.0);
    hand_add_all_tiles(h, false);
    struct hand_request *r = hand_request_create(h, 4, 1, 5, 1, 1);
    struct weft_multipass_report report;
    const float samples[5] = {-2.0f, 7.0f, NAN, INFINITY, 1.0f};
    memcpy(r->samples[0], samples, sizeof samples);
    r->grid.du[0] = 1.0;
    r->source.low = r->source.high = NAN;
    assert_int_equal(hand_run(NULL, h, r, &report), WEFT_OK);
    assert_true(report.low == -2.0 && report.high == 7.0);
    assert_int_equal(report.clamped, 2);
    // At whole positions taps are the pixels' own samples: the next ones' weights are 0.
    assert_int_equal(report.not_finite, 2);
    for (int i = 0; i < 4; i++)
        assert_int_equal(isnan(r->pixels[0][i]), i > 1);
    struct weft_verify_report error;
    assert_int_equal(hand_verify(h, r, &error), WEFT_OK);
    assert_int_equal(error.not_finite_mismatches, 0);
    // Declared on one side only, beyond what is there.
    r->source.low = 9.0;
    assert_int_equal(hand_run(NULL, h, r, &report), WEFT_OK);
    assert_true(report.low == 9.0 && report.high == 9.0);
    assert_int_equal(report.clamped, 5);
    for (int i = 0; i < 5; i++)
        r->samples[0][i] = NAN;
    r->source.low = NAN;
    assert_int_equal(hand_run(NULL, h, r, &report), WEFT_OK);
    assert_int_equal(report.not_finite, 4);
    free(r);
    hand_list_destroy(h);
}

// ---- refusals -----------------------------------------------------------------------------------

// A request that is fine, and its list.
struct request {
    struct hand_list *h;
    struct hand_request *r;
};

static struct request make_request(void)
{
    struct hand_list *h = hand_list_create(&(struct hand_params){HAND_DEFAULTS});
    hand_add_all_tiles(h, false);
    hand_add_pass(
        h, (struct weft_pass){
               .kind = WEFT_PASS_COMBINE, .input_count = 1, .numerator = {1}, .denominator = 1});
    return (struct request){h, hand_request_create(h, 3, 3, 4, 4, 1)};
}

static void destroy_request(struct request *q)
{
    free(q->r);
    hand_list_destroy(q->h);
}

static void assert_refused(const struct request *q, int number)
{
    struct message message = {0};
    const struct weft_log log = {keep_message, &message};
    q->r->params.log = &log;
    const enum weft_result res = hand_run(NULL, q->h, q->r, NULL);
    if (res != WEFT_ERR_ARGUMENT || message.count != 1)
        fail_msg("number %d: result %d, '%s'", number, (int)res, message.text);
}

// Each in turn has a value that makes no sense.
static void bad_numbers_are_refused(void **state)
{
    (void)state;
    enum { INTEGERS = 18, REALS = 6, POINTERS = 5 };
    for (int n = 0; n < INTEGERS + REALS + POINTERS; n++) {
        struct request q = make_request();
        struct weft_pass *pass = &q.h->passes[0];
        struct weft_pass *last = &q.h->passes[q.h->list.pass_count - 1];
        struct weft_tap_group *group = &q.h->groups[0];
        const struct {
            int *at, value;
        } integers[INTEGERS] = {
            {&q.r->grid.width, 0},       {&q.r->grid.height, -1},   {&q.r->source.size[1], 0},
            {&q.r->source.size[2], 2},   {&group->tile[0], 1000},   {&group->sign[0], 2},
            {&group->shift[0], -1},      {&group->offset[0], 1000}, {&group->offset[2], 1},
            {&pass->target, 1},          {&pass->group_count, 999}, {&pass->divisor, 0},
            {&last->denominator, 0},     {&last->input[0], -1},     {&q.h->list.result, 1},
            {&q.h->list.extra_bits, 25}, {&q.h->list.dims, 3},      {&q.h->work.channels, 2},
        };
        const struct {
            double *at, value;
        } reals[REALS] = {
            {&q.r->source.low, 2.0},        {&q.r->source.high, INFINITY},
            {&q.r->grid.origin[0], NAN},    {&q.r->grid.du[1], 1e308},
            {&q.h->list.result_scale, 0.0}, {&q.h->list.result_scale, INFINITY},
        };
        if (n < INTEGERS)
            *integers[n].at = integers[n].value;
        else if (n < INTEGERS + REALS)
            *reals[n - INTEGERS].at = reals[n - INTEGERS].value;
        else if (n == INTEGERS + REALS)
            q.r->params.samples = NULL;
        else if (n == INTEGERS + REALS + 1)
            q.r->params.grid = NULL;
        else if (n == INTEGERS + REALS + 2)
            q.r->source.plane[0] = NULL;
        else if (n == INTEGERS + REALS + 3)
            q.r->params.pixels[0] = NULL;
        else
            q.r->params.stride = 2; // of 3 pixels
        assert_refused(&q, n);
        destroy_request(&q);
    }
}

static void other_bad_requests_are_refused(void **state)
{
    (void)state;
    struct request q = make_request();
    assert_int_equal(hand_run(NULL, q.h, q.r, NULL), WEFT_OK);
    q.h->work.kernel = kernel_named("linear"); // the tiles are of another
    assert_refused(&q, 0);
    destroy_request(&q);
    struct weft_verify_report error;
    weft_multipass *compiled = NULL;
    assert_int_equal(weft_multipass_compile(NULL, weft_multipass_params(.plan = NULL), &compiled),
                     WEFT_ERR_ARGUMENT);
    assert_null(compiled);
    assert_int_equal(weft_multipass_verify(&(struct weft_multipass_verify_params){0}, &error),
                     WEFT_ERR_ARGUMENT);
}

// 65535 * 16383 is just below 2^30.
static void sums_of_more_than_32_bits_are_refused(void **state)
{
    (void)state;
    for (int shift = 1; shift <= 2; shift++) {
        struct message message = {0};
        const struct weft_log log = {keep_message, &message};
        struct hand_list *h = hand_list_create(&(struct hand_params){
            HAND_DEFAULTS.target = WEFT_TARGET_UNORM16, .bits = 14, .dims = 1, .kernel = "nearest",
            .samples = 1, .scaling = WEFT_TILE_UNSCALED});
        hand_add_pass(h, (struct weft_pass){.clears = true, .divisor = 16383});
        hand_add_group(h, tap(1, shift));
        struct hand_request *r = hand_request_create(h, 1, 1, 1, 1, 1);
        r->params.log = &log;
        assert_int_equal(hand_run(NULL, h, r, NULL), shift > 1 ? WEFT_ERR_LIMIT : WEFT_OK);
        assert_int_equal(message.count, shift > 1);
        free(r);
        hand_list_destroy(h);
    }
}

static void progress_can_cancel(void **state)
{
    (void)state;
    int calls = 3;
    const struct weft_progress progress = {cancel_at_call, &calls};
    struct hand_list *h = hand_list_create(&(struct hand_params){HAND_DEFAULTS});
    hand_add_all_tiles(h, false);
    struct hand_request *r = hand_request_create(h, 3, 3, 4, 4, 1);
    r->params.progress = &progress;
    assert_int_equal(hand_run(NULL, h, r, NULL), WEFT_ERR_CANCELLED);
    calls = 1;
    struct weft_verify_report error;
    assert_int_equal(hand_verify(h, r, &error), WEFT_ERR_CANCELLED);
    free(r);
    hand_list_destroy(h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_lists_agree_with_the_rules),
        cmocka_unit_test(parts_and_signs_by_hand),
        cmocka_unit_test(three_and_one_saturate_apart),
        cmocka_unit_test(targets_combine),
        cmocka_unit_test(logarithms_multiply),
        cmocka_unit_test(clamps_are_counted),
        cmocka_unit_test(halves_truncate),
        cmocka_unit_test(floats_reconstruct),
        cmocka_unit_test(constants_keep_their_range),
        cmocka_unit_test(the_range_is_measured),
        cmocka_unit_test(bad_numbers_are_refused),
        cmocka_unit_test(other_bad_requests_are_refused),
        cmocka_unit_test(sums_of_more_than_32_bits_are_refused),
        cmocka_unit_test(progress_can_cancel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
