// SPDX-License-Identifier: BSD-3-Clause
// Every public function, called with values that its header does not allow: an error with a line in
// the log, or what the header says; never a crash, never a hang. Each case runs in a child of its
// own. The list of functions is made from the public headers: one without a case fails the test.
#include <setjmp.h>
#include <stdarg.h>
#include <sys/wait.h>

#include "tests/callers/callers.h"

#include <cmocka.h>

#include "callers_functions.h"

enum { SECONDS = 30 };

static const struct caller_case *const rooms[] = {
    callers_filter,    callers_tiles,  callers_plans,   callers_engines,
    callers_slices,    callers_images, callers_warps,   callers_accumulate,
    callers_antialias, callers_ranks,  callers_lattice, callers_simple,
};

static bool is_called(const char *function)
{
    for (size_t r = 0; r < WEFT_COUNT(rooms); r++)
        for (const struct caller_case *c = rooms[r]; c->run; c++)
            for (size_t f = 0; c->functions[f]; f++)
                if (strcmp(c->functions[f], function) == 0)
                    return true;
    return false;
}

static void every_function_has_a_case(void **state)
{
    (void)state;
    assert_true(WEFT_COUNT(public_functions) > 100);
    for (size_t i = 0; i < WEFT_COUNT(public_functions); i++)
        if (!is_called(public_functions[i]))
            fail_msg("%s has no case", public_functions[i]);
}

// Runs a case in a child; returns how that ends, as waitpid has it.
static int run_in_child(const struct caller_case *one)
{
    int status = 0;
    fflush(NULL);
    const double started = weft_now_seconds();
    const pid_t child = fork();
    if (child == 0) {
        for (int number = 1; number < NSIG; number++)
            signal(number, SIG_DFL);
        alarm(SECONDS);
        one->run();
        _exit(callers_complaints > 0 ? CALLERS_COMPLAINTS : 0);
    }
    assert_true(child > 0 && waitpid(child, &status, 0) == child);
    if (getenv("WEFT_CALLERS_TIMES"))
        print_message("%6.2f s %s, ...\n", weft_now_seconds() - started, one->functions[0]);
    return status;
}

static void bad_values_are_refused(void **state)
{
    (void)state;
    int failed = 0, skipped = 0;
    for (size_t r = 0; r < WEFT_COUNT(rooms); r++) {
        for (const struct caller_case *c = rooms[r]; c->run; c++) {
            const int status = run_in_child(c), code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
            skipped += code == CALLERS_SKIPPED;
            if (code == 0 || code == CALLERS_SKIPPED)
                continue;
            failed++;
            print_error("%s, ...: %s\n", c->functions[0],
                        WIFSIGNALED(status)          ? strsignal(WTERMSIG(status))
                        : code == CALLERS_COMPLAINTS ? "see above"
                                                     : "it ended");
        }
    }
    if (skipped > 0)
        print_message("[  SKIPPED ] %d cases without a GL context\n", skipped);
    assert_int_equal(failed, 0);
}

// What is all zero but for what is required gives what the defaults written out give.
static void zero_asks_for_the_defaults(void **state)
{
    (void)state;
    static const float plane[4] = {-1.0f, 0.0f, 2.0f, 5.0f};
    float range[2];
    const struct weft_preview_params preview = {
        .path = "/dev/null", .width = 4, .height = 1, .plane = plane};
    assert_int_equal(weft_preview_save(&preview, range), WEFT_OK);
    assert_true(range[0] == -1.0f && range[1] == 5.0f);

    const struct weft_pass_plan_params plain = {0};
    const struct weft_pass_plan_params *full =
        weft_pass_plan_params(.kernel = named("catmull-rom"), .dims = 2,
                              .profile = *weft_profile_find("unorm8"), .samples = 64, .bits = 8,
                              .channels = 1, .memory_bytes = UINT64_C(1) << 30);
    weft_pass_plan *a = NULL, *b = NULL;
    assert_int_equal(weft_pass_plan_create(&plain, &a), WEFT_OK);
    assert_int_equal(weft_pass_plan_create(full, &b), WEFT_OK);
    assert_int_equal(weft_pass_plan_get_info(a)->fetches, weft_pass_plan_get_info(b)->fetches);
    assert_true(weft_pass_plan_get_info(a)->error.bound == weft_pass_plan_get_info(b)->error.bound);
    weft_pass_plan_destroy(&a);
    weft_pass_plan_destroy(&b);

    weft_kernel_tiles *set = NULL;
    const struct weft_kernel_tiles_params set_params = {.kernel = named("catmull-rom")};
    assert_int_equal(weft_kernel_tiles_create(&set_params, &set), WEFT_OK);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    assert_true(info->dims == 2 && info->samples == 64 && info->bits == 8 && info->mirrored);
    weft_kernel_tiles_destroy(&set);

    // Of no range: that of the samples, so that the pixel of the largest is it.
    float pixel = 0.0f;
    weft_pass_plan *reals = NULL;
    const struct weft_samples samples = {.size = {4, 1, 1}, .plane = {plane}};
    const struct weft_pixel_grid grid = {.width = 1, .height = 1, .origin = {3.0, 0.0, 0.0}};
    assert_int_equal(
        weft_pass_plan_create(
            weft_pass_plan_params(.kernel = named("linear"), .profile = *weft_profile_find("fp32")),
            &reals),
        WEFT_OK);
    weft_multipass *compiled = NULL;
    struct weft_multipass_report report;
    assert_int_equal(weft_multipass_compile(NULL, weft_multipass_params(.plan = reals), &compiled),
                     WEFT_OK);
    assert_int_equal(
        weft_multipass_run(
            compiled,
            weft_multipass_run_params(.samples = &samples, .grid = &grid, .pixels = {&pixel}),
            &report),
        WEFT_OK);
    weft_multipass_destroy(&compiled);
    assert_true(report.low == -1.0 && report.high == 5.0 && report.clamped == 0);
    weft_pass_plan_destroy(&reals);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_has_a_case),
        cmocka_unit_test(bad_values_are_refused),
        cmocka_unit_test(zero_asks_for_the_defaults),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
