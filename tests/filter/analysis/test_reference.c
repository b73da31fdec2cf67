// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "tests/support/common.h"
#include "filter/check.h"
#include "filter/analysis/reference.h"

static const double positions[][3] = {
    {0.0, 0.0, 0.0},     {0.5, 0.25, 0.75},         {-0.3, 0.9999, 12.0},
    {-7.125, 3.5, -0.5}, {1000.1, -2000.2, 3000.3},
};

static double constant(void *priv, const int64_t index[3])
{
    (void)index;
    return *(const double *)priv;
}

static double sum_of_powers(void *priv, const int64_t index[3])
{
    const int power = *(const int *)priv;
    return pow((double)index[0], power) + 2.0 * pow((double)index[1], power) +
           3.0 * pow((double)index[2], power);
}

static double plane_sum(void *priv, const int64_t index[3])
{
    (void)priv;
    return 1.0 + (double)index[0] * (double)index[1] * (double)index[2];
}

static void test_constant(void **state)
{
    double value = -3.25;
    int checked = 0;
    (void)state;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_create(NULL, weft_kernel_list[i], NULL, &kernel), WEFT_OK);
        if (!kernel.info->unit_sum)
            continue;
        for (int dims = 1; dims <= 3; dims++) {
            for (size_t p = 0; p < WEFT_COUNT(positions); p++) {
                const struct weft_reference_value v =
                    weft_reference_compute(&kernel, dims, positions[p], constant, &value);
                assert_near(v.value, value, 1e-14, kernel.info->name);
                assert_near(v.magnitude, 3.25, 0.0, kernel.info->name);
                checked++;
            }
        }
    }
    assert_true(checked >= 10 * 3 * (int)WEFT_COUNT(positions));
}

// A kernel of order N reproduces powers below N, in every dimension on its own.
static void test_polynomials(void **state)
{
    int checked = 0; // beyond constants
    (void)state;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_create(NULL, weft_kernel_list[i], NULL, &kernel), WEFT_OK);
        if (!kernel.info->unit_sum)
            continue;
        for (int power = 0; power < kernel.order; power++) {
            for (int dims = 1; dims <= 3; dims++) {
                for (size_t p = 0; p < WEFT_COUNT(positions); p++) {
                    const double *x = positions[p];
                    const double y = dims > 1 ? x[1] : 0.0, z = dims > 2 ? x[2] : 0.0;
                    const double expected =
                        pow(x[0], power) + 2.0 * pow(y, power) + 3.0 * pow(z, power);
                    const struct weft_reference_value v =
                        weft_reference_compute(&kernel, dims, x, sum_of_powers, &power);
                    assert_near(v.value, expected, 2e-15 * (1.0 + v.magnitude), kernel.info->name);
                    checked += power > 0;
                }
            }
        }
    }
    assert_true(checked >= 10 * 3 * (int)WEFT_COUNT(positions));
}

static void test_trilinear(void **state)
{
    const struct weft_kernel kernel = kernel_named("linear");
    (void)state;
    const struct weft_reference_value v =
        weft_reference_compute(&kernel, 3, (double[]){1.5, -2.25, 3.75}, plane_sum, NULL);
    assert_near(v.value, 1.0 - 1.5 * 2.25 * 3.75, 1e-14, "value");
    // Corners (1..2, -3..-2, 3..4): the largest is 1 + 2 * -3 * 4.
    assert_near(v.magnitude, 23.0, 0.0, "magnitude");
}

struct impulse {
    int64_t at[3];
};

static double impulse(void *priv, const int64_t index[3])
{
    const struct impulse *p = priv;
    return index[0] == p->at[0] && index[1] == p->at[1] && index[2] == p->at[2] ? 1.0 : 0.0;
}

// The reconstruction of an impulse is the kernel, as a product over the dimensions.
static void test_impulse(void **state)
{
    const struct weft_kernel kernel = kernel_named("mitchell");
    (void)state;
    for (int dims = 1; dims <= 3; dims++) {
        for (double t = -2.5; t < 2.5; t += 0.15625) {
            struct impulse at = {{5, dims > 1 ? -6 : 0, dims > 2 ? 7 : 0}};
            const double x[3] = {5.0 + t, -6.0 + 0.5 * t, 7.0 - 0.75 * t};
            double expected = 1.0;
            for (int d = 0; d < dims; d++)
                expected *= weft_kernel_weight(&kernel, x[d] - (double)at.at[d]);
            const struct weft_reference_value v =
                weft_reference_compute(&kernel, dims, x, impulse, &at);
            assert_near(v.value, expected, 1e-16, "impulse");
        }
    }
}

static double cancelling(void *priv, const int64_t index[3])
{
    static const double f[4] = {0x1p60, 1.0, 3.0, 0x1p60};
    (void)priv;
    return (index[0] & 1 ? -1.0 : 1.0) * f[(index[0] + 1) & 3];
}

// -1/16 * -2^60 + 9/16 * 1 - 9/16 * 3 - 1/16 * 2^60: a plain sum loses the middle.
static void test_compensated(void **state)
{
    const struct weft_kernel kernel = kernel_named("catmull-rom");
    (void)state;
    const struct weft_reference_value v =
        weft_reference_compute(&kernel, 1, (double[]){0.5}, cancelling, NULL);
    assert_near(v.value, -9.0 / 8.0, 0.0, "sum");
    assert_near(v.magnitude, 0x1p60, 0.0, "magnitude");
}

static void test_special_values(void **state)
{
    const struct weft_kernel kernel = kernel_named("bspline");
    double value = INFINITY;
    (void)state;
    const double x[3] = {0.25, 0.25, 0.25};
    assert_true(weft_reference_compute(&kernel, 3, x, constant, &value).value == INFINITY);
    value = NAN;
    assert_true(isnan(weft_reference_compute(&kernel, 3, x, constant, &value).value));
    value = 1.0;
    assert_true(isnan(weft_reference_compute(&kernel, 0, x, constant, &value).value));
    assert_true(isnan(weft_reference_compute(&kernel, 4, x, constant, &value).value));
}

// What `at` holds, 1e30 but for the one sample.
struct lone {
    int64_t at[3];
    double value, others;
};

static double lone(void *priv, const int64_t index[3])
{
    const struct lone *l = priv;
    const bool here = index[0] == l->at[0] && index[1] == l->at[1] && index[2] == l->at[2];
    return here ? l->value : l->others;
}

// A tap whose weight is 0 does not count, whatever it holds.
static void test_zero_weights(void **state)
{
    const double others[] = {NAN, INFINITY, -INFINITY, 1e30};
    int checked = 0;
    (void)state;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_create(NULL, weft_kernel_list[i], NULL, &kernel), WEFT_OK);
        for (size_t o = 0; kernel.interpolating && o < WEFT_COUNT(others); o++) {
            struct lone l = {{3, -5, 7}, 0.1, others[o]};
            const double at[3] = {3.0, -5.0, 7.0}, between[3] = {3.0, -5.0, 7.0 + 0x1p-30};
            const struct weft_reference_value v = weft_reference_compute(&kernel, 3, at, lone, &l);
            assert_near(v.value, 0.1, 0.0, kernel.info->name);
            assert_near(v.magnitude, kernel.width > 1 && isfinite(others[o]) ? 1e30 : 0.1, 0.0,
                        kernel.info->name);
            // A position a little off has weights beside the sample.
            if (kernel.width > 1 && !isfinite(others[o]))
                assert_false(isfinite(weft_reference_compute(&kernel, 3, between, lone, &l).value));
            checked++;
        }
    }
    assert_true(checked >= 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constant),     cmocka_unit_test(test_polynomials),
        cmocka_unit_test(test_trilinear),    cmocka_unit_test(test_impulse),
        cmocka_unit_test(test_compensated),  cmocka_unit_test(test_special_values),
        cmocka_unit_test(test_zero_weights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
