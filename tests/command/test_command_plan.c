// SPDX-License-Identifier: BSD-3-Clause
// weft plan and weft validate as their users see them, and what they refuse.
#include <ctype.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

// Tap by tap.
#define NATURAL "0,0 1,0 2,0 3,0 0,1 1,1 2,1 3,1 0,2 1,2 2,2 3,2 0,3 1,3 2,3 3,3"

static struct command_result result;

static bool flag(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_boolean(value))
        fail_msg("no flag %s", key);
    return json_is_true(value);
}

static void write_json(const char *path, const json_t *root)
{
    assert_int_equal(json_dump_file(root, path, 0), 0);
}

// What `weft plan ... --json` prints, kept in plan.json too.
#define make_plan(...) make_plan_list((const char *[]){"weft", "plan", "--json", __VA_ARGS__, NULL})
static json_t *make_plan_list(const char *const *argv)
{
    const char *out = command_succeeds_list(__FILE__, __LINE__, argv);
    assert_true(strlen(out) < sizeof result.out - 1);
    command_write_file("plan.json", out, strlen(out));
    return parse(out);
}

// `weft validate` must end with the code and print one line that holds `text`.
#define answers(code, text, ...)                                                                   \
    answers_list(__LINE__, code, text, (const char *[]){"weft", "validate", __VA_ARGS__, NULL})
static void answers_list(int line, int code, const char *text, const char *const *argv)
{
    command_run_list(&result, argv);
    const char *end = strchr(result.out, '\n');
    if (result.code == code && end && !end[1] && strstr(result.out, text) && !result.err[0])
        return;
    print_error("expected exit code %d and \"%s\", not %d\n%s%s", code, text, result.code,
                result.out, result.err);
    _fail(__FILE__, line);
}

// ---- plans --------------------------------------------------------------------------------------

static void assert_same_error(const json_t *error, const struct weft_pass_plan_error *expected)
{
    assert_true(number(error, "source") == expected->source);
    assert_true(number(error, "e2") == expected->e2);
    assert_true(number(error, "e3") == expected->e3);
    assert_true(number(error, "clamp") == expected->clamp);
    assert_true(number(error, "total") == expected->bound);
    assert_true(number(error, "any") == expected->bound_any);
}

static void assert_same_ranges(const json_t *list, const struct weft_pass_plan_info *info)
{
    assert_int_equal(json_array_size(list), info->passes->pass_count);
    for (int i = 0; i < info->passes->pass_count; i++) {
        const json_t *entry = json_array_get(list, (size_t)i);
        const json_t *range = json_object_get(entry, "range");
        range = range ? range : entry;
        assert_true(number(range, "minimum") == info->ranges[i].minimum);
        assert_true(number(range, "maximum") == info->ranges[i].maximum);
        const json_t *at = json_object_get(range, "maximum_at");
        for (int a = 0; a < info->dims; a++)
            assert_int_equal(json_integer_value(json_array_get(at, (size_t)a)),
                             info->ranges[i].maximum_at[a]);
    }
}

static void assert_same_plan(const json_t *root, const struct weft_pass_plan_info *info)
{
    const json_t *profile = json_object_get(root, "profile");
    assert_same_error(json_object_get(root, "bound_parts"), &info->error);
    assert_same_ranges(json_object_get(root, "passes"), info);
    assert_int_equal(flag(root, "valid"), info->valid);
    assert_true(number(root, "tile_bytes") == (double)info->tile_bytes);
    assert_true(number(root, "fetches") == info->fetches);
    assert_true(number(root, "pass_count") == info->passes->pass_count);
    assert_true(number(root, "tap_count") == info->tap_count);
    assert_true(number(root, "bits") == info->bits);
    assert_string_equal(json_string_value(json_object_get(profile, "name")), info->profile.name);
    assert_true(number(profile, "internal_bits") == info->profile.internal_bits);
    assert_true(number(profile, "taps") == info->profile.taps_per_pass);
}

// The validator rebuilds tiles and passes from the file: its ranges are the plan's, to the bit.
static void assert_round_trip(const struct weft_pass_plan_info *info)
{
    command_run(&result, "weft", "validate", "plan.json", "--json");
    if (result.code != !info->valid)
        fail_msg("exit code %d: %s%s", result.code, result.out, result.err);
    json_t *root = parse(result.out);
    assert_int_equal(flag(root, "valid"), info->valid);
    assert_same_ranges(json_object_get(root, "ranges"), info);
    assert_true(number(root, "overflow") == info->range.overflow);
    const json_t *problem = json_object_get(root, "problem");
    assert_int_equal(json_is_null(problem), info->valid);
    if (!info->valid) {
        assert_true(number(problem, "pass") == info->range.pass);
        assert_true(number(problem, "value") == info->range.value);
    }
    json_decref(root);
    answers(!info->valid, info->valid ? "valid: range [" : "invalid: pass ", "plan.json");
}

static void assert_text(const char *out, const struct weft_pass_plan_info *info)
{
    const size_t size = strlen(info->text);
    char first[32];
    if (strncmp(out, info->text, size) != 0 || strlen(out + size) > 1)
        fail_msg("%s\ninstead of\n%s", out, info->text);
    for (int i = 0; i < info->passes->pass_count; i++) {
        snprintf(first, sizeof first, "\npass %02d: ", i);
        assert_non_null(strstr(out, first));
    }
}

// One profile and technique: the command has what the library says, in text and JSON.
static void compare(const struct weft_profile *profile, int technique, int *planned)
{
    const char *name = weft_technique_names[technique];
    weft_pass_plan *plan = NULL;
    enum weft_result res = weft_pass_plan_create(
        weft_pass_plan_params(.profile = *profile, .technique = (enum weft_technique)technique,
                              .samples = 16),
        &plan);
    if (res != WEFT_OK) {
        command_fails(3, "plan: ", "plan", "--profile", profile->name, "--technique", name,
                      "--resolution", "16");
        return;
    }
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    (*planned)++;
    assert_text(command_succeeds("plan", "--profile", profile->name, "--technique", name,
                                 "--resolution", "16"),
                info);
    // A table of logarithms of 16-bit codes is longer than what is kept of the output here.
    if (technique != WEFT_TECHNIQUE_LOG || profile->target != WEFT_TARGET_UNORM16) {
        json_t *root = make_plan("--profile", profile->name, "--technique", name, "-m", "16");
        assert_same_plan(root, info);
        assert_round_trip(info);
        json_decref(root);
    }
    weft_pass_plan_destroy(&plan);
}

static void every_profile_and_technique(void **state)
{
    (void)state;
    int planned[5] = {0};
    for (int i = 0; weft_profile_list[i]; i++)
        for (int technique = 0; weft_technique_names[technique]; technique++)
            compare(weft_profile_list[i], technique, &planned[technique]);
    for (size_t i = 0; i < COUNT(planned); i++)
        assert_true(planned[i] > 0);
    unlink("plan.json");
}

static void other_plans_make_the_trip(void **state)
{
    (void)state;
    static const char *const cases[][7] = {
        {"-k", "bspline", "-d", "3", "-m", "8"},
        {"-k", "mitchell", "--derivative", "y", "-m", "16"},
        {"-k", "bspline", "--derivative", "xy", "--profile", "unorm16"},
        {"-k", "bspline", "--derivative", "xx", "--profile", "unorm16"},
        {"-k", "d-bspline", "--profile", "geforce3", "-m", "16"},
        {"-k", "catmull-rom", "--round-singly", "--single-bias", "-m", "16"},
        {"-k", "linear+radial+unit", "--profile", "radeon8500", "-m", "16"},
        {"-k", "catmull-rom", "--channels", "4", "--profile", "fp16"},
        {"-k", "lanczos:2", "-w", "any", "--profile", "geforce3,taps=1"},
        {"-k", "keys6", "-b", "6", "-m", "7", "--blend-only"},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        const char *const *c = cases[i];
        json_decref(make_plan(c[0], c[1], c[2] ? c[2] : "-q", c[3] ? c[3] : "-q",
                              c[4] ? c[4] : "-q", c[5] ? c[5] : "-q", c[6] ? c[6] : "-q"));
        answers(0, "valid: range [", "plan.json");
    }
    unlink("plan.json");
}

// ---- orders that clamp --------------------------------------------------------------------------

static void naive_orders_are_named(void **state)
{
    (void)state;
    assert_non_null(
        strstr(command_succeeds("plan", "--order", "natural", "--profile", "geforce3"),
               "INVALID for constants of any level: stores clamp by up to 35 codes; the "
               "first is pass 01, with -0.0824"));
    json_t *root = make_plan("--order", "natural", "--profile", "geforce3");
    assert_false(flag(root, "valid"));
    const json_t *outside = json_object_get(json_object_get(root, "range"), "first_outside");
    assert_true(number(outside, "pass") == 1 && number(outside, "value") < 0);
    answers(1,
            "invalid: pass 01 (taps (1,0) (2,0), subtract) leaves [0, 1]: -0.0823529 (-21.0 LSB) "
            "at sample position (49, 18)",
            "plan.json");
    json_decref(root);
    command_run(&result, "weft", "validate", "plan.json", "--json");
    assert_int_equal(result.code, 1);
    root = parse(result.out);
    const json_t *problem = json_object_get(root, "problem");
    assert_true(number(problem, "pass") == 1 && fabs(number(problem, "lsb") + 21.0) < 1e-9);
    assert_int_equal(json_array_size(json_object_get(problem, "taps")), 2);
    json_decref(root);
    unlink("plan.json");
}

static void worst_case_is_the_files_or_given(void **state)
{
    (void)state;
    json_decref(make_plan("--profile", "geforce3"));
    answers(0, "valid: range [0, 0.996078] over 8 passes", "plan.json");
    answers(0, "valid: range [0, 0.99", "plan.json", "--worst-case", "constant");
    answers(1, "invalid: pass ", "plan.json", "--worst-case", "any");
    unlink("plan.json");
}

static void orders_by_hand(void **state)
{
    (void)state;
    answers(1, "invalid: pass 01 (taps (1,0), subtract) leaves [0, 1]: -0.07", "--order", NATURAL);
    answers(0, "valid: range [0, 1] over 2 passes", "--order", NATURAL, "--taps-per-pass", "8");
    answers(0, "over 4 passes", "--order", "0,0;1,0; 0,1\t1,1", "--kernel", "linear");
    answers(0, "over 8 passes", "--dims", "3", "-k", "linear", "--order",
            "0,0,0 1,0,0 0,1,0 1,1,0 0,0,1 1,0,1 0,1,1 1,1,1");
    answers(0, "over 5 passes", "--order", "0,0 1,0+ 0,1 1,1/1 1,1", "--split", "1,1@0.5", "-k",
            "linear");
    answers(0, "over 6 passes", "--order", "0,0 1,0 0,1 1,1/1 1,1 1,1/2", "--split",
            "1,1@0.5;1,1/1@0.2", "-k", "linear");
    // The order that the planner found is one that can be given; roundings, for which the planner
    // scales and a given order does not, may take it some codes beyond.
    json_t *root = make_plan("--profile", "geforce3", "-t", "1", "-m", "16");
    const json_t *passes = json_object_get(root, "passes");
    char order[512] = "";
    for (size_t i = 0; i < json_array_size(passes); i++) {
        const json_t *group =
            json_array_get(json_object_get(json_array_get(passes, i), "groups"), 0);
        const json_t *tap =
            json_object_get(json_array_get(json_object_get(group, "taps"), 0), "tap");
        const size_t used = strlen(order);
        snprintf(order + used, sizeof order - used, "%d,%d ",
                 (int)json_integer_value(json_array_get(tap, 0)),
                 (int)json_integer_value(json_array_get(tap, 1)));
    }
    json_decref(root);
    command_run(&result, "weft", "validate", "--order", order, "--profile", "geforce3", "-m", "16",
                "--json");
    json_t *given = parse(result.out);
    assert_int_equal(json_array_size(json_object_get(given, "ranges")), 16);
    assert_true(number(given, "overflow") <= 4.0 / 255.0 + 1e-9);
    json_decref(given);
    unlink("plan.json");
}

static void orders_refused(void **state)
{
    (void)state;
    static const struct {
        const char *order, *text;
    } cases[] = {
        {NATURAL " 0,0", "(0,0) comes twice"},
        {"0,0", "(1,0)- is missing"},
        {NATURAL " 0,9", "no tile (0,9)"},
        {NATURAL " 1,1-", "no tile (1,1)-"},
        {NATURAL " 1,1/1", "no tile (1,1)/1"},
        {"a", "--order: 'a' is not a tap as 1,0,"},
        {"0,0 1 0,1", "--order: '1' is not a tap"},
        {"0,0,1", "--order: '0,0,1' is not a tap"},
        {"0,0x", "--order: '0,0x' is not a tap"},
        {"0,123456", "--order: '0,123456' is not a tap"},
        {"0,0/", "--order: '0,0/' is not a tap"},
        {" ; ", "there is no tap in it"},
    };
    for (size_t i = 0; i < COUNT(cases); i++)
        command_fails(2, cases[i].text, "validate", "--order", cases[i].order);
    command_fails(2, "'0,0' is not a tap as 1,0,2,", "validate", "-d", "3", "--order", "0,0");
    static const char *const splits[] = {"1,1", "1,1@", "1,1@x", "1,1@nan", "1,1@1e999", "1,1@ 1"};
    for (size_t i = 0; i < COUNT(splits); i++)
        command_fails(2, "and @T with a threshold", "validate", "--order", NATURAL, "--split",
                      splits[i]);
    command_fails(2, "no tile (9,9)", "validate", "--order", NATURAL, "--split", "9,9@0.5");
    command_fails(3, "finds its own groups", "validate", "--order", NATURAL, "--technique", "dot4");
}

// ---- plans that were changed --------------------------------------------------------------------

static json_t *passes_of(json_t *root)
{
    return json_object_get(root, "passes");
}

static json_t *pass_of(json_t *root, size_t number)
{
    return json_array_get(passes_of(root), number);
}

static json_t *tap_of(json_t *root, size_t pass)
{
    const json_t *group = json_array_get(json_object_get(pass_of(root, pass), "groups"), 0);
    return json_array_get(json_object_get(group, "taps"), 0);
}

static size_t first_subtraction(json_t *root)
{
    size_t at = 0;
    while (!json_is_true(json_object_get(pass_of(root, at), "subtract")))
        at++;
    return at;
}

static void swap_passes(json_t *root)
{
    static const char *const keys[] = {"groups", "subtract"};
    json_t *a = pass_of(root, 0), *b = pass_of(root, first_subtraction(root));
    for (size_t i = 0; i < COUNT(keys); i++) {
        json_t *kept = json_incref(json_object_get(a, keys[i]));
        json_object_set(a, keys[i], json_object_get(b, keys[i]));
        json_object_set_new(b, keys[i], kept);
    }
}

static void swap_whole_passes(json_t *root)
{
    json_t *first = json_incref(pass_of(root, 0));
    json_array_set(passes_of(root), 0, pass_of(root, 1));
    json_array_set_new(passes_of(root), 1, first);
}

static void drop_pass(json_t *root)
{
    json_array_remove(passes_of(root), 3);
}

static void clear_late(json_t *root)
{
    json_object_set_new(pass_of(root, 3), "clears", json_true());
}

static void repeat_pass(json_t *root)
{
    json_array_append(passes_of(root), pass_of(root, 5));
}

static void turn_sign(json_t *root)
{
    json_object_set_new(
        tap_of(root, 2), "sign",
        json_integer(-json_integer_value(json_object_get(tap_of(root, 2), "sign"))));
}

static void shift_tap(json_t *root)
{
    json_object_set_new(tap_of(root, 0), "shift", json_integer(1));
}

static void turn_subtraction(json_t *root)
{
    json_object_set_new(pass_of(root, first_subtraction(root)), "subtract", json_false());
}

static void halve_divisor(json_t *root)
{
    json_t *pass = pass_of(root, 1);
    json_object_set_new(pass, "divisor",
                        json_integer(2 * json_integer_value(json_object_get(pass, "divisor"))));
}

static void add_bias(json_t *root)
{
    json_object_set_new(pass_of(root, 1), "bias", json_integer(100));
}

static void move_sample(json_t *root)
{
    json_t *group = json_array_get(json_object_get(pass_of(root, 1), "groups"), 0);
    json_object_set_new(group, "offset", json_pack("[ii]", 0, 0));
    json_object_set_new(tap_of(root, 1), "tap", json_pack("[ii]", 1, 1));
}

static void leave_the_kernel(json_t *root)
{
    json_object_set_new(tap_of(root, 1), "tap", json_pack("[ii]", 7, 1));
}

static void unknown_kernel(json_t *root)
{
    json_object_set_new(root, "kernel", json_string("nope"));
}

static void missing_member(json_t *root)
{
    json_object_del(pass_of(root, 2), "divisor");
}

static void wrong_word(json_t *root)
{
    json_object_set_new(pass_of(root, 2), "part", json_string("middle"));
}

static void too_many_slots(json_t *root)
{
    json_object_set_new(json_object_get(root, "targets"), "slots", json_integer(1000000));
}

static void huge_resolution(json_t *root)
{
    json_object_set_new(root, "resolution", json_integer(4096));
    json_object_set_new(root, "kernel", json_string("lanczos:8"));
}

static void too_many_groups(json_t *root)
{
    json_t *groups = json_object_get(pass_of(root, 0), "groups");
    json_array_append(groups, json_array_get(groups, 0));
    json_array_append(groups, json_array_get(groups, 0));
}

static void no_such_slot(json_t *root)
{
    json_object_set_new(pass_of(root, 0), "slot", json_integer(1));
}

static void no_passes(json_t *root)
{
    json_array_clear(passes_of(root));
}

static void split_without_piece(json_t *root)
{
    json_array_append_new(
        json_object_get(json_object_get(root, "tile_set"), "splits"),
        json_pack("{s:[ii],s:s,s:i,s:f}", "tap", 1, 1, "part", "+", "piece", 0, "threshold", 0.5));
}

static void changed_plans(void **state)
{
    (void)state;
    static const struct {
        void (*change)(json_t *root);
        int code;
        const char *text;
    } cases[] = {
        {swap_passes, 1, "invalid: pass 00 (taps "},
        {swap_whole_passes, 3, "pass 00 reads slot 0, which holds nothing"},
        {drop_pass, 1, " is missing"},
        {clear_late, 1, " is missing"},
        {repeat_pass, 1, " is there twice"},
        {turn_sign, 1, " counts -1 times"},
        {shift_tap, 1, " is there twice"},
        {turn_subtraction, 1, " blends a sum outside [0, 1]: -0."},
        {halve_divisor, 1, " counts 0.5 times"},
        {add_bias, 1, "invalid: the bias of the passes is "},
        {move_sample, 3, "passes[1].groups[0].offset is not where tap (1,1)+ has its sample"},
        {leave_the_kernel, 3, "passes[1].groups[0].tap and part and piece (7,1)"},
        {unknown_kernel, 3, "no kernel 'nope'; there are nearest, area, linear, "},
        {missing_member, 3, "plan.json: passes[2].divisor is missing"},
        {wrong_word, 3, "passes[2].part is not one of: whole, high, low"},
        {too_many_slots, 3, "targets.slots is not a whole number from 1 to "},
        {huge_resolution, 3, "over the limit of 1073741824"},
        {too_many_groups, 3, "passes[0].groups is not a list of 0 to 2 entries"},
        {no_such_slot, 3, "passes[0].slot is not a whole number from 0 to 0"},
        {no_passes, 3, "passes is not a list of 1 to "},
        {split_without_piece, 1, "invalid: tap (1,1)/1 is missing"},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        json_t *root = make_plan("--profile", "geforce3", "-m", "16");
        cases[i].change(root);
        write_json("plan.json", root);
        json_decref(root);
        if (cases[i].code == 1)
            answers(1, cases[i].text, "plan.json");
        else
            command_fails(cases[i].code, cases[i].text, "validate", "plan.json");
    }
    command_run(&result, "weft", "validate", "plan.json", "--json");
    json_t *root = parse(result.out);
    const json_t *problem = json_object_get(root, "problem");
    assert_string_equal(json_string_value(json_object_get(problem, "kind")), "tap");
    assert_true(number(problem, "times") == 0.0);
    json_decref(root);
    unlink("plan.json");
}

// ---- what a plan says of itself -----------------------------------------------------------------

static void set_in(json_t *root, const char *object, const char *key, json_t *value)
{
    json_object_set_new(object ? json_object_get(root, object) : root, key, value);
}

static void zero_logarithms(json_t *root)
{
    json_t *table = json_object_get(json_object_get(root, "targets"), "log_table");
    for (size_t i = 0; i < json_array_size(table); i++)
        json_array_set_new(table, i, json_integer(0));
}

static void claim_log_scale(json_t *root)
{
    set_in(root, "targets", "result_scale", json_real(0.5));
}

static void claim_octaves(json_t *root)
{
    set_in(root, "targets", "log_octaves", json_real(11.0));
}

static void claim_scale(json_t *root)
{
    set_in(root, "targets", "result_scale", json_real(1.00001));
}

static void claim_range(json_t *root)
{
    set_in(root, "targets", "range", json_real(8.0));
}

static void claim_exact_sums(json_t *root)
{
    set_in(root, "targets", "exact_inside", json_true());
}

static void claim_bits(json_t *root)
{
    set_in(root, "targets", "extra_bits", json_integer(8));
}

static void claim_dot(json_t *root)
{
    set_in(root, "targets", "dot_width", json_integer(4));
}

static void claim_no_scratch(json_t *root)
{
    set_in(root, "targets", "scratch", json_integer(3));
}

static void claim_profile(json_t *root)
{
    set_in(root, "profile", "taps", json_integer(6));
}

static void claim_bound(json_t *root)
{
    set_in(root, "bound_parts", "total", json_real(0.001));
}

static void claim_fetches(json_t *root)
{
    set_in(root, NULL, "fetches", json_integer(1));
}

static void claim_pass_range(json_t *root)
{
    set_in(json_object_get(pass_of(root, 1), "range"), NULL, "maximum", json_real(0.5));
}

static void claim_more(json_t *root)
{
    set_in(root, NULL, "certified", json_true());
}

static void read_a_file(json_t *root)
{
    set_in(root, NULL, "kernel", json_string("table:/etc/passwd"));
}

static void claims_are_judged(void **state)
{
    (void)state;
    static const struct {
        const char *technique;
        void (*change)(json_t *root);
        int code;
        const char *text;
    } cases[] = {
        {"log", zero_logarithms, 3, "targets.log_table[0] is 0, not "},
        {"log", claim_log_scale, 3, "targets.log_table[0] is "},
        {"log", claim_octaves, 3, "targets.log_octaves is 11.0, not 10.0"},
        {"plain", claim_scale, 1, "invalid: the scale of the passes is "},
        {"plain", claim_range, 3, "targets.range is 8, not 1"},
        {"plain", claim_exact_sums, 3, "targets.exact_inside is true, with 9 bits inside"},
        {"plain", claim_bits, 3, "targets.extra_bits is 8, not 1"},
        {"dot4", claim_dot, 3, "targets.dot_width is 4, not 3"},
        {"plain", claim_no_scratch, 3, "targets.scratch is 3, not 0"},
        {"plain", claim_profile, 3, "profile.taps is 6, not 2"},
        {"plain", claim_bound, 3, "bound_parts.total is 0.001, not 0."},
        {"plain", claim_fetches, 3, "fetches is 1, not "},
        {"plain", claim_pass_range, 3, "passes[1].range.maximum is 0.5, not 0."},
        {"plain", claim_more, 3, "certified is no member of a plan"},
        {"plain", read_a_file, 3, "kernel is a table in a file; a plan that is read names none"},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        json_t *root =
            make_plan("--profile", "geforce3", "-m", "16", "--technique", cases[i].technique);
        answers(0, "valid: range [0, ", "plan.json");
        cases[i].change(root);
        write_json("plan.json", root);
        json_decref(root);
        if (cases[i].code == 1)
            answers(1, cases[i].text, "plan.json");
        else
            command_fails(cases[i].code, cases[i].text, "validate", "plan.json");
    }
    unlink("plan.json");
}

static void put_text(const char *path, const char *text, int repeats)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    for (int i = 0; i < repeats; i++)
        assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void hostile_files(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int repeats;
        const char *expected;
    } cases[] = {
        {"", 1, "is no JSON"},
        {"hello", 1, "is no JSON"},
        {"[", 100000, "is no JSON"},
        {"{\"a\":", 100000, "is no JSON"},
        {"[1]", 1, "is JSON, but no plan"},
        {"{}", 1, "format is missing"},
        {"{\"format\":\"other\"}", 1, "format is not one of: weft-plan"},
        {"{\"format\":\"weft-plan\",\"version\":2}", 1, "version is not a whole number"},
        {"{\"a\":1,\"a\":1}", 1, "is no JSON"},
        {"{\"a\":99999999999999999999}", 1, "is no JSON"},
        {"{\"a\":1e999}", 1, "is no JSON"},
        {"[],", 8 << 20, "so many values take"},
        {"          ", 7 << 20, "the limit for a plan"},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        put_text("plan.json", cases[i].text, cases[i].repeats);
        command_fails(3, cases[i].expected, "validate", "plan.json");
    }
    command_fails(3, "No such file", "validate", "none.json");
    command_fails(3, "cannot be read", "validate", "/tmp");
    json_decref(make_plan("-m", "16"));
    size_t size;
    char *whole = command_read_file("plan.json", &size);
    for (size_t cut = 0; cut + 16 < size; cut += size / 20) {
        command_write_file("plan.json", whole, cut);
        command_fails(3, "is no JSON", "validate", "plan.json");
    }
    command_write_file("plan.json", whole, size);
    command_fails(3, "over the limit of 1000", "validate", "plan.json", "--memory", "1000");
    free(whole);
    unlink("plan.json");
}

// Replaces one value after the other by what it cannot be, or may just be.
static void disturb(json_t *root, json_t *parent, const char *key, size_t index, int *runs)
{
    static const char *const values[] = {"null", "-1", "2147483647", "1.5e300", "\"x\"", "[]"};
    json_t *value = key ? json_object_get(parent, key) : json_array_get(parent, index);
    for (size_t i = 0; i < COUNT(values); i++) {
        json_incref(value);
        json_t *other = json_loads(values[i], JSON_DECODE_ANY, NULL);
        key ? json_object_set_new(parent, key, other) : json_array_set_new(parent, index, other);
        write_json("plan.json", root);
        key ? json_object_set_new(parent, key, value) : json_array_set_new(parent, index, value);
        command_run(&result, "weft", "validate", "plan.json");
        const bool refused =
            result.code == 3 && !result.out[0] && strncmp(result.err, "weft: error: ", 13) == 0;
        const bool answered = (result.code == 0 || result.code == 1) && !result.err[0];
        if (!refused && !answered)
            fail_msg("%s[%zu] = %s: %d\n%s%s", key ? key : "", index, values[i], result.code,
                     result.out, result.err);
        (*runs)++;
    }
}

// The figures are not read.
static bool is_read(const char *key)
{
    static const char *const skipped[] = {"range",      "bound_parts", "tiles",     "tap_count",
                                          "tile_count", "fetches",     "kept_bits", "description"};
    for (size_t i = 0; i < COUNT(skipped); i++)
        if (strcmp(key, skipped[i]) == 0)
            return false;
    return true;
}

static void disturb_all(json_t *root, json_t *at, int *runs)
{
    const char *key;
    json_t *value, *copy = json_copy(at);
    size_t i;
    json_object_foreach(copy, key, value)
    {
        if (is_read(key)) {
            disturb(root, at, key, 0, runs);
            disturb_all(root, value, runs);
        }
    }
    json_array_foreach(copy, i, value)
    {
        if (i > 0) // the first one's stands for all
            continue;
        disturb(root, at, NULL, i, runs);
        disturb_all(root, value, runs);
    }
    json_decref(copy);
}

static void any_value_may_be_wrong(void **state)
{
    (void)state;
    static const char *const techniques[] = {"dot4", "split-precision"};
    for (size_t i = 0; i < COUNT(techniques); i++) {
        json_t *root = make_plan("-k", "linear", "-m", "4", "--profile", "geforce3", "--technique",
                                 techniques[i]);
        int runs = 0;
        // Only the first and the last pass, which combines.
        while (json_array_size(passes_of(root)) > 2)
            json_array_remove(passes_of(root), 1);
        disturb_all(root, root, &runs);
        assert_true(runs > 300);
        json_decref(root);
    }
    unlink("plan.json");
}

// ---- the rest -----------------------------------------------------------------------------------

static void through_a_pipe(void **state)
{
    (void)state;
    static const struct {
        const char *plan, *validate;
        int code;
    } cases[] = {
        {"--profile radeon8500", "", 0},
        {"--profile radeon8500", "--worst-case any", 1},
        {"-d 3 --profile unorm16 -b 10 -m 8", "", 0},
        {"-d 3 --profile geforce3 -m 8", "-q", 0},
        {"--profile unorm16 --technique log", "", 0},
        {"-k nope 2>/dev/null", "2>/dev/null", 3},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        char line[1024];
        snprintf(line, sizeof line, "'%s/weft' plan --json %s | '%s/weft' validate - %s >/dev/null",
                 WEFT_BINARY_DIR, cases[i].plan, WEFT_BINARY_DIR, cases[i].validate);
        const int status = system(line);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != cases[i].code)
            fail_msg("%s: status %d", line, status);
    }
}

static void names_are_listed(void **state)
{
    (void)state;
    const char *out = command_succeeds("plan", "--profile", "help");
    for (int i = 0; weft_profile_list[i]; i++) {
        assert_non_null(strstr(out, weft_profile_list[i]->name));
        assert_non_null(strstr(out, weft_profile_list[i]->description));
    }
    assert_non_null(strstr(out, "profile     target   internal-bits  range  taps  dot  max-scale  "
                                "ping-pong\n"));
    assert_non_null(strstr(
        out, "radeon8500  unorm8              12      8     3    4          8         no\n"));
    assert_non_null(strstr(command_succeeds("validate", "--profile", "help"), "geforce3"));
    assert_non_null(strstr(command_succeeds("plan", "--kernel", "help"), "mitchell"));
    command_fails(2, "there are nearest, area, linear,", "plan", "--kernel", "nope");
    command_fails(2, "there are fp32, fp16, unorm16, unorm8, geforce3, radeon8500", "plan",
                  "--profile", "nope");
    command_fails(2, "did you mean taps? There are target, internal-bits,", "plan", "--profile",
                  "geforce3,tap=2");
    command_fails(2, "range takes a number from 1", "plan", "--profile", "range=0");
    command_fails(2, "'x' is not one of: plain, dot4, split-precision, hierarchical, log", "plan",
                  "--technique", "x");
    command_fails(2, "'x' is not one of: planned, greedy, natural", "plan", "--order", "x");
    command_fails(2, "'x' is not one of: constant, any", "validate", "p.json", "-w", "x");
    command_fails(2, "'4' is not one of: 2, 3", "plan", "--dims", "4");
}

// Choices are the library's names, in its order.
static void techniques_are_the_librarys(void **state)
{
    (void)state;
    char list[256] = "";
    for (int i = 0; weft_technique_names[i]; i++) {
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s",
                 i ? ", " : "is not one of: ", weft_technique_names[i]);
    }
    command_fails(2, list, "plan", "--technique", "x");
    json_t *root = make_plan("--technique", "dot4", "-m", "8");
    assert_string_equal(json_string_value(json_object_get(root, "technique")), "dot4");
    json_decref(root);
    unlink("plan.json");
}

static void wrong_usage(void **state)
{
    (void)state;
    command_fails(2, "weft plan takes options only", "plan", "x");
    command_fails(2, "--bits 3: not a whole number from 4 to 16", "plan", "--bits", "3");
    command_fails(2, "--bits 8.5: not a whole", "plan", "--bits", "8.5");
    command_fails(2, "--resolution 0: not a whole", "plan", "--resolution", "0");
    command_fails(2, "--taps-per-pass 17: not a whole", "plan", "--taps-per-pass", "17");
    command_fails(2, "takes 1 to 2 taps per pass, not 3", "plan", "-t", "3", "--profile",
                  "geforce3");
    command_fails(2, "--derivative z needs --dims 3", "plan", "--derivative", "z");
    command_fails(2, "--derivative xz needs --dims 3", "plan", "--derivative", "xz");
    command_fails(2, "no derivative 'xxx': there are x, y", "plan", "--derivative", "xxx");
    command_fails(2, "nothing to validate", "validate");
    command_fails(2, "exclude each other", "validate", "plan.json", "--order", NATURAL);
    command_fails(2, "--split needs --order", "validate", "plan.json", "--split", "0,0@1");
    command_fails(2, "--kernel goes with --order; plan.json says it itself", "validate",
                  "plan.json", "-k", "linear");
    command_fails(2, "one argument too many", "validate", "a.json", "b.json");
    command_fails(3, "over the limit of 1024", "plan", "--memory", "1K");
    command_fails(3, "is for targets of fixed point", "plan", "--profile", "fp32", "--technique",
                  "log");
}

static void help_is_there_and_fits(void **state)
{
    (void)state;
    static const char *const verbs[] = {"plan", "validate"};
    for (size_t i = 0; i < COUNT(verbs); i++) {
        const char *out = command_succeeds("help", verbs[i], "all");
        assert_non_null(strstr(out, "--worst-case constant|any"));
        assert_non_null(strstr(out, "--technique plain|dot4|split-precision|hierarchical|log"));
        for (const char *line = out; *line; line += strcspn(line, "\n") + 1)
            if (strcspn(line, "\n") > 79 && strncmp(line, "  weft ", 7) != 0)
                fail_msg("%.*s", (int)strcspn(line, "\n"), line);
        assert_string_equal(command_succeeds(verbs[i], "--help=all"), out);
    }
    assert_non_null(
        strstr(command_succeeds("validate", "--help=all"), "'invalid: ...', and with exit code"));
    assert_non_null(strstr(command_succeeds("help", "all"), "validate: invalid"));
}

static void ctrl_c_stops_planning(void **state)
{
    (void)state;
    const char *const argv[] = {"weft", "plan", "-d", "3", "-k", "lanczos:4", "-m", "64", NULL};
    const int code = command_interrupt(0.5, SIGINT, argv);
    if (code < 0)
        skip();
    assert_int_equal(code, 128 + SIGINT);
}

// ---- defaults -----------------------------------------------------------------------------------

static int default_of(const char *key, const char *dims, const char *profile, const char *technique)
{
    command_run(&result, "weft", "plan", "--kernel", "linear", "--dims", dims, "--profile", profile,
                "--technique", technique, "--json");
    json_t *plan = parse(result.out);
    const int value = (int)number(plan, key);
    json_decref(plan);
    return value;
}

// With lines that are one.
static void join_lines(const char *text, char *out, size_t size)
{
    size_t used = 0;
    for (; *text && used + 1 < size; text++)
        if (!isspace((unsigned char)*text))
            out[used++] = *text;
        else if (used && out[used - 1] != ' ')
            out[used++] = ' ';
    out[used] = '\0';
}

// What helps say of defaults is what plans have.
static void helps_tell_the_defaults(void **state)
{
    (void)state;
    static const char *const verbs[] = {"plan", "validate", "slice", "resample"};
    static char help[65536];
    char bits[160], samples[80];
    snprintf(bits, sizeof bits,
             "(default %d; on 16-bit targets %d, hierarchical %d, split-precision %d, at most",
             default_of("bits", "2", "unorm8", "plain"),
             default_of("bits", "2", "unorm16", "plain"),
             default_of("bits", "2", "unorm16", "hierarchical"),
             default_of("bits", "2", "unorm16", "split-precision"));
    snprintf(samples, sizeof samples, "(default %d, in 3D %d)",
             default_of("resolution", "2", "unorm8", "plain"),
             default_of("resolution", "3", "unorm8", "plain"));
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++) {
        command_run(&result, "weft", "help", verbs[i], "all");
        join_lines(result.out, help, sizeof help);
        if (!strstr(help, bits) || !strstr(help, samples))
            fail_msg("weft help %s does not say %s and %s", verbs[i], bits, samples);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_profile_and_technique),
        cmocka_unit_test(other_plans_make_the_trip),
        cmocka_unit_test(naive_orders_are_named),
        cmocka_unit_test(worst_case_is_the_files_or_given),
        cmocka_unit_test(orders_by_hand),
        cmocka_unit_test(orders_refused),
        cmocka_unit_test(changed_plans),
        cmocka_unit_test(claims_are_judged),
        cmocka_unit_test(hostile_files),
        cmocka_unit_test(any_value_may_be_wrong),
        cmocka_unit_test(through_a_pipe),
        cmocka_unit_test(names_are_listed),
        cmocka_unit_test(techniques_are_the_librarys),
        cmocka_unit_test(wrong_usage),
        cmocka_unit_test(help_is_there_and_fits),
        cmocka_unit_test(helps_tell_the_defaults),
        cmocka_unit_test(ctrl_c_stops_planning),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
