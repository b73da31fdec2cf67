// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "filter/check.h"
#include "tests/support/fixed.h"

static void test_quantise(void **state)
{
    static const struct {
        double x;
        int bits;
        int64_t rounded, truncated;
    } cases[] = {
        {0.0, 8, 0, 0},
        {1.0, 8, 255, 255},
        {0.5, 8, 128, 127},
        {0.499 / 255, 8, 0, 0},
        {0.501 / 255, 8, 1, 0},
        {-0.5, 8, -128, -127},
        {-0.999 / 255, 8, -1, 0},
        {1.0625, 8, 271, 270},
        {1.0, 1, 1, 1},
        {0.5, 16, 32768, 32767},
        {1.0, 24, 16777215, 16777215},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        assert_int_equal(fixed_quantise(cases[i].x, cases[i].bits, WEFT_FIXED_ROUND),
                         cases[i].rounded);
        assert_int_equal(fixed_quantise(cases[i].x, cases[i].bits, WEFT_FIXED_TRUNCATE),
                         cases[i].truncated);
    }
    assert_true(fixed_value(51, 8) == 0.2);
}

static void test_clamp(void **state)
{
    (void)state;
    assert_int_equal(fixed_clamp(-1, 8), 0);
    assert_int_equal(fixed_clamp(255, 8), 255);
    assert_int_equal(fixed_clamp(256, 8), 255);
    assert_int_equal(fixed_clamp(70000, 12), 4095);
}

// All pairs of bytes: the definition, the signs, and the largest errors, eq. 7 and 8.
static void test_multiply_bytes(void **state)
{
    double rounded_error = 0.0, truncated_error = 0.0;
    (void)state;
    for (int64_t x = 0; x < 256; x++) {
        for (int64_t y = 0; y < 256; y++) {
            const int64_t rounded = fixed_multiply(x, y, 8, WEFT_FIXED_ROUND);
            const int64_t truncated = fixed_multiply(x, y, 8, WEFT_FIXED_TRUNCATE);
            const double exact = (double)(x * y) / 255.0;
            assert_int_equal(rounded, (int64_t)floor(exact + 0.5));
            assert_int_equal(truncated, (int64_t)floor(exact));
            assert_int_equal(fixed_multiply(-x, y, 8, WEFT_FIXED_ROUND), -rounded);
            assert_int_equal(fixed_multiply(x, -y, 8, WEFT_FIXED_TRUNCATE), -truncated);
            rounded_error = fmax(rounded_error, fabs((double)rounded - exact) / 255.0);
            truncated_error = fmax(truncated_error, fabs((double)truncated - exact) / 255.0);
        }
    }
    assert_true(fabs(rounded_error - 127.0 / 65025) < 1e-15);
    assert_true(fabs(truncated_error - 254.0 / 65025) < 1e-15);
}

static void test_multiply_wide(void **state)
{
    const int64_t one = weft_fixed_one(24);
    (void)state;
    assert_int_equal(fixed_multiply(one, one, 24, WEFT_FIXED_ROUND), one);
    assert_int_equal(fixed_multiply(one, 12345, 24, WEFT_FIXED_TRUNCATE), 12345);
    assert_int_equal(fixed_multiply(one - 1, one - 1, 24, WEFT_FIXED_TRUNCATE), one - 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quantise),
        cmocka_unit_test(test_clamp),
        cmocka_unit_test(test_multiply_bytes),
        cmocka_unit_test(test_multiply_wide),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
