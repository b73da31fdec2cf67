// SPDX-License-Identifier: BSD-3-Clause
// What edges cover: against polygons, closed forms of splines and Gaussians, and identities.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/passes/jitter/points.h"
#include "passes/jitter/edge.h"

// ---- squares and discs
// ----------------------------------------------------------------------------

// The area of the square's part with p . n <= d: clipped, and added up by the shoelace formula.
static double clipped_area(const double n[2], double d)
{
    static const long double corners[4][2] = {{-.5L, -.5L}, {.5L, -.5L}, {.5L, .5L}, {-.5L, .5L}};
    long double kept[8][2], twice = 0.0L;
    int count = 0;
    for (int i = 0; i < 4; i++) {
        const long double *a = corners[i], *b = corners[(i + 1) % 4];
        const long double u = a[0] * n[0] + a[1] * n[1] - d, v = b[0] * n[0] + b[1] * n[1] - d;
        if (u <= 0.0L) {
            kept[count][0] = a[0], kept[count][1] = a[1];
            count++;
        }
        if ((u <= 0.0L) != (v <= 0.0L)) {
            const long double t = u / (u - v);
            for (int axis = 0; axis < 2; axis++)
                kept[count][axis] = a[axis] + t * (b[axis] - a[axis]);
            count++;
        }
    }
    for (int i = 0; i < count; i++) {
        const long double *a = kept[i], *b = kept[(i + 1) % count];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return (double)(0.5L * twice);
}

static void test_square(void **state)
{
    (void)state;
    uint64_t random = 1;
    int inside = 0;
    for (int i = 0; i < 100000; i++) {
        double n[2];
        random_normal(&random, n);
        const double d = random_in(&random, -0.75, 0.75), share = weft_edge_square(n, d);
        const double mirrored[2] = {n[1], -n[0]}, longer[2] = {3.0 * n[0], 3.0 * n[1]};
        assert_near(share, clipped_area(n, d), 1e-15, "polygon");
        assert_near(share + weft_edge_square(n, -d), 1.0, 3e-16, "both sides");
        assert_near(weft_edge_square(mirrored, d), share, 3e-16, "mirrored");
        assert_near(weft_edge_square(longer, d), share, 1e-15, "longer");
        inside += share > 0.0 && share < 1.0;
    }
    assert_true(inside > 50000);
}

static void test_square_ends(void **state)
{
    (void)state;
    const double along[2] = {1.0, 0.0}, down[2] = {0.0, -2.0}, oblique[2] = {1.0, 1.0};
    for (int i = -4; i <= 4; i++)
        assert_true(weft_edge_square(along, i / 8.0) == 0.5 + i / 8.0);
    assert_true(weft_edge_square(down, 0.25) == 0.75);
    assert_true(weft_edge_square(along, 0.6) == 1.0 && weft_edge_square(along, -0.6) == 0.0);
    assert_true(weft_edge_square(oblique, INFINITY) == 1.0);
    assert_true(weft_edge_square(oblique, -INFINITY) == 0.0);
    // The corner's triangle, s from the corner: s^2, to a part in 10^9 of itself when s is 1e-7.
    const double s = 1e-7, share = weft_edge_square(oblique, s - M_SQRT1_2);
    assert_near(share / (s * s), 1.0, 1e-8, "corner");
    const double none[][2] = {{0.0, 0.0}, {NAN, 1.0}, {1.0, INFINITY}};
    for (size_t i = 0; i < WEFT_COUNT(none); i++)
        assert_true(isnan(weft_edge_square(none[i], 0.1)));
    assert_true(isnan(weft_edge_square(along, NAN)));
    // Normals that are nearly along an axis are no exception.
    const double tiny[2] = {1.0, 1e-300};
    assert_near(weft_edge_square(tiny, 0.3), 0.8, 1e-15, "tiny");
}

// The chord's length is the slope; quarters by hand.
static void test_disc(void **state)
{
    (void)state;
    uint64_t random = 2;
    for (int i = 0; i < 10000; i++) {
        const double d = random_in(&random, -0.499, 0.499), h = 1e-6;
        const double slope = (weft_edge_disc(d + h) - weft_edge_disc(d - h)) / (2.0 * h);
        assert_near(slope, 2.0 * sqrt(0.25 - d * d) / M_PI_4, 1e-7, "chord");
        assert_near(weft_edge_disc(d) + weft_edge_disc(-d), 1.0, 3e-16, "both sides");
    }
    assert_true(weft_edge_disc(0.0) == 0.5 && weft_edge_disc(0.5) == 1.0);
    assert_true(weft_edge_disc(-0.5) == 0.0 && weft_edge_disc(-7.0) == 0.0);
    assert_true(weft_edge_disc(INFINITY) == 1.0 && isnan(weft_edge_disc(NAN)));
    // Half a radius out: 1/3 less sqrt(3) / (4 pi) is beyond.
    assert_near(weft_edge_disc(0.25), 1.0 - (1.0 / 3.0 - sqrt(3.0) / (4.0 * M_PI)), 1e-15, "hand");
}

// ---- kernels
// --------------------------------------------------------------------------------------

static double covered(const char *name, double width, const double n[2], double d)
{
    const struct weft_kernel kernel = kernel_named(name);
    struct weft_edge_value v;
    assert_int_equal(weft_edge_kernel(&log_to_stderr, &kernel, width, n, d, &v), WEFT_OK);
    if (!(v.error >= 0.0 && v.error <= 1e-14))
        fail_msg("%s: error %g at (%g, %g), %g", name, v.error, n[0], n[1], d);
    return v.value;
}

// The share of a sum of `count` independent boxes of these widths that is below d: the sum over the
// corners of a cube of signed powers, in long double.
static double boxes_below(const double *widths, int count, double d)
{
    long double sum = 0.0L, scale = 1.0L;
    for (int i = 0; i < count; i++)
        scale *= (long double)widths[i] * (i + 1);
    for (int corner = 0; corner < 1 << count; corner++) {
        long double at = d;
        int negative = 0;
        for (int i = 0; i < count; i++) {
            at += (corner >> i & 1 ? -0.5L : 0.5L) * widths[i];
            negative ^= corner >> i & 1;
        }
        if (at > 0.0L)
            sum += (negative ? -1.0L : 1.0L) * powl(at, count);
    }
    return (double)(sum / scale);
}

// A B-spline of degree k is k + 1 boxes along each axis.
static void test_splines(void **state)
{
    (void)state;
    static const char *const names[] = {"nearest", "linear", "bspline2", "bspline"};
    uint64_t random = 3;
    int between = 0;
    for (int i = 0; i < 800; i++) {
        const int k = i % 4;
        double n[2], widths[8];
        random_normal(&random, n);
        if (fmin(fabs(n[0]), fabs(n[1])) < 0.2)
            n[0] = n[1] = M_SQRT1_2;
        const double d = random_in(&random, -2.0, 2.0);
        for (int j = 0; j <= k; j++)
            widths[2 * j] = fabs(n[0]), widths[2 * j + 1] = fabs(n[1]);
        const double share = covered(names[k], 0.0, n, d);
        // What cancels in long double: 2^8 terms of 4^8 / 8! over 0.2^4.
        assert_near(share, boxes_below(widths, 2 * k + 2, d), k < 3 ? 1e-14 : 1e-12, names[k]);
        if (k == 0)
            assert_near(share, weft_edge_square(n, d), 5e-15, "square");
        between += share > 1e-9 && share < 1.0 - 1e-9;
    }
    assert_true(between > 400);
}

// A Gaussian that is cut where nothing is left of it is the same at every angle.
static void test_gaussian(void **state)
{
    (void)state;
    uint64_t random = 4;
    for (int i = 0; i < 200; i++) {
        double n[2];
        random_normal(&random, n);
        const double d = random_in(&random, -3.0, 3.0);
        assert_near(covered("gaussian:8,0.9", 0.0, n, d), 0.5 * erfc(-d / (0.9 * M_SQRT2)), 1e-14,
                    "gaussian");
    }
}

static const char *const kernels[] = {
    "nearest",
    "linear",
    "catmull-rom",
    "mitchell",
    "bspline7",
    "omoms",
    "lagrange5",
    "keys6",
    "lanczos:3",
    "lanczos:2.3",
    "lanczos:2.3+unit",
    "hann-sinc:5.5",
    "blackman-sinc:3.7",
    "kaiser-sinc:4",
    "gaussian:2",
    "gaussian:0.7,0.4+unit",
    "rect-sinc:4",
    "welch-sinc:8",
    "notch",
    NULL,
};

// Even kernels: both sides make 1, mirrors do not matter, nor do swapped axes; width scales.
static void test_identities(void **state)
{
    (void)state;
    uint64_t random = 5;
    int negative = 0;
    for (int k = 0; kernels[k]; k++) {
        const double r = kernel_named(kernels[k]).support;
        for (int i = 0; i < 12; i++) {
            double n[2];
            random_normal(&random, n);
            if (i == 0)
                n[0] = 1.0, n[1] = 0.0;
            const double d = random_in(&random, -r, r), mirrored[2] = {-n[1], n[0]};
            const double share = covered(kernels[k], 0.0, n, d);
            assert_near(share + covered(kernels[k], 0.0, n, -d), 1.0, 2e-14, kernels[k]);
            assert_near(covered(kernels[k], 0.0, mirrored, d), share, 2e-14, kernels[k]);
            assert_near(covered(kernels[k], 3.0, n, d * 1.5 / r), share, 1e-13, kernels[k]);
            assert_near(covered(kernels[k], 0.0, n, 3.0 * r), 1.0, 1e-14, kernels[k]);
            assert_near(covered(kernels[k], 0.0, n, -INFINITY), 0.0, 1e-14, kernels[k]);
            negative += share < -1e-4;
        }
    }
    assert_true(negative > 3);
}

// The double integral itself, by a lattice of middles: the share of those below the edge.
static void test_lattice(void **state)
{
    (void)state;
    enum { SIDE = 600 };
    uint64_t random = 6;
    for (int k = 0; kernels[k]; k++) {
        const struct weft_kernel kernel = kernel_named(kernels[k]);
        const double r = kernel.support, step = 2.0 * r / SIDE, d = random_in(&random, -r, r) / 2.0;
        double n[2], h[SIDE], inside = 0.0, whole = 0.0, largest = 0.0;
        random_normal(&random, n);
        for (int i = 0; i < SIDE; i++)
            h[i] = weft_kernel_weight(&kernel, -r + (i + 0.5) * step);
        for (int i = 0; i < SIDE; i++)
            for (int j = 0; j < SIDE; j++) {
                const double past =
                    (-r + (i + 0.5) * step) * n[0] + (-r + (j + 0.5) * step) * n[1] - d;
                // A middle on the edge counts as far as its cell is covered.
                inside += h[i] * h[j] * weft_edge_square(n, -past / step);
                whole += h[i] * h[j];
                largest = fmax(largest, fabs(h[i] * h[j]));
            }
        // Middles err by step^2 / 24 of the second derivative, a jump by half a step of its line.
        const double tolerance = kernel.continuity < 0 ? 2.0 * step : 3.0 * step * step * r;
        assert_near(covered(kernels[k], 0.0, n, d), inside / whole, tolerance, kernels[k]);
    }
}

// ---- what is refused
// ------------------------------------------------------------------------------

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static void refused(const char *name, double width, double x, double y, double d,
                    enum weft_result expected)
{
    const struct weft_kernel kernel = kernel_named(name);
    const double n[2] = {x, y};
    struct weft_edge_value v;
    last.count = 0;
    assert_int_equal(weft_edge_kernel(&remember_log, &kernel, width, n, d, &v), expected);
    assert_true(last.count == 1 && isnan(v.value) && isnan(v.error));
}

static void test_refused(void **state)
{
    (void)state;
    refused("d-bspline", 0.0, 1.0, 0.0, 0.0, WEFT_ERR_ARGUMENT);
    refused("lanczos:3+radial", 0.0, 1.0, 0.0, 0.0, WEFT_ERR_UNSUPPORTED);
    refused("bspline3i", 0.0, 1.0, 0.0, 0.0, WEFT_ERR_UNSUPPORTED);
    refused("linear", -1.0, 1.0, 0.0, 0.0, WEFT_ERR_ARGUMENT);
    refused("linear", NAN, 1.0, 0.0, 0.0, WEFT_ERR_ARGUMENT);
    refused("linear", 0.0, 0.0, 0.0, 0.0, WEFT_ERR_ARGUMENT);
    refused("linear", 0.0, 1.0, 0.0, NAN, WEFT_ERR_ARGUMENT);
}

// A record of one's own with a corner where none is expected: the error says so, and holds.
static double crooked(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return x >= -1.0 && x < 1.0 ? 1.0 - fabs(x - 0.3) / 1.3 : 0.0;
}

static void test_error_estimate(void **state)
{
    (void)state;
    const struct weft_kernel_info info = {
        .name = "crooked", .weight = crooked, .radius = 1.0, .degree = -1, .continuity = -1};
    struct weft_kernel kernel;
    struct weft_edge_value v;
    assert_int_equal(weft_kernel_create(&log_to_stderr, &info, NULL, &kernel), WEFT_OK);
    const double n[2] = {1.0, 0.0};
    assert_int_equal(weft_edge_kernel(&log_to_stderr, &kernel, 0.0, n, 0.3, &v), WEFT_OK);
    // The integral up to its peak is 1.3 / 2, after it (1 + 0.6 / 1.3) 0.7 / 2.
    const double before = 0.65, after = 0.7 * (1.0 + (1.3 - 0.7) / 1.3) / 2.0;
    assert_true(v.error > 1e-13 && v.error < 1e-3);
    assert_near(v.value, before / (before + after), 10.0 * v.error, "crooked");
}

// Every kernel of the catalogue, its normal from along an axis to the diagonal by all magnitudes:
// what is nearly along the axis is what is along it, and both sides make 1 within both errors.
static void test_catalogue(void **state)
{
    (void)state;
    uint64_t random = 9;
    int checked = 0;
    for (int k = 0; weft_kernel_list[k]; k++) {
        const struct weft_kernel_info *info = weft_kernel_list[k];
        if (info->derivation > 0)
            continue;
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_create(&log_to_stderr, info, NULL, &kernel), WEFT_OK);
        for (int power = -18; power <= 0; power += 1 + (power < -2), checked++) {
            const double tilt = pow(10.0, power), axis[2] = {0.0, 1.0}, n[2] = {tilt, 1.0};
            const double d = random_in(&random, -kernel.support, kernel.support);
            struct weft_edge_value v, other, along;
            weft_edge_kernel(&log_to_stderr, &kernel, 0.0, n, d, &v);
            weft_edge_kernel(&log_to_stderr, &kernel, 0.0, n, -d, &other);
            weft_edge_kernel(&log_to_stderr, &kernel, 0.0, axis, d, &along);
            assert_true(v.error <= 1e-14 && along.error <= 1e-14);
            assert_near(v.value + other.value, 1.0, v.error + other.error, info->name);
            // The edge is off by the tilt times the support, its weight by 2 at most for each.
            assert_near(v.value, along.value, v.error + along.error + 2.0 * tilt * kernel.width,
                        info->name);
        }
    }
    assert_true(checked >= 25 * 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_square),         cmocka_unit_test(test_square_ends),
        cmocka_unit_test(test_disc),           cmocka_unit_test(test_splines),
        cmocka_unit_test(test_gaussian),       cmocka_unit_test(test_identities),
        cmocka_unit_test(test_lattice),        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_error_estimate), cmocka_unit_test(test_catalogue),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
