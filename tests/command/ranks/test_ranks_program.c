// SPDX-License-Identifier: BSD-3-Clause
// weft under a launcher: what it becomes, who tells, and with which code it ends.
#include <sched.h>

#include <jansson.h>

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
        assert_int_equal(mpirun_count_lines(result.out, "weft " WEFT_TEST_VERSION "\n"), 1);
        assert_string_equal(result.err, "");
        mpirun(&result, kind, 3, "nonsense");
        assert_int_equal(result.code, 2);
        assert_string_equal(result.out, "");
        assert_int_equal(mpirun_count_lines(result.err, "weft: error: unknown verb"), 1);
        assert_int_equal(mpirun_count_lines(result.err, "weft: "), 1);
    }
}

// Where the program that weft becomes is not installed: one line, of rank 0.
static void test_without_its_program(void **state)
{
    (void)state;
    for (int kind = 0; kind < MPIRUN_KINDS; kind++) {
        needs(kind);
        command_environment("WEFT_LIBEXEC=.");
        mpirun(&result, kind, 2, "effect", "antialias");
        assert_int_equal(result.code, 1);
        assert_int_equal(mpirun_count_lines(result.err, "weft: "), 1);
        assert_non_null(strstr(result.err, mpirun_names[kind]));
        assert_non_null(strstr(result.err, "WEFT_MPI"));
    }
}

// Rank 0 and rank 1 with different renderers.
static void run_mixed(const char *flag)
{
    char weft[512];
    snprintf(weft, sizeof weft, "%s/weft", WEFT_BINARY_DIR);
#define EFFECT weft, "effect", "antialias", "--frames", "4", "--size", "16x16", "-o", "m.exr", flag
    command_run_list(&result,
                     (const char *[]){"/usr/bin/mpirun.mpich", "-n", "1", EFFECT, ":", "-n", "1",
                                      "/usr/bin/env", "GALLIUM_DRIVER=softpipe", EFFECT, NULL});
#undef EFFECT
}

static void test_renderers(void **state)
{
    (void)state;
    needs(MPIRUN_MPICH);
    if (!command_has_gl())
        skip();
    run_mixed("-q");
    assert_int_equal(result.code, 3);
    assert_int_equal(mpirun_count_lines(result.err, "weft: error: renderer of rank 1 "), 1);
    assert_int_equal(mpirun_count_lines(result.err, "weft: "), 1);
    assert_int_equal(access("m.exr", F_OK), -1);
    run_mixed("--mixed");
    assert_int_equal(result.code, 0);
    assert_int_equal(mpirun_count_lines(result.err, "weft: warning: renderer of rank 1 "), 1);
    assert_int_equal(access("m.exr", F_OK), 0);
}

// Ranks times threads are the processors that the test may run on, and at least one each.
static int64_t threads_of_all(enum mpirun_kind kind, int ranks)
{
    mpirun(&result, kind, ranks, "slice", "ml.vdb", "--size", "16x16", "-o", "s.exr", "--json");
    assert_int_equal(result.code, 0);
    json_t *root = json_loads(result.out, 0, NULL);
    assert_non_null(root);
    const json_t *each = json_object_get(json_object_get(root, "ranks"), "each");
    assert_int_equal(json_array_size(each), ranks);
    int64_t sum = 0;
    for (int r = 0; r < ranks; r++) {
        const int64_t one =
            json_integer_value(json_object_get(json_array_get(each, (size_t)r), "threads"));
        assert_true(one >= 1);
        sum += one;
    }
    json_decref(root);
    return sum;
}

static void test_threads(void **state)
{
    (void)state;
    cpu_set_t set;
    if (!command_has_gl() || sched_getaffinity(0, sizeof set, &set) != 0)
        skip();
    const int processors = CPU_COUNT(&set);
    needs(MPIRUN_MPICH);
    for (int ranks = 2; ranks <= 3; ranks++)
        assert_int_equal(threads_of_all(MPIRUN_MPICH, ranks),
                         ranks > processors ? ranks : processors);
    needs(MPIRUN_OPENMPI);
    assert_int_equal(threads_of_all(MPIRUN_OPENMPI, 2), processors > 2 ? processors : 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_other_verbs),
        cmocka_unit_test(test_without_its_program),
        cmocka_unit_test(test_renderers),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
