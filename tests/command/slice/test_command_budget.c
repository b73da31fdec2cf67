// SPDX-License-Identifier: BSD-3-Clause
// weft slice with error budgets, formats, look-ups and savings, as its users see it.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "tests/support/json.h"

static void skip_without_gl(void)
{
    if (!command_has_gl())
        skip();
}

static const char *text(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

// A plane that runs along no axis.
#define OBLIQUE "--origin=0,0,1", "--u", "14,1,2", "--v", "1,13,-.5", "--size", "90x80"

static void budgets_are_kept(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const budgets[] = {"6bit", "8bit", "12bit", "16bit", "0.05", "1e-3"};
    for (size_t i = 0; i < sizeof budgets / sizeof *budgets; i++) {
        json_t *root = parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--max-error", budgets[i],
                                              "--verify", "--json"));
        const json_t *budget = json_object_get(root, "budget"), *candidate;
        const double most = number(budget, "max_error");
        const double range = number(budget, "high") - number(budget, "low");
        int chosen = 0, bits = atoi(budgets[i]);
        size_t k;
        if (strstr(budgets[i], "bit"))
            assert_true(fabs(most - 0.5 * range / ((1 << bits) - 1)) <= 1e-12);
        else
            assert_true(most == atof(budgets[i]));
        assert_true(number(budget, "bound") <= most);
        assert_true(number(json_object_get(root, "error"), "max") <= number(budget, "bound"));
        json_array_foreach(json_object_get(budget, "candidates"), k, candidate)
        {
            if (strcmp(text(candidate, "state"), "chosen"))
                continue;
            chosen++;
            assert_string_equal(text(candidate, "name"), text(budget, "method"));
        }
        assert_int_equal(chosen, 1);
        json_decref(root);
    }
}

static void a_budget_on_a_profile_chooses_its_plan(void **state)
{
    (void)state;
    skip_without_gl();
    json_t *root =
        parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--profile", "unorm16", "--kernel",
                               "linear", "--max-error", "0.2", "--verify", "--json"));
    const json_t *budget = json_object_get(root, "budget");
    assert_non_null(strstr(text(budget, "method"), "passes unorm16 "));
    assert_string_equal(text(json_object_get(root, "pass_plan"), "profile"), "unorm16");
    assert_true(number(json_object_get(root, "error"), "max") <= 0.2);
    json_decref(root);
}

// Half a code is one of the voxels' range, not of their coefficients'; messages name the voxels.
static void bits_are_the_voxels_own(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const kernels[] = {"bspline3i", "bspline7i", "omomsi"};
    json_t *plain = parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--max-error", "8bit",
                                           "--kernel", "bspline7", "--json"));
    for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) {
        json_t *root = parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--max-error", "8bit",
                                              "--kernel", kernels[i], "--verify", "--json"));
        const json_t *budget = json_object_get(root, "budget");
        const double low = number(budget, "low"), high = number(budget, "high");
        assert_true(low >= 0.0 && high <= 1.0); // coefficients reach beyond
        assert_true(fabs(high - number(json_object_get(plain, "budget"), "high")) < 0.02);
        assert_true(fabs(number(budget, "max_error") - 0.5 * (high - low) / 255.0) < 1e-12);
        assert_true(number(json_object_get(root, "error"), "max") <= number(budget, "max_error"));
        json_decref(root);
    }
    json_decref(plain);
    command_fails(1, "voxels from 0 to 0.99", "slice", "ml.vdb", "-o", "no.exr", "--max-error",
                  "1e-12", "--kernel", "bspline5i");
}

static void what_was_considered_is_explained(void **state)
{
    (void)state;
    const char *out = command_succeeds("slice", "ml.vdb", "--max-error", "12bit", "--explain");
    static const char *const parts[] = {"for voxels from 0 to 0.",
                                        "method ",
                                        "chosen",
                                        "exceeds",
                                        "separable",
                                        "fastest",
                                        "E1 of the ",
                                        "passes unorm8",
                                        "tile 00",
                                        "savings:",
                                        "cost model"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        if (!strstr(out, parts[i]))
            fail_msg("'%s' is not in: %s", parts[i], out);
}

static void what_cannot_be_met_is_refused(void **state)
{
    (void)state;
    command_fails(1, "no method is within 1e-12: the best is ", "slice", "ml.vdb", "-o", "no.exr",
                  "--max-error", "1e-12");
    command_fails(1, "the best is passes unorm8", "slice", "ml.vdb", "-o", "no.exr", "--max-error",
                  "8bit", "--profile", "unorm8", "--kernel", "nearest");
    static const char *const bad[] = {"many", "-1",  "0bit",   "25bit", "8bits",
                                      "nan",  "inf", "8.5bit", "0x1"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char option[32];
        snprintf(option, sizeof option, "--max-error=%s", bad[i]);
        command_fails(2, "half a code", "slice", "ml.vdb", "-o", "no.exr", option);
    }
    command_fails(2, "--max-error chooses what", "slice", "ml.vdb", "--json", "--max-error", "8bit",
                  "--source", "unorm8");
    command_fails(2, "--max-error chooses what", "slice", "ml.vdb", "--json", "--max-error", "8bit",
                  "--profile", "unorm8", "--technique", "dot4");
    command_fails(2, "--source, --lookup and --clamp", "slice", "ml.vdb", "--json", "--profile",
                  "unorm8", "--clamp");
    command_fails(2, "need --profile", "slice", "ml.vdb", "--json", "--resolution", "16");
    command_fails(2, "need --profile", "slice", "ml.vdb", "--json", "--lookup", "polynomial",
                  "--resolution", "16");
    command_fails(2, "1 to 4096", "slice", "ml.vdb", "--json", "--lookup", "nearest",
                  "--resolution", "5000");
    command_fails(2, "there are constant, axis, separable, smooth and all", "slice", "ml.vdb",
                  "--json", "--without", "constant,bricks");
    command_fails(2, "LO must be less than HI", "slice", "ml.vdb", "--json", "--source", "unorm8",
                  "--source-range", "0,0");
}

static void formats_and_lookups_stay_within_their_bounds(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const options[][4] = {
        {"--source", "16f", "--lookup", "polynomial"},
        {"--source", "unorm16", "--layout", "plain"},
        {"--source", "unorm8", "--layout", "aligned"},
        {"--lookup", "linear", "--resolution", "32"},
        {"--lookup", "nearest", "--resolution", "512"},
        {"--source", "unorm8", "--source-range", "0,1"},
    };
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        json_t *root =
            parse(command_succeeds("slice", "ml.vdb", OBLIQUE, options[i][0], options[i][1],
                                   options[i][2], options[i][3], "--verify", "--json"));
        const json_t *verify = json_object_get(root, "error");
        const double bound = number(root, "relative_bound") * number(verify, "magnitude") +
                             number(root, "error_absolute");
        assert_true(number(verify, "max") <= bound);
        assert_true(number(verify, "max") > 1e-6);
        if (!strcmp(options[i][0], "--source"))
            assert_string_equal(text(root, "source"), options[i][1]);
        json_decref(root);
    }
}

static void savings_are_told_and_can_be_left_out(void **state)
{
    (void)state;
    skip_without_gl();
    json_t *with = parse(command_succeeds("slice", "ml.vdb", "--size", "200x200", "--json"));
    json_t *without = parse(
        command_succeeds("slice", "ml.vdb", "--size", "200x200", "--json", "--without", "all"));
    const json_t *saved = json_object_get(with, "savings"),
                 *none = json_object_get(without, "savings");
    assert_int_equal(json_array_size(json_object_get(saved, "kinds")), 2);
    assert_int_equal(json_array_size(json_object_get(none, "kinds")), 0);
    assert_int_equal((int)number(saved, "summed_axis"), 2);
    assert_int_equal((int)number(none, "summed_axis"), -1);
    assert_true(number(saved, "fetches") < 0.5 * number(none, "fetches"));
    assert_true(number(json_object_get(with, "bytes"), "uploaded") <
                number(json_object_get(without, "bytes"), "uploaded"));
    assert_true(fabs(number(with, "maximum") - number(without, "maximum")) < 1e-6);
    json_decref(with);
    json_decref(without);
}

static void clamped_slices_do_not_ring(void **state)
{
    (void)state;
    skip_without_gl();
    json_t *plain = parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--json"));
    json_t *clamped =
        parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--json", "--clamp", "--verify"));
    assert_true(number(clamped, "maximum") <= number(plain, "maximum"));
    assert_true(number(json_object_get(clamped, "error"), "relative_max") <= 2e-6);
    json_decref(plain);
    json_decref(clamped);
}

// The sampler's own bound is what --verify and --json tell; what cannot be filtered so is refused.
static void hardware_stays_within_its_bound(void **state)
{
    static const struct {
        const char *kernel, *source;
        int fetches;
    } cases[] = {{"catmull-rom", "32f", 27}, {"bspline3", "unorm8", 8}, {"bspline3i", "16f", 8}};
    (void)state;
    skip_without_gl();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        json_t *root = parse(command_succeeds("slice", "ml.vdb", OBLIQUE, "--hardware", "--kernel",
                                              cases[i].kernel, "--source", cases[i].source,
                                              "--verify", "--json"));
        const json_t *hardware = json_object_get(root, "hardware");
        const json_t *verify = json_object_get(root, "error");
        assert_int_equal(number(hardware, "fetches_per_pixel"), cases[i].fetches);
        assert_true(number(verify, "max") > 0.0);
        assert_true(number(verify, "max") <= number(root, "bound"));
        json_decref(root);
    }
    const char *explained = command_succeeds("slice", "ml.vdb", OBLIQUE, "--hardware", "--explain");
    assert_non_null(strstr(explained, "hardware filtering: taps 0 1+2 3 along each axis"));
    command_fails(3, "no two neighbouring taps", "slice", "ml.vdb", "--hardware", "--kernel",
                  "nearest", "--json");
    command_fails(2, "--hardware excludes", "slice", "ml.vdb", "--hardware", "--max-error", "8bit",
                  "--json");
    command_fails(2, "--hardware is of OpenGL", "slice", "ml.vdb", "--hardware", "--engine", "cpu",
                  "--json");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(budgets_are_kept),
        cmocka_unit_test(a_budget_on_a_profile_chooses_its_plan),
        cmocka_unit_test(bits_are_the_voxels_own),
        cmocka_unit_test(what_was_considered_is_explained),
        cmocka_unit_test(what_cannot_be_met_is_refused),
        cmocka_unit_test(formats_and_lookups_stay_within_their_bounds),
        cmocka_unit_test(hardware_stays_within_its_bound),
        cmocka_unit_test(savings_are_told_and_can_be_left_out),
        cmocka_unit_test(clamped_slices_do_not_ring),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
