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
#include "filter/kernels/signal.h"

static void test_records(void **state)
{
    static const char *const names[] = {"marschner-lobb", "sphere",   "chirp",
                                        "ramp",           "constant", "impulse"};
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        const struct weft_signal_info *info = weft_signal_find(names[i]);
        assert_non_null(info);
        assert_ptr_equal(info, weft_signal_list[i]);
        assert_string_equal(info->name, names[i]);
        assert_true(strlen(info->description) > 0);
        assert_true(info->default_size >= 40);
        assert_non_null(info->value);
        assert_int_equal(info->level_set, !strcmp(names[i], "sphere"));
        assert_int_equal(info->lattice, !strcmp(names[i], "impulse"));
        assert_true(info->lattice || info->gradient);
    }
    assert_null(weft_signal_list[WEFT_COUNT(names)]);
    assert_null(weft_signal_find("noise"));
    assert_null(weft_signal_find(NULL));
    assert_int_equal(weft_signal_find("marschner-lobb")->default_size, 128);
}

static void test_values(void **state)
{
    static const struct {
        const char *signal;
        double position[3], value;
    } cases[] = {
        {"marschner-lobb", {0, 0, 0}, 0.6},                  // (1 + 0.25 * 2) / 2.5
        {"marschner-lobb", {1, 0, 0}, 0.6},                  // cos(pi/2) = 0: the same
        {"marschner-lobb", {0, 0, 1}, 0.2},                  // (1 - 1 + 0.5) / 2.5
        {"marschner-lobb", {0, 0, -1}, 1.0},                 // (1 + 1 + 0.5) / 2.5
        {"marschner-lobb", {0.9468867572533427, 0, 0}, 0.4}, // cos(pi r/2) = 1/12: half a turn
        {"marschner-lobb", {0, 0.9734664948525692, 0}, 0.5}, // 1/24: a quarter
        {"sphere", {0, 0, 0}, -0.75},
        {"sphere", {0.75, 0, 0}, 0.0},
        {"sphere", {2.0 / 3, -1.0 / 3, 2.0 / 3}, 0.25},
        {"chirp", {0, 0, 0}, 1.0},
        {"chirp", {0, 1, 0}, 1.0},         // 32 pi
        {"chirp", {0, 0, 0.125}, 0.5},     // pi / 2
        {"chirp", {0.125, 0.125, 0}, 0.0}, // pi
        {"ramp", {0, 0, 0}, 0.5},
        {"ramp", {-1, -1, -1}, 0.0},
        {"ramp", {1, 1, 1}, 1.0},
        {"ramp", {1, 0, -1}, 1.0 / 3},
        {"constant", {0.3, -0.7, 0.1}, 1.0},
        {"impulse", {1.0 / 64, 1.0 / 64, 1.0 / 64}, 1.0},
        {"impulse", {1.0 / 64, 3.0 / 64, 1.0 / 64}, 0.0},
        {"impulse", {-1.0 / 64, 1.0 / 64, 1.0 / 64}, 0.0},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        assert_near(weft_signal_find(cases[i].signal)->value(cases[i].position), cases[i].value,
                    2e-14, cases[i].signal);
}

static void test_coordinates(void **state)
{
    (void)state;
    assert_near(weft_signal_coordinate(0, 40), -0.975, 1e-16, "first");
    assert_near(weft_signal_coordinate(39, 40), 0.975, 2e-16, "last");
    assert_near(weft_signal_coordinate(2, 5), 0.0, 1e-16, "middle");
}

// One voxel of the impulse's default lattice is 1: n/2 along each axis.
static void test_impulse_lattice(void **state)
{
    const struct weft_signal_info *info = weft_signal_find("impulse");
    const int64_t n = info->default_size;
    (void)state;
    for (int64_t k = n / 2 - 2; k <= n / 2 + 2; k++)
        for (int64_t j = n / 2 - 2; j <= n / 2 + 2; j++)
            for (int64_t i = n / 2 - 2; i <= n / 2 + 2; i++) {
                const double p[3] = {weft_signal_coordinate(i, n), weft_signal_coordinate(j, n),
                                     weft_signal_coordinate(k, n)};
                const bool middle = i == n / 2 && j == n / 2 && k == n / 2;
                assert_near(info->value(p), middle ? 1.0 : 0.0, 0.0, "impulse");
            }
}

// The fourth-order difference errs by step^4 times a fifth derivative over 30: the chirp's is below
// 1e13 (its rate is 2 * 32 pi * 1.7 at most), so 1e-5^4 * 1e13 / 30 = 3e-9; rounding adds 1e-11.
static void test_gradients(void **state)
{
    const double h = 1e-5;
    (void)state;
    for (size_t s = 0; weft_signal_list[s]; s++) {
        const struct weft_signal_info *info = weft_signal_list[s];
        for (int i = 0; info->gradient && i < 200; i++) {
            const double p[3] = {sin(1.0 + 12.9898 * i), sin(2.0 + 78.233 * i),
                                 sin(3.0 + 37.719 * i)};
            double gradient[3];
            info->gradient(p, gradient);
            for (int d = 0; d < 3; d++) {
                double at[4];
                for (int o = 0; o < 4; o++) {
                    double q[3] = {p[0], p[1], p[2]};
                    q[d] += h * (o < 2 ? o - 2 : o - 1);
                    at[o] = info->value(q);
                }
                const double slope = (8.0 * (at[2] - at[1]) - (at[3] - at[0])) / (12.0 * h);
                assert_near(gradient[d], slope, 2e-8, info->name);
            }
        }
    }
}

static void test_gradients_at_origin(void **state)
{
    static const double origin[3] = {0};
    int checked = 0;
    (void)state;
    for (size_t s = 0; weft_signal_list[s]; s++) {
        double gradient[3] = {NAN, NAN, NAN};
        if (!weft_signal_list[s]->gradient)
            continue;
        weft_signal_list[s]->gradient(origin, gradient);
        for (int d = 0; d < 3; d++)
            assert_true(isfinite(gradient[d]));
        checked++;
    }
    assert_true(checked >= 3);
}

// The chirp turns half a period per voxel at the faces and far less near the centre.
static void test_chirp_sampling(void **state)
{
    const struct weft_signal_info *info = weft_signal_find("chirp");
    const double voxel = 2.0 / info->default_size;
    (void)state;
    double largest = 0.0, central = 0.0, gradient[3];
    for (int i = 0; i <= 4000; i++) {
        const double p[3] = {i / 4000.0, 0.0, 0.0};
        info->gradient(p, gradient);
        // The value swings by 1/2: its slope is at most half the phase's rate.
        const double turns = 2.0 * fabs(gradient[0]) * voxel / (2.0 * M_PI);
        largest = larger(largest, turns);
        central = larger(central, i <= 400 ? turns : 0.0);
    }
    assert_near(largest, 0.5, 0.005, "at the face");
    assert_true(central <= 0.05);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_records),        cmocka_unit_test(test_values),
        cmocka_unit_test(test_coordinates),    cmocka_unit_test(test_impulse_lattice),
        cmocka_unit_test(test_gradients),      cmocka_unit_test(test_gradients_at_origin),
        cmocka_unit_test(test_chirp_sampling),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
