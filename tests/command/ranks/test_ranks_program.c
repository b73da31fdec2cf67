// SPDX-License-Identifier: BSD-3-Clause
// weft under a launcher: what it becomes, who tells, and with which code it ends.
#include "tests/command/ranks/mpirun.h"

static struct command_result result;

#define needs(kind)                                                                                \
    do {                                                                                           \
        if (!mpirun_is_here(kind))                                                                 \
            skip();                                                                                \
    } while (0)

// What does not distribute is done once, by rank 0, and nothing of MPI is started for it.
static void test_other_verbs(void **state)
{
    (void)state;
    for (int kind = 0; kind < MPIRUN_KINDS; kind++) {
        needs(kind);
        mpirun(&result, kind, 3, "--version");
        assert_int_equal(result.code, 0);
        assert_string_equal(result.out, "weft " WEFT_TEST_VERSION "\n");
        assert_string_equal(result.err, "");
        mpirun(&result, kind, 3, "nonsense");
        assert_int_equal(result.code, 2);
        assert_string_equal(result.out, "");
        assert_int_equal(mpirun_count_lines(result.err, "weft: error: unknown verb"), 1);
        assert_int_equal(mpirun_count_lines(result.err, "weft: "), 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_other_verbs),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
