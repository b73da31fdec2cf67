// SPDX-License-Identifier: BSD-3-Clause
// What the command says to slips of its users: suggestions, questions, and where things are.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/command.h"

static void says(const char *text, const char *const *argv)
{
    struct command_result r;
    command_run_list(&r, argv);
    assert_int_equal(r.code, 0);
    if (!strstr(r.err, text))
        fail_msg("'%s' is not in: %s", text, r.err);
}

static void verbs_and_options_are_suggested(void **state)
{
    (void)state;
    command_fails(2, "did you mean slice?", "slcie", "ml.vdb");
    command_fails(2, "did you mean resample?", "resize", "photo.exr");
    command_fails(2, "did you mean help?", "hepl");
    command_fails(2, "did you mean kernel?", "help", "kernels");
    command_fails(2, "did you mean --kernel?", "slice", "ml.vdb", "--kernal", "linear");
    command_fails(2, "did you mean --kernel?", "slice", "ml.vdb", "--filter=linear");
    command_fails(2, "did you mean --size?", "resample", "photo.exr", "--width", "3");
    command_fails(2, "did you mean --preview?", "slice", "ml.vdb", "-preview", "a.png");
    command_fails(2, "did you mean world?", "slice", "ml.vdb", "--space", "wrold");
    says("weft: info: kernel 'lanczos3' is lanczos:3 here",
         (const char *[]){"weft", "slice", "ml.vdb", "--explain", "--kernel", "lanczos3", NULL});
    command_fails(2, "did you mean catmull-rom", "resample", "photo.exr", "-o", "a.exr", "--kernel",
                  "bicubic");
    const char *help = command_succeeds("help", "help");
    assert_non_null(strstr(help, "usage: weft VERB"));
}

static void products_of_derivatives_are_refused(void **state)
{
    (void)state;
    command_fails(2, "mixed derivative of order 3", "slice", "ml.vdb", "--json", "--kernel",
                  "d-catmull-rom");
    command_fails(2, "mixed derivative of order 6", "slice", "ml.vdb", "--json", "--kernel",
                  "dd-bspline3i");
    command_fails(2, "use catmull-rom", "slice", "ml.vdb", "--json", "--profile", "unorm8",
                  "--kernel", "d-catmull-rom");
    command_fails(2, "mixed derivative of order 2", "resample", "photo.exr", "-o", "a.exr",
                  "--kernel", "d-linear");
    command_fails(2, "mixed derivative of order 3", "chart", "ml.vdb", "-o", "a.svg", "--kernel",
                  "d-linear");
}

static void lists_have_prefiltered_kernels(void **state)
{
    (void)state;
    static const char *const names[] = {"bspline3i ", "bspline7i ", "omomsi ", "bsplinei "};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        assert_non_null(strstr(command_succeeds("kernel", "--list"), names[i]));
        assert_non_null(strstr(command_succeeds("slice", "--kernel", "help"), names[i]));
    }
    assert_non_null(strstr(command_succeeds("kernel", "--list", "--json"), "\"bspline3i\""));
}

// ml.vdb has 32^3 voxels, 0.5 wide, the first at the origin.
static void a_slice_that_misses_says_where_the_volume_is(void **state)
{
    (void)state;
    says("misses grid",
         (const char *[]){"weft", "slice", "ml.vdb", "--at", "100", "--explain", NULL});
    says("from (-0.25, -0.25, -0.25) to (15.75, 15.75, 15.75) in world space",
         (const char *[]){"weft", "slice", "ml.vdb", "--at", "100", "--explain", NULL});
    says("in index space the same numbers would meet it",
         (const char *[]){"weft", "slice", "ml.vdb", "--origin", "20,20,20", "--u", "5,0,0", "--v",
                          "0,5,0", "--explain", NULL});
    says("from (-0.5, -0.5, -0.5) to (31.5, 31.5, 31.5) in index space: every pixel is",
         (const char *[]){"weft", "slice", "ml.vdb", "--space", "index", "--at", "100", "--explain",
                          NULL});
}

static void a_budget_without_bits_is_questioned(void **state)
{
    (void)state;
    says("was 8bit meant?",
         (const char *[]){"weft", "slice", "ml.vdb", "--max-error", "8", "--explain", NULL});
    struct command_result r;
    command_run(&r, "weft", "slice", "ml.vdb", "--max-error", "0.01", "--explain");
    assert_int_equal(r.code, 0);
    assert_string_equal(r.err, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verbs_and_options_are_suggested),
        cmocka_unit_test(products_of_derivatives_are_refused),
        cmocka_unit_test(lists_have_prefiltered_kernels),
        cmocka_unit_test(a_slice_that_misses_says_where_the_volume_is),
        cmocka_unit_test(a_budget_without_bits_is_questioned),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
