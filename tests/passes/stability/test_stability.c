// SPDX-License-Identifier: BSD-3-Clause
// The cases of passes/stability/stability.h, on every GL context that is to be had and without one.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "weft.h"

// Whether there was something to check: a case may need a context that is not there.
static bool check(const struct weft_stability_case *c, const struct weft_stability_params *params)
{
    struct weft_stability_result r;
    assert_int_equal(weft_stability_run(c, params, &r), WEFT_OK);
    assert_true(memchr(r.text, '\0', sizeof r.text) && !strchr(r.text, '\n'));
    if (r.verdict == WEFT_STABILITY_SKIPPED) {
        assert_true(c->needs_context && !params->context);
        assert_true(isnan(r.naive) && isnan(r.ours) && isnan(r.limit));
        return false;
    }
    print_message("%-15s naive %-9.3g ours %-9.3g limit %-9.3g %s, %s\n", c->name, r.naive, r.ours,
                  r.limit, r.unit, weft_stability_verdict_text(r.verdict));
    if (r.verdict == WEFT_STABILITY_OURS_FAILS || !(r.ours <= r.limit))
        fail_msg("%s: %.3g %s, limit %.3g: %s", c->name, r.ours, r.unit, r.limit, r.text);
    assert_int_equal(r.verdict == WEFT_STABILITY_HOLDS, !(r.naive <= r.limit));
    // What is known of llvmpipe, and of arithmetic anywhere; another GL may filter or round better.
    if (!params->context || !weft_context_get_info(params->context)->hardware)
        assert_int_equal(r.verdict, WEFT_STABILITY_HOLDS);
    return true;
}

// Returns how many cases ran.
static int check_all(weft_context *context, const char *data_folder)
{
    int ran = 0;
    const struct weft_stability_params params = {
        .context = context, .data_folder = data_folder, .log = &log_to_stderr};
    for (int i = 0; weft_stability_list[i]; i++)
        ran += check(weft_stability_list[i], &params);
    return ran;
}

static int count_cases(bool with_context)
{
    int count = 0;
    for (int i = 0; weft_stability_list[i]; i++)
        count += with_context || !weft_stability_list[i]->needs_context;
    assert_true(count > 0);
    return count;
}

static void every_case_holds_on_every_context(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        print_message("on %s, generated images\n", weft_context_get_info(contexts[c])->platform);
        assert_int_equal(check_all(contexts[c], NULL), count_cases(true));
    }
}

static void every_case_holds_without_a_context(void **state)
{
    (void)state;
    assert_int_equal(check_all(NULL, NULL), count_cases(false));
}

static void cases_hold_with_the_images(void **state)
{
    (void)state;
    const struct weft_stability_params params = {
        .context = contexts[0], .data_folder = WEFT_TEST_DATA, .log = &log_to_stderr};
    int checked = 0;
    for (int i = 0; weft_stability_list[i]; i++) {
        char path[512];
        const struct weft_stability_case *c = weft_stability_list[i];
        if (!c->image)
            continue;
        snprintf(path, sizeof path, "%s/%s", WEFT_TEST_DATA, c->image);
        if (access(path, R_OK) != 0) {
            print_message("[  SKIPPED ] %s is not here\n", path);
            continue;
        }
        struct weft_stability_result r;
        check(c, &params);
        assert_int_equal(weft_stability_run(c, &params, &r), WEFT_OK);
        assert_non_null(strstr(r.text, c->image));
        checked++;
    }
    if (!checked)
        skip();
}

// Without the file a case says what it used instead.
static void missing_images_are_generated(void **state)
{
    (void)state;
    const struct weft_stability_params params = {
        .context = contexts[0], .data_folder = "/nowhere", .log = &log_to_stderr};
    int checked = 0;
    for (int i = 0; weft_stability_list[i]; i++) {
        struct weft_stability_result r;
        if (!weft_stability_list[i]->image)
            continue;
        check(weft_stability_list[i], &params);
        assert_int_equal(weft_stability_run(weft_stability_list[i], &params, &r), WEFT_OK);
        assert_non_null(strstr(r.text, "generated"));
        checked++;
    }
    assert_true(checked > 0);
}

static void the_list_is_well_formed(void **state)
{
    (void)state;
    for (int i = 0; weft_stability_list[i]; i++) {
        const struct weft_stability_case *c = weft_stability_list[i];
        assert_true(c->name && c->failure && c->naive && c->ours && c->measure);
        assert_true(strlen(c->name) <= 15 && !strpbrk(c->name, ", "));
        assert_ptr_equal(weft_stability_find(c->name), c);
    }
    assert_null(weft_stability_find(""));
    assert_null(weft_stability_find("order"));
}

// ---- verdicts -----------------------------------------------------------------------------------

static struct weft_stability_result pretended;

static enum weft_result pretend(const struct weft_stability_params *params,
                                struct weft_stability_result *result)
{
    (void)params;
    *result = pretended;
    return WEFT_OK;
}

static void verdicts_follow_from_the_numbers(void **state)
{
    (void)state;
    static const struct {
        double naive, ours, limit;
        enum weft_stability_verdict verdict;
    } cases[] = {
        {2.0, 0.5, 1.0, WEFT_STABILITY_HOLDS},
        {2.0, 1.0, 1.0, WEFT_STABILITY_HOLDS},
        {INFINITY, 0.0, 0.0, WEFT_STABILITY_HOLDS},
        {NAN, 0.0, 0.0, WEFT_STABILITY_HOLDS},
        {1.0, 1.0, 1.0, WEFT_STABILITY_NAIVE_HOLDS_TOO},
        {2.0, 1.5, 1.0, WEFT_STABILITY_OURS_FAILS},
        {0.5, 1.5, 1.0, WEFT_STABILITY_OURS_FAILS},
        {0.5, NAN, 1.0, WEFT_STABILITY_OURS_FAILS},
        {2.0, 0.5, NAN, WEFT_STABILITY_OURS_FAILS},
        {INFINITY, INFINITY, 1.0, WEFT_STABILITY_OURS_FAILS},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_stability_params params = {.log = &log_to_stderr};
        struct weft_stability_case c = {.name = "pretended", .measure = pretend};
        struct weft_stability_result r;
        pretended = (struct weft_stability_result){
            .naive = cases[i].naive, .ours = cases[i].ours, .limit = cases[i].limit};
        assert_int_equal(weft_stability_run(&c, &params, &r), WEFT_OK);
        assert_int_equal(r.verdict, cases[i].verdict);
        c.needs_context = true;
        assert_int_equal(weft_stability_run(&c, &params, &r), WEFT_OK);
        assert_int_equal(r.verdict, WEFT_STABILITY_SKIPPED);
        assert_non_null(strstr(r.text, "context"));
    }
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_list_is_well_formed),
        cmocka_unit_test(verdicts_follow_from_the_numbers),
        cmocka_unit_test(every_case_holds_without_a_context),
        cmocka_unit_test(every_case_holds_on_every_context),
        cmocka_unit_test(cases_hold_with_the_images),
        cmocka_unit_test(missing_images_are_generated),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
