// SPDX-License-Identifier: BSD-3-Clause
// tests/command/ranks/mpirun.h - runs the built weft under a launcher of MPI, as tests/support
// runs it alone: in the scratch folder, with no process left afterwards (the launcher hands its
// environment on, so that all it starts are known).
#ifndef WEFT_TESTS_COMMAND_RANKS_MPIRUN_H
#define WEFT_TESTS_COMMAND_RANKS_MPIRUN_H

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <setjmp.h>

#include <cmocka.h>

#include "tests/support/command.h"

// MPICH starts in a third of the time that Open MPI takes: most tests have it.
enum mpirun_kind { MPIRUN_MPICH, MPIRUN_OPENMPI, MPIRUN_KINDS };
static const char *const mpirun_names[] = {"mpich", "openmpi"};

// "weft VERB ..." of so many arguments at most.
enum { MPIRUN_MOST = 64 };

// Whether this kind's launcher is installed and weft was built for it; says so once if not. Tests
// that need it skip() then.
static inline bool mpirun_is_here(enum mpirun_kind kind)
{
    static int known[MPIRUN_KINDS];
    char launcher[64], program[512];
    snprintf(launcher, sizeof launcher, "/usr/bin/mpirun.%s", mpirun_names[kind]);
    snprintf(program, sizeof program, "%s/weft-%s", WEFT_BINARY_DIR, mpirun_names[kind]);
    if (!known[kind]) {
        known[kind] = access(launcher, X_OK) != 0 ? 2 : access(program, X_OK) != 0 ? 3 : 1;
        if (known[kind] > 1)
            print_message("there is no %s: tests that need it are skipped\n",
                          known[kind] == 2 ? launcher : program);
    }
    return known[kind] == 1;
}

// Tests run as root in containers, with more ranks than there are processors, and several at once:
// Open MPI refuses the first two and binds ranks of all to the same processors unless it is told.
static inline void mpirun_build(enum mpirun_kind kind, int ranks, const char *const *argv,
                                const char *list[MPIRUN_MOST + 16])
{
    static char launcher[64], count[16], program[512];
    int at = 0;
    snprintf(launcher, sizeof launcher, "/usr/bin/mpirun.%s", mpirun_names[kind]);
    snprintf(count, sizeof count, "%d", ranks);
    snprintf(program, sizeof program, "%s/weft", WEFT_BINARY_DIR);
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    list[at++] = launcher;
    if (kind == MPIRUN_OPENMPI) {
        list[at++] = "--oversubscribe";
        list[at++] = "--bind-to";
        list[at++] = "none";
    }
    list[at++] = "-n";
    list[at++] = count;
    list[at++] = program;
    for (int i = 0; argv[i]; i++) {
        assert_true(i < MPIRUN_MOST);
        list[at++] = argv[i];
    }
    list[at] = NULL;
}

// Whether all combinations of ranks, schedules and sizes are asked for, not a few that cover them.
static inline bool mpirun_is_full(void)
{
    const char *asked = getenv("WEFT_RANKS");
    return asked && strcmp(asked, "full") == 0;
}

// Runs `weft` with the arguments, "VERB" to NULL, on so many ranks, 0: without a launcher; see
// command_run.
#define mpirun(result, kind, ranks, ...)                                                           \
    mpirun_list(result, kind, ranks, (const char *[]){__VA_ARGS__, NULL})
static inline void mpirun_list(struct command_result *result, enum mpirun_kind kind, int ranks,
                               const char *const *argv)
{
    const char *list[MPIRUN_MOST + 16] = {"weft"};
    if (ranks)
        mpirun_build(kind, ranks, argv, list);
    for (int i = 0; !ranks && argv[i]; i++) {
        assert_true(i < MPIRUN_MOST);
        list[i + 1] = argv[i];
        list[i + 2] = NULL;
    }
    command_run_list(result, list);
}

// The same, which must succeed: otherwise what it told is printed, and the test fails.
#define mpirun_succeeds(kind, ranks, ...)                                                          \
    mpirun_succeeds_list(__FILE__, __LINE__, kind, ranks, (const char *[]){__VA_ARGS__, NULL})
static inline void mpirun_succeeds_list(const char *file, int line, enum mpirun_kind kind,
                                        int ranks, const char *const *argv)
{
    static struct command_result result;
    mpirun_list(&result, kind, ranks, argv);
    if (result.code == 0)
        return;
    print_error("%s, %d ranks: weft", mpirun_names[kind], ranks);
    for (int i = 0; argv[i]; i++)
        print_error(" %s", argv[i]);
    print_error("\nexit code %d\nstdout: %s\nstderr: %s\n", result.code, result.out, result.err);
    _fail(file, line);
}

// Starts it without waiting; see command_start.
static inline pid_t mpirun_start(int out, int err, enum mpirun_kind kind, int ranks,
                                 const char *const *argv)
{
    const char *list[MPIRUN_MOST + 16];
    mpirun_build(kind, ranks, argv, list);
    return command_start(out, err, list);
}

// Lines of weft's own among what was told, beside the launcher's.
static inline int mpirun_count_lines(const char *err, const char *start)
{
    int count = 0;
    const size_t length = strlen(start);
    for (const char *line = err; *line; line = strchr(line, '\n') + 1) {
        count += strncmp(line, start, length) == 0;
        if (!strchr(line, '\n'))
            break;
    }
    return count;
}

#endif
