// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "filter/half.h"

// By the format's definition.
static double value_of(int half)
{
    const int exponent = half >> 10 & 31, fraction = half & 1023;
    const double size = exponent == 31  ? (fraction ? NAN : INFINITY)
                        : exponent == 0 ? ldexp(fraction, -24)
                                        : ldexp(1024 + fraction, exponent - 25);
    return half & 0x8000 ? -size : size;
}

static void test_every_half(void **state)
{
    (void)state;
    for (int half = 0; half < 0x10000; half++) {
        const float value = weft_half_to_float((uint16_t)half);
        if (isnan(value_of(half))) {
            assert_true(isnan(value));
            assert_int_equal(weft_half_from_float(value), half | 0x200); // quiet
        } else {
            assert_true((double)value == value_of(half) && !signbit(value) == !(half & 0x8000));
            assert_int_equal(weft_half_from_float(value), half);
        }
    }
}

// Many at once, from any place in a line: the same.
static void test_lines_of_halves(void **state)
{
    (void)state;
    enum { COUNT = 0x10000 };
    static uint16_t halves[COUNT];
    static float values[COUNT];
    for (int i = 0; i < COUNT; i++)
        halves[i] = (uint16_t)i;
    for (size_t first = 0; first < 9; first++) {
        weft_half_to_floats(halves + first, COUNT - first, values + first);
        for (size_t i = first; i < COUNT; i++) {
            const float one = weft_half_to_float(halves[i]);
            assert_true(isnan(one) ? isnan(values[i]) && !signbit(one) == !signbit(values[i])
                                   : memcmp(&one, &values[i], sizeof one) == 0);
        }
    }
}

// Between neighbours: the middle goes to the even one, what is beside it to the nearer one.
static void test_between_halves(void **state)
{
    (void)state;
    for (int half = 0; half < 0x7c00; half++) {
        const double next = half == 0x7bff ? 65536.0 : value_of(half + 1);
        const float middle = (float)(0.5 * (value_of(half) + next)); // exact: 12 bits
        const int even = half & 1 ? half + 1 : half;
        assert_int_equal(weft_half_from_float(middle), even);
        assert_int_equal(weft_half_from_float(nextafterf(middle, 0.0f)), half);
        assert_int_equal(weft_half_from_float(nextafterf(middle, INFINITY)), half + 1);
        assert_int_equal(weft_half_from_float(-middle), 0x8000 | even);
    }
    assert_int_equal(weft_half_from_float(WEFT_HALF_MAX), 0x7bff);
    assert_int_equal(weft_half_from_float(65520.0f), 0x7c00);
    assert_int_equal(weft_half_from_float(FLT_MAX), 0x7c00);
    assert_int_equal(weft_half_from_float(-INFINITY), 0xfc00);
    assert_int_equal(weft_half_from_float(1e-45f), 0);
    assert_int_equal(weft_half_from_float(-FLT_MIN), 0x8000);
}

// Every kind of float: exponents around the halves' and fractions of all lengths, in lines of all
// lengths, with the same losses as one by one.
static void test_lines(void **state)
{
    (void)state;
    enum { COUNT = 77 };
    uint32_t seed = 1;
    uint64_t overflows = 0, denormals = 0, infinite = 0, nans = 0;
    for (int round = 0; round < 20000; round++) {
        float values[COUNT];
        uint16_t out[COUNT];
        struct weft_half_losses losses = {0}, wanted = {0};
        const size_t count = (size_t)round % (COUNT + 1);
        for (size_t i = 0; i < count; i++) {
            seed = seed * 1664525u + 1013904223u;
            const uint32_t kind = seed >> 28, any = seed >> 8 & 255;
            const uint32_t exponent = kind == 0 ? 255 : kind == 1 ? any : 95 + any % 52;
            seed = seed * 1664525u + 1013904223u;
            const uint32_t bits = (seed & 0x80000000) | exponent << 23 |
                                  (seed & (UINT32_C(0x7fffff) << seed % 24) & 0x7fffff);
            memcpy(&values[i], &bits, sizeof bits);
        }
        weft_half_from_floats(values, count, out, &losses);
        for (size_t i = 0; i < count; i++) {
            const uint16_t half = weft_half_from_float(values[i]);
            const double stored = value_of(half);
            assert_int_equal(out[i], half);
            nans += isnan(stored) != 0;
            infinite += isinf(values[i]) != 0;
            denormals += (half & 0x7fff) > 0 && (half & 0x7fff) < 0x400;
            if (isfinite(stored))
                wanted.rounding = fmax(wanted.rounding, fabs(stored - (double)values[i]));
            else
                wanted.overflows += isfinite(values[i]) != 0;
        }
        overflows += losses.overflows;
        assert_int_equal(losses.overflows, wanted.overflows);
        assert_true(losses.rounding == wanted.rounding);
    }
    assert_true(overflows > 1000 && denormals > 1000 && infinite > 100 && nans > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_half),
        cmocka_unit_test(test_lines_of_halves),
        cmocka_unit_test(test_between_halves),
        cmocka_unit_test(test_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
