// SPDX-License-Identifier: BSD-3-Clause
// JSON that could not be built whole is not printed: every allocation of jansson's is made to fail,
// or WEFT_JSON_FAILURES of them (default 3) for each verb.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"

enum { MAX_ARGUMENTS = 12 };

static void preload(unsigned long failing)
{
    static char number[64], count[] = "WEFT_COUNT_JSON=count.txt";
    snprintf(number, sizeof number, "WEFT_FAIL_JSON=%lu", failing);
    command_environment("LD_PRELOAD=" WEFT_FAIL_JSON_LIBRARY);
    command_environment("ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0");
    command_environment(number);
    command_environment(count);
}

static unsigned long count_allocations(const char *const *argv)
{
    struct command_result r;
    preload(0);
    command_run_list(&r, argv);
    assert_int_equal(r.code, 0);
    json_t *root = json_loads(r.out, 0, NULL);
    assert_non_null(root);
    json_decref(root);
    size_t size;
    char *text = command_read_file("count.txt", &size);
    text[size] = 0;
    unsigned long count = strtoul(text, NULL, 10);
    free(text);
    unlink("count.txt");
    return count;
}

static void every_failure_is_told(const char *const *argv)
{
    static unsigned long limit;
    const char *text = getenv("WEFT_JSON_FAILURES");
    limit = text ? strtoul(text, NULL, 10) : 3;
    unsigned long count = count_allocations(argv), runs = count < limit ? count : limit;
    assert_true(runs > 0);
    for (unsigned long i = 0; i < runs; i++) {
        struct command_result r;
        unsigned long failing = runs > 1 ? 1 + i * (count - 1) / (runs - 1) : 1;
        preload(failing);
        command_run_list(&r, argv);
        unlink("count.txt");
        if (r.code != 1 || *r.out || !strstr(r.err, "weft: error: out of memory"))
            fail_msg("%s: allocation %lu of %lu: exit code %d, stderr %s, stdout %s", argv[1],
                     failing, count, r.code, r.err, r.out);
    }
}

static void without_gl(void **state)
{
    (void)state;
    static const char *const verbs[][MAX_ARGUMENTS] = {
        {"weft", "kernel", "--list", "--json"},
        {"weft", "kernel", "bspline3i", "--json"},
        {"weft", "info", "ml.vdb", "--json"},
        {"weft", "plan", "--kernel", "linear", "--json"},
        {"weft", "table", "--dims", "1", "--resolutions", "4", "-f", "json"},
        {"weft", "slice", "ml.vdb", "--explain", "--json"},
        {"weft", "slice", "ml.vdb", "--explain", "--json", "--at", "1..2", "--frames", "0-1"},
        {"weft", "stability", "--list", "--json"},
    };
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++)
        every_failure_is_told(verbs[i]);
}

static void with_gl(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    static const char *const slice[] = {"weft",  "slice",    "ml.vdb", "--size",
                                        "16x16", "--verify", "--json", NULL};
    static const char *const frames[] = {"weft", "slice",    "ml.vdb", "--size", "16x16", "--at",
                                         "1..2", "--frames", "0-1",    "--json", NULL};
    static const char *const resample[] = {"weft",  "resample", "s.exr",  "--size",
                                           "16x16", "--verify", "--json", NULL};
    static const char *const info[] = {"weft", "info", "s.exr", "--json", NULL};
    static const char *const antialias[] = {"weft",    "antialias",    "adaptive", "--size", "8x8",
                                            "--scene", "polygons:3,9", "--verify", "--json", NULL};
    command_succeeds("slice", "ml.vdb", "--size", "8x8", "-o", "s.exr");
    every_failure_is_told(slice);
    every_failure_is_told(frames);
    every_failure_is_told(resample);
    every_failure_is_told(info);
    every_failure_is_told(antialias);
    unlink("s.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_gl),
        cmocka_unit_test(with_gl),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
