// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "filter/analysis/analysis.h"
#include "passes/plan/work.h"
#include "tests/support/common.h"

// ---- the least that a plan can do ---------------------------------------------------------------

static void check_least(const struct weft_pass_plan_params *params, const weft_pass_plan *plan,
                        double *nearest)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const struct weft_pass_work least = weft_pass_work_least(params),
                                work = weft_pass_work_of(info);
    const double slope = weft_analysis_slope(&info->kernel);
    const struct weft_bound_terms terms = weft_pass_bound_least(params, slope);
    // Coefficients reach farther than samples.
    const struct weft_bound_values values = {
        .low = -0.5, .high = 1.5, .sample_low = 0.0, .sample_high = 1.0};
    assert_int_equal(least.target, work.target);
    assert_int_equal(least.dot4, work.dot4);
    assert_true(least.exact_weights == work.exact_weights);
    if (!(least.passes > 0.0 && least.passes <= work.passes && least.fetches > 0.0 &&
          least.fetches <= work.fetches && least.tile_bytes > 0.0 &&
          least.tile_bytes <= work.tile_bytes))
        fail_msg("%s: %g passes, %g fetches, %g bytes; at least %g, %g, %g were expected",
                 info->text, work.passes, work.fetches, work.tile_bytes, least.passes,
                 least.fetches, least.tile_bytes);
    const double bound = weft_bound_compute(&info->bound, &values).total;
    const double least_bound = weft_bound_compute(&terms, &values).total;
    if (!(least_bound <= bound))
        fail_msg("%s: bound %g, at least %g was expected", info->text, bound, least_bound);
    *nearest = fmin(*nearest, bound / least_bound);
}

// With taps that mirror each other, that are 0 on one side, that interpolate or not, and weights
// that do not add up to one.
static void plans_do_no_less(void **state)
{
    (void)state;
    static const char *const kernels[] = {"nearest",  "linear",    "catmull-rom", "bspline3",
                                          "mitchell", "lanczos:2", "bspline3i",   "omoms"};
    int made = 0, refused = 0;
    double nearest = INFINITY;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        for (int p = 0; weft_profile_list[p]; p++) {
            for (int t = 0; weft_technique_names[t]; t++) {
                for (int samples = 8; samples <= 32; samples *= 4) {
                    weft_pass_plan *plan = NULL;
                    const struct weft_pass_plan_params params = {
                        .kernel = kernel_named(kernels[k]),
                        .profile = *weft_profile_list[p],
                        .technique = (enum weft_technique)t,
                        .worst_case = WEFT_WORST_ANY,
                        .samples = samples,
                    };
                    const enum weft_result res = weft_pass_plan_create(&params, &plan);
                    made += res == WEFT_OK;
                    refused += res != WEFT_OK;
                    if (res == WEFT_OK)
                        check_least(&params, plan, &nearest);
                    weft_pass_plan_destroy(&plan);
                }
            }
        }
    }
    print_message("%d plans, %d refused; bound / least bound: from %.3g\n", made, refused, nearest);
    assert_true(made > 200 && refused > 20);
}

// What cannot be planned for a reason that needs no plan does nothing at all.
static void what_a_profile_cannot_is_no_work(void **state)
{
    (void)state;
    const struct weft_pass_plan_params params = {.profile = *weft_profile_find("fp32"),
                                                 .technique = WEFT_TECHNIQUE_LOG};
    assert_true(weft_pass_work_least(&params).passes == 0.0);
    assert_true(isnan(weft_pass_bound_least(&params, 1.0).e2));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plans_do_no_less),
        cmocka_unit_test(what_a_profile_cannot_is_no_work),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
