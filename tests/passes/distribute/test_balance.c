// SPDX-License-Identifier: BSD-3-Clause
// Boundaries that are moved by load: regions stay a cover, come to take the same time, and are
// never thinner than what is asked for.
#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "passes/distribute/schedule/schedule.h"
#include "tests/passes/distribute/cover.h"
#include "tests/support/common.h"

static weft_regions *make(const struct weft_regions_params *params)
{
    weft_regions *regions = NULL;
    struct weft_regions_params p = *params;
    p.log = &log_to_stderr;
    assert_int_equal(weft_regions_create(&p, &regions), WEFT_OK);
    return regions;
}

// ---- costs that have integrals ------------------------------------------------------------------

// Integral of a density over [0, x] times [0, y].
typedef double (*integral)(double x, double y);

static double uniform(double x, double y)
{
    return x * y;
}

static double ramp(double x, double y) // 1 + x / 64
{
    return (x + x * x / 128.0) * y;
}

static double corner(double x, double y) // (1 + x / 32) (1 + y / 16)
{
    return (x + x * x / 64.0) * (y + y * y / 32.0);
}

static double hill(double x, double y) // around (180, 330), as high as 30 times what is around it
{
    const double s = 60.0;
    return x * y + 29.0 * s * s * 1.5707963267948966 *
                       (erf((x - 180.0) / s * 0.7071067811865476) + 1.0) *
                       (erf((y - 330.0) / s * 0.7071067811865476) + 1.0);
}

static double *measure(const weft_regions *regions, integral cost, double constant)
{
    const int64_t count = weft_regions_count(regions);
    double *seconds = malloc((size_t)count * sizeof *seconds);
    assert_non_null(seconds);
    for (int64_t i = 0; i < count; i++) {
        const struct weft_rectangle r = weft_regions_get(regions, i);
        const double x[2] = {r.x, r.x + (double)r.width}, y[2] = {r.y, r.y + (double)r.height};
        seconds[i] = constant + fmax(0.0, cost(x[1], y[1]) - cost(x[0], y[1]) - cost(x[1], y[0]) +
                                              cost(x[0], y[0]));
    }
    return seconds;
}

// The dearest of all to the mean.
static double imbalance(const double *seconds, int64_t count)
{
    double sum = 0.0, most = 0.0;
    for (int64_t i = 0; i < count; i++) {
        sum += seconds[i];
        most = fmax(most, seconds[i]);
    }
    return most * (double)count / sum;
}

static double balance(weft_regions *regions, integral cost, double constant, double keep, int times)
{
    const int64_t count = weft_regions_count(regions);
    for (int t = 0; t < times; t++) {
        double *seconds = measure(regions, cost, constant);
        assert_int_equal(weft_regions_balance(regions, seconds, keep), WEFT_OK);
        free(seconds);
    }
    double *seconds = measure(regions, cost, constant);
    const double result = imbalance(seconds, count);
    free(seconds);
    return result;
}

// Of 64 regions of 512 x 512 pixels the dearest takes at most so much more than the mean: a pixel
// more along a side where regions are smallest (17 pixels in the hill).
static void regions_come_to_take_the_same_time(void **state)
{
    (void)state;
    static const struct {
        integral cost;
        double constant, keep;
        int frames;
        double before, bound; // imbalance at first, at least, and at last, at most
    } cases[] = {
        {uniform, 0.0, 0.0, 1, 1.0, 1.0},      {ramp, 0.0, 0.0, 8, 1.4, 1.02},
        {corner, 0.0, 0.0, 8, 3.0, 1.03},      {hill, 0.0, 0.0, 12, 4.0, 1.06},
        {ramp, 0.0, 0.5, 16, 1.4, 1.02},       {corner, 0.0, 0.5, 16, 3.0, 1.03},
        {hill, 0.0, 0.5, 24, 4.0, 1.06},       {hill, 0.0, 0.9, 120, 4.0, 1.06},
        {corner, 50000.0, 0.5, 16, 1.5, 1.03}, {hill, 5000.0, 0.5, 24, 2.0, 1.06},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_regions *regions = make(weft_regions_params(.width = 512, .height = 512, .ranks = 8));
        const double before = balance(regions, cases[i].cost, cases[i].constant, 0.0, 0);
        const double after =
            balance(regions, cases[i].cost, cases[i].constant, cases[i].keep, cases[i].frames);
        assert_covers(regions, 512, 512, 1);
        if (getenv("WEFT_BALANCE"))
            print_message("%zu: %.4f to %.4f\n", i, before, after);
        if (!(before >= cases[i].before && after <= cases[i].bound))
            fail_msg("case %zu: %.4f, then %.4f", i, before, after);
        weft_regions_destroy(&regions);
    }
}

// Whatever the even division of a side was rounded to stays as it is.
static void uniform_load_leaves_even_regions_alone(void **state)
{
    (void)state;
    static const int32_t sides[] = {1, 2, 7, 64, 100, 509, 512, 4096};
    int ran = 0;
    for (size_t w = 0; w < WEFT_COUNT(sides); w++)
        for (size_t h = 0; h < WEFT_COUNT(sides); h++)
            for (int ranks = 1; ranks < 8; ranks++, ran++) {
                weft_regions *regions = make(
                    weft_regions_params(.width = sides[w], .height = sides[h], .ranks = ranks));
                weft_regions *moved = make(
                    weft_regions_params(.width = sides[w], .height = sides[h], .ranks = ranks));
                balance(moved, uniform, 0.0, ranks / 8.0, 2);
                for (int64_t i = 0; i < weft_regions_count(regions); i++) {
                    const struct weft_rectangle a = weft_regions_get(regions, i),
                                                b = weft_regions_get(moved, i);
                    assert_memory_equal(&a, &b, sizeof a);
                }
                weft_regions_destroy(&regions);
                weft_regions_destroy(&moved);
            }
    assert_int_equal(ran, 8 * 8 * 7);
    // Multiples of a size that leave a rest are made even.
    weft_regions *rest = make(
        weft_regions_params(.width = 100, .height = 10, .region_width = 33, .region_height = 10));
    balance(rest, uniform, 0.0, 0.0, 1);
    for (int64_t i = 0; i < 4; i++)
        assert_int_equal(weft_regions_get(rest, i).width, 25);
    weft_regions_destroy(&rest);
}

// ---- anything else ------------------------------------------------------------------------------

static uint64_t random_bits(uint64_t *seed)
{
    *seed ^= *seed << 13, *seed ^= *seed >> 7, *seed ^= *seed << 17;
    return *seed;
}

static double random_seconds(uint64_t *seed, int kind)
{
    const double unit = (double)(random_bits(seed) >> 11) * 0x1p-53;
    switch (kind) {
    case 0:
        return unit;
    case 1:
        return random_bits(seed) % 8 ? 0.0 : unit;
    case 2:
        return exp(60.0 * (unit - 0.5));
    case 3:
        return unit * DBL_MAX;
    case 4:
        return unit * DBL_TRUE_MIN * 8.0;
    default:
        return random_bits(seed) % 64 ? 0.0 : exp(1400.0 * (unit - 0.5));
    }
}

static void any_load_leaves_a_cover_with_sides_of_least(void **state)
{
    (void)state;
    static const int32_t sides[] = {1, 2, 7, 40, 64, 509, 1000, INT32_MAX};
    static const int32_t sizes[] = {0, 1, 7, 64, 1 << 30};
    uint64_t seed = 17;
    int ran = 0;
    for (int run = 0; run < 3000; run++) {
        struct weft_regions_params p = {
            .width = sides[random_bits(&seed) % 8],
            .height = sides[random_bits(&seed) % 8],
            .region_width = sizes[random_bits(&seed) % 5],
            .region_height = sizes[random_bits(&seed) % 5],
            .ranks = 1 + (int)(random_bits(&seed) % 30),
            .least = 1 + (int32_t)(random_bits(&seed) % 20),
        };
        weft_regions *regions;
        if (weft_regions_create(&p, &regions) != WEFT_OK)
            continue;
        const int64_t count = weft_regions_count(regions);
        if (count <= 20000) {
            double *seconds = malloc((size_t)count * sizeof *seconds);
            const int kind = (int)(random_bits(&seed) % 6);
            // Regions that were asked for thinner than `least` may stay so: even ones are.
            int64_t columns = 0;
            while (columns < count && weft_regions_get(regions, columns).y == 0)
                columns++;
            const int32_t even[2] = {(int32_t)(p.width / columns),
                                     (int32_t)(p.height / (count / columns))};
            for (int t = 0; t < 3; t++) {
                for (int64_t i = 0; i < count; i++)
                    seconds[i] = random_seconds(&seed, kind);
                seconds[0] += DBL_TRUE_MIN; // where nothing was done nothing moves
                assert_int_equal(weft_regions_balance(regions, seconds, t / 4.0), WEFT_OK);
                assert_int_equal(weft_regions_count(regions), count);
                assert_covers(regions, p.width, p.height, 1);
                for (int64_t i = 0; i < count; i++) {
                    const struct weft_rectangle r = weft_regions_get(regions, i);
                    if (r.width < (even[0] < p.least ? even[0] : p.least) ||
                        r.height < (even[1] < p.least ? even[1] : p.least))
                        fail_msg("run %d: %d x %d", run, r.width, r.height);
                }
            }
            free(seconds);
            ran++;
        }
        weft_regions_destroy(&regions);
    }
    assert_true(ran > 1500);
}

static void the_same_seconds_give_the_same_regions(void **state)
{
    (void)state;
    weft_regions *regions[2];
    for (int i = 0; i < 2; i++)
        regions[i] = make(weft_regions_params(.width = 509, .height = 300, .ranks = 5));
    const int64_t count = weft_regions_count(regions[0]);
    double *seconds = malloc((size_t)count * sizeof *seconds);
    uint64_t seed = 5;
    for (int frame = 0; frame < 20; frame++) {
        for (int64_t i = 0; i < count; i++)
            seconds[i] = random_seconds(&seed, 2);
        for (int i = 0; i < 2; i++)
            assert_int_equal(weft_regions_balance(regions[i], seconds, 0.5), WEFT_OK);
        for (int64_t i = 0; i < count; i++) {
            const struct weft_rectangle a = weft_regions_get(regions[0], i),
                                        b = weft_regions_get(regions[1], i);
            assert_memory_equal(&a, &b, sizeof a);
        }
    }
    free(seconds);
    weft_regions_destroy(&regions[0]);
    weft_regions_destroy(&regions[1]);
}

static void what_is_no_time_is_refused_and_moves_nothing(void **state)
{
    (void)state;
    static const double bad[] = {-1.0, -DBL_TRUE_MIN, (double)NAN, (double)INFINITY};
    static const double bad_keeps[] = {-0.1, 1.0, 2.0, (double)NAN, (double)INFINITY};
    weft_regions *regions = make(weft_regions_params(.width = 64, .height = 64, .ranks = 8));
    const struct weft_rectangle before = weft_regions_get(regions, 9);
    double seconds[64] = {0.0};
    assert_int_equal(weft_regions_balance(regions, seconds, 0.0), WEFT_OK); // nothing was done
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        for (int k = 0; k < 64; k++)
            seconds[k] = k == 63 ? bad[i] : k;
        assert_int_equal(weft_regions_balance(regions, seconds, 0.0), WEFT_ERR_ARGUMENT);
    }
    seconds[63] = 1.0;
    for (size_t i = 0; i < WEFT_COUNT(bad_keeps); i++)
        assert_int_equal(weft_regions_balance(regions, seconds, bad_keeps[i]), WEFT_ERR_ARGUMENT);
    struct weft_rectangle after = weft_regions_get(regions, 9);
    assert_memory_equal(&before, &after, sizeof before);
    assert_int_equal(weft_regions_balance(regions, seconds, 0.0), WEFT_OK);
    after = weft_regions_get(regions, 9);
    assert_memory_not_equal(&before, &after, sizeof before);
    weft_regions_destroy(&regions);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regions_come_to_take_the_same_time),
        cmocka_unit_test(uniform_load_leaves_even_regions_alone),
        cmocka_unit_test(any_load_leaves_a_cover_with_sides_of_least),
        cmocka_unit_test(the_same_seconds_give_the_same_regions),
        cmocka_unit_test(what_is_no_time_is_refused_and_moves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
