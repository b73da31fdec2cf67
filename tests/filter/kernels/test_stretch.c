// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "filter/analysis/analysis.h"
#include "filter/kernels/stretch.h"

enum { ROOM = 400 };

static const double scales[] = {1.0, 1.0000001, 1.5, 2.0, 2.7, 3.7, 16.0, 23.4};

static struct weft_kernel named(const char *text)
{
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_parse(NULL, text, &kernel), WEFT_OK);
    return kernel;
}

// Every tap whose weight is not 0 is there, and only a kernel whose weights add up to one is
// divided by their sum.
static void weights_are_of_the_stretched_kernel(void **state)
{
    (void)state;
    static const char *const names[] = {"linear", "catmull-rom", "bspline3", "lanczos:3",
                                        "hann-sinc:3"};
    double weights[ROOM];
    int compared = 0;
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        const struct weft_kernel kernel = named(names[n]);
        for (size_t s = 0; s < sizeof scales / sizeof *scales; s++) {
            const double scale = scales[s];
            const int width = (int)weft_stretch_width(&kernel, scale);
            assert_in_range(width, 1, ROOM);
            for (double x = -7.0; x < 7.0; x += 0.171875) {
                const int first = (int)weft_stretch_weights(&kernel, scale, x, weights);
                double sum = 0.0;
                for (int j = first - 3; j < first + width + 3; j++)
                    sum += weft_kernel_weight(&kernel, (x - j) / scale);
                const double divisor = kernel.unit_sum ? sum : scale;
                for (int j = first - 3; j < first + width + 3; j++) {
                    const bool in = j >= first && j < first + width;
                    const double w = weft_kernel_weight(&kernel, (x - j) / scale) / divisor;
                    assert_true(fabs((in ? weights[j - first] : 0.0) - w) <= 1e-14);
                    compared++;
                }
            }
        }
    }
    assert_true(compared > 10000);
}

// One tap: how much of each sample's square lies within the stretched box.
static void boxes_are_area_averages(void **state)
{
    (void)state;
    const struct weft_kernel box = named("nearest");
    double weights[ROOM];
    for (size_t s = 1; s < sizeof scales / sizeof *scales; s++) {
        const int width = (int)weft_stretch_width(&box, scales[s]);
        for (double x = -3.0; x < 3.0; x += 0.09375) {
            const int first = (int)weft_stretch_weights(&box, scales[s], x, weights);
            double sum = 0.0, mean = 0.0;
            for (int i = 0; i < width; i++) {
                assert_true(weights[i] >= 0.0 && weights[i] <= 1.0 / scales[s] + 1e-15);
                sum += weights[i];
                mean += weights[i] * (first + i);
            }
            assert_true(fabs(sum - 1.0) < 1e-13);
            // The box's middle, but for what whole samples at its ends make of that.
            assert_true(fabs(mean - x) <= 0.25 / scales[s] + 1e-12);
        }
    }
    const int first = (int)weft_stretch_weights(&box, 2.5, 1.0, weights);
    assert_int_equal(first, 0);
    assert_true(weights[0] == 0.3 && weights[1] == 0.4 && weights[2] == 0.3);
}

// A wave at the pixels' Nyquist frequency is weakened by what the kernel's response says there, up
// to the images of it that sampling the stretched kernel lets in, which fall with the scale.
static void waves_are_weakened_by_the_response(void **state)
{
    (void)state;
    const struct weft_kernel kernel = named("catmull-rom");
    double weights[ROOM];
    const double scale = 16.0;
    const double response = weft_analysis_response(&kernel, 0.5).re;
    const int width = (int)weft_stretch_width(&kernel, scale);
    const int first = (int)weft_stretch_weights(&kernel, scale, 0.0, weights);
    double sum = 0.0;
    for (int i = 0; i < width; i++)
        sum += weights[i] * cos(2.0 * acos(-1.0) * 0.5 / scale * (first + i));
    assert_true(fabs(sum - response) < 1e-4);
}

// The slope of a line comes out, whatever the scale.
static void derivatives_stay_derivatives(void **state)
{
    (void)state;
    const struct weft_kernel kernel = named("d-bspline3");
    double weights[ROOM];
    for (double scale = 1.0; scale <= 16.0; scale *= 2.0) {
        const int width = (int)weft_stretch_width(&kernel, scale);
        const int first = (int)weft_stretch_weights(&kernel, scale, 0.25, weights);
        double slope = 0.0;
        for (int i = 0; i < width; i++)
            slope += weights[i] * 3.0 * (first + i);
        assert_true(fabs(slope - 3.0) < 1e-9);
    }
}

// The nearest sample is what it is; the same box as an area average is stretched.
static void samples_that_are_moved_are_not_stretched(void **state)
{
    (void)state;
    const struct weft_kernel nearest = named("nearest"), area = named("area");
    assert_true(weft_stretch_scale(&nearest, 3.7) == 1.0 && weft_stretch_scale(&area, 3.7) == 3.7);
    assert_true(weft_stretch_scale(&area, 0.5) == 1.0 && weft_stretch_scale(&area, NAN) == 1.0);
    assert_true(weft_stretch_scale(&area, INFINITY) == WEFT_STRETCH_MAX);
    assert_true(weft_stretch_scale(NULL, 2.0) == 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_are_of_the_stretched_kernel),
        cmocka_unit_test(boxes_are_area_averages),
        cmocka_unit_test(waves_are_weakened_by_the_response),
        cmocka_unit_test(derivatives_stay_derivatives),
        cmocka_unit_test(samples_that_are_moved_are_not_stretched),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
