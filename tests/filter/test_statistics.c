// SPDX-License-Identifier: BSD-3-Clause
// Statistics against definitions that are written out one value at a time.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "filter/check.h"
#include "filter/statistics.h"

enum { MOST = 10000 };

static struct weft_statistics expected(const float *values, size_t count)
{
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    s.count = count;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            s.not_finite++;
        } else {
            s.minimum =
                isnan(s.minimum) || (double)values[i] < s.minimum ? (double)values[i] : s.minimum;
            s.maximum =
                isnan(s.maximum) || (double)values[i] > s.maximum ? (double)values[i] : s.maximum;
        }
    }
    return s;
}

static bool same(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

static void check(const struct weft_statistics *a, const struct weft_statistics *b)
{
    assert_true(same(a->minimum, b->minimum) && same(a->maximum, b->maximum));
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->not_finite, b->not_finite);
}

static float *make_values(size_t count)
{
    float *values = malloc((count + 1) * sizeof *values);
    srand(7);
    for (size_t i = 0; i < count; i++)
        values[i] = (float)(rand() - RAND_MAX / 3) / 1024.0f;
    return values;
}

// Around each place where lanes and blocks end, with nothing, one or everything not finite.
static void test_range(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, 2, 15, 16, 17, 33, 4095, 4096, 4097, 8192, MOST};
    static const float odd[] = {NAN, INFINITY, -INFINITY};
    float *values = make_values(MOST);
    for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
        const size_t count = counts[c];
        struct weft_statistics found = WEFT_STATISTICS_NONE, exact = expected(values, count);
        weft_statistics_add(&found, values, count);
        check(&found, &exact);
        assert_int_equal(isnan(found.minimum), count == 0);
        for (size_t o = 0; o < WEFT_COUNT(odd) && count; o++) {
            const float kept = values[count - 1];
            values[count - 1] = odd[o];
            found = (struct weft_statistics)WEFT_STATISTICS_NONE;
            exact = expected(values, count);
            weft_statistics_add(&found, values, count);
            check(&found, &exact);
            assert_int_equal(found.not_finite, 1);
            values[count - 1] = kept;
        }
    }
    for (size_t i = 0; i < MOST; i++)
        values[i] = odd[i % WEFT_COUNT(odd)];
    struct weft_statistics found = WEFT_STATISTICS_NONE;
    weft_statistics_add(&found, values, MOST);
    assert_true(isnan(found.minimum) && isnan(found.maximum));
    assert_int_equal(found.not_finite, MOST);
    assert_true(weft_statistics_magnitude(&found) == 0.0);
    free(values);
}

// The same whatever the portions.
static void test_portions(void **state)
{
    (void)state;
    float *values = make_values(MOST);
    values[5000] = NAN;
    const struct weft_statistics exact = expected(values, MOST);
    for (size_t step = 1; step < MOST; step = step * 3 + 1) {
        struct weft_statistics found = WEFT_STATISTICS_NONE;
        for (size_t i = 0; i < MOST; i += step)
            weft_statistics_add(&found, values + i, step < MOST - i ? step : MOST - i);
        check(&found, &exact);
        assert_true(weft_statistics_magnitude(&found) ==
                    fmax(fabs(exact.minimum), fabs(exact.maximum)));
        struct weft_statistics first = WEFT_STATISTICS_NONE, rest = WEFT_STATISTICS_NONE;
        weft_statistics_add(&first, values, step);
        weft_statistics_add(&rest, values + step, MOST - step);
        weft_statistics_join(&first, &rest);
        check(&first, &exact);
    }
    free(values);
}

// The n-th difference of i^n is n! everywhere, and the next one 0.
static void test_powers(void **state)
{
    (void)state;
    static const double factorial[] = {1.0, 1.0, 2.0, 6.0, 24.0};
    enum { COUNT = 64 };
    for (int n = 1; n <= WEFT_STATISTICS_DIFFERENCES; n++) {
        float values[2 * COUNT];
        for (int i = 0; i < 2 * COUNT; i++)
            values[i] = i % 2 ? NAN : (float)pow(i / 2, n); // at most 63^4 < 2^24
        struct weft_statistics s = WEFT_STATISTICS_NONE;
        weft_statistics_add_differences(&s, values, COUNT, 2);
        assert_true(s.difference[n - 1] == factorial[n]);
        if (n < WEFT_STATISTICS_DIFFERENCES)
            assert_true(s.difference[n] == 0.0);
        assert_true(isnan(s.minimum) && s.count == 0);
    }
}

// A step is found wherever it lies, and its higher differences are binomials' largest: 1, 1, 2, 3.
// Next to a value that is not finite there are fewer; lines too short have none.
static void test_steps(void **state)
{
    (void)state;
    enum { COUNT = 600 };
    static const double binomial[] = {1.0, 1.0, 2.0, 3.0};
    for (size_t at = 4; at + 4 < COUNT; at++) {
        float values[COUNT] = {0};
        for (size_t i = at; i < COUNT; i++)
            values[i] = 1.0f;
        struct weft_statistics s = WEFT_STATISTICS_NONE;
        weft_statistics_add_differences(&s, values, COUNT, 1);
        for (int n = 0; n < WEFT_STATISTICS_DIFFERENCES; n++)
            assert_true(s.difference[n] == binomial[n]);
        values[at] = at % 2 ? NAN : INFINITY;
        s = (struct weft_statistics)WEFT_STATISTICS_NONE;
        weft_statistics_add_differences(&s, values, COUNT, 1);
        for (int n = 0; n < WEFT_STATISTICS_DIFFERENCES; n++)
            assert_true(s.difference[n] == 0.0);
    }
    const float line[] = {3.0f, 5.0f, 9.0f};
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    weft_statistics_add_differences(&s, line, 0, 1);
    weft_statistics_add_differences(&s, line, 1, 1);
    assert_true(s.difference[0] == 0.0);
    weft_statistics_add_differences(&s, line, 3, 1);
    assert_true(s.difference[0] == 4.0 && s.difference[1] == 2.0 && s.difference[2] == 0.0);
}

// A plane's differences are those of its rows and its columns as lines, in bands or whole: exactly,
// of integers.
static void test_planes(void **state)
{
    (void)state;
    enum { MOST_SIDE = 41, STRIDE = 50 };
    static const size_t sides[][2] = {{1, 1}, {1, 30}, {30, 1}, {4, 5}, {41, 3}, {3, 41}, {37, 41}};
    for (size_t i = 0; i < 4 * WEFT_COUNT(sides); i++) {
        const size_t *side = sides[i / 4];
        const int n = (int)(i % 4) + 1;
        float values[MOST_SIDE * STRIDE];
        for (size_t k = 0; k < WEFT_COUNT(values); k++)
            values[k] = k * 7919 % 89 == 3 ? (k % 2 ? NAN : INFINITY) : (float)(k * 7919 % 1013);
        const struct weft_statistics_plane plane = {values, side[0], side[1], STRIDE};
        struct weft_statistics s = WEFT_STATISTICS_NONE;
        for (size_t y = 0; y < side[1]; y++)
            weft_statistics_add_differences(&s, values + y * STRIDE, side[0], 1);
        for (size_t x = 0; x < side[0]; x++)
            weft_statistics_add_differences(&s, values + x, side[1], STRIDE);
        double bands = 0.0;
        for (size_t y = 0; y < side[1]; y += 6)
            bands = fmax(bands, weft_statistics_plane_difference(&plane, n, y, y + 6));
        assert_true(weft_statistics_plane_difference(&plane, n, 0, SIZE_MAX) ==
                    s.difference[n - 1]);
        assert_true(bands == s.difference[n - 1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_range),  cmocka_unit_test(test_portions),
        cmocka_unit_test(test_powers), cmocka_unit_test(test_steps),
        cmocka_unit_test(test_planes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
