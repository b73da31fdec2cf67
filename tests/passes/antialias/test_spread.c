// SPDX-License-Identifier: BSD-3-Clause
// What samples count in the pixels around them: against the kernels themselves, sums, integers.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "passes/antialias/pattern/pattern.h"

typedef const double (*points_of)[2];

static const double four[4][2] = {
    {-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}};

static struct weft_spread spread_of(points_of position, int count, const char *kernel, double width,
                                    int bits)
{
    struct weft_spread_params params = {.position = position,
                                        .count = count,
                                        .filter_width = width,
                                        .bits = bits,
                                        .log = &log_to_stderr};
    struct weft_spread spread;
    if (kernel)
        params.filter = kernel_named(kernel);
    assert_int_equal(weft_spread_create(&params, &spread), WEFT_OK);
    return spread;
}

static size_t entries(const struct weft_spread *s)
{
    const size_t side = 2 * (size_t)s->radius + 1;
    return side * side * (size_t)s->count;
}

// Weights are the kernel's at each pixel's distance over their sum, negative ones too.
static void check_weights(const struct weft_spread *s, points_of position, const char *name,
                          double width)
{
    const struct weft_kernel kernel = kernel_named(name);
    const double scale = width > 0.0 ? width / (2.0 * kernel.support) : 1.0;
    double sum = 0.0, expected = 0.0, negative = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        const double *weight = s->weight;
        for (int y = -s->radius; y <= s->radius; y++)
            for (int x = -s->radius; x <= s->radius; x++)
                for (int i = 0; i < s->count; i++, weight++) {
                    const double h = weft_kernel_weight(&kernel, (x - position[i][0]) / scale) *
                                     weft_kernel_weight(&kernel, (y - position[i][1]) / scale);
                    if (pass == 0) {
                        expected += h;
                        sum += *weight;
                        negative += *weight < 0.0 ? -*weight : 0.0;
                    } else {
                        assert_near(*weight, h / expected, 1e-14, name);
                    }
                }
    }
    assert_near(sum, 1.0, 1e-13, name);
    assert_near(s->negative, negative, 1e-13, name);
    // Nothing lies further out.
    for (int i = 0; i < s->count; i++)
        for (int axis = 0; axis < 2; axis++)
            for (int sign = -1; sign <= 1; sign += 2)
                assert_true(weft_kernel_weight(
                                &kernel, (sign * (s->radius + 1) - position[i][axis]) / scale) ==
                            0.0);
}

// Integers of sum 2^bits, each less than 1 from its share.
static void check_integers(const struct weft_spread *s, int bits)
{
    int64_t total = 0;
    double error = 0.0;
    for (size_t i = 0; i < entries(s); i++) {
        total += s->integer[i];
        // A share that is whole but for rounding may come out a unit of 2^-20 further off.
        assert_near(s->integer[i], s->weight[i] * (double)s->total, 1.0 + 0x1p-19, "integer");
        error += fabs((double)s->integer[i] / (double)s->total - s->weight[i]);
    }
    assert_int_equal(total, s->total);
    assert_int_equal(total, INT64_C(1) << bits);
    assert_near(s->error, error, 1e-15, "error");
}

static void test_kernels(void **state)
{
    static const struct {
        const char *name;
        double width;
        int radius;
        bool negative;
    } kernels[] = {
        {"linear", 0.0, 1, false},    {"mitchell", 0.0, 2, true},  {"catmull-rom", 0.0, 2, true},
        {"lanczos:3", 0.0, 3, true},  {"bspline3", 0.0, 2, false}, {"mitchell", 2.5, 1, true},
        {"gaussian", 0.0, -1, false}, {"lanczos:2", 8.0, 4, true},
    };
    struct weft_pattern pattern;
    (void)state;
    assert_int_equal(weft_pattern_create(weft_pattern_params(.device = four, .device_count = 4,
                                                             .count = 16, .log = &log_to_stderr),
                                         &pattern),
                     WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(kernels); i++)
        for (int several = 0; several < 2; several++) {
            const points_of position = several ? (points_of)pattern.position : four;
            for (int bits = 8; bits <= 30; bits += 11) {
                struct weft_spread s =
                    spread_of(position, several ? 16 : 4, kernels[i].name, kernels[i].width, bits);
                if (kernels[i].radius >= 0)
                    assert_int_equal(s.radius, kernels[i].radius);
                assert_int_equal(s.negative > 0.0, kernels[i].negative);
                check_weights(&s, position, kernels[i].name, kernels[i].width);
                check_integers(&s, bits);
                weft_spread_clear(&s);
                assert_null(s.weight);
            }
        }
}

// Every pixel gets as much, wherever the samples are: a constant picture stays what it is. Linear,
// at the middle alone, is nobody else's.
static void test_single(void **state)
{
    static const double middle[1][2] = {{0.0, 0.0}};
    (void)state;
    struct weft_spread s = spread_of(middle, 1, "linear", 0.0, 20);
    assert_int_equal(s.radius, 0);
    assert_int_equal(s.integer[0], 1);
    assert_int_equal(s.total, 1);
    weft_spread_clear(&s);
    // Of cubic B-splines 4/6 and 1/6, products of them, exactly.
    s = spread_of(middle, 1, "bspline3", 0.0, 0);
    assert_int_equal(s.radius, 1);
    static const double axis[3] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
    for (int y = 0; y < 3; y++)
        for (int x = 0; x < 3; x++)
            assert_near(s.weight[3 * y + x], axis[x] * axis[y], 1e-15, "B-spline");
    assert_null(s.integer);
    weft_spread_clear(&s);
}

// A box counts each sample once, in its own pixel, those on the lower rim too; wider boxes in as
// many pixels as they are wide.
static void test_boxes(void **state)
{
    static const double rim[4][2] = {{-0.5, -0.5}, {0.0, -0.5}, {0.25, 0.25}, {-0.25, 0.0}};
    (void)state;
    struct weft_spread s = spread_of(rim, 4, NULL, 0.0, 16);
    assert_int_equal(s.radius, 0);
    assert_int_equal(s.total, 4);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(s.integer[i], 1);
        assert_true(s.weight[i] == 0.25);
    }
    assert_true(s.error == 0.0 && s.negative == 0.0);
    weft_spread_clear(&s);
    for (int width = 2; width <= 5; width++) {
        s = spread_of(rim, 4, "nearest", width, 16);
        int total = 0, each[4] = {0};
        for (size_t i = 0; i < entries(&s); i++) {
            assert_true(s.integer[i] == 0 || s.integer[i] == 1);
            total += s.integer[i];
            each[i % 4] += s.integer[i];
        }
        assert_int_equal(total, s.total);
        for (int i = 0; i < 4; i++)
            assert_int_equal(each[i], width * width);
        weft_spread_clear(&s);
    }
}

static void test_errors(void **state)
{
    static const double outside[1][2] = {{0.0, -0.75}}, nowhere[1][2] = {{(double)INFINITY, 0.0}};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    const struct {
        points_of position;
        int count;
        const char *kernel;
        double width;
        int bits;
        enum weft_result result;
        const char *text;
    } bad[] = {
        {NULL, 4, "linear", 0.0, 0, WEFT_ERR_ARGUMENT, "params->position"},
        {four, 0, "linear", 0.0, 0, WEFT_ERR_ARGUMENT, "weights of 0 samples"},
        {four, 257, "linear", 0.0, 0, WEFT_ERR_ARGUMENT, "weights of 257 samples"},
        {four, 4, "linear", 0.0, 31, WEFT_ERR_ARGUMENT, "with 31 bits"},
        {four, 4, "linear", 0.0, -1, WEFT_ERR_ARGUMENT, "with -1 bits"},
        {four, 4, "linear", 1e-9, 0, WEFT_ERR_ARGUMENT, "1e-09 pixels wide"},
        {four, 4, "linear", 0x1p-20, 0, WEFT_ERR_ARGUMENT, "add up to 0"},
        {four, 4, "d-catmull-rom", 0.0, 0, WEFT_ERR_ARGUMENT, "derivative"},
        {four, 4, "linear", 18.0, 0, WEFT_ERR_LIMIT, "reaches further than 8 pixels"},
        {four, 4, "mitchell+radial", 0.0, 0, WEFT_ERR_UNSUPPORTED, "radial"},
        {four, 4, "bspline3i", 0.0, 0, WEFT_ERR_UNSUPPORTED, "prefiltered"},
        {outside, 1, "linear", 0.0, 0, WEFT_ERR_ARGUMENT, "(0, -0.75) is not in its pixel"},
        {nowhere, 1, "linear", 0.0, 0, WEFT_ERR_ARGUMENT, "inf"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        struct weft_spread s, none;
        memset(&none, 0, sizeof none);
        memset(&s, 1, sizeof s);
        assert_int_equal(
            weft_spread_create(
                weft_spread_params(.position = bad[i].position, .count = bad[i].count,
                                   .filter = kernel_named(bad[i].kernel),
                                   .filter_width = bad[i].width, .bits = bad[i].bits, .log = &log),
                &s),
            bad[i].result);
        if (!strstr(message.text, bad[i].text))
            fail_msg("'%s' does not tell of '%s'", message.text, bad[i].text);
        assert_memory_equal(&s, &none, sizeof s);
    }
    weft_spread_clear(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kernels),
        cmocka_unit_test(test_single),
        cmocka_unit_test(test_boxes),
        cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
