// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/support/common.h"
#include "filter/check.h"
#include "filter/kernels/kernel.h"

enum { POSITIONS = 97 };

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

// The whole catalogue with initial parameters, and parameters that exercise the families.
static const char *const extra_kernels[] = {
    "cubic:1,0",
    "cubic:0,0",
    "cubic:1.5,-0.25",
    "cubic:0,0.75",
    "cubic:-2,3",
    "cubic:0.3,0.1",
    "d-cubic:1,0",
    "dd-cubic:1,0",
    "dd-cubic:0,0.5",
    "cardinal:0.5",
    "cardinal:1",
    "d-cardinal:0.5",
    "lanczos:2",
    "lanczos:8",
    "lanczos:2.3",
    "lanczos:3+unit",
    "hann-sinc:1",
    "hann-sinc:5.5",
    "hamming-sinc:4",
    "hamming-sinc:2.75",
    "blackman-sinc:3",
    "blackman-sinc:3.7+unit",
    "kaiser-sinc:4,8",
    "kaiser-sinc:2.2,0",
    "kaiser-sinc:3,20+unit",
    "gauss-sinc:2,0.7",
    "welch-sinc:8",
    "rect-sinc:4",
    "rect-sinc:4.4",
    "gaussian:3,0.6",
    "gaussian:0.7,0.4+unit",
    "d-lanczos:2.5",
    "dd-blackman-sinc:4",
    "dd-kaiser-sinc:2,5.36",
    "d-gaussian:3,1",
    NULL,
};

// Kernels that a check had something to say about.
static int checked;

static void for_each(void (*check)(const struct weft_kernel *kernel, const char *name))
{
    checked = 0;
    char name[128];
    struct weft_kernel kernel;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        assert_int_equal(weft_kernel_create(NULL, weft_kernel_list[i], NULL, &kernel), WEFT_OK);
        weft_kernel_format(&kernel, name, sizeof name);
        check(&kernel, name);
    }
    for (size_t i = 0; extra_kernels[i]; i++) {
        kernel = kernel_named(extra_kernels[i]);
        check(&kernel, extra_kernels[i]);
    }
    assert_true(checked >= 8);
}

static void check_record(const struct weft_kernel *kernel, const char *name)
{
    const struct weft_kernel_info *info = kernel->info;
    checked++;
    assert_non_null(info->name);
    assert_true(info->description && strlen(info->description) > 0);
    assert_true(info->citation && strlen(info->citation) > 0);
    assert_ptr_equal(weft_kernel_find(info->name), info);
    assert_true(strlen(info->name) < 32 && !strpbrk(info->name, ":,' \t\"$"));
    assert_true(kernel->support > 0.0);
    assert_int_equal(kernel->width, (int)ceil(2.0 * kernel->support));
    assert_true(kernel->width <= WEFT_KERNEL_MAX_WIDTH);
    for (size_t i = 0; i < WEFT_KERNEL_PARAMS && info->params[i].name; i++)
        assert_true(info->params[i].min <= info->params[i].initial &&
                    info->params[i].initial <= info->params[i].max);
    (void)name;
}

static void check_support(const struct weft_kernel *kernel, const char *name)
{
    const double r = kernel->support;
    const double outside[] = {
        r, nextafter(-r, -INFINITY), r + 1e-9, -r - 0.3, 1e9, -1e300, INFINITY, -INFINITY};
    for (size_t i = 0; i < WEFT_COUNT(outside); i++) {
        assert_near(weft_kernel_weight(kernel, outside[i]), 0.0, 0.0, name);
        if (kernel->info->derivative)
            assert_near(weft_kernel_derivative(kernel, outside[i]), 0.0, 0.0, name);
    }
    if (!kernel->info->derivative)
        assert_true(isnan(weft_kernel_derivative(kernel, 0.1)));
    // Continuous kernels come down to 0 at both ends; the box includes its left end.
    if (kernel->continuity < 0 && kernel->width > 1)
        return;
    checked++;
    const double ends = kernel->continuity >= 0 ? 0.0 : weft_kernel_weight(kernel, 0.0);
    assert_near(weft_kernel_weight(kernel, -r), ends, 1e-15, name);
    assert_near(weft_kernel_weight(kernel, nextafter(r, 0.0)), ends, 1e-14, name);
}

// Derivatives of even kernels are odd and even in turn, except where they jump.
static void check_symmetry(const struct weft_kernel *kernel, const char *name)
{
    const double parity = kernel->info->derivation % 2 ? -1.0 : 1.0;
    checked++;
    for (int i = 1; i < POSITIONS; i++) {
        const double x = kernel->support * i / (POSITIONS + 0.5);
        const double h = weft_kernel_weight(kernel, x), d = weft_kernel_derivative(kernel, x);
        if (kernel->info->derivation && 2.0 * x == floor(2.0 * x))
            continue;
        const double tolerance =
            kernel->info->derivation || kernel->normalised ? 1e-14 * (1.0 + fabs(h)) : 0.0;
        assert_near(weft_kernel_weight(kernel, -x), parity * h, tolerance, name);
        if (kernel->info->derivative && 2.0 * x != floor(2.0 * x))
            assert_near(weft_kernel_derivative(kernel, -x), -parity * d, 1e-14 * (1.0 + fabs(d)),
                        name);
    }
}

static void check_integers(const struct weft_kernel *kernel, const char *name)
{
    if (!kernel->interpolating)
        return;
    checked++;
    for (int k = -kernel->width; k <= kernel->width; k++)
        assert_near(weft_kernel_weight(kernel, k), k == 0 ? 1.0 : 0.0, 0.0, name);
}

static double coefficient_scale(const struct weft_kernel *kernel)
{
    return 1.0 + fabs(kernel->param[0]) + fabs(kernel->param[1]);
}

// Also: the weights of a derivative add up to the derivative of that sum, 0.
static void check_unit_sum(const struct weft_kernel *kernel, const char *name)
{
    const struct weft_kernel_info *info = kernel->info;
    const bool zero_sum = info->primitive && info->primitive->unit_sum;
    if (!kernel->unit_sum && !zero_sum)
        return;
    checked++;
    for (int i = 0; i < POSITIONS; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0, slope = 0.0;
        const double x = (double)i / POSITIONS;
        const int64_t first = weft_kernel_weights(kernel, x, weights);
        for (int j = 0; j < kernel->width; j++) {
            sum += weights[j];
            slope += weft_kernel_derivative(kernel, x - (double)(first + j));
            assert_near(weights[j], weft_kernel_weight(kernel, x - (double)(first + j)),
                        2e-15 * coefficient_scale(kernel), name);
        }
        const double tolerance = (zero_sum ? 4e-15 : 4e-16) * kernel->width;
        assert_near(sum, zero_sum ? 0.0 : 1.0, tolerance * coefficient_scale(kernel), name);
        if (info->derivative)
            assert_near(slope, 0.0, 4e-15 * kernel->width * coefficient_scale(kernel), name);
    }
}

// Gauss-Legendre with 4 nodes is exact to degree 7 on each half unit, where every kernel is one
// polynomial.
static void check_integral(const struct weft_kernel *kernel, const char *name)
{
    static const double node[2] = {0.339981043584856264803, 0.861136311594052575224};
    static const double share[2] = {0.652145154862546142627, 0.347854845137453857373};
    double sum = 0.0;
    if (!kernel->info->unit_sum || kernel->info->degree < 0)
        return;
    checked++;
    for (double left = -kernel->support; left < kernel->support; left += 0.5)
        for (int i = 0; i < 2; i++)
            for (int sign = -1; sign <= 1; sign += 2)
                sum += 0.25 * share[i] *
                       weft_kernel_weight(kernel, left + 0.25 + sign * 0.25 * node[i]);
    assert_near(sum, 1.0, 1e-14 * coefficient_scale(kernel), name);
}

// Central differences away from the knots: the error is step^2 / 6 times a third derivative, which
// is below 5000.
static void check_derivative(const struct weft_kernel *kernel, const char *name)
{
    const double step = 1e-5;
    if (!kernel->info->derivative)
        return;
    checked++;
    for (int i = 0; i < 401; i++) {
        const double x = kernel->support * (i - 200.4) / 201.0;
        if (fabs(2.0 * x - round(2.0 * x)) < 1e-3)
            continue;
        const double slope =
            (weft_kernel_weight(kernel, x + step) - weft_kernel_weight(kernel, x - step)) /
            (2.0 * step);
        assert_near(weft_kernel_derivative(kernel, x), slope, 1e-7, name);
    }
}

// Across each half integer and the ends, at least what is promised does not jump.
static void check_continuity(const struct weft_kernel *kernel, const char *name)
{
    checked += kernel->continuity >= 1;
    for (int i = -2 * kernel->width; i <= 2 * kernel->width; i++) {
        const double knot = fmax(-kernel->support, fmin(kernel->support, 0.5 * i));
        const double left = knot - 1e-9, right = knot + 1e-9;
        if (kernel->continuity >= 0)
            assert_near(weft_kernel_weight(kernel, left), weft_kernel_weight(kernel, right), 1e-7,
                        name);
        if (kernel->continuity >= 1)
            assert_near(weft_kernel_derivative(kernel, left), weft_kernel_derivative(kernel, right),
                        1e-6, name);
    }
}

static void check_primitive(const struct weft_kernel *kernel, const char *name)
{
    const struct weft_kernel_info *info = kernel->info;
    struct weft_kernel primitive;
    assert_int_equal(info->derivation > 0, info->primitive != NULL);
    if (!info->primitive)
        return;
    checked++;
    assert_string_equal(info->name + info->derivation + 1, info->primitive->name);
    assert_int_equal(weft_kernel_create(NULL, info->primitive, kernel->param, &primitive), WEFT_OK);
    assert_int_equal(primitive.width, kernel->width);
    for (int i = 0; info->derivation == 1 && i < 401; i++) {
        const double x = kernel->support * (i - 200) / 200.0;
        assert_near(weft_kernel_weight(kernel, x), weft_kernel_derivative(&primitive, x), 0.0,
                    name);
    }
    assert_int_equal(kernel->continuity, primitive.continuity - info->derivation < -1
                                             ? -1
                                             : primitive.continuity - info->derivation);
}

// Of records with a derivative in the catalogue that is the kernel's own derivative at every
// position, for the same parameters.
static void check_derive(const struct weft_kernel *kernel, const char *name)
{
    char slope_name[40];
    struct weft_kernel slope;
    snprintf(slope_name, sizeof slope_name, kernel->info->derivation ? "d%s" : "d-%s",
             kernel->info->name);
    const struct weft_kernel_info *info = weft_kernel_find(slope_name);
    const bool derivable = info && !kernel->normalised;
    assert_int_equal(weft_kernel_derive(&remember_log, kernel, &slope),
                     derivable ? WEFT_OK : WEFT_ERR_ARGUMENT);
    if (!derivable) {
        assert_null(slope.info);
        assert_non_null(strstr(last.text, kernel->info->name));
        return;
    }
    checked++;
    assert_ptr_equal(slope.info, info);
    assert_memory_equal(slope.param, kernel->param, sizeof slope.param);
    assert_int_equal(slope.width, kernel->width);
    assert_near(slope.support, kernel->support, 0.0, name);
    for (int i = 0; i < 401; i++) {
        const double x = kernel->support * (i - 200) / 200.0;
        assert_near(weft_kernel_weight(&slope, x), weft_kernel_derivative(kernel, x), 0.0, name);
    }
}

static double taylor_coefficient(const struct weft_kernel *kernel, int n, double t)
{
    double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
    const int64_t first = weft_kernel_weights(kernel, t, weights);
    for (int j = 0; j < kernel->width; j++)
        sum += pow((double)(first + j) - t, n) * weights[j];
    return sum / tgamma(n + 1.0);
}

static void taylor_range(const struct weft_kernel *kernel, int n, double *min, double *max)
{
    *min = INFINITY;
    *max = -INFINITY;
    for (int i = 0; i < POSITIONS; i++) {
        const double a = taylor_coefficient(kernel, n, (double)i / POSITIONS);
        *min = -larger(-*min, -a);
        *max = larger(*max, a);
    }
}

// Order N of the d-th derivative: a_n is 1 for n = d and else 0 for n < d + N, and not for n = d +
// N.
static void check_order(const struct weft_kernel *kernel, const char *name)
{
    const int derivation = kernel->info->derivation;
    const double tolerance = 2e-14 * coefficient_scale(kernel);
    double min, max, wrong = 0.0;
    checked += kernel->order > 0;
    for (int n = 0; n < derivation + kernel->order; n++) {
        taylor_range(kernel, n, &min, &max);
        assert_near(min, n == derivation, kernel->order ? tolerance : INFINITY, name);
        assert_near(max, n == derivation, kernel->order ? tolerance : INFINITY, name);
    }
    for (int n = kernel->order ? derivation + kernel->order : 0; n <= derivation + kernel->order;
         n++) {
        taylor_range(kernel, n, &min, &max);
        wrong = larger(wrong, larger(fabs(max - (n == derivation)), fabs(min - (n == derivation))));
    }
    if (!(wrong >= 1e-6))
        fail_msg("%s: order is above %d", name, kernel->order);
}

// Order N after a prefilter: a_n does not depend on the position for n < N (Strang and Fix), and
// does for n = N.
static void check_order_prefiltered(const struct weft_kernel *kernel, const char *name)
{
    double min, max;
    if (kernel->order_prefiltered == 0)
        return;
    checked++;
    for (int n = 0; n < kernel->order_prefiltered; n++) {
        taylor_range(kernel, n, &min, &max);
        assert_near(max, min, 1e-13 * coefficient_scale(kernel), name);
    }
    taylor_range(kernel, kernel->order_prefiltered, &min, &max);
    if (!(max - min >= 1e-7))
        fail_msg("%s: prefiltered order is above %d", name, kernel->order_prefiltered);
    assert_true(kernel->order_prefiltered >= kernel->order);
}

#define EACH(check)                                                                                \
    static void test_##check(void **state)                                                         \
    {                                                                                              \
        (void)state;                                                                               \
        for_each(check);                                                                           \
    }
EACH(check_record)
EACH(check_support)
EACH(check_symmetry)
EACH(check_integers)
EACH(check_unit_sum)
EACH(check_integral)
EACH(check_derivative)
EACH(check_continuity)
EACH(check_primitive)
EACH(check_derive)
EACH(check_order)
EACH(check_order_prefiltered)

// By hand, exact to a few units in the last place.
static void test_fractions(void **state)
{
    static const struct {
        const char *kernel;
        double x, weight, derivative;
    } cases[] = {
        {"nearest", -0.5, 1, NAN},
        {"nearest", 0.5, 0, NAN},
        {"linear", 0.25, 0.75, -1},
        {"linear", 0, 1, -1},
        {"linear", -1, 0, 1},
        {"bspline", 0, 2.0 / 3, 0},
        {"bspline", 1, 1.0 / 6, -0.5},
        {"bspline", -0.5, 23.0 / 48, 5.0 / 8},
        {"bspline", 1.5, 1.0 / 48, -1.0 / 8},
        {"catmull-rom", 0.5, 9.0 / 16, -11.0 / 8},
        {"catmull-rom", 1.5, -1.0 / 16, 1.0 / 8},
        {"catmull-rom", -1, 0, 0.5},
        {"mitchell", 0, 8.0 / 9, 0},
        {"mitchell", 1, 1.0 / 18, -0.5},
        {"mitchell", 0.5, 77.0 / 144, -9.0 / 8},
        {"mitchell", -1.5, -5.0 / 144, -1.0 / 24},
        {"cubic:1.5,-0.25", 0.5, 7.0 / 16, -1.0 / 4},
        {"cubic:0,0.75", 1.5, -3.0 / 32, 3.0 / 16},
        {"bspline2", 0, 3.0 / 4, 0},
        {"bspline2", 0.5, 0.5, -1},
        {"bspline2", -1, 1.0 / 8, 0.5},
        {"bspline4", 0, 115.0 / 192, 0},
        {"bspline4", 1, 19.0 / 96, -11.0 / 24},
        {"bspline4", 2, 1.0 / 384, -1.0 / 48},
        {"bspline5", 0, 11.0 / 20, 0},
        {"bspline5", 1, 13.0 / 60, -5.0 / 12},
        {"bspline5", 2, 1.0 / 120, -1.0 / 24},
        {"bspline6", 0, 5887.0 / 11520, 0},
        {"bspline6", 3, 1.0 / 46080, -1.0 / 3840},
        {"bspline7", 0, 151.0 / 315, 0},
        {"bspline7", 1, 397.0 / 1680, -49.0 / 144},
        {"bspline7", 3, 1.0 / 5040, -1.0 / 720},
        {"omoms", 0, 13.0 / 21, 1.0 / 14},
        {"omoms", -1, 4.0 / 21, 3.0 / 7},
        {"lagrange3", 0.5, 9.0 / 16, -9.0 / 8},
        {"lagrange3", -1.5, -1.0 / 16, -1.0 / 24},
        {"lagrange5", 0.5, 75.0 / 128, -75.0 / 64},
        {"lagrange5", 1.5, -25.0 / 256, 25.0 / 384},
        {"lagrange5", 2.5, 3.0 / 256, -3.0 / 640},
        {"keys6", 0.5, 7.0 / 12, -4.0 / 3},
        {"keys6", 1.5, -3.0 / 32, 7.0 / 48},
        {"keys6", -2.5, 1.0 / 96, 1.0 / 48},
        {"d-linear", -0.25, 1, NAN},
        {"d-linear", 1.0 - 0x1p-53, -1, NAN}, // 1.5 - 2^-53 would round to 1.5
        {"d-catmull-rom", 1, -0.5, 2},
        {"dd-catmull-rom", 0, -5, 9},
        {"dd-catmull-rom", -1, 4, -9},
        {"dd-catmull-rom", 1, 2, -3},
        {"dd-catmull-rom", -2, -1, 3},
        {"dd-bspline", 0, -2, 3},
        {"dd-bspline", 1.5, 0.5, -1},
        {"dd-bspline2", -0.5, -2, NAN},
        {"dd-keys6", 0, -14.0 / 3, 8},
        {"lanczos:3", 0.5, 6 / (M_PI * M_PI), NAN},
        {"lanczos:2", -1.5, -4 / (9 * M_PI * M_PI) * M_SQRT2, NAN},
        {"blackman-sinc:2", 1.5, -2 / (3 * M_PI) * (0.42 - M_SQRT1_2 / 2), NAN},
        {"hann-sinc:3", 1.5, -1 / (3 * M_PI), NAN},
        {"hamming-sinc:3", 0.5, 2 / M_PI * (0.54 + 0.23 * 1.7320508075688772), NAN},
        {"welch-sinc:4", 2.5, 2 / (5 * M_PI) * 39 / 64, NAN},
        {"rect-sinc:4", 3.5, -2 / (7 * M_PI), NAN},
        {"kaiser-sinc:2,0", 1.5, -2 / (3 * M_PI), NAN},
        {"d-rect-sinc", 0, 0, -M_PI * M_PI / 3},
        {"d-rect-sinc", 1, -1, 2},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        assert_near(weft_kernel_weight(&kernel, cases[i].x), cases[i].weight,
                    4e-16 * (1.0 + fabs(cases[i].weight)), cases[i].kernel);
        if (!isnan(cases[i].derivative))
            assert_near(weft_kernel_derivative(&kernel, cases[i].x), cases[i].derivative,
                        9e-16 * (1.0 + fabs(cases[i].derivative)), cases[i].kernel);
    }
}

// Close to the end of the support, where sums of truncated powers keep no digit.
static void test_bspline_tail(void **state)
{
    (void)state;
    const struct weft_kernel kernel = kernel_named("bspline5");
    const double distance = 0x1p-20, expected = pow(distance, 5) / 120.0;
    assert_near(weft_kernel_weight(&kernel, 3.0 - distance) / expected, 1.0, 1e-14, "right end");
    assert_near(weft_kernel_weight(&kernel, distance - 3.0) / expected, 1.0, 1e-14, "left end");
}

static void test_same_kernels(void **state)
{
    static const char *const pairs[][2] = {
        {"nearest", "bspline0"},
        {"linear", "bspline1"},
        {"bspline", "bspline3"},
        {"bspline", "cubic:1,0"},
        {"catmull-rom", "cubic"},
        {"catmull-rom", "cubic:0,0.5"},
        {"mitchell", "cubic:0.3333333333333333,0.3333333333333333"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(pairs); i++) {
        const struct weft_kernel a = kernel_named(pairs[i][0]), b = kernel_named(pairs[i][1]);
        for (double x = -3.0; x < 3.0; x += 0.03125)
            assert_near(weft_kernel_weight(&a, x), weft_kernel_weight(&b, x), 3e-16, pairs[i][0]);
    }
}

// Moeller et al. (1997): a_n(t), from the closed forms.
static void test_taylor_coefficients(void **state)
{
    static const struct {
        const char *kernel;
        int n;
        double t, value;
    } cases[] = {
        {"linear", 2, 0.5, 1.0 / 8},         {"bspline", 2, 0.0, 1.0 / 6},
        {"bspline", 2, 0.37, 1.0 / 6},       {"bspline", 3, 0.25, 0.0},
        {"bspline", 4, 0.5, 13.0 / 1152},    {"mitchell", 2, 0.0, 1.0 / 18},
        {"mitchell", 2, 0.61, 1.0 / 18},     {"mitchell", 3, 0.25, 1.0 / 96},
        {"catmull-rom", 2, 0.3, 0.0},        {"catmull-rom", 3, 0.25, 1.0 / 64},
        {"catmull-rom", 4, 0.5, -3.0 / 128}, {"cubic:1.5,-0.25", 2, 0.2, 1.0 / 4},
        {"cubic:0,0.75", 1, 0.25, 3.0 / 64},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        assert_near(taylor_coefficient(&kernel, cases[i].n, cases[i].t), cases[i].value, 1e-15,
                    cases[i].kernel);
    }
}

static void test_family_flags(void **state)
{
    static const struct {
        const char *kernel;
        int order;
        bool interpolating;
    } cases[] = {
        {"cubic", 3, true},
        {"cubic:0,0.75", 1, true},
        {"cubic:1.5,-0.25", 2, false},
        {"cubic:1,0", 2, false},
        {"cubic:0.5,0.5", 1, false},
        {"cubic:0.333333,0.333333", 2, false},
        {"catmull-rom", 3, true},
        {"lanczos:3", 0, true},
        {"lanczos:3+unit", 1, true},
        {"notch", 2, false},
        {"cardinal", 1, true},
        {"cardinal:0.5", 3, true},
        {"d-cubic:0,0.5", 2, false},
        {"mitchell", 2, false},
        {"bspline", 2, false},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        assert_int_equal(kernel.order, cases[i].order);
        assert_int_equal(kernel.interpolating, cases[i].interpolating);
    }
}

static void test_first_tap(void **state)
{
    static const double below_half = 0.5 - 0x1p-54, below_one = 1.0 - 0x1p-53;
    static const struct {
        const char *kernel;
        double x;
        int64_t tap;
        double fraction;
    } cases[] = {
        {"catmull-rom", 0.0, -1, 0.0},
        {"catmull-rom", 0.75, -1, 0.75},
        {"catmull-rom", below_one, -1, below_one},
        {"catmull-rom", -0.25, -2, 0.75},
        {"catmull-rom", -3.0, -4, 0.0},
        {"catmull-rom", -1e-30, -1, 0.0},
        {"catmull-rom", 1e15 + 0.125, 1000000000000000 - 1, 0.125},
        {"catmull-rom", -1e15 - 0.125, -1000000000000000 - 2, 0.875},
        {"catmull-rom", 1e300, INT64_C(0x4000000000000000) - 1, 0.0},
        {"catmull-rom", -INFINITY, -INT64_C(0x4000000000000000) - 1, 0.0},
        {"catmull-rom", NAN, -1, 0.0},
        {"linear", 7.5, 7, 0.5},
        {"nearest", 0.0, 0, 0.5},
        {"nearest", 0.5, 1, 0.0},
        {"nearest", below_half, 0, below_one},
        {"nearest", -0.5, 0, 0.0},
        {"nearest", -0.75, -1, 0.75},
        {"nearest", 1e300, INT64_C(0x4000000000000000), 0.5},
        {"bspline2", 0.25, -1, 0.75},
        {"bspline2", 0.5, 0, 0.0},
        {"bspline2", -7.75, -9, 0.75},
        {"bspline4", 0.0, -2, 0.5},
        {"bspline5", 0.0, -2, 0.0},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        double fraction = NAN;
        assert_int_equal(weft_kernel_first_tap(&kernel, cases[i].x, &fraction), cases[i].tap);
        assert_near(fraction, cases[i].fraction, 0.0, cases[i].kernel);
        if (fabs(cases[i].x) < 1e3)
            assert_near(cases[i].x - (double)cases[i].tap - fraction, weft_kernel_offset(&kernel),
                        1e-15, cases[i].kernel);
    }
}

static void test_weights(void **state)
{
    static const struct {
        const char *kernel;
        double x;
        int64_t tap;
        double weights[5];
    } cases[] = {
        {"nearest", -0.5, 0, {1}},
        {"linear", -0.25, -1, {0.25, 0.75}},
        {"bspline2", 0.0, -1, {1.0 / 8, 3.0 / 4, 1.0 / 8}},
        {"catmull-rom", -10.5, -12, {-1.0 / 16, 9.0 / 16, 9.0 / 16, -1.0 / 16}},
        {"catmull-rom", 0x1p52, INT64_C(0x10000000000000) - 1, {0, 1, 0, 0}},
        {"bspline", 1e12 + 0.5, 1000000000000 - 1, {1.0 / 48, 23.0 / 48, 23.0 / 48, 1.0 / 48}},
        {"dd-catmull-rom", 1.0 - 0x1p-53, -1, {-1, 4, -5, 2}}, // the limit from the left
        {"bspline4", 3, 1, {1.0 / 384, 19.0 / 96, 115.0 / 192, 19.0 / 96, 1.0 / 384}},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].kernel);
        double weights[WEFT_KERNEL_MAX_WIDTH];
        assert_int_equal(weft_kernel_weights(&kernel, cases[i].x, weights), cases[i].tap);
        for (int j = 0; j < kernel.width; j++)
            assert_near(weights[j], cases[i].weights[j], 2e-15, cases[i].kernel);
    }
}

static void test_derive(void **state)
{
    const struct weft_kernel_info users = *weft_kernel_find("bspline");
    struct weft_kernel own, kernel = kernel_named("kaiser-sinc:2.5,8");
    (void)state;
    // In place; the name with parameters is that of the derivative.
    assert_int_equal(weft_kernel_derive(NULL, &kernel, &kernel), WEFT_OK);
    char text[128];
    weft_kernel_format(&kernel, text, sizeof text);
    assert_string_equal(text, "d-kaiser-sinc:2.5,8");
    assert_int_equal(weft_kernel_derive(NULL, &kernel, &kernel), WEFT_OK);
    weft_kernel_format(&kernel, text, sizeof text);
    assert_string_equal(text, "dd-kaiser-sinc:2.5,8");
    // "+unit" says nothing where weights add up to one anyway.
    kernel = kernel_named("mitchell+unit");
    assert_int_equal(weft_kernel_derive(NULL, &kernel, &kernel), WEFT_OK);
    assert_int_equal(weft_kernel_create(NULL, &users, NULL, &own), WEFT_OK);
    const struct {
        struct weft_kernel kernel;
        enum weft_result expected;
        const char *message;
    } cases[] = {
        {kernel_named("nearest"), WEFT_ERR_ARGUMENT, "kernel nearest: the catalogue has no record"},
        {kernel_named("d-linear"), WEFT_ERR_ARGUMENT, "kernel d-linear: the catalogue has no"},
        {kernel_named("dd-bspline"), WEFT_ERR_ARGUMENT, "kernel dd-bspline: the catalogue has no"},
        {kernel_named("lanczos:3+unit"), WEFT_ERR_ARGUMENT, "kernel lanczos: divided by the sum"},
        {kernel_named("linear+radial"), WEFT_ERR_UNSUPPORTED, "kernel linear: the slope of a rad"},
        {own, WEFT_ERR_ARGUMENT, "kernel bspline: the catalogue has no record"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        memset(&kernel, 0x55, sizeof kernel);
        assert_int_equal(weft_kernel_derive(&remember_log, &cases[i].kernel, &kernel),
                         cases[i].expected);
        assert_null(kernel.info);
        if (!strstr(last.text, cases[i].message))
            fail_msg("case %zu logs '%s'", i, last.text);
    }
    assert_int_equal(weft_kernel_derive(NULL, NULL, &kernel), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_derive(NULL, &own, NULL), WEFT_ERR_ARGUMENT);
}

static void check_round_trip(const struct weft_kernel *kernel, const char *name)
{
    char text[128], small[4];
    struct weft_kernel back;
    const int length = weft_kernel_format(kernel, text, sizeof text);
    checked++;
    assert_int_equal((size_t)length, strlen(text));
    assert_int_equal(weft_kernel_format(kernel, small, sizeof small), length);
    assert_int_equal(strncmp(small, text, 3), 0);
    assert_int_equal(small[3], 0);
    assert_int_equal(weft_kernel_format(kernel, NULL, 0), length);
    assert_int_equal(weft_kernel_parse(NULL, text, &back), WEFT_OK);
    assert_ptr_equal(back.info, kernel->info);
    for (int i = 0; i < WEFT_KERNEL_PARAMS; i++)
        assert_near(back.param[i], kernel->param[i], 0.0, name);
}
EACH(check_round_trip)

static void test_format(void **state)
{
    static const char *const cases[][2] = {
        {"catmull-rom", "catmull-rom"},
        {"cubic", "cubic:0,0.5"},
        {"cubic:0.25", "cubic:0.25,0.5"},
        {"cubic:+1e0,-.5", "cubic:1,-0.5"},
        {"cubic:0.1,0.3333333333333333", "cubic:0.1,0.3333333333333333"},
        {"lanczos+unit", "lanczos:3+unit"},
        {"linear+unit", "linear"},
        {"kaiser-sinc:2,5.36", "kaiser-sinc:2,5.36"},
    };
    (void)state;
    // Where a locale with decimal commas is installed, it changes nothing.
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8"))
        print_message("[  SKIPPED ] decimal commas: the locale de_DE.UTF-8 is not installed\n");
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i][0]);
        char text[128];
        weft_kernel_format(&kernel, text, sizeof text);
        assert_string_equal(text, cases[i][1]);
    }
    setlocale(LC_NUMERIC, "C");
    const struct weft_kernel thirds = kernel_named("cubic:-0.33333333333333331,1e-300");
    check_round_trip(&thirds, "thirds");
}

static void test_bad_text(void **state)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"", "no kernel ''; there are nearest, area, linear, cubic,"},
        {"lanczos-7", "no kernel 'lanczos-7'; did you mean lanczos"},
        {"Linea", "no kernel 'Linea'; did you mean linear?"},
        {"linear ", "no kernel 'linear '"},
        {"bsplin", "no kernel 'bsplin'"},
        {"linear:", "kernel linear takes no parameters"},
        {"linear:1", "kernel linear takes no parameters, more are given: ':1'"},
        {"cubic:", "kernel cubic: B = '' is not a finite number"},
        {"cubic:,1", "B = ',1' is not a finite number"},
        {"cubic:1,", "C = '' is not a finite number"},
        {"cubic:1,2,3", "takes 2 parameters, more are given: ':1,2,3'"},
        {"lanczos:3,2", "takes 1 parameter, more are given: ':3,2'"},
        {"hermite:1", "takes 2 parameters, more are given: ':0,0,1'"},
        {"mitchell:0.2,0.4", "takes no parameters, more are given: ':0.2,0.4'; with B and C: "
                             "cubic:0.2,0.4"},
        {"cubic:1,2,", "takes 2 parameters"},
        {"cubic:a", "B = 'a' is not a finite number"},
        {"cubic:0.5x", "B = '0.5x' is not a finite number"},
        {"cubic:0.5 ,1", "B = '0.5 ,1' is not a finite number"},
        {"cubic: 0.5", "B = ' 0.5' is not a finite number"},
        {"cubic:nan", "B = 'nan' is not a finite number"},
        {"cubic:0,-nan", "C = '-nan' is not a finite number"},
        {"cubic:0,inf", "C = 'inf' is not a finite number"},
        {"cubic:-infinity", "B = '-infinity' is not a finite number"},
        {"cubic:1e999", "B = '1e999' is not a finite number"},
        {"cubic:-", "B = '-' is not a finite number"},
        {"cubic:0;1", "B = '0;1' is not a finite number"},
        {"cubic:0:1", "B = '0:1' is not a finite number"},
        {"cubic:11", "kernel cubic: B = 11 is not in [-10, 10]"},
        {"cubic:0,-10.5", "kernel cubic: C = -10.5 is not in [-10, 10]"},
        {"lanczos:0", "kernel lanczos: radius = 0 is not in [0.5, 8]"},
        {"lanczos:9", "kernel lanczos: radius = 9 is not in [0.5, 8]"},
        {"kaiser-sinc:2,51", "kernel kaiser-sinc: beta = 51 is not in [0, 50]"},
        {"lanczos+", "no kernel 'lanczos'"},
        {"lanczos+units", "no kernel 'lanczos'"},
        {"lanczos:3+", "radius = '3+' is not a finite number"},
        {"lanczos:3+unit+unit", "radius = '3+unit+unit' is not a finite number"},
        {"d-lanczos+unit", "the weights of a derivative add up to 0"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel kernel;
        memset(&kernel, 0x55, sizeof kernel);
        assert_int_equal(weft_kernel_parse(&remember_log, cases[i].text, &kernel),
                         WEFT_ERR_ARGUMENT);
        assert_null(kernel.info);
        if (!strstr(last.text, cases[i].message))
            fail_msg("'%s' logs '%s', not '%s'", cases[i].text, last.text, cases[i].message);
    }
}

static void test_unknown_lists_all(void **state)
{
    struct weft_kernel kernel;
    (void)state;
    assert_int_equal(weft_kernel_parse(&remember_log, "gargoyle", &kernel), WEFT_ERR_ARGUMENT);
    for (size_t i = 0; weft_kernel_list[i]; i++)
        if (!weft_kernel_list[i]->primitive)
            assert_non_null(strstr(last.text, weft_kernel_list[i]->name));
    assert_non_null(strstr(last.text, "d-NAME, dd-NAME"));
}

static void test_long_text(void **state)
{
    char text[4096];
    struct weft_kernel kernel;
    (void)state;
    memset(text, '0', sizeof text);
    memcpy(text, "cubic:", 6);
    text[255] = '\0';
    assert_int_equal(weft_kernel_parse(&remember_log, text, &kernel), WEFT_OK);
    text[255] = '0';
    text[256] = '\0';
    assert_int_equal(weft_kernel_parse(&remember_log, text, &kernel), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last.text, "longer than 255 bytes"));
}

static void test_bad_arguments(void **state)
{
    static const struct weft_kernel_info no_weight = {.name = "no weight", .radius = 1.0};
    struct weft_kernel_info wide = *weft_kernel_find("linear");
    struct weft_kernel kernel;
    (void)state;
    wide.radius = 8.5;
    assert_null(weft_kernel_find(NULL));
    assert_null(weft_kernel_find(""));
    assert_int_equal(weft_kernel_parse(&remember_log, NULL, &kernel), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_parse(&remember_log, "linear", NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_create(&remember_log, NULL, NULL, &kernel), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_create(NULL, &no_weight, NULL, &kernel), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_create(&remember_log, &wide, NULL, &kernel), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last.text, "half-width 8.5 is not in (0, 8]"));
    const struct weft_kernel_info *cubic = weft_kernel_find("cubic");
    assert_int_equal(weft_kernel_create(&remember_log, cubic, (double[]){NAN, INFINITY}, &kernel),
                     WEFT_ERR_ARGUMENT);
    assert_null(kernel.info);
    assert_int_equal(weft_kernel_create(NULL, cubic, (double[]){1.0, NAN}, &kernel), WEFT_OK);
    assert_near(kernel.param[0], 1.0, 0.0, "given");
    assert_near(kernel.param[1], 0.5, 0.0, "initial");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_check_record),     cmocka_unit_test(test_check_support),
        cmocka_unit_test(test_check_symmetry),   cmocka_unit_test(test_check_integers),
        cmocka_unit_test(test_check_unit_sum),   cmocka_unit_test(test_check_integral),
        cmocka_unit_test(test_check_derivative), cmocka_unit_test(test_check_continuity),
        cmocka_unit_test(test_check_primitive),  cmocka_unit_test(test_check_derive),
        cmocka_unit_test(test_check_order),      cmocka_unit_test(test_check_order_prefiltered),
        cmocka_unit_test(test_fractions),        cmocka_unit_test(test_bspline_tail),
        cmocka_unit_test(test_same_kernels),     cmocka_unit_test(test_taylor_coefficients),
        cmocka_unit_test(test_family_flags),     cmocka_unit_test(test_first_tap),
        cmocka_unit_test(test_weights),          cmocka_unit_test(test_derive),
        cmocka_unit_test(test_check_round_trip), cmocka_unit_test(test_format),
        cmocka_unit_test(test_bad_text),         cmocka_unit_test(test_unknown_lists_all),
        cmocka_unit_test(test_long_text),        cmocka_unit_test(test_bad_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
