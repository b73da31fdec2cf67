// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/fixed.h"
#include "filter/analysis/analysis.h"
#include "filter/check.h"
#include "filter/analysis/error.h"

// Sanitizers make the 3D cells ten times as slow; they see all of the code in the smaller ones.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { LARGEST_3D = 16 };
#else
enum { LARGEST_3D = 512 };
#endif

struct cell {
    const char *kernel;
    int dims, samples;
    double nearest, linear;
};

// Eq. 4 by its definition, 255 eps_h to six digits, from an independent calculation.
static const struct cell eq4_cells[] = {
    {"bspline", 2, 16, 18.7940, 13.2924},
    {"bspline", 2, 32, 11.2295, 8.29239},
    {"bspline", 2, 64, 8.13762, 4.82148},
    {"bspline", 2, 128, 6.35383, 4.87170},
    {"bspline", 2, 256, 5.87064, 5.06577},
    {"bspline", 2, 512, 5.83264, 4.95764},
    {"bspline", 3, 16, 27.1512, 21.2672},
    {"bspline", 3, 32, 19.0513, 14.3167},
    {"bspline", 3, 64, 15.8662, 12.3536},
    {"bspline", 3, 128, 14.3937, 12.1622},
    {"catmull-rom", 2, 16, 41.5478, 16.7507},
    {"catmull-rom", 2, 32, 21.8420, 7.75128},
    {"catmull-rom", 2, 64, 12.9523, 5.46320},
    {"catmull-rom", 2, 128, 9.26111, 5.67027},
    {"catmull-rom", 2, 256, 7.74719, 5.91264},
    {"catmull-rom", 2, 512, 6.72206, 5.55799},
    {"catmull-rom", 3, 16, 66.6172, 24.5001},
    {"catmull-rom", 3, 32, 40.2265, 19.0043},
    {"catmull-rom", 3, 64, 30.9758, 18.4411},
    {"catmull-rom", 3, 128, 25.2560, 20.8342},
    {"blackman-sinc:2", 2, 16, 34.0436, 10.8304},
    {"blackman-sinc:2", 2, 32, 19.0200, 5.33863},
    {"blackman-sinc:2", 2, 64, 11.3554, 4.65550},
    {"blackman-sinc:2", 2, 128, 7.73430, 4.53421},
    {"blackman-sinc:2", 2, 256, 6.20425, 4.58555},
    {"blackman-sinc:2", 2, 512, 5.36876, 4.34126},
    {"blackman-sinc:2", 3, 16, 43.0182, 15.9776},
    {"blackman-sinc:2", 3, 32, 26.4641, 10.5560},
    {"blackman-sinc:2", 3, 64, 17.6446, 10.8734},
    {"blackman-sinc:2", 3, 128, 14.1773, 10.3482},
    {"kaiser-sinc:2,5.36", 2, 16, 37.8846, 16.7409},
    {"kaiser-sinc:2,5.36", 2, 32, 20.8197, 7.74141},
    {"kaiser-sinc:2,5.36", 2, 64, 13.0929, 5.34479},
    {"kaiser-sinc:2,5.36", 2, 128, 8.91964, 5.79593},
    {"kaiser-sinc:2,5.36", 2, 256, 7.84444, 6.10891},
    {"kaiser-sinc:2,5.36", 2, 512, 7.27900, 6.03234},
    {"kaiser-sinc:2,5.36", 3, 16, 59.0190, 24.4434},
    {"kaiser-sinc:2,5.36", 3, 32, 34.5577, 14.5824},
    {"kaiser-sinc:2,5.36", 3, 64, 24.6135, 14.8063},
    {"kaiser-sinc:2,5.36", 3, 128, 19.6786, 15.0784},
};

// The recovered conventions of table 1, 256 eps_h: what an independent calculation gives, which is
// the printed value to 0.01 % in 53 of the 60 cells.
static const struct cell wscg2003_cells[] = {
    {"bspline", 2, 16, 11.2350, 5.5804},
    {"bspline", 2, 32, 6.1618, 3.9218},
    {"bspline", 2, 64, 3.8836, 3.1834},
    {"bspline", 2, 128, 2.8294, 2.5841},
    {"bspline", 2, 256, 2.3144, 2.2677},
    {"bspline", 2, 512, 2.0866, 2.0866},
    {"bspline", 3, 16, 12.3400, 6.4790},
    {"bspline", 3, 32, 7.1811, 5.1686},
    {"bspline", 3, 64, 5.0478, 4.6428},
    {"bspline", 3, 128, 4.4375, 4.0927},
    {"catmull-rom", 2, 16, 25.3076, 15.0835},
    {"catmull-rom", 2, 32, 14.4101, 10.8904},
    {"catmull-rom", 2, 64, 8.7092, 8.3325},
    {"catmull-rom", 2, 128, 6.0308, 7.1139},
    {"catmull-rom", 2, 256, 4.9058, 6.7169},
    {"catmull-rom", 2, 512, 4.3536, 6.3614},
    {"catmull-rom", 3, 16, 32.6553, 19.0220},
    {"catmull-rom", 3, 32, 17.8090, 14.3187},
    {"catmull-rom", 3, 64, 11.2477, 11.9767},
    {"catmull-rom", 3, 128, 8.1040, 10.5024},
    {"kaiser-sinc:2,5.36", 2, 16, 26.3035, 15.4278},
    {"kaiser-sinc:2,5.36", 2, 32, 14.3231, 10.7961},
    {"kaiser-sinc:2,5.36", 2, 64, 8.8159, 8.3061},
    {"kaiser-sinc:2,5.36", 2, 128, 6.0954, 7.2064},
    {"kaiser-sinc:2,5.36", 2, 256, 4.9425, 6.6605},
    {"kaiser-sinc:2,5.36", 2, 512, 4.3151, 6.3229},
    {"kaiser-sinc:2,5.36", 3, 16, 34.0124, 20.0338},
    {"kaiser-sinc:2,5.36", 3, 32, 17.9082, 14.7746},
    {"kaiser-sinc:2,5.36", 3, 64, 11.4054, 12.1154},
    {"kaiser-sinc:2,5.36", 3, 128, 8.1721, 10.6158},
};

// As printed in table 1 ("Blackman sinc" is a Kaiser window).
static const struct cell printed_cells[] = {
    {"bspline", 2, 16, 11.2351, 5.5803},
    {"bspline", 2, 32, 6.1619, 3.9219},
    {"bspline", 2, 64, 3.8838, 3.3165},
    {"bspline", 2, 128, 2.8293, 2.5841},
    {"bspline", 2, 256, 2.3145, 2.2676},
    {"bspline", 2, 512, 2.0867, 2.0867},
    {"bspline", 3, 16, 12.3400, 7.2346},
    {"bspline", 3, 32, 7.1811, 5.4758},
    {"bspline", 3, 64, 5.0478, 7.0751},
    {"bspline", 3, 128, 4.4375, 4.1687},
    {"catmull-rom", 2, 16, 25.3076, 15.0835},
    {"catmull-rom", 2, 32, 14.4100, 10.8905},
    {"catmull-rom", 2, 64, 8.7091, 8.3325},
    {"catmull-rom", 2, 128, 6.0308, 7.1140},
    {"catmull-rom", 2, 256, 4.9057, 6.7169},
    {"catmull-rom", 2, 512, 4.3535, 6.3613},
    {"catmull-rom", 3, 16, 32.6554, 19.1470},
    {"catmull-rom", 3, 32, 17.8089, 14.3186},
    {"catmull-rom", 3, 64, 11.2476, 11.9767},
    {"catmull-rom", 3, 128, 8.1039, 10.5024},
    {"kaiser-sinc:2,5.36", 2, 16, 26.3035, 15.4278},
    {"kaiser-sinc:2,5.36", 2, 32, 14.3229, 10.7960},
    {"kaiser-sinc:2,5.36", 2, 64, 8.8159, 8.3062},
    {"kaiser-sinc:2,5.36", 2, 128, 6.0954, 7.2064},
    {"kaiser-sinc:2,5.36", 2, 256, 4.9426, 6.6606},
    {"kaiser-sinc:2,5.36", 2, 512, 4.3151, 6.3229},
    {"kaiser-sinc:2,5.36", 3, 16, 34.0124, 20.0338},
    {"kaiser-sinc:2,5.36", 3, 32, 17.9082, 14.7748},
    {"kaiser-sinc:2,5.36", 3, 64, 11.4056, 12.0028},
    {"kaiser-sinc:2,5.36", 3, 128, 8.1723, 10.6158},
};

static double scaled_maximum(const struct cell *cell, enum weft_error_convention convention,
                             enum weft_error_lookup lookup)
{
    const struct weft_error_kernel_params params = {
        .kernel = kernel_named(cell->kernel),
        .dims = cell->dims,
        .samples = cell->samples,
        .lookup = lookup,
        .convention = convention,
    };
    struct weft_error_kernel error;
    assert_int_equal(weft_error_kernel_compute(&params, &error), WEFT_OK);
    assert_true(error.mean <= error.rms && error.rms <= error.maximum);
    assert_true(error.median <= error.percentile_90 && error.percentile_90 <= error.percentile_99 &&
                error.percentile_99 <= error.maximum);
    assert_true(error.signed_min <= error.signed_mean && error.signed_mean <= error.signed_max);
    return error.maximum * error.scale;
}

static void tell_what_is_skipped(void)
{
    if (LARGEST_3D < 512)
        print_message("[  SKIPPED ] 3D cells above M = %d: sanitizer build\n", LARGEST_3D);
}

static void test_eq4(void **state)
{
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(eq4_cells); i++) {
        const struct cell *c = &eq4_cells[i];
        if (c->dims == 3 && c->samples > LARGEST_3D)
            continue;
        // Half a unit of the sixth digit.
        const double near = scaled_maximum(c, WEFT_ERROR_EQ4, WEFT_ERROR_NEAREST);
        assert_near(near, c->nearest, c->nearest < 10.0 ? 0.51e-5 : 0.51e-4, c->kernel);
        const double linear = scaled_maximum(c, WEFT_ERROR_EQ4, WEFT_ERROR_LINEAR);
        assert_near(linear, c->linear, c->linear < 10.0 ? 0.51e-5 : 0.51e-4, c->kernel);
    }
    tell_what_is_skipped();
}

static void test_wscg2003(void **state)
{
    int agreeing = 0;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(wscg2003_cells); i++) {
        const struct cell *c = &wscg2003_cells[i], *printed = &printed_cells[i];
        if (c->dims == 3 && c->samples > LARGEST_3D)
            continue;
        const double near = scaled_maximum(c, WEFT_ERROR_WSCG2003, WEFT_ERROR_NEAREST);
        const double linear = scaled_maximum(c, WEFT_ERROR_WSCG2003, WEFT_ERROR_LINEAR);
        assert_near(near, c->nearest, 1e-4, c->kernel);
        assert_near(linear, c->linear, 1e-4, c->kernel);
        agreeing += fabs(near / printed->nearest - 1.0) < 1e-4;
        agreeing += fabs(linear / printed->linear - 1.0) < 1e-4;
    }
    tell_what_is_skipped();
    if (LARGEST_3D >= 512)
        assert_int_equal(agreeing, 53);
}

// ---- against the plainest possible program ----

struct plain {
    struct weft_error_kernel_params p;
    double *magnitudes;
    size_t count;
    double sum, squares, signed_sum, signed_min, signed_max, maximum, single;
};

static double axis_weight(const struct plain *s, double u, int j)
{
    return weft_kernel_weight(&s->p.kernel, u + weft_kernel_offset(&s->p.kernel) - j);
}

static double tile_value(const struct plain *s, const int texel[3], const int tap[3])
{
    double product = 1.0;
    for (int d = 0; d < s->p.dims; d++) {
        const int k = texel[d] < 0 ? 0 : texel[d] >= s->p.samples ? s->p.samples - 1 : texel[d];
        product *= axis_weight(s, (k + 0.5) / s->p.samples, tap[d]);
    }
    return fixed_value(fixed_quantise(product, s->p.bits, s->p.rounding), s->p.bits);
}

static double looked_up(const struct plain *s, const double u[3], const int tap[3])
{
    int texel[3] = {0};
    double fraction[3] = {0}, value = 0.0;
    for (int d = 0; d < s->p.dims; d++) {
        const double at = u[d] * s->p.samples - (s->p.lookup == WEFT_ERROR_LINEAR ? 0.5 : 0.0);
        texel[d] = (int)floor(at);
        fraction[d] = at - texel[d];
    }
    if (s->p.lookup == WEFT_ERROR_NEAREST)
        return tile_value(s, texel, tap);
    for (int corner = 0; corner < 1 << s->p.dims; corner++) {
        int k[3];
        double share = 1.0;
        for (int d = 0; d < s->p.dims; d++) {
            k[d] = texel[d] + (corner >> d & 1);
            share *= corner >> d & 1 ? fraction[d] : 1.0 - fraction[d];
        }
        value += share * tile_value(s, k, tap);
    }
    return value;
}

static void plain_location(struct plain *s, const double u[3])
{
    const int w = s->p.kernel.width, dims = s->p.dims;
    double magnitude = 0.0, value = 0.0;
    for (int t = 0; t < (int)pow(w, dims); t++) {
        const int tap[3] = {t % w, t / w % w, t / w / w};
        double exact = 1.0;
        for (int d = 0; d < dims; d++)
            exact *= axis_weight(s, u[d], tap[d]);
        const double e = looked_up(s, u, tap) - exact;
        magnitude += fabs(e);
        value += e;
        s->single = fmax(s->single, fabs(e));
    }
    s->magnitudes[s->count++] = magnitude;
    s->sum += magnitude;
    s->squares += magnitude * magnitude;
    s->signed_sum += value;
    s->signed_min = fmin(s->signed_min, value);
    s->signed_max = fmax(s->signed_max, value);
    s->maximum = fmax(s->maximum, magnitude);
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double rank(const struct plain *s, double share)
{
    return s->magnitudes[(size_t)ceil(share * (double)s->count) - 1];
}

static void check_statistics(const struct weft_error_kernel_params *params, const char *name)
{
    struct weft_error_kernel error;
    const int l = params->locations, dims = params->dims;
    const int all = (int)pow(l, dims);
    struct plain s = {.p = *params, .signed_min = INFINITY, .signed_max = -INFINITY};
    s.magnitudes = calloc((size_t)all, sizeof *s.magnitudes);
    assert_non_null(s.magnitudes);
    for (int i = 0; i < all; i++)
        plain_location(
            &s, (double[3]){(i % l + 0.5) / l, (i / l % l + 0.5) / l, (i / l / l + 0.5) / l});
    qsort(s.magnitudes, s.count, sizeof *s.magnitudes, compare_doubles);
    assert_int_equal(weft_error_kernel_compute(params, &error), WEFT_OK);
    assert_near(error.maximum, s.maximum, 1e-13, name);
    assert_near(error.mean, s.sum / all, 1e-13, name);
    assert_near(error.rms, sqrt(s.squares / all), 1e-13, name);
    assert_near(error.signed_min, s.signed_min, 1e-13, name);
    assert_near(error.signed_max, s.signed_max, 1e-13, name);
    assert_near(error.signed_mean, s.signed_sum / all, 1e-13, name);
    assert_near(error.single, s.single, 1e-13, name);
    assert_near(error.scale, (double)weft_fixed_one(params->bits), 0.0, name);
    assert_near(error.median, rank(&s, 0.5), 2e-4 * s.maximum, name);
    assert_near(error.percentile_90, rank(&s, 0.9), 2e-4 * s.maximum, name);
    assert_near(error.percentile_99, rank(&s, 0.99), 2e-4 * s.maximum, name);
    // The location named has the maximum.
    s.maximum = 0.0;
    s.count = 0;
    plain_location(&s, error.position);
    assert_near(s.maximum, error.maximum, 1e-13, name);
    free(s.magnitudes);
}

// Odd widths, kernels without symmetry or unit sum, locations on texel borders (M = 24 with L =
// 12), grids that are no powers of two.
static void test_statistics(void **state)
{
    static const struct {
        const char *kernel;
        int dims, samples, bits, locations;
    } cases[] = {
        {"catmull-rom", 1, 7, 8, 30},
        {"bspline2", 2, 5, 8, 12},
        {"nearest", 2, 3, 8, 6},
        {"bspline", 2, 24, 8, 12},
        {"d-catmull-rom", 2, 6, 10, 12},
        {"lanczos:3", 2, 4, 12, 10},
        {"gaussian:2.3,0.7", 2, 5, 8, 9},
        {"linear", 3, 3, 4, 9},
        {"mitchell", 3, 4, 8, 8},
        {"bspline2", 3, 16, 6, 8},
        {"hann-sinc:2.5+unit", 3, 3, 8, 5},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        for (int mode = 0; mode < 4; mode++) {
            const struct weft_error_kernel_params params = {
                .kernel = kernel_named(cases[i].kernel),
                .dims = cases[i].dims,
                .samples = cases[i].samples,
                .bits = cases[i].bits,
                .locations = cases[i].locations,
                .lookup = mode & 1 ? WEFT_ERROR_LINEAR : WEFT_ERROR_NEAREST,
                .rounding = mode & 2 ? WEFT_FIXED_TRUNCATE : WEFT_FIXED_ROUND,
                .threads = 2,
            };
            check_statistics(&params, cases[i].kernel);
        }
    }
}

static void test_threads(void **state)
{
    struct weft_error_kernel one, many;
    struct weft_error_kernel_params params = {.kernel = kernel_named("lanczos:2"),
                                              .dims = 3,
                                              .samples = 20,
                                              .locations = 40,
                                              .threads = 1};
    (void)state;
    assert_int_equal(weft_error_kernel_compute(&params, &one), WEFT_OK);
    params.threads = 7;
    assert_int_equal(weft_error_kernel_compute(&params, &many), WEFT_OK);
    assert_memory_equal(&one, &many, sizeof one);
}

static bool stop_at_half(void *priv, double fraction)
{
    double *last = priv;
    assert_true(fraction >= *last && fraction <= 1.0);
    *last = fraction;
    return fraction < 0.5;
}

static void test_cancel(void **state)
{
    double last = 0.0;
    struct weft_error_kernel error;
    const struct weft_error_kernel_params params = {
        .kernel = kernel_named("linear"),
        .locations = 300,
        .threads = 1,
        .progress = &(struct weft_progress){.report = stop_at_half, .priv = &last}};
    (void)state;
    assert_int_equal(weft_error_kernel_compute(&params, &error), WEFT_ERR_CANCELLED);
    assert_true(last >= 0.5 && error.maximum == 0.0);
}

static void test_bad_arguments(void **state)
{
    const struct weft_error_kernel_params good = {.kernel = kernel_named("linear"), .locations = 4};
    struct weft_error_kernel_params bad[10];
    struct weft_error_kernel error;
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        bad[i] = good;
    bad[0].kernel = (struct weft_kernel){0};
    bad[1].dims = 4;
    bad[2].dims = -1;
    bad[3].samples = -5;
    bad[4].samples = 65537;
    bad[5].bits = 25;
    bad[6].locations = 4097;
    bad[7].rounding = (enum weft_fixed_rounding)7;
    bad[8].lookup = (enum weft_error_lookup)7;
    bad[9].convention = (enum weft_error_convention)7;
    assert_int_equal(weft_error_kernel_compute(&good, &error), WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        assert_int_equal(weft_error_kernel_compute(&bad[i], &error), WEFT_ERR_ARGUMENT);
    bad[0] = good;
    bad[0].kernel = kernel_named("bspline2");
    bad[0].convention = WEFT_ERROR_WSCG2003;
    assert_int_equal(weft_error_kernel_compute(&bad[0], &error), WEFT_ERR_UNSUPPORTED);
}

// E1 of linear interpolation: |f''| / 8 per axis.
static void test_terms(void **state)
{
    const struct weft_kernel linear = kernel_named("linear");
    (void)state;
    assert_near(weft_error_e1(&linear, 1, 2.0), 0.25, 1e-12, "E1");
    assert_near(weft_error_e1(&linear, 3, 1.0), 0.375, 1e-12, "E1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_eq4),        cmocka_unit_test(test_wscg2003),
        cmocka_unit_test(test_statistics), cmocka_unit_test(test_threads),
        cmocka_unit_test(test_cancel),     cmocka_unit_test(test_bad_arguments),
        cmocka_unit_test(test_terms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
