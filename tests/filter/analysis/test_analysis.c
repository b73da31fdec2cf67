// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "tests/support/common.h"
#include "filter/analysis/analysis.h"
#include "filter/check.h"

// Moeller et al. (1997): a_n(t), from the closed forms.
static void test_taylor(void **state)
{
    static const struct {
        const char *kernel;
        int n;
        double t, value;
    } cases[] = {
        {"nearest", 1, 0.25, -0.25},        {"linear", 2, 0.5, 1.0 / 8},
        {"bspline", 2, 0.0, 1.0 / 6},       {"bspline", 2, 0.37, 1.0 / 6},
        {"bspline", 3, 0.25, 0.0},          {"bspline", 4, 0.5, 13.0 / 1152},
        {"mitchell", 2, 0.0, 1.0 / 18},     {"mitchell", 2, 0.61, 1.0 / 18},
        {"mitchell", 3, 0.25, 1.0 / 96},    {"catmull-rom", 2, 0.3, 0.0},
        {"catmull-rom", 3, 0.25, 1.0 / 64}, {"catmull-rom", 4, 0.5, -3.0 / 128},
        {"notch", 2, 0.2, 1.0 / 4},         {"cardinal", 1, 0.25, 3.0 / 64},
        {"d-linear", 1, 0.3, 1.0},          {"dd-bspline", 2, 0.3, 1.0},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        assert_near(weft_analysis_taylor(&kernel, cases[i].n, cases[i].t), cases[i].value, 1e-15,
                    cases[i].kernel);
        assert_near(weft_analysis_taylor(&kernel, cases[i].n, cases[i].t - 5.0), cases[i].value,
                    1e-14, cases[i].kernel);
    }
}

// Moments of the B-spline of degree n: variance (n + 1) / 12.
static void test_moments(void **state)
{
    static const struct {
        const char *kernel;
        int n;
        double value;
    } cases[] = {
        {"nearest", 0, 1},          {"nearest", 2, 1.0 / 12},
        {"nearest", 4, 1.0 / 80},   {"linear", 2, 1.0 / 6},
        {"linear", 4, 1.0 / 15},    {"bspline", 1, 0},
        {"bspline", 2, 1.0 / 3},    {"bspline", 4, 3.0 / 10},
        {"bspline7", 2, 2.0 / 3},   {"catmull-rom", 2, 0},
        {"mitchell", 2, 1.0 / 9},   {"omoms", 2, 1.0 / 3 + 1.0 / 21},
        {"d-bspline", 1, -1},       {"dd-bspline", 2, 2},
        {"gaussian:2.3,0.4", 0, 1}, {"rect-sinc:1", 0, 1.1789797444721675},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        assert_near(weft_analysis_moment(&kernel, cases[i].n), cases[i].value, 1e-13,
                    cases[i].kernel);
    }
}

// What the records say is what is observed.
static void test_orders(void **state)
{
    (void)state;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        const struct weft_kernel_info *info = weft_kernel_list[i];
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_create(NULL, info, NULL, &kernel), WEFT_OK);
        const struct weft_analysis_order order = weft_analysis_order(&kernel);
        if (order.order != kernel.order)
            fail_msg("%s: order %d, the record says %d", info->name, order.order, kernel.order);
        if (!info->primitive && order.prefiltered != kernel.order_prefiltered)
            fail_msg("%s: prefiltered order %d, the record says %d", info->name, order.prefiltered,
                     kernel.order_prefiltered);
        assert_true(order.constant > 0.0 && order.largest >= order.constant - 1e-12);
    }
}

// Thevenaz, Blu and Unser (2000), from the formulas; and the root mean squares of t (1 - t) / 2, of
// the box's t and of the Catmull-Rom spline's t (1 - t) (1 - 2t) / 6.
static void test_constants(void **state)
{
    static const struct {
        const char *kernel;
        double constant, prefiltered, tolerance;
    } cases[] = {
        {"linear", 0.091287092917527686, 0.037267799624996495, 1e-15},
        {"nearest", 0.28867513459481287, 0.28867513459481287, 1e-15},
        {"bspline", 1.0 / 6, 9.0924e-4, 0.5e-8},
        {"omoms", 1.0 / 6 + 1.0 / 42, 1.9841e-4, 0.5e-8},
        {"catmull-rom", 0.011501092655705903, 0.011501092655705903, 1e-14},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        const struct weft_analysis_order order = weft_analysis_order(&kernel);
        assert_near(order.constant, cases[i].constant, 1e-13, cases[i].kernel);
        assert_near(order.prefiltered_constant, cases[i].prefiltered, cases[i].tolerance,
                    cases[i].kernel);
    }
    const struct weft_kernel bspline = kernel_named("bspline"), omoms = kernel_named("omoms");
    assert_near(weft_analysis_order(&bspline).prefiltered_constant /
                    weft_analysis_order(&omoms).prefiltered_constant,
                4.58, 0.005, "ratio");
}

static double sinc(double x)
{
    return x == 0.0 ? 1.0 : sin(M_PI * x) / (M_PI * x);
}

// A B-spline of degree n has the response sinc^(n + 1); a derivative multiplies by 2 pi i f.
static void test_response(void **state)
{
    static const double frequencies[] = {0.0, 0.1, 0.25, 0.5, -0.5, 0.77, 1.5, 4.25, 20.2};
    static const char *const names[] = {"bspline0", "bspline1", "bspline2", "bspline3",
                                        "bspline4", "bspline5", "bspline6", "bspline7"};
    (void)state;
    for (int n = 0; n < 8; n++) {
        const struct weft_kernel kernel = kernel_named(names[n]);
        for (size_t i = 0; i < WEFT_COUNT(frequencies); i++) {
            const struct weft_analysis_response h = weft_analysis_response(&kernel, frequencies[i]);
            assert_near(h.re, pow(sinc(frequencies[i]), n + 1), 1e-14, names[n]);
            assert_near(h.im, 0.0, 1e-14, names[n]);
        }
    }
    const struct weft_kernel slope = kernel_named("d-bspline");
    const struct weft_analysis_response h = weft_analysis_response(&slope, 0.3);
    assert_near(h.re, 0.0, 1e-14, "d-bspline");
    assert_near(h.im, 0.6 * M_PI * pow(sinc(0.3), 4), 1e-14, "d-bspline");
}

// Marschner and Lobb (1994) plot these; the digits come from an independent calculation.
static void test_metrics(void **state)
{
    static const struct {
        const char *kernel;
        double s1, p1, s3, p3;
    } cases[] = {
        {"nearest", .226305, .226305, .536863, .536863},
        {"linear", .366784, .033451, .746104, .042401},
        {"bspline", .523540, .002905, .891837, .001991},
        {"mitchell", .340448, .021929, .713088, .029580},
        {"catmull-rom", .223952, .038238, .532624, .072546},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        const struct weft_analysis_metrics one = weft_analysis_metrics(&kernel, 1);
        const struct weft_analysis_metrics three = weft_analysis_metrics(&kernel, 3);
        assert_near(one.smoothing, cases[i].s1, 0.51e-6, cases[i].kernel);
        assert_near(one.postaliasing, cases[i].p1, 0.51e-6, cases[i].kernel);
        assert_near(three.smoothing, cases[i].s3, 0.51e-6, cases[i].kernel);
        assert_near(three.postaliasing, cases[i].p3, 0.51e-6, cases[i].kernel);
    }
}

// The better the window, the closer to the ideal: wide sincs leave little to smooth or to alias.
static void test_wide_sinc(void **state)
{
    const struct weft_kernel kernel = kernel_named("kaiser-sinc:8,4");
    (void)state;
    const struct weft_analysis_metrics m = weft_analysis_metrics(&kernel, 1);
    assert_true(m.smoothing > 0.0 && m.smoothing < 0.06);
    assert_true(m.postaliasing > 0.0 && m.postaliasing < 0.02);
}

static void test_overshoot(void **state)
{
    static const struct {
        const char *kernel;
        double overshoot, gain;
    } cases[] = {
        {"nearest", 0, 1},
        {"linear", 0, 1},
        {"bspline", 0, 1},
        {"catmull-rom", 2.0 / 27, 5.0 / 4}, // the largest of s^2 (1 - s) / 2; at 1/2
        {"cardinal:1", 4.0 / 27, 3.0 / 2},
        {"lagrange3", 0.064150029909958409, 5.0 / 4}, // the largest of (s - s^3) / 6
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        const struct weft_analysis_overshoot o = weft_analysis_overshoot(&kernel);
        assert_near(o.above, cases[i].overshoot, 1e-13, cases[i].kernel);
        assert_near(o.below, cases[i].overshoot, 1e-13, cases[i].kernel);
        assert_near(weft_analysis_gain(&kernel), cases[i].gain, 1e-13, cases[i].kernel);
    }
}

// Largest sums of |h'|, by hand: of the tent 1 + 1 everywhere, of the splines and of Catmull-Rom
// half way between two samples (of degree 2 on one).
static void test_slope(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        double slope;
    } cases[] = {{"nearest", 0.0},
                 {"linear", 2.0},
                 {"bspline2", 2.0},
                 {"bspline3", 1.5},
                 {"catmull-rom", 3.0}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        const double slope = weft_analysis_slope(&kernel);
        assert_true(slope <= cases[i].slope + 1e-12);
        assert_near(slope, cases[i].slope, 1e-2, cases[i].kernel);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_taylor),    cmocka_unit_test(test_moments),
        cmocka_unit_test(test_orders),    cmocka_unit_test(test_constants),
        cmocka_unit_test(test_response),  cmocka_unit_test(test_metrics),
        cmocka_unit_test(test_wide_sinc), cmocka_unit_test(test_overshoot),
        cmocka_unit_test(test_slope),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
