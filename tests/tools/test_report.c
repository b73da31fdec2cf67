// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/common/ending.h"
#include "tools/common/report.h"

bool ending_start_thread(pthread_t *thread, void *(*call)(void *priv), void *priv)
{
    (void)thread, (void)call, (void)priv;
    return false;
}

bool ending_is_due(void)
{
    return false;
}

static void verdicts_hold_errors_to_their_bounds(void **state)
{
    (void)state;
    static const struct {
        double error, bound;
        uint64_t mismatches;
        bool good;
    } cases[] = {
        {0.0, 0.0, 0, true},     {1e-3, 1e-3, 0, true}, {2e-3, 1e-3, 0, false},
        {1e30, NAN, 0, true},    {0.0, NAN, 0, true},   {INFINITY, 1.0, 0, false},
        {0.0, 1.0, 1, false},    {0.0, NAN, 7, false},  {2.0, 1.0, 1, false},
        {5e-324, 0.0, 0, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(
            report_verdict("a slice", cases[i].error, cases[i].bound, cases[i].mismatches),
            cases[i].good);
}

// The first failure is the error line: what, where, the numbers.
static void a_failure_is_one_line(void **state)
{
    (void)state;
    char line[512] = "";
    const int saved = dup(STDERR_FILENO);
    FILE *file = tmpfile();
    assert_true(saved >= 0 && file);
    dup2(fileno(file), STDERR_FILENO);
    report_verdict("channels R", 0.25, 0.125, 0);
    report_verdict("channels G", 0.5, 0.125, 3);
    dup2(saved, STDERR_FILENO);
    close(saved);
    rewind(file);
    assert_non_null(fgets(line, sizeof line, file));
    assert_non_null(strstr(line, "channels R"));
    assert_non_null(strstr(line, "0.25"));
    assert_non_null(strstr(line, "0.125"));
    assert_null(fgets(line, sizeof line, file));
    fclose(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_failure_is_one_line),
        cmocka_unit_test(verdicts_hold_errors_to_their_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
