// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/prefilter.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "filter/analysis/analysis.h"
#include "filter/analysis/error.h"
#include "filter/analysis/reference.h"

static const char *const splines[] = {"bspline2i", "bspline3i", "bspline4i", "bspline5i",
                                      "bspline6i", "bspline7i", "omomsi",    "bsplinei"};

static struct weft_prefilter prefilter_named(const char *name)
{
    const struct weft_kernel kernel = kernel_named(name);
    struct weft_prefilter prefilter;
    assert_int_equal(weft_prefilter_compute(&log_to_stderr, &kernel, &prefilter), WEFT_OK);
    return prefilter;
}

// A repeatable value in [-1, 1].
static double noise(int64_t i)
{
    uint64_t h = (uint64_t)i * UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)(h >> 11) * 0x1p-52 - 1.0;
}

// ---- names --------------------------------------------------------------------------------------

static void names_are_read_and_written(void **state)
{
    (void)state;
    static const char *const names[] = {"bspline3i", "d-bspline3i", "dd-bspline5i",
                                        "omomsi",    "d-omomsi",    "bsplinei"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        const struct weft_kernel kernel = kernel_named(names[i]);
        char text[64];
        assert_true(kernel.prefiltered && !kernel.interpolating);
        weft_kernel_format(&kernel, text, sizeof text);
        assert_string_equal(text, names[i]);
    }
    assert_true(kernel_named("bspline3i+unit").prefiltered);
    assert_false(kernel_named("bspline3i+unit").normalised);
    assert_false(kernel_named("bspline3").prefiltered);
    assert_int_equal(kernel_named("bspline3i").order, 4);
    assert_int_equal(kernel_named("bspline3").order, 2);
}

static void other_kernels_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } cases[] = {
        {"mitchelli", "bspline7i, omomsi"}, {"lineari", "bspline2i,"},
        {"bspline1i", "bspline2i,"},        {"catmull-romi", "bspline2i,"},
        {"cubici:1,0", "bspline2i,"},       {"lagrange3i", "bspline2i,"},
        {"bspline3i+radial", "radial"},     {"i", "no kernel"},
        {"bspline3ii", "no kernel"},        {"bspline3i:1", "takes no parameters"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_kernel kernel;
        assert_int_equal(weft_kernel_parse(&log, cases[i].name, &kernel), WEFT_ERR_ARGUMENT);
        if (message.count != 1 || !strstr(message.text, cases[i].text))
            fail_msg("%s: '%s'", cases[i].name, message.text);
    }
    struct weft_kernel radial = kernel_named("bspline3+radial"), linear = kernel_named("linear");
    struct weft_prefilter prefilter;
    assert_int_equal(weft_kernel_make_prefiltered(NULL, &radial), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_prefilter_compute(NULL, &linear, &prefilter), WEFT_ERR_ARGUMENT);
}

static void derivatives_stay_prefiltered(void **state)
{
    (void)state;
    const struct weft_kernel kernel = kernel_named("bspline5i");
    struct weft_kernel derived;
    assert_int_equal(weft_kernel_derive(NULL, &kernel, &derived), WEFT_OK);
    assert_string_equal(derived.info->name, "d-bspline5");
    assert_true(derived.prefiltered);
    assert_int_equal(derived.order, 5);
}

// ---- the filter ---------------------------------------------------------------------------------

// Unser, IEEE Signal Processing Magazine 1999, box 2, and Thevenaz, Blu and Unser, IEEE TMI 2000.
static void poles_are_the_published_ones(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double pole[3], tolerance;
    } cases[] = {
        {"bspline2i", {-0.17157287525380990}, 1e-15}, // 2 sqrt(2) - 3
        {"bspline3i", {-0.26794919243112271}, 1e-15}, // sqrt(3) - 2
        {"bspline4i", {-0.361341, -0.0137254}, 5e-7},
        {"bspline5i", {-0.430575, -0.0430963}, 5e-7},
        {"bspline6i", {-0.488295, -0.0816793, -0.00141415}, 5e-7},
        {"bspline7i", {-0.535280, -0.122555, -0.00914869}, 5e-7},
        {"omomsi", {-0.34413115425505}, 1e-14}, // (sqrt(105) - 13) / 8
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_prefilter p = prefilter_named(cases[i].name);
        for (int n = 0; n < 3; n++)
            assert_near(p.pole[n], cases[i].pole[n], cases[i].tolerance, cases[i].name);
    }
}

static void gains_and_overlaps_are_those_of_the_taps(void **state)
{
    (void)state;
    assert_near(prefilter_named("bspline3i").gain, 3.0, 1e-14, "cubic");
    assert_near(prefilter_named("bspline5i").gain, 7.5, 1e-13, "quintic");
    const struct weft_prefilter cubic = prefilter_named("bspline3i");
    assert_int_equal(weft_prefilter_overlap(&cubic, 0x1p-24), 13);
    for (size_t i = 0; i < WEFT_COUNT(splines); i++) {
        const struct weft_prefilter p = prefilter_named(splines[i]);
        double taps[WEFT_PREFILTER_MAX_OVERLAP + 1], sum = 0.0;
        weft_prefilter_taps(&p, WEFT_PREFILTER_MAX_OVERLAP, taps);
        for (int k = WEFT_PREFILTER_MAX_OVERLAP; k >= 0; k--)
            sum += (k ? 2.0 : 1.0) * fabs(taps[k]);
        assert_near(sum, p.gain, 1e-12 * p.gain, splines[i]);
        const int overlap = weft_prefilter_overlap(&p, 0x1p-24);
        double rest = 0.0;
        for (int k = WEFT_PREFILTER_MAX_OVERLAP; k > overlap; k--)
            rest += 2.0 * fabs(taps[k]);
        assert_true(rest <= 0x1p-24 && rest + 2.0 * fabs(taps[overlap]) > 0x1p-24);
        assert_true(weft_prefilter_overlap(&p, 0x1p-80) < WEFT_PREFILTER_MAX_OVERLAP);
    }
}

enum { COUNT = 41, ROOM = 400, LINE = COUNT + 2 * ROOM };

static double extended(int k, double before, double after)
{
    if (k < 0)
        return isnan(before) ? noise(0) : before;
    return k < COUNT ? noise(k) : isnan(after) ? noise(COUNT - 1) : after;
}

// Against the impulse response over a signal so much longer that its ends do not matter.
static void lines_are_exact_for_the_infinite_signal(void **state)
{
    (void)state;
    static const double values[][2] = {{NAN, NAN}, {0.0, 0.0}, {3.5, NAN}, {NAN, -1e3}};
    static const int counts[] = {1, 2, 3, COUNT};
    for (size_t s = 0; s < WEFT_COUNT(splines); s++) {
        const struct weft_prefilter p = prefilter_named(splines[s]);
        for (size_t e = 0; e < WEFT_COUNT(values); e++) {
            double before = values[e][0], after = values[e][1];
            double line[COUNT * 3];
            const int stride = e % 2 ? 3 : 1;
            for (int k = 0; k < COUNT; k++)
                line[k * stride] = noise(k);
            weft_prefilter_line(&p, line, COUNT, stride, before, after);
            for (int k = 0; k < COUNT; k++) {
                double sum = 0.0;
                for (int l = ROOM; l >= -ROOM; l--)
                    for (int i = 0; i < p.poles; i++)
                        sum +=
                            p.factor[i] * pow(p.pole[i], abs(l)) * extended(k + l, before, after);
                assert_near(line[k * stride], sum, 1e-11 * fmax(1.0, fabs(after)), splines[s]);
            }
        }
        for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
            double line[COUNT];
            for (int k = 0; k < counts[c]; k++)
                line[k] = 0.1;
            weft_prefilter_line(&p, line, (size_t)counts[c], 1, NAN, NAN);
            for (int k = 0; k < counts[c]; k++)
                assert_near(line[k], 0.1, 1e-15 * p.gain, "constant");
        }
        weft_prefilter_line(&p, NULL, 0, 1, NAN, NAN);
    }
}

// ---- interpolation ------------------------------------------------------------------------------

struct lattice {
    int dims, size[3];
    double *values;
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct lattice *l = priv;
    size_t at = 0;
    for (int a = 2; a >= 0; a--) {
        const int64_t i = index[a] < 0 ? 0 : index[a] >= l->size[a] ? l->size[a] - 1 : index[a];
        at = at * (size_t)l->size[a] + (size_t)i;
    }
    return l->values[at];
}

static void filter_lattice(const struct weft_prefilter *p, struct lattice *l)
{
    const ptrdiff_t stride[3] = {1, l->size[0], (ptrdiff_t)l->size[0] * l->size[1]};
    for (int a = 0; a < l->dims; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (int i = 0; i < l->size[b]; i++)
            for (int j = 0; j < l->size[c]; j++)
                weft_prefilter_line(p, l->values + i * stride[b] + j * stride[c],
                                    (size_t)l->size[a], stride[a], NAN, NAN);
    }
}

static void coefficients_interpolate_in_every_dimension(void **state)
{
    (void)state;
    enum { SIDE = 21 };
    static double values[SIDE * SIDE * SIDE];
    for (size_t s = 0; s < WEFT_COUNT(splines); s++) {
        const struct weft_kernel kernel = kernel_named(splines[s]);
        const struct weft_prefilter p = prefilter_named(splines[s]);
        for (int dims = 1; dims <= 3; dims++) {
            struct lattice l = {dims, {SIDE, dims > 1 ? SIDE : 1, dims > 2 ? SIDE : 1}, values};
            const int count = l.size[0] * l.size[1] * l.size[2];
            for (int i = 0; i < count; i++)
                values[i] = noise(i);
            filter_lattice(&p, &l);
            for (int i = 0; i < count; i++) {
                const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
                bool inside = true; // past the ends the coefficients would be needed
                for (int a = 0; a < dims; a++)
                    inside = inside && at[a] >= 4 && at[a] < SIDE - 4;
                if (!inside)
                    continue;
                const double position[3] = {at[0], at[1], at[2]};
                assert_near(weft_reference_compute(&kernel, dims, position, fetch, &l).value,
                            noise(i), 1e-12, splines[s]);
            }
        }
    }
}

static void cardinal_weights_are_the_filter_and_the_kernel(void **state)
{
    (void)state;
    enum { OVERLAP = 80, CENTRE = 100, LENGTH = 2 * CENTRE + 1 };
    static const char *const names[] = {"bspline2i", "bspline3i",   "bspline7i",
                                        "omomsi",    "d-bspline3i", "dd-bspline5i"};
    for (size_t s = 0; s < WEFT_COUNT(names); s++) {
        const struct weft_kernel kernel = kernel_named(names[s]);
        const struct weft_prefilter p = prefilter_named(names[s]);
        double line[LENGTH];
        for (int k = 0; k < LENGTH; k++)
            line[k] = noise(k);
        weft_prefilter_line(&p, line, LENGTH, 1, NAN, NAN);
        for (int i = 0; i < 20; i++) {
            const double x = CENTRE + 0.37 * i - 3.0;
            double weights[WEFT_PREFILTER_MAX_WEIGHTS], plain[WEFT_KERNEL_MAX_WIDTH];
            const int64_t from = weft_kernel_weights(&kernel, x, plain);
            const int64_t first = weft_prefilter_weights(&p, &kernel, OVERLAP, x, weights);
            double direct = 0.0, filtered = 0.0;
            for (int j = 0; j < kernel.width + 2 * OVERLAP; j++)
                direct += weights[j] * noise(first + j);
            for (int j = 0; j < kernel.width; j++)
                filtered += plain[j] * line[from + j];
            assert_near(direct, filtered, 1e-13 * p.gain, names[s]);
        }
    }
    // At a sample the cardinal spline is 1 there and 0 at all others.
    const struct weft_kernel kernel = kernel_named("bspline5i");
    const struct weft_prefilter p = prefilter_named("bspline5i");
    double weights[WEFT_PREFILTER_MAX_WEIGHTS];
    const int64_t first = weft_prefilter_weights(&p, &kernel, OVERLAP, 7.0, weights);
    for (int j = 0; j < kernel.width + 2 * OVERLAP; j++)
        assert_near(weights[j], first + j == 7, 1e-15, "cardinal");
}

// ---- accuracy -----------------------------------------------------------------------------------

static double interpolate(const struct weft_kernel *kernel, const struct weft_prefilter *p,
                          double (*f)(const void *priv, double x), const void *priv, double x)
{
    double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
    const int overlap = weft_prefilter_overlap(p, 0x1p-80);
    const int64_t first = weft_prefilter_weights(p, kernel, overlap, x, weights);
    for (int j = 0; j < kernel->width + 2 * overlap; j++)
        sum += weights[j] * f(priv, (double)(first + j));
    return sum;
}

static double power(const void *priv, double x)
{
    return pow(x, *(const int *)priv);
}

static void polynomials_are_reproduced(void **state)
{
    (void)state;
    for (size_t s = 0; s < WEFT_COUNT(splines); s++) {
        const struct weft_kernel kernel = kernel_named(splines[s]);
        const struct weft_prefilter p = prefilter_named(splines[s]);
        for (int n = 0; n < kernel.order; n++)
            for (double x = -2.0; x < 2.0; x += 0.17)
                assert_near(interpolate(&kernel, &p, power, &n, x), pow(x, n), n < 4 ? 1e-11 : 1e-8,
                            splines[s]);
    }
}

static double wave(const void *priv, double x)
{
    return sin(*(const double *)priv * x + 0.4);
}

static double wave_error(const struct weft_kernel *kernel, double frequency)
{
    const struct weft_prefilter p = prefilter_named(kernel->info->name);
    double largest = 0.0;
    for (int i = 0; i < 2000; i++) {
        const double x = 0.0617 * i;
        largest = larger(largest,
                         fabs(interpolate(kernel, &p, wave, &frequency, x) - wave(&frequency, x)));
    }
    return largest;
}

// Halving the sample distance divides the error by 2^order; E1 is its leading term, which the next
// one adds to.
static void errors_fall_with_the_order(void **state)
{
    (void)state;
    for (size_t s = 0; s < WEFT_COUNT(splines); s++) {
        const struct weft_kernel kernel = kernel_named(splines[s]);
        const double frequency = 0.2, error = wave_error(&kernel, frequency);
        const double observed = log2(error / wave_error(&kernel, 0.5 * frequency));
        const double bound = weft_error_e1(&kernel, 1, pow(frequency, kernel.order));
        if (!(fabs(observed - kernel.order) < 0.1))
            fail_msg("%s: observed order %.3f instead of %d", splines[s], observed, kernel.order);
        if (!(error <= 1.1 * bound && error >= 0.5 * bound))
            fail_msg("%s: E1 is %.4g, measured %.4g", splines[s], bound, error);
    }
}

// By root mean square, against what `weft kernel` says of the interpolator; the least error in the
// space of the kernel's shifts, which another prefilter would have, is less.
static void errors_have_the_interpolators_constant(void **state)
{
    (void)state;
    for (size_t s = 0; s < WEFT_COUNT(splines); s++) {
        const struct weft_kernel kernel = kernel_named(splines[s]);
        struct weft_kernel plain = kernel;
        plain.prefiltered = false;
        const struct weft_prefilter p = prefilter_named(splines[s]);
        const double frequency = 0.05;
        double squares = 0.0;
        enum { POINTS = 5000 };
        for (int i = 0; i < POINTS; i++) {
            const double x = 0.0617 * i;
            const double error =
                interpolate(&kernel, &p, wave, &frequency, x) - wave(&frequency, x);
            squares += error * error;
        }
        const double constant = sqrt(2.0 * squares / POINTS) / pow(frequency, kernel.order);
        const struct weft_analysis_order order = weft_analysis_order(&kernel);
        // The next term is relatively about order frequency^2; roundings count at high orders.
        if (kernel.order < 7)
            assert_near(constant / order.constant, 1.0, 0.03, splines[s]);
        // Of odd orders the mean of a_N(t) is 0 by symmetry, and both are the same.
        const double least = weft_analysis_order(&plain).prefiltered_constant;
        assert_true(least <= (kernel.order % 2 ? 1.0001 : 0.99) * order.constant);
    }
}

static void the_analysis_is_of_the_cardinal_spline(void **state)
{
    (void)state;
    static const char *const names[] = {"bspline3i", "bspline7i", "omomsi", "d-bspline4i",
                                        "dd-bspline5i"};
    for (size_t s = 0; s < WEFT_COUNT(names); s++) {
        const struct weft_kernel kernel = kernel_named(names[s]);
        const struct weft_prefilter p = prefilter_named(names[s]);
        assert_int_equal(weft_analysis_order(&kernel).order, kernel.order);
        const int overlap = weft_prefilter_overlap(&p, 0x1p-80);
        for (int n = 0; n < 7; n++) {
            double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0, size = 0.0;
            const int64_t first = weft_prefilter_weights(&p, &kernel, overlap, 0.3, weights);
            for (int j = 0; j < kernel.width + 2 * overlap; j++) {
                const double term =
                    weights[j] * pow((double)(first + j) - 0.3, n) / tgamma(n + 1.0);
                sum += term;
                size += fabs(term);
            }
            assert_near(weft_analysis_taylor(&kernel, n, 0.3), sum, 1e-12 * (1.0 + size), names[s]);
        }
    }
    // The cardinal cubic: 1/384 is its constant (de Boor, A Practical Guide to Splines).
    const struct weft_kernel cubic = kernel_named("bspline3i");
    assert_near(weft_analysis_order(&cubic).largest, 1.0 / 384.0, 1e-8, "cubic");
    assert_near(weft_analysis_moment(&cubic, 0), 1.0, 1e-12, "integral");
    assert_near(weft_analysis_moment(&cubic, 2), 0.0, 1e-12, "second moment");
    // B(1/2) = 1/3, and the plain spline's response there is (2/pi)^4.
    assert_near(weft_analysis_response(&cubic, 0.5).re, 3.0 * pow(M_2_PI, 4.0), 1e-12, "Nyquist");
    const struct weft_analysis_metrics m = weft_analysis_metrics(&cubic, 1);
    assert_true(m.smoothing > 0.0 && m.smoothing < 0.2 && m.postaliasing > 0.0);
    assert_near(weft_analysis_gain(&cubic), 1.54904, 1e-4, "Lebesgue constant");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_read_and_written),
        cmocka_unit_test(other_kernels_are_refused),
        cmocka_unit_test(derivatives_stay_prefiltered),
        cmocka_unit_test(poles_are_the_published_ones),
        cmocka_unit_test(gains_and_overlaps_are_those_of_the_taps),
        cmocka_unit_test(lines_are_exact_for_the_infinite_signal),
        cmocka_unit_test(coefficients_interpolate_in_every_dimension),
        cmocka_unit_test(cardinal_weights_are_the_filter_and_the_kernel),
        cmocka_unit_test(polynomials_are_reproduced),
        cmocka_unit_test(errors_fall_with_the_order),
        cmocka_unit_test(errors_have_the_interpolators_constant),
        cmocka_unit_test(the_analysis_is_of_the_cardinal_spline),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
