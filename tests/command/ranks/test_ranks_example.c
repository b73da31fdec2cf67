// SPDX-License-Identifier: BSD-3-Clause
// The program of docs/ranks.md, with each MPI: the same picture from any number of ranks.
#include "tests/command/ranks/mpirun.h"

static char *run_example(const char *launcher, const char *count, const char *program, size_t *size)
{
    struct command_result r;
    const char *const mpich[] = {launcher, "-n", count, program, NULL};
    const char *const openmpi[] = {launcher, "--oversubscribe", "--bind-to", "none", "-n",
                                   count,    program,           NULL};
    command_run_list(&r, strstr(launcher, "openmpi") ? openmpi : mpich);
    if (r.code != 0 || r.err[0])
        fail_msg("%s -n %s: exit code %d: %s", launcher, count, r.code, r.err);
    char *data = command_read_file("julia.png", size);
    assert_int_equal(unlink("julia.png"), 0);
    return data;
}

static void the_example_draws_the_same_picture_everywhere(void **state)
{
    (void)state;
    static const char *const counts[MPIRUN_KINDS][2] = {{"1", "3"}, {"2"}};
    static char launcher[64], program[512];
    char *first = NULL;
    size_t first_size = 0;
    int runs = 0;
    for (int kind = 0; kind < MPIRUN_KINDS; kind++) {
        if (!mpirun_is_here(kind))
            continue;
        snprintf(launcher, sizeof launcher, "/usr/bin/mpirun.%s", mpirun_names[kind]);
        snprintf(program, sizeof program, "%s/ranks_example_%s", WEFT_BINARY_DIR,
                 mpirun_names[kind]);
        for (int i = 0; i < 2 && counts[kind][i]; i++, runs++) {
            size_t size;
            char *data = run_example(launcher, counts[kind][i], program, &size);
            if (!first) {
                first = data, first_size = size;
                continue;
            }
            assert_int_equal(size, first_size);
            assert_memory_equal(data, first, size);
            free(data);
        }
    }
    if (!runs)
        skip();
    assert_true(first_size > 10000); // a picture, not a plain colour
    free(first);
}

int main(void)
{
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_example_draws_the_same_picture_everywhere),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
