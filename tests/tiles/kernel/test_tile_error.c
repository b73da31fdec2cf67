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
#include "tests/support/contexts.h"
#include "filter/check.h"
#include "tests/support/tile_error.h"
#include "weft.h"

static weft_context *context;

static weft_kernel_tiles *make(const struct weft_kernel_tiles_params *params)
{
    weft_kernel_tiles *set = NULL;
    struct weft_kernel_tiles_params p = *params;
    p.log = &log_to_stderr;
    assert_int_equal(weft_kernel_tiles_create(&p, &set), WEFT_OK);
    return set;
}

static bool software_gl(void)
{
    return strstr(weft_context_get_info(context)->renderer, "llvmpipe") != NULL;
}

// What floats may differ from the models by: a texture coordinate is off by a few 2^-24, a texel
// has M of those, neighbouring texels differ by at most `slope / M`; and a filtered value has a
// handful of roundings of 2^-24 itself. Weights are sums of two parts at most.
static double float_tolerance(const weft_kernel_tiles *set, enum weft_error_lookup lookup)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    double largest = 0.0;
    for (int t = 0; t < info->tile_count; t++)
        largest = fmax(largest, fmax(weft_kernel_tiles_get(set, t)->maximum,
                                     -weft_kernel_tiles_get(set, t)->minimum));
    // Linear: up to 2^dims texels, each share with errors of M 2^-22 of a step no larger than the
    // whole range.
    const double roundings =
        lookup == WEFT_ERROR_LINEAR ? 8.0 * info->dims + 4.0 * info->samples : 2.0;
    return 2.0 * roundings * 0x1p-24 * largest;
}

static void measure(const weft_kernel_tiles *set, enum weft_error_lookup lookup, int locations,
                    struct weft_tile_error *out)
{
    const struct weft_tile_error_params params = {
        .tiles = set, .lookup = lookup, .locations = locations, .log = &log_to_stderr};
    assert_int_equal(weft_tile_error_measure(context, &params, out), WEFT_OK);
}

static const struct {
    enum weft_tile_format format;
    int bits;
} formats[] = {{WEFT_TILE_UNORM, 8},  {WEFT_TILE_UNORM, 5}, {WEFT_TILE_UNORM, 12},
               {WEFT_TILE_UNORM, 16}, {WEFT_TILE_SNORM, 8}, {WEFT_TILE_SNORM, 16},
               {WEFT_TILE_HALF, 0},   {WEFT_TILE_FLOAT, 0}};

// Every kernel, in turn with every format, dimension, resolution and placement.
static void the_target_follows_its_model(void **state)
{
    (void)state;
    int i = 0, compared = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        // 8-bit unorm, whose model is special, and three of the others.
        for (int n = 0; n < 4; n++, i++) {
            const size_t f = n ? 1 + (size_t)(i % 7) : 0;
            struct weft_kernel_tiles_params p =
                *weft_kernel_tiles_params(.kernel = kernel_named((*k)->name), .dims = 1 + i % 3,
                                          .samples = 5 + i % 12, .format = formats[f].format,
                                          .bits = formats[f].bits,
                                          .placement =
                                              i % 5 == 0 ? WEFT_TILE_ENDS : WEFT_TILE_CENTRES,
                                          .scaling = WEFT_TILE_SCALE_SET);
            if (p.dims == 3 && p.kernel.width > 4)
                p.dims = 1;
            if (p.dims == 2 && p.kernel.width > 6)
                p.dims = 1;
            weft_kernel_tiles *set = make(&p);
            for (int l = WEFT_ERROR_NEAREST; l <= WEFT_ERROR_LINEAR; l++) {
                struct weft_tile_error e;
                const double bound = float_tolerance(set, (enum weft_error_lookup)l);
                measure(set, (enum weft_error_lookup)l, 32 >> (p.dims - 1), &e);
                const bool exact = formats[f].bits != 8 || formats[f].format != WEFT_TILE_UNORM ||
                                   l == WEFT_ERROR_NEAREST;
                if (e.borders > 0)
                    continue;
                compared++;
                if ((software_gl() && !(e.difference_eight_bit <= bound)) ||
                    (exact && !(e.difference_ideal <= bound)))
                    fail_msg("ends %d, %s, %dD, M %d, format %d, %d bits, lookup %d: %.3g from the "
                             "model, "
                             "%.3g from ideal, bound %.3g",
                             (int)p.placement, (*k)->name, p.dims, p.samples, (int)p.format, p.bits,
                             l, e.difference_eight_bit, e.difference_ideal, bound);
                assert_true(fabs(e.measured.single - (exact ? e.ideal : e.eight_bit).single) <=
                            2.0 * bound);
            }
            weft_kernel_tiles_destroy(&set);
        }
    }
    // Few have a position where a rounding decides.
    assert_true(compared > 9 * i / 5);
}

// Ideal arithmetic is what filter/analysis/error.h computes without ever storing a tile.
static void the_ideal_model_is_eq_4(void **state)
{
    (void)state;
    const char *const names[] = {"bspline", "catmull-rom", "blackman-sinc:2"};
    for (size_t n = 0; n < WEFT_COUNT(names); n++) {
        for (int dims = 1; dims <= 3; dims++) {
            for (int l = WEFT_ERROR_NEAREST; l <= WEFT_ERROR_LINEAR; l++) {
                const int m = dims == 3 ? 16 : 64, locations = dims == 3 ? 16 : 128;
                weft_kernel_tiles *set =
                    make(weft_kernel_tiles_params(.kernel = kernel_named(names[n]), .dims = dims,
                                                  .samples = m));
                const struct weft_tile_error_params params = {
                    .tiles = set, .lookup = (enum weft_error_lookup)l, .locations = locations};
                struct weft_tile_error e;
                struct weft_error_kernel expected;
                assert_int_equal(weft_tile_error_model(&params, &e), WEFT_OK);
                assert_true(isnan(e.measured.maximum));
                assert_int_equal(
                    weft_error_kernel_compute(
                        &(struct weft_error_kernel_params){.kernel = kernel_named(names[n]),
                                                           .dims = dims,
                                                           .samples = m,
                                                           .lookup = (enum weft_error_lookup)l,
                                                           .locations = locations},
                        &expected),
                    WEFT_OK);
                assert_true(fabs(e.ideal.maximum - expected.maximum) < 1e-12);
                assert_true(fabs(e.ideal.single - expected.single) < 1e-12);
                assert_true(fabs(e.ideal.mean - expected.mean) < 1e-12);
                weft_kernel_tiles_destroy(&set);
            }
        }
    }
}

// Positions rounded to 1/256 of a texel, and the result once per axis: at most
// dims (step / 512 + 1/2) LSB from ideal, the step being the largest between neighbouring texels.
static void eight_bit_lookup_costs_what_it_may(void **state)
{
    (void)state;
    const char *const names[] = {"linear", "bspline", "catmull-rom", "blackman-sinc:2"};
    for (size_t n = 0; n < WEFT_COUNT(names); n++) {
        for (int dims = 1; dims <= 3; dims++) {
            const int m = dims == 3 ? 16 : 64;
            struct weft_tile_error e;
            weft_kernel_tiles *set = make(weft_kernel_tiles_params(.kernel = kernel_named(names[n]),
                                                                   .dims = dims, .samples = m));
            measure(set, WEFT_ERROR_LINEAR, dims == 3 ? 32 : 128, &e);
            // No slope of these reaches 1.5 per unit: neighbours differ by 1.5 / M and a rounding.
            const double step = 255.0 * 1.5 / m + 1.0;
            const double limit = dims * (step / 512.0 + 0.5) / 255.0;
            print_message("%-16s %dD M %d: 255 eps_h measured %.4f, model %.4f, ideal %.4f; "
                          "a weight is up to %.4f LSB off ideal, %.2g off the model\n",
                          names[n], dims, m, 255.0 * e.measured.maximum,
                          255.0 * e.eight_bit.maximum, 255.0 * e.ideal.maximum,
                          255.0 * e.difference_ideal, 255.0 * e.difference_eight_bit);
            assert_true(e.difference_ideal <= limit || !software_gl());
            weft_kernel_tiles_destroy(&set);
        }
    }
}

static void sum_preserving_tiles_have_no_ripple(void **state)
{
    (void)state;
    struct weft_tile_error e;
    for (int rounding = WEFT_TILE_NEAREST; rounding <= WEFT_TILE_SUM_PRESERVING; rounding++) {
        weft_kernel_tiles *set =
            make(weft_kernel_tiles_params(.kernel = kernel_named("catmull-rom"),
                                          .rounding = (enum weft_tile_rounding)rounding));
        measure(set, WEFT_ERROR_NEAREST, 128, &e);
        // Floats as they come from texels, summed in double.
        if (rounding == WEFT_TILE_SUM_PRESERVING)
            assert_true(e.measured.signed_max < 1e-6 && e.measured.signed_min > -1e-6);
        else
            assert_true(e.measured.signed_max - e.measured.signed_min > 1.0 / 255.0);
        weft_kernel_tiles_destroy(&set);
    }
}

static void borders_are_counted(void **state)
{
    (void)state;
    const struct {
        int samples, locations, borders;
        enum weft_tile_placement placement;
    } cases[] = {{64, 256, 0, WEFT_TILE_CENTRES},
                 {64, 32, 32, WEFT_TILE_CENTRES},
                 {6, 9, 3, WEFT_TILE_CENTRES},
                 {6, 15, 5, WEFT_TILE_ENDS}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_tile_error e;
        weft_kernel_tiles *set = make(
            weft_kernel_tiles_params(.kernel = kernel_named("linear"), .dims = 1,
                                     .samples = cases[i].samples, .placement = cases[i].placement));
        int expected = 0;
        for (int n = 0; n < cases[i].locations; n++) {
            const double u = (n + 0.5) / cases[i].locations;
            const double at = cases[i].placement == WEFT_TILE_ENDS
                                  ? u * (cases[i].samples - 1) + 0.5
                                  : u * cases[i].samples;
            expected += fabs(at - nearbyint(at)) < 1e-9;
        }
        measure(set, WEFT_ERROR_NEAREST, cases[i].locations, &e);
        assert_int_equal(e.borders, expected);
        weft_kernel_tiles_destroy(&set);
    }
}

static void bad_requests_are_refused(void **state)
{
    (void)state;
    struct weft_tile_error e;
    weft_kernel_tiles *set =
        make(weft_kernel_tiles_params(.kernel = kernel_named("linear"), .dims = 3, .samples = 4));
    const struct {
        struct weft_tile_error_params params;
        enum weft_result expected;
    } cases[] = {
        {{.tiles = NULL}, WEFT_ERR_ARGUMENT},
        {{.tiles = set, .locations = -1}, WEFT_ERR_ARGUMENT},
        {{.tiles = set, .locations = 5000}, WEFT_ERR_ARGUMENT},
        {{.tiles = set, .locations = 1000}, WEFT_ERR_LIMIT}, // 10^9 positions
        {{.tiles = set, .locations = 200}, WEFT_ERR_LIMIT},  // 40000 rows of a target
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        assert_int_equal(weft_tile_error_measure(context, &cases[i].params, &e), cases[i].expected);
    weft_kernel_tiles_destroy(&set);
}

static int set_context(void **state)
{
    create_contexts(state);
    context = contexts[0];
    if (!software_gl())
        print_message("[  SKIPPED ] the model of lookups of 8 bits: it is that of llvmpipe\n");
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_target_follows_its_model),
        cmocka_unit_test(the_ideal_model_is_eq_4),
        cmocka_unit_test(eight_bit_lookup_costs_what_it_may),
        cmocka_unit_test(sum_preserving_tiles_have_no_ripple),
        cmocka_unit_test(borders_are_counted),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, set_context, destroy_contexts);
}
