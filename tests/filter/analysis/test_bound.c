// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "filter/analysis/bound.h"
#include "tests/support/common.h"

static const struct weft_bound_values values = {
    .low = -3.0, .high = 5.0, .sample_low = -1.0, .sample_high = 2.0, .beyond = 16.0};

static double total(const struct weft_bound_terms *terms)
{
    return weft_bound_compute(terms, &values).total;
}

// Each term alone, by hand: the width read is 8, the largest read 5, that of samples 2.
static void terms_count_as_they_say(void **state)
{
    (void)state;
    const struct {
        struct weft_bound_terms terms;
        double expected;
    } cases[] = {
        {{0}, 0.0},
        {{.relative = 0.25}, 1.25},
        {{.source = 0.25}, 2.0},
        {{.e2 = 0.25}, 2.0},
        {{.e3 = 0.25}, 2.0},
        {{.clamp = 0.25}, 2.0},
        {{.absolute = 0.25}, 0.25},
        {{.sample_rounding = 0.25}, 0.5},
        {{.absolute_rounding = 0.25}, 0.25},
        {{.rounded_gain = 2.0}, 10.0 * 0x1p-24},
        {{.prefilter.coefficient = 0.25}, 1.25},
        {{.prefilter.sample = 0.25}, 0.5},
        {{.prefilter.beyond = 0.25}, 4.0},
        // Weights that are off weigh wrong coefficients.
        {{.relative = 0.5, .prefilter.coefficient = 0.25}, 2.5 + 1.5 * 1.25},
        {{.e2 = 0.5, .prefilter.beyond = 0.25}, 4.0 + 1.5 * 4.0},
        // The nearest position's spline sees samples that are farther away, too.
        {{.e2 = 1.0, .e2_sampled = 0.125, .prefilter.beyond = 0.25},
         0.375 + 2.0 * 4.0 + 2.0 * 0.25 * 18.0},
        // What is counted before a result is rounded makes it larger.
        {{.absolute = 6.0, .rounded_gain = 2.0}, 6.0 + 16.0 * 0x1p-24},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        assert_near(total(&cases[i].terms), cases[i].expected, 1e-15 * cases[i].expected, "total");
}

static void the_smaller_e2_holds(void **state)
{
    (void)state;
    struct weft_bound_terms terms = {.e2 = 0.25, .e2_quantised = 0.125, .e2_sampled = 0.25};
    assert_true(weft_bound_compute(&terms, &values).e2 == 1.75); // 0.125 8 + 0.25 3
    terms.e2_sampled = 0.5;
    assert_true(weft_bound_compute(&terms, &values).e2 == 2.0);
}

static void parts_add_up(void **state)
{
    (void)state;
    const struct weft_bound_terms terms = {.relative = 1e-7,
                                           .source = 1e-4,
                                           .e2 = 1e-3,
                                           .e3 = 1e-5,
                                           .clamp = 1e-6,
                                           .absolute = 1e-8,
                                           .rounded_gain = 1.5,
                                           .sample_rounding = 1e-7,
                                           .absolute_rounding = 0.5,
                                           .prefilter = {1e-7, 1e-8, 1e-8, 2.0}};
    struct weft_bound_values of = values;
    const struct weft_bound any = weft_bound_compute(&terms, &of);
    assert_near(any.total, any.source + any.e2 + any.e3 + any.clamp + any.rounding + any.prefilter,
                1e-15, "sum");
    // A result that is known rounds less.
    of.result = 2.0;
    const struct weft_bound known = weft_bound_compute(&terms, &of);
    assert_near(any.total - known.total, any.rounding - known.rounding, 1e-15, "rounding");
    assert_near(known.rounding, 2e-7 + 0.5 + 2.0 * 0x1p-24, 1e-15, "rounding of 2");
    assert_true(known.total < any.total);
    of.high = NAN;
    assert_true(isnan(weft_bound_compute(&terms, &of).total));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_count_as_they_say),
        cmocka_unit_test(the_smaller_e2_holds),
        cmocka_unit_test(parts_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
