// SPDX-License-Identifier: BSD-3-Clause
// What weft validate judges: plans of all profiles and techniques with one value changed. No
// changed claim may be believed, and what is called valid is run: the emulation must stay within
// the bound that the file claims, with nothing clamped. WEFT_PLAN_MUTANTS=3000 is all of it.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <jansson.h>

#include "tests/support/common.h"
#include "tests/support/plan_runs.h"
#include "filter/check.h"
#include "tests/support/plans.h"
#include "tools/plan_json/plan_claims.h"
#include "weft.h"

enum { FEW = 240, SIDE = 6, PIXELS = 12 };

static uint64_t seed = 2003;

static uint32_t random_below(uint32_t limit)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)((seed >> 33) % limit);
}

static char path[] = "/tmp/weft-mutants-XXXXXX";

enum answer { REFUSED, INVALID, VALID, ANSWERS };

// What the command would say; of a valid plan, the plan.
static enum answer judge(const json_t *root, weft_pass_plan **plan)
{
    struct plan_file file;
    struct plan_fault fault = {0};
    *plan = NULL;
    assert_int_equal(json_dump_file(root, path, 0), 0);
    if (plan_file_load(path, 0, &file) != WEFT_OK)
        return REFUSED;
    const enum weft_result res = plan_claims_judge(path, &file, NULL, &fault, plan);
    enum answer answer = res != WEFT_OK                          ? REFUSED
                         : fault.kind != PLAN_FAULT_NONE         ? INVALID
                         : weft_pass_plan_get_info(*plan)->valid ? VALID
                                                                 : INVALID;
    if (answer != VALID)
        weft_pass_plan_destroy(plan);
    plan_file_clear(&file);
    return answer;
}

// ---- an independent rule ------------------------------------------------------------------------

// Noise where any input is declared or no bound distinguishes, constants else.
static void check_run(const weft_pass_plan *plan, const json_t *root, bool constant)
{
    static float plane[SIDE * SIDE * SIDE], pixels[PIXELS * PIXELS];
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const json_t *error = json_object_get(root, "bound_parts");
    const double bound = json_number_value(json_object_get(error, constant ? "total" : "any"));
    const bool declared = constant || info->worst_case == WEFT_WORST_ANY;
    const float level = (float)random_below(256) / 255.0f;
    for (size_t i = 0; i < WEFT_COUNT(plane); i++)
        plane[i] = constant ? level : (float)random_below(256) / 255.0f;
    const struct weft_samples samples = {.size = {SIDE, SIDE, info->dims > 2 ? SIDE : 1},
                                         .plane = {plane, plane, plane, plane},
                                         .low = 0.0,
                                         .high = 1.0};
    struct weft_pixel_grid grid = {.width = PIXELS, .height = PIXELS};
    for (int a = 0; a < info->dims; a++) {
        grid.origin[a] = 0.31;
        grid.du[a] = a == 1 ? 0.03 : 0.37;
        grid.dv[a] = a == 0 ? 0.05 : 0.41;
    }
    const struct weft_multipass_run_params params = {
        .samples = &samples, .grid = &grid, .pixels = {pixels}, .log = &log_to_stderr};
    struct weft_multipass_report report;
    struct weft_verify_report found;
    assert_int_equal(run_plan(NULL, plan, &params, &report), WEFT_OK);
    assert_int_equal(verify_plan(plan, &params, &found), WEFT_OK);
    if (!(found.maximum <= bound + 4.0 * 0x1p-24) || found.not_finite_mismatches ||
        (declared && report.clamps))
        fail_msg("called valid: error %g, bound %g, %d not finite, %d stores clamp\n%s",
                 found.maximum, bound, (int)found.not_finite_mismatches, (int)report.clamps,
                 info->text);
}

// ---- changes ------------------------------------------------------------------------------------

static json_t *changed(const json_t *value)
{
    static const double factors[] = {0.0, -1.0, 0.5, 1.001, 2.0};
    if (json_is_integer(value)) {
        const json_int_t i = json_integer_value(value);
        return json_integer(random_below(2) ? i + 1 : random_below(2) ? i - 1 : 2 * i + 1);
    }
    if (json_is_real(value)) {
        const double x = json_real_value(value) * factors[random_below(WEFT_COUNT(factors))];
        return json_real(x != json_real_value(value) ? x : x + 0.125);
    }
    if (json_is_boolean(value))
        return json_boolean(!json_is_true(value));
    if (json_is_string(value)) {
        char text[128];
        snprintf(text, sizeof text, "%s,taps=1", json_string_value(value));
        return json_string(random_below(3) ? text : "constant");
    }
    return json_real(1.0); // null
}

// All but words that nothing follows from, and what is asked (the worst case) and done (numbers of
// passes), where another one may do as well, as floats that are subtracted twice turned: the run
// tells.
static bool is_claim(const char *key)
{
    static const char *const others[] = {"order",     "search_seconds", "worst_case", "kind",
                                         "slot",      "clears",         "initial",    "part",
                                         "bias",      "subtract",       "divisor",    "offset",
                                         "ping_pong", "denominator",    "numerator",  "sign",
                                         "shift",     "piece",          "tap",        "threshold"};
    for (size_t i = 0; i < WEFT_COUNT(others); i++)
        if (strcmp(key, others[i]) == 0)
            return false;
    return true;
}

// Changes one value somewhere below; its key, or that of its list.
static const char *mutate(json_t *at, const char *key)
{
    const bool list = json_is_array(at);
    const size_t count = list ? json_array_size(at) : json_object_size(at);
    if (count == 0)
        return NULL;
    size_t n = random_below((uint32_t)count);
    void *entry = list ? NULL : json_object_iter(at);
    for (size_t i = 0; entry && i < n; i++)
        entry = json_object_iter_next(at, entry);
    json_t *value = list ? json_array_get(at, n) : json_object_iter_value(entry);
    key = list ? key : json_object_iter_key(entry);
    if (json_is_object(value) || json_is_array(value))
        return mutate(value, key);
    if (list)
        json_array_set_new(at, n, changed(value));
    else
        json_object_iter_set_new(at, entry, changed(value));
    return key;
}

struct tally {
    int plans, mutants, answers[ANSWERS];
};

static void mutate_plan(const json_t *root, int mutants, struct tally *tally)
{
    for (int done = 0; done < mutants;) {
        json_t *copy = json_deep_copy(root);
        const char *key = mutate(copy, "");
        weft_pass_plan *plan = NULL;
        if (key && !json_equal(copy, root)) {
            const enum answer answer = judge(copy, &plan);
            if (answer == VALID && is_claim(key))
                fail_msg("%s was changed, and the plan is called valid:\n%s", key,
                         weft_pass_plan_get_info(plan)->text);
            if (answer == VALID) {
                check_run(plan, copy, true);
                check_run(plan, copy, false);
            }
            tally->answers[answer]++;
            tally->mutants++;
            done++;
        }
        weft_pass_plan_destroy(&plan);
        json_decref(copy);
    }
}

static void judge_plan(const struct weft_pass_plan_params *params, int mutants, struct tally *tally)
{
    weft_pass_plan *plan = NULL, *judged = NULL;
    if (weft_pass_plan_create(params, &plan) != WEFT_OK)
        return;
    json_t *root = plan_json(plan);
    assert_non_null(root);
    const bool valid = weft_pass_plan_get_info(plan)->valid;
    assert_int_equal(judge(root, &judged), valid ? VALID : INVALID);
    if (valid)
        assert_string_equal(weft_pass_plan_get_info(judged)->text,
                            weft_pass_plan_get_info(plan)->text);
    mutate_plan(root, mutants, tally);
    tally->plans++;
    json_decref(root);
    weft_pass_plan_destroy(&judged);
    weft_pass_plan_destroy(&plan);
}

// 30 requests, of which those that a profile has no means for are none.
static void no_mutant_is_believed(void **state)
{
    (void)state;
    static const char *const kernels[] = {"catmull-rom", "linear", "mitchell", "bspline2"};
    const bool all = getenv("WEFT_PLAN_MUTANTS") != NULL;
    const int mutants = (all ? atoi(getenv("WEFT_PLAN_MUTANTS")) : FEW) / 24 + 1;
    struct tally tally = {0};
    const int screen = dup(STDERR_FILENO), nowhere = open("/dev/null", O_WRONLY);
    assert_true(screen >= 0 && nowhere >= 0);
    if (!getenv("WEFT_PASS_PLAN_MUTANTS_TOLD"))
        dup2(nowhere, STDERR_FILENO); // a line for every refusal
    for (int i = 0; weft_profile_list[i]; i++) {
        for (int t = 0; weft_technique_names[t]; t++) {
            struct weft_pass_plan_params *p =
                weft_pass_plan_params(.kernel = kernel_named(kernels[(i + t) % 4]),
                                      .profile = *weft_profile_list[i],
                                      .technique = (enum weft_technique)t, .samples = 4 + i % 3,
                                      .dims = 2 + (t + i) % 2);
            p->worst_case = (enum weft_worst_case)((i + 2 * t) % 3 == 1);
            p->order = (2 * i + t) % 5 == 2 ? WEFT_ORDER_NATURAL : WEFT_ORDER_PLANNED;
            // A table of 131071 logarithms takes a while to read.
            if (all || t != WEFT_TECHNIQUE_LOG || p->profile.target != WEFT_TARGET_UNORM16)
                judge_plan(p, mutants, &tally);
        }
    }
    dup2(screen, STDERR_FILENO);
    close(screen);
    close(nowhere);
    print_message("%d mutants of %d plans: %d refused, %d invalid, %d valid\n", tally.mutants,
                  tally.plans, tally.answers[REFUSED], tally.answers[INVALID],
                  tally.answers[VALID]);
    assert_true(tally.plans >= 22 && tally.mutants >= tally.plans * mutants);
    for (int i = 0; i < ANSWERS; i++)
        assert_true(tally.answers[i] > 0);
}

static int make_file(void **state)
{
    (void)state;
    const int fd = mkstemp(path);
    return fd < 0 ? -1 : close(fd);
}

static int remove_file(void **state)
{
    (void)state;
    return unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(no_mutant_is_believed, make_file, remove_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
