// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_half),
        cmocka_unit_test(test_between_halves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
