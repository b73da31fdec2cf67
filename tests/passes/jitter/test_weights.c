// SPDX-License-Identifier: BSD-3-Clause
// Weights of samples by kernels, of frames by shutters, and how many frames there are to be.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/passes/jitter/points.h"
#include "passes/jitter/counts.h"
#include "passes/jitter/edge.h"
#include "passes/jitter/shutter.h"

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static double *weigh(const struct weft_jitter *set, const char *kernel, double width,
                     struct weft_weights_report *report)
{
    double *weights = malloc((size_t)set->count * sizeof *weights);
    assert_non_null(weights);
    assert_int_equal(
        weft_weights_kernel(weft_weights_kernel_params(.points = (points_of)set->points,
                                                       .count = set->count,
                                                       .kernel = kernel_named(kernel),
                                                       .width = width, .log = &log_to_stderr),
                            weights, report),
        WEFT_OK);
    return weights;
}

// What a report says, counted anew.
static void check_report(const double *weights, int count, const struct weft_weights_report *r)
{
    long double sum = 0.0L, size = 0.0L, below = 0.0L, squares = 0.0L;
    double largest = 0.0;
    int zeros = 0;
    for (int i = 0; i < count; i++) {
        sum += weights[i];
        size += fabs(weights[i]);
        below += fmin(weights[i], 0.0);
        squares += (long double)weights[i] * weights[i];
        largest = fmax(largest, fabs(weights[i]));
        zeros += weights[i] == 0.0;
    }
    assert_near((double)sum, 1.0, 1e-13, "sum");
    assert_near(r->gain, (double)size, 1e-13, "gain");
    assert_near(r->negative, (double)(-below / size), 1e-13, "negative");
    assert_near(r->effective, (double)(1.0L / squares), 1e-9, "effective");
    assert_true(r->largest == largest && r->zeros == zeros && r->sum > 0.0);
}

static void test_even(void **state)
{
    (void)state;
    for (int n = 1; n < 200; n++) {
        double weights[200];
        struct weft_weights_report r;
        assert_int_equal(weft_weights_even(NULL, n, weights, &r), WEFT_OK);
        check_report(weights, n, &r);
        for (int i = 0; i < n; i++)
            assert_true(weights[i] == 1.0 / n);
        assert_true(r.sum == n && r.largest == 1.0 / n && r.negative == 0.0);
        assert_near(r.effective, n, 1e-12 * n, "effective");
    }
}

// ---- kernels
// --------------------------------------------------------------------------------------

// A box weighs all samples of a pixel alike, those on its rims too.
static void test_box(void **state)
{
    (void)state;
    for (int i = 0; weft_jitter_list[i]; i++) {
        struct weft_jitter set;
        struct weft_weights_report r;
        assert_int_equal(
            weft_jitter_create(weft_jitter_params(.info = weft_jitter_list[i], .size = 3.0), &set),
            WEFT_OK);
        double *weights = weigh(&set, "nearest", 3.0, &r);
        for (int k = 0; k < set.count; k++)
            assert_true(weights[k] == 1.0 / set.count);
        free(weights);
        weft_jitter_clear(&set);
    }
    struct weft_jitter rim = set_named("msaa:16", WEFT_JITTER_SQUARE, 1.0, false);
    double weights[16];
    // The kernel that is all zero is the box of one pixel.
    assert_int_equal(weft_weights_kernel(
                         weft_weights_kernel_params(.points = (points_of)rim.points, .count = 16),
                         weights, NULL),
                     WEFT_OK);
    for (int k = 0; k < 16; k++)
        assert_true(weights[k] == 1.0 / 16.0);
    weft_jitter_clear(&rim);
}

static const char *const kernels[] = {
    "linear", "catmull-rom", "mitchell",         "bspline",       "bspline7", "lanczos:3",
    "keys6",  "gaussian",    "lanczos:2.3+unit", "hann-sinc:5.5", NULL,
};

// Ratios of weights are ratios of h h; on a grid the sum of all is that of rows times that of
// columns, the negative share that of products of one axis.
static void test_kernels(void **state)
{
    (void)state;
    int with_lobes = 0;
    for (int k = 0; kernels[k]; k++) {
        const struct weft_kernel kernel = kernel_named(kernels[k]);
        const double r = kernel.support;
        struct weft_jitter set = set_named("grid:900", WEFT_JITTER_SQUARE, 2.0 * r, false);
        struct weft_weights_report report;
        double *weights = weigh(&set, kernels[k], 0.0, &report);
        check_report(weights, set.count, &report);
        double sum = 0.0, size = 0.0;
        for (int i = 0; i < 30; i++) {
            const double h = weft_kernel_weight(&kernel, set.points[i][0]);
            sum += h;
            size += fabs(h);
        }
        assert_near(report.sum, sum * sum, 1e-10, kernels[k]);
        assert_near(report.gain, size * size / (sum * sum), 1e-12, kernels[k]);
        assert_near(report.negative, 0.5 - 0.5 * sum * sum / (size * size), 1e-12, kernels[k]);
        for (int i = 0; i < set.count; i++) {
            const double *p = set.points[i];
            const double h = weft_kernel_weight(&kernel, p[0]) * weft_kernel_weight(&kernel, p[1]);
            assert_near(weights[i], h / (sum * sum), 1e-13, kernels[k]);
        }
        with_lobes += report.negative > 0.01;
        free(weights);
        weft_jitter_clear(&set);
    }
    assert_true(with_lobes >= 4);
}

// Twice the width is the same weights at twice the places.
static void test_width(void **state)
{
    (void)state;
    struct weft_jitter narrow = set_named("sobol:64", WEFT_JITTER_SQUARE, 4.0, true);
    struct weft_jitter wide = set_named("sobol:64", WEFT_JITTER_SQUARE, 8.0, true);
    double *a = weigh(&narrow, "mitchell", 4.0, NULL), *b = weigh(&wide, "mitchell", 8.0, NULL);
    for (int i = 0; i < 64; i++)
        assert_near(a[i], b[i], 1e-15, "width");
    free(a);
    free(b);
    weft_jitter_clear(&narrow);
    weft_jitter_clear(&wide);
}

// Samples past the support weigh nothing; a kernel that is not even is mirrored, since its argument
// is position less sample.
static double slanted(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return x >= -1.0 && x < 1.0 ? 1.0 + 0.5 * x : 0.0;
}

static void test_places(void **state)
{
    (void)state;
    const struct weft_kernel_info info = {
        .name = "slanted", .weight = slanted, .radius = 1.0, .degree = -1, .continuity = -1};
    struct weft_kernel kernel;
    const double points[4][2] = {{0.5, 0.0}, {-0.5, 0.0}, {1.5, 0.0}, {0.0, -1.0}};
    double weights[4];
    struct weft_weights_report report;
    assert_int_equal(weft_kernel_create(&log_to_stderr, &info, NULL, &kernel), WEFT_OK);
    assert_int_equal(
        weft_weights_kernel(weft_weights_kernel_params(.points = points, .count = 4,
                                                       .kernel = kernel, .log = &log_to_stderr),
                            weights, &report),
        WEFT_OK);
    const double sum = 0.75 + 1.25 + 0.0 + 1.5, expected[4] = {0.75, 1.25, 0.0, 1.5};
    for (int i = 0; i < 4; i++)
        assert_near(weights[i], expected[i] / sum, 1e-15, "slanted");
    assert_int_equal(report.zeros, 1);
}

// An edge seen by weighted samples is the exact integral within what the set can do: smooth kernels
// on grids of 96 by 96 err by the edge's cells, 1/96 of the largest weight a row at most.
static void test_edges(void **state)
{
    (void)state;
    uint64_t random = 8;
    for (int k = 0; kernels[k]; k++) {
        const struct weft_kernel kernel = kernel_named(kernels[k]);
        struct weft_jitter set =
            set_named("grid:9216", WEFT_JITTER_SQUARE, 2.0 * kernel.support, false);
        double *weights = weigh(&set, kernels[k], 0.0, NULL);
        for (int edge = 0; edge < 20; edge++) {
            double n[2], inside = 0.0;
            struct weft_edge_value exact;
            random_normal(&random, n);
            const double d = random_in(&random, -1.0, 1.0);
            for (int i = 0; i < set.count; i++)
                inside += set.points[i][0] * n[0] + set.points[i][1] * n[1] <= d ? weights[i] : 0.0;
            assert_int_equal(weft_edge_kernel(&log_to_stderr, &kernel, 0.0, n, d, &exact), WEFT_OK);
            assert_near(inside, exact.value, 2.0 * kernel.support / 96.0, kernels[k]);
        }
        free(weights);
        weft_jitter_clear(&set);
    }
}

static void refused(const char *kernel, double width, double x, enum weft_result expected)
{
    const double points[2][2] = {{x, 0.0}, {x, 0.1}};
    double weights[2] = {5.0, 5.0};
    struct weft_weights_report report;
    last.count = 0;
    assert_int_equal(
        weft_weights_kernel(weft_weights_kernel_params(.points = points, .count = 2, .width = width,
                                                       .kernel = kernel_named(kernel),
                                                       .log = &remember_log),
                            weights, &report),
        expected);
    assert_true(last.count == 1 && weights[0] == 5.0 && isnan(report.sum) && report.zeros == 0);
}

static void test_refused(void **state)
{
    (void)state;
    refused("d-bspline", 0.0, 0.0, WEFT_ERR_ARGUMENT);
    refused("lanczos:3+radial", 0.0, 0.0, WEFT_ERR_UNSUPPORTED);
    refused("bspline3i", 0.0, 0.0, WEFT_ERR_UNSUPPORTED);
    refused("linear", -1.0, 0.0, WEFT_ERR_ARGUMENT);
    refused("linear", 0.0, NAN, WEFT_ERR_ARGUMENT);
    refused("linear", 0.0, 7.0, WEFT_ERR_ARGUMENT);
    refused("lanczos:3", 0.0, 1.5, WEFT_ERR_ARGUMENT);
    double weights[1];
    assert_int_equal(weft_weights_even(&remember_log, 0, weights, NULL), WEFT_ERR_ARGUMENT);
}

// Products of other weights, by hand: (2, -1, 0, 3) / 4.
static void test_own_weights(void **state)
{
    (void)state;
    static const double bad[][4] = {{1.0, -1.0, 0.0, 0.0},    {0.0, 0.0, 0.0, 0.0},
                                    {1.0, NAN, 1.0, 1.0},     {1.0, 1.0, 1.0, INFINITY},
                                    {-1.0, -1.0, -1.0, -1.0}, {1.0, -0.9999, 0.0, 0.0}};
    double weights[4] = {2.0, -1.0, 0.0, 3.0};
    struct weft_weights_report r;
    assert_int_equal(weft_weights_normalise(&log_to_stderr, 4, weights, &r), WEFT_OK);
    assert_true(weights[0] == 0.5 && weights[1] == -0.25 && weights[2] == 0.0 &&
                weights[3] == 0.75);
    assert_true(r.sum == 4.0 && r.largest == 0.75 && r.gain == 1.5 && r.zeros == 1);
    assert_near(r.negative, 0.25 / 1.5, 1e-15, "negative");
    assert_near(r.effective, 1.0 / 0.875, 1e-15, "effective");
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        memcpy(weights, bad[i], sizeof weights);
        last.count = 0;
        assert_int_equal(weft_weights_normalise(&remember_log, 4, weights, &r), WEFT_ERR_ARGUMENT);
        assert_int_equal(last.count, 1);
        assert_memory_equal(weights, bad[i], sizeof weights);
        assert_true(isnan(r.sum) && isnan(r.gain) && r.zeros == 0);
    }
}

// ---- shutters
// -------------------------------------------------------------------------------------

static struct weft_shutter shutter_named(const char *text)
{
    struct weft_shutter shutter;
    assert_int_equal(weft_shutter_parse(&log_to_stderr, text, &shutter), WEFT_OK);
    return shutter;
}

static const char *const shutters[] = {"box",       "tent",       "gauss",   "gauss:0.1", "gauss:2",
                                       "0:1",       "0.5:0.5",    "0.2:0.7", "0:0",       "1:1",
                                       "0.25:0.75", "0.01:0.995", NULL};

static void test_shutter_texts(void **state)
{
    (void)state;
    const struct weft_shutter box = shutter_named("box"), tent = shutter_named("tent");
    const struct weft_shutter gauss = shutter_named("gauss:0.3"),
                              ramps = shutter_named("0.25:0.75");
    assert_true(box.open == 0.0 && box.close == 1.0 && tent.open == 0.5 && tent.close == 0.5);
    assert_true(gauss.shape == WEFT_SHUTTER_GAUSS && gauss.sigma == 0.3);
    assert_true(shutter_named("gauss").sigma == 0.2);
    assert_true(ramps.shape == WEFT_SHUTTER_RAMPS && ramps.open == 0.25 && ramps.close == 0.75);
    static const char *const wrong[][2] = {
        {"", "there are box, tent, gauss[:SIGMA] and OPEN:CLOSE"},
        {"boxes", "no shutter 'boxes'"},
        {"gauss:", "no shutter"},
        {"gauss:x", "no shutter"},
        {"gaussian", "no shutter"},
        {"0.5", "no shutter"},
        {"0.5:", "no shutter"},
        {"0.2:0.4:0.6", "no shutter"},
        {"0.7:0.3", "0.7 to 0.3"},
        {"-0.1:1", "-0.1 to 1"},
        {"0:1.5", "0 to 1.5"},
        {"gauss:0", "sigma is 0"},
        {"gauss:-1", "sigma is -1"},
        {"nan:1", "no shutter"},
        {"gauss:1e9", "sigma is 1e+09"},
    };
    for (size_t i = 0; i < WEFT_COUNT(wrong); i++) {
        struct weft_shutter out = {.open = 9.0};
        last.count = 0;
        assert_int_equal(weft_shutter_parse(&remember_log, wrong[i][0], &out), WEFT_ERR_ARGUMENT);
        assert_true(last.count == 1 && out.open == 0.0 && out.close == 1.0);
        if (!strstr(last.text, wrong[i][1]))
            fail_msg("'%s': '%s' lacks '%s'", wrong[i][0], last.text, wrong[i][1]);
    }
}

static void test_light(void **state)
{
    (void)state;
    const struct weft_shutter tent = shutter_named("tent"), ramps = shutter_named("0.2:0.7");
    const struct weft_shutter gauss = shutter_named("gauss:0.25");
    for (int i = 0; i <= 64; i++) {
        const double t = i / 64.0;
        assert_near(weft_shutter_light(&tent, t), 1.0 - fabs(2.0 * t - 1.0), 1e-15, "tent");
        assert_near(weft_shutter_light(&gauss, t), exp(-0.5 * pow((t - 0.5) / 0.25, 2.0)), 1e-15,
                    "gauss");
        assert_near(weft_shutter_light(&ramps, t), fmin(1.0, fmin(t / 0.2, (1.0 - t) / 0.3)), 1e-15,
                    "ramps");
    }
    const struct weft_shutter box = WEFT_SHUTTER_BOX;
    assert_true(weft_shutter_light(&box, 0.0) == 1.0 && weft_shutter_light(&box, 1.0) == 1.0);
    assert_true(weft_shutter_light(&box, -1e-9) == 0.0 && weft_shutter_light(&box, 1.1) == 0.0);
    const struct weft_shutter wrong[] = {{.open = 2.0, .close = 1.0},
                                         {.shape = WEFT_SHUTTER_GAUSS, .sigma = NAN},
                                         {.shape = WEFT_SHUTTER_SHAPE_COUNT, .close = 1.0}};
    for (size_t i = 0; i < WEFT_COUNT(wrong); i++)
        assert_true(isnan(weft_shutter_light(&wrong[i], 0.5)) &&
                    isnan(weft_shutter_share(&wrong[i], 0.5)));
    assert_true(isnan(weft_shutter_light(&box, NAN)) && isnan(weft_shutter_share(&box, NAN)));
}

// The share is the integral of the light: its differences are middles of the light, and its ends 0
// and 1. By hand: a tent has t^2 2 before the middle, 0.2:0.7 has 0.1 / 0.75 at 0.2.
static void test_share(void **state)
{
    (void)state;
    for (int s = 0; shutters[s]; s++) {
        const struct weft_shutter shutter = shutter_named(shutters[s]);
        enum { PARTS = 20000 };
        long double sum = 0.0L;
        for (int i = 0; i < PARTS; i++)
            sum += weft_shutter_light(&shutter, (i + 0.5) / PARTS);
        long double part = 0.0L;
        for (int i = 0; i < PARTS; i++) {
            assert_near(weft_shutter_share(&shutter, (double)i / PARTS), (double)(part / sum), 1e-8,
                        shutters[s]);
            part += weft_shutter_light(&shutter, (i + 0.5) / PARTS);
        }
        assert_true(weft_shutter_share(&shutter, 0.0) == 0.0);
        assert_near(weft_shutter_share(&shutter, 1.0), 1.0, 1e-16, shutters[s]);
        assert_true(weft_shutter_share(&shutter, -3.0) == 0.0);
    }
    const struct weft_shutter tent = shutter_named("tent"), ramps = shutter_named("0.2:0.7");
    assert_near(weft_shutter_share(&tent, 0.25), 0.125, 1e-16, "tent");
    assert_near(weft_shutter_share(&ramps, 0.2), 0.1 / 0.75, 1e-15, "ramps");
    assert_near(weft_shutter_share(&ramps, 0.7), 0.6 / 0.75, 1e-15, "ramps");
}

// What the header says of the middles of parts, in shares of all light.
static double middle_error(const struct weft_shutter *s, int n)
{
    if (s->shape == WEFT_SHUTTER_GAUSS) {
        const double whole = s->sigma * sqrt(2.0 * M_PI) * erf(0.5 / (s->sigma * M_SQRT2));
        return 2.0 / whole / (24.0 * s->sigma * s->sigma * n * n);
    }
    const double rise = s->open > 0.0 ? 1.0 / s->open : 0.0;
    const double fall = s->close < 1.0 ? 1.0 / (1.0 - s->close) : 0.0;
    return 2.0 / (0.5 * (1.0 + s->close - s->open)) * (rise + fall) / (8.0 * n * n);
}

// A moving edge: where it has passed by time t, the frames so far are what is seen.
static void test_moving_edge(void **state)
{
    (void)state;
    int checked = 0;
    for (int s = 0; shutters[s]; s++)
        for (int n = 1; n <= 260; n += n < 20 ? 1 : 17) {
            const struct weft_shutter shutter = shutter_named(shutters[s]);
            double times[300], weights[300], seen = 0.0;
            struct weft_weights_report r;
            assert_int_equal(weft_shutter_weights(&log_to_stderr, &shutter, n, times, weights, &r),
                             WEFT_OK);
            check_report(weights, n, &r);
            const bool is_box = shutter.open == 0.0 && shutter.close == 1.0;
            const double bound = is_box ? 0.5 / n : 0.5 * r.largest + middle_error(&shutter, n);
            for (int k = 0; k < n; k++, checked++) {
                assert_near(times[k], (k + 0.5) / n, 1e-16, "time");
                // Just before frame k and just after it.
                const double share = weft_shutter_share(&shutter, times[k]);
                assert_near(seen, share, bound + 1e-14, shutters[s]);
                seen += weights[k];
                assert_near(seen, share, bound + 1e-14, shutters[s]);
            }
        }
    assert_true(checked > 20000);
}

static void test_shutter_errors(void **state)
{
    (void)state;
    const struct weft_shutter wrong = {.shape = 9}, box = WEFT_SHUTTER_BOX;
    double weights[4];
    struct weft_weights_report r;
    last.count = 0;
    assert_int_equal(weft_shutter_weights(&remember_log, &wrong, 4, NULL, weights, &r),
                     WEFT_ERR_ARGUMENT);
    assert_true(last.count == 1 && isnan(r.gain));
    assert_int_equal(weft_shutter_weights(&remember_log, &box, 0, NULL, weights, &r),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(last.count, 2);
    assert_int_equal(weft_shutter_weights(&remember_log, &box, 4, NULL, weights, NULL), WEFT_OK);
}

// ---- counts
// ---------------------------------------------------------------------------------------

static void test_counts(void **state)
{
    (void)state;
    assert_int_equal(weft_frames_for_motion(0.0), 1);
    assert_int_equal(weft_frames_for_motion(1.0), 1);
    assert_int_equal(weft_frames_for_motion(1.001), 2);
    assert_int_equal(weft_frames_for_motion(64.0), 64);
    // Copies lie a pixel apart at most, and would not with a frame less.
    for (double v = 1.5; v < 1000.0; v *= 1.07) {
        const double n = (double)weft_frames_for_motion(v);
        assert_true(v / n <= 1.0 && v / (n - 1.0) > 1.0);
        const double area = M_PI_4 * v * v, discs = (double)weft_frames_for_circle(v);
        assert_true(discs >= area && discs - 1.0 < area);
    }
    assert_int_equal(weft_frames_for_circle(0.0), 1);
    assert_int_equal(weft_frames_for_circle(1.0), 1);
    assert_int_equal(weft_frames_for_circle(8.0), 51);
    assert_int_equal(weft_frames_for_penumbra(20.2, 0.0), 21);
    assert_int_equal(weft_frames_for_penumbra(1e6, 0.0), 255);
    assert_int_equal(weft_frames_for_penumbra(1e6, 1.0 / 1023.0), 1023);
    assert_int_equal(weft_frames_for_penumbra(INFINITY, 0.3), 4);
    assert_int_equal(weft_frames_for_penumbra(0.2, 0.0), 1);
    const double bad[] = {NAN, -1.0, -INFINITY, INFINITY, 1e300};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        assert_int_equal(weft_frames_for_motion(bad[i]), -1);
        assert_int_equal(weft_frames_for_circle(bad[i]), -1);
    }
    assert_int_equal(weft_frames_for_penumbra(NAN, 0.1), -1);
    assert_int_equal(weft_frames_for_penumbra(5.0, NAN), -1);
    assert_int_equal(weft_frames_for_penumbra(5.0, -0.1), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_even),           cmocka_unit_test(test_box),
        cmocka_unit_test(test_kernels),        cmocka_unit_test(test_width),
        cmocka_unit_test(test_places),         cmocka_unit_test(test_edges),
        cmocka_unit_test(test_refused),        cmocka_unit_test(test_shutter_texts),
        cmocka_unit_test(test_own_weights),    cmocka_unit_test(test_light),
        cmocka_unit_test(test_share),          cmocka_unit_test(test_moving_edge),
        cmocka_unit_test(test_shutter_errors), cmocka_unit_test(test_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
