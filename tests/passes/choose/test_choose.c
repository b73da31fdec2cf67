// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/support/slice_jobs.h"

// Or WEFT_JOBS; 200 is a long sweep.
enum { JOBS = 60 };

// ---- jobs ---------------------------------------------------------------------------------------

// Order, states and bounds of the candidates are as the header says.
static void check_candidates(const struct weft_choice *choice, double budget)
{
    int chosen = 0;
    for (size_t i = 0; i < choice->count; i++) {
        const struct weft_candidate *c = &choice->candidates[i];
        const bool refused = c->state == WEFT_CANDIDATE_REFUSED;
        if (i > 0 && !refused)
            assert_true(c->seconds >= choice->candidates[i - 1].seconds);
        assert_true(refused || c->bound >= 0.0);
        if (c->state == WEFT_CANDIDATE_EXCEEDS)
            assert_true(c->bound > budget);
        // What is predicted to be faster than the chosen one has a reason.
        if (choice->chosen >= 0 && (int)i < choice->chosen)
            assert_int_equal(c->state, WEFT_CANDIDATE_EXCEEDS);
        if (choice->chosen < 0)
            assert_true(refused || c->state == WEFT_CANDIDATE_EXCEEDS);
        chosen += c->state == WEFT_CANDIDATE_CHOSEN;
    }
    assert_int_equal(chosen, choice->chosen >= 0);
}

// Runs what was chosen; returns the largest error.
static double error_of(weft_context *context, const struct job *job, const struct weft_choice *c)
{
    const struct weft_slice_geometry *g = &job->params.slice.geometry;
    float *pixels = malloc((size_t)g->width * (size_t)g->height * sizeof *pixels);
    struct weft_verify_report error;
    assert_non_null(pixels);
    assert_int_equal(weft_method_run(c->plan,
                                     weft_method_run_params(.context = context, .pixels = pixels),
                                     NULL),
                     WEFT_OK);
    assert_int_equal(weft_slice_verify(weft_method_plan_get_slice(c->plan), pixels, NULL, &error),
                     WEFT_OK);
    assert_int_equal(error.not_finite_mismatches, 0);
    free(pixels);
    return error.maximum;
}

static void random_jobs_stay_within_their_budgets(void **state)
{
    (void)state;
    struct random r = {2026};
    int chosen = 0, methods[2][4] = {{0}}, doubles = 0;
    double closest = 0.0;
    const int jobs = getenv("WEFT_JOBS") ? atoi(getenv("WEFT_JOBS")) : JOBS;
    for (int i = 0; i < jobs; i++) {
        struct job job;
        struct weft_choice choice;
        set_job(&r, 1, &job);
        struct weft_choose_params params = {
            .slice = job.params.slice,
            .max_error = random_budget(&r, &job.params.statistics),
            // All, each alone; of all mostly the CPU engine's are the fastest.
            .engines = (unsigned)(i % 3),
        };
        params.slice.log = &log_to_stderr;
        // What only sums in double are within, of kernels that gain little.
        const struct weft_slice_statistics *s = &job.params.statistics;
        if (i % 12 == 2) {
            params.slice.kernel = kernel_named(i % 24 == 2 ? "catmull-rom" : "bspline3");
            params.max_error = 2.5e-7 * fmax(fabs(s->low), fabs(s->high));
        }
        // Plans of passes for few taps and coarse budgets, which are quick to plan and can be met.
        if (i % 10 == 9) {
            params.engines = 0;
            params.profile = weft_profile_find(i % 20 == 9 ? "unorm16" : "unorm8");
            params.slice.kernel = kernel_named(i % 4 == 1 ? "linear" : "nearest");
            params.max_error = (job.params.statistics.high - job.params.statistics.low) *
                               ldexp(1.0, -(int)(1 + i / 10 % 4));
        }
        assert_int_equal(weft_choose(job.volume, &params, &choice), WEFT_OK);
        check_candidates(&choice, params.max_error);
        if (choice.chosen >= 0) {
            const double error = error_of(contexts[0], &job, &choice);
            if (!(error <= params.max_error))
                fail_msg("job %d: %s is off by %.3g, the budget is %.3g", i,
                         choice.candidates[choice.chosen].name, error, params.max_error);
            assert_true(weft_method_plan_get_info(choice.plan)->bound <= params.max_error);
            closest = fmax(closest, error / params.max_error);
            const struct weft_method *method = &choice.candidates[choice.chosen].method;
            methods[method->engine][method->algorithm]++;
            doubles += method->sums == WEFT_SUMS_DOUBLE;
            assert_true(!params.engines || params.engines == 1u << method->engine);
            chosen++;
        }
        weft_choice_clear(&choice);
        weft_volume_destroy(&job.volume);
    }
    print_message(
        "%d of %d budgets met: on OpenGL %d fused, %d separable, %d by passes, %d by hardware; on "
        "the CPU %d fused, %d separable, %d of them in double; error at most %.2f of the budget\n",
        chosen, jobs, methods[0][0], methods[0][1], methods[0][2], methods[0][3], methods[1][0],
        methods[1][1], doubles, closest);
    assert_true(methods[0][0] > 0 && methods[0][1] > 0 && methods[0][2] > 0);
    assert_true(methods[1][0] > 0 && methods[1][1] > 0 && doubles > 0);
    assert_in_range(chosen, jobs / 2, jobs - 1); // some cannot be met
}

// ---- what cannot be met -------------------------------------------------------------------------

static void what_cannot_be_met_is_told(void **state)
{
    (void)state;
    struct random r = {3};
    struct job job;
    struct weft_choice choice;
    struct message message = {0};
    const struct weft_log log = {keep_message, &message};
    set_job(&r, 1, &job);
    struct weft_choose_params params = {.slice = job.params.slice, .max_error = 0.0};
    params.slice.kernel = kernel_named("catmull-rom");
    params.slice.log = &log;
    assert_int_equal(weft_choose(job.volume, &params, &choice), WEFT_OK);
    assert_int_equal(choice.chosen, -1);
    assert_true(choice.best >= 0 && !choice.plan);
    const double best = choice.candidates[choice.best].bound;
    for (size_t i = 0; i < choice.count; i++)
        if (choice.candidates[i].state != WEFT_CANDIDATE_REFUSED && !choice.candidates[i].estimated)
            assert_true(choice.candidates[i].bound >= best);
    weft_choice_clear(&choice);
    // The best bound is a budget that can be met.
    params.max_error = best;
    assert_int_equal(weft_choose(job.volume, &params, &choice), WEFT_OK);
    assert_true(choice.chosen >= 0);
    weft_choice_clear(&choice);
    assert_int_equal(message.count, 0);
    const double bad[] = {-1.0, NAN};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        params.max_error = bad[i];
        message.count = 0;
        assert_int_equal(weft_choose(job.volume, &params, &choice), WEFT_ERR_ARGUMENT);
        assert_int_equal(message.count, 1);
        assert_null(choice.candidates);
    }
    weft_volume_destroy(&job.volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_jobs_stay_within_their_budgets),
        cmocka_unit_test(what_cannot_be_met_is_told),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
