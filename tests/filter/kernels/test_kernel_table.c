// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "tests/support/common.h"
#include "filter/check.h"
#include "filter/kernels/kernel_table.h"

static const double tent[] = {1.0, 0.5, 0.0}, whole_tent[] = {0.0, 0.5, 1.0, 0.5, 0.0};

static struct weft_kernel created(const struct weft_kernel_table_params *params,
                                  struct weft_kernel_table *table)
{
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_table_init(params, table), WEFT_OK);
    assert_int_equal(weft_kernel_create(NULL, &table->info, NULL, &kernel), WEFT_OK);
    return kernel;
}

// Straight lines between samples of a straight line: linear interpolation, derivatives included.
static void test_tent(void **state)
{
    const struct weft_kernel_table_params params[] = {
        {.samples = tent, .count = 3, .support = 1.0},
        {.samples = whole_tent, .count = 5, .support = 1.0, .whole = true},
    };
    struct weft_kernel linear;
    (void)state;
    assert_int_equal(weft_kernel_parse(NULL, "linear", &linear), WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(params); i++) {
        struct weft_kernel_table table;
        const struct weft_kernel kernel = created(&params[i], &table);
        assert_int_equal(kernel.width, 2);
        assert_true(kernel.interpolating);
        assert_int_equal(kernel.continuity, 0);
        assert_int_equal(kernel.info->degree, -1);
        for (double x = -1.5; x < 1.5; x += 0.0625) {
            assert_near(weft_kernel_weight(&kernel, x), weft_kernel_weight(&linear, x), 1e-15, "h");
            assert_near(weft_kernel_derivative(&kernel, x), weft_kernel_derivative(&linear, x),
                        1e-15, "h'");
        }
    }
}

// A sampled smooth kernel comes back: cubics err by the fourth power of the spacing.
static void test_sampled_kernel(void **state)
{
    enum { COUNT = 257 };
    double half[COUNT], whole[2 * COUNT - 1];
    struct weft_kernel bspline;
    (void)state;
    assert_int_equal(weft_kernel_parse(NULL, "bspline5", &bspline), WEFT_OK);
    for (int i = 0; i < COUNT; i++)
        half[i] = weft_kernel_weight(&bspline, 3.0 * i / (COUNT - 1));
    for (int i = 0; i < 2 * COUNT - 1; i++)
        whole[i] = weft_kernel_weight(&bspline, 3.0 * (i - COUNT + 1) / (COUNT - 1));
    for (int mode = 0; mode < 4; mode++) {
        const struct weft_kernel_table_params params = {
            .samples = mode & 1 ? whole : half,
            .count = mode & 1 ? 2 * COUNT - 1 : COUNT,
            .support = 3.0,
            .whole = mode & 1,
            .between = mode & 2 ? WEFT_KERNEL_BETWEEN_CUBIC : WEFT_KERNEL_BETWEEN_LINEAR,
        };
        struct weft_kernel_table table;
        const struct weft_kernel kernel = created(&params, &table);
        assert_int_equal(kernel.interpolating, false);
        for (double x = -3.0; x < 3.0; x += 0.01) {
            assert_near(weft_kernel_weight(&kernel, x), weft_kernel_weight(&bspline, x),
                        mode & 2 ? 1e-7 : 2e-5, "h");
            const double t = fmod(x + 3.0, 3.0 / (COUNT - 1)); // off the corners of linear pieces
            if (mode & 2 || (t > 1e-4 && t < 3.0 / (COUNT - 1) - 1e-4))
                assert_near(weft_kernel_derivative(&kernel, x), weft_kernel_derivative(&bspline, x),
                            mode & 2 ? 1e-4 : 6e-3, "h'");
        }
    }
}

static void test_cubic_derivative(void **state)
{
    static const double samples[] = {-0.1, 0.3, 0.9, 0.2, 0.4, -0.2};
    const struct weft_kernel_table_params params = {.samples = samples,
                                                    .count = 6,
                                                    .support = 2.0,
                                                    .whole = true,
                                                    .between = WEFT_KERNEL_BETWEEN_CUBIC};
    struct weft_kernel_table table;
    const struct weft_kernel kernel = created(&params, &table);
    (void)state;
    assert_int_equal(kernel.continuity, -1);
    for (int i = 0; i < 6; i++)
        assert_near(weft_kernel_weight(&kernel, i == 5 ? nextafter(2.0, 0.0) : -2.0 + 0.8 * i),
                    samples[i], 1e-14, "sample");
    for (double x = -1.99; x < 1.99; x += 0.013)
        assert_near(
            weft_kernel_derivative(&kernel, x),
            (weft_kernel_weight(&kernel, x + 1e-6) - weft_kernel_weight(&kernel, x - 1e-6)) / 2e-6,
            2e-5, "h'");
}

static void test_normalised(void **state)
{
    const struct weft_kernel_table_params params = {
        .samples = (const double[]){0.7, 0.4, 0.1}, .count = 3, .support = 1.3};
    struct weft_kernel_table table;
    struct weft_kernel kernel = created(&params, &table);
    double weights[WEFT_KERNEL_MAX_WIDTH];
    (void)state;
    assert_int_equal(weft_kernel_normalise(NULL, &kernel), WEFT_OK);
    assert_true(kernel.unit_sum);
    for (double x = 0.0; x < 1.0; x += 0.03) {
        double sum = 0.0;
        weft_kernel_weights(&kernel, x, weights);
        for (int j = 0; j < kernel.width; j++)
            sum += weights[j];
        assert_near(sum, 1.0, 1e-15, "sum");
    }
}

static void test_bad_arguments(void **state)
{
    const struct weft_kernel_table_params good = {.samples = tent, .count = 3, .support = 1.0};
    struct weft_kernel_table_params bad[8];
    struct weft_kernel_table table;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        bad[i] = good;
    bad[0].samples = NULL;
    bad[1].count = 1;
    bad[2].support = 0.0;
    bad[3].support = 8.5;
    bad[4].support = NAN;
    bad[5].between = (enum weft_kernel_between)5;
    bad[6].samples = (const double[]){1.0, INFINITY, 0.0};
    bad[7].samples = (const double[]){1.0, 0.5, NAN};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        assert_int_equal(weft_kernel_table_init(&bad[i], &table), WEFT_ERR_ARGUMENT);
        assert_null(table.info.name);
    }
    bad[0] = good;
    bad[0].count = WEFT_KERNEL_TABLE_MAX_SAMPLES + 1;
    assert_int_equal(weft_kernel_table_init(&bad[0], &table), WEFT_ERR_LIMIT);
}

// A kernel of a user's own: a record and a function.
static double tenth_power(const struct weft_kernel *kernel, double x)
{
    const double scale = *(const double *)kernel->info->data;
    return x >= -1.0 && x < 1.0 ? scale * pow(1.0 - x * x, 10.0) : 0.0;
}

static void test_user_kernel(void **state)
{
    static const double scale = 0.5;
    static const struct weft_kernel_info info = {
        .name = "mine", .radius = 1.0, .weight = tenth_power, .data = &scale, .degree = -1};
    struct weft_kernel kernel;
    char text[32];
    (void)state;
    assert_int_equal(weft_kernel_create(NULL, &info, NULL, &kernel), WEFT_OK);
    assert_near(weft_kernel_weight(&kernel, 0.0), 0.5, 0.0, "h");
    assert_true(isnan(weft_kernel_derivative(&kernel, 0.0)));
    assert_int_equal(weft_kernel_normalise(NULL, &kernel), WEFT_OK);
    assert_near(weft_kernel_weight(&kernel, 0.0), 1.0, 0.0, "h");
    weft_kernel_format(&kernel, text, sizeof text);
    assert_string_equal(text, "mine+unit");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tent),
        cmocka_unit_test(test_sampled_kernel),
        cmocka_unit_test(test_cubic_derivative),
        cmocka_unit_test(test_normalised),
        cmocka_unit_test(test_bad_arguments),
        cmocka_unit_test(test_user_kernel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
