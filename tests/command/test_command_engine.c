// SPDX-License-Identifier: BSD-3-Clause
// What filters, as the options say it: OpenGL or the CPU engine, threads and sums.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/command.h"

#define SLICE "slice", "ml.vdb", "--size", "16x16", "--json"

static void contradictions_are_refused(void **state)
{
    (void)state;
    command_fails(2, "auto, gl, cpu", SLICE, "--engine", "opengl");
    command_fails(2, "float, double", SLICE, "--sums", "half");
    command_fails(2, "--context is of OpenGL", SLICE, "--engine", "cpu", "--context", "osmesa");
    command_fails(2, "--context makes no sense with --sums double", SLICE, "--sums", "double",
                  "--context", "auto");
    command_fails(2, "--engine gl makes no sense with --sums double", SLICE, "--sums", "double",
                  "--engine", "gl");
    command_fails(2, "--threads is of the CPU engine", SLICE, "--threads", "2", "--engine", "gl");
    command_fails(2, "--max-error chooses what --sums says", SLICE, "--sums", "double",
                  "--max-error", "8bit");
    static const char *const of_gl[][2] = {{"--profile", "unorm8"},
                                           {"--layout", "plain"},
                                           {"--source", "16f"},
                                           {"--lookup", "polynomial"}};
    for (size_t i = 0; i < sizeof of_gl / sizeof *of_gl; i++) {
        command_fails(2, of_gl[i][0], SLICE, of_gl[i][0], of_gl[i][1], "--engine", "cpu");
        command_fails(2, of_gl[i][0], SLICE, of_gl[i][0], of_gl[i][1], "--sums", "double");
    }
    static const char *const threads[] = {"0", "-1", "1.5", "1025", "1e9"};
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
        char option[32];
        snprintf(option, sizeof option, "--threads=%s", threads[i]);
        command_fails(2, "not a whole number from 1 to 1024", SLICE, option);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contradictions_are_refused),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
