// SPDX-License-Identifier: BSD-3-Clause
// A rank that dies or is stopped, or the launcher, ends the job: with one line that names the rank,
// no partial output, and no process left, ranks, readers or guards. By default a few of all cases
// once, WEFT_RANKS=full in the environment: all of them, ten times.
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "tests/command/ranks/mpirun.h"

enum { RANKS = 3, FRAMES = 12, ROUNDS = 10, LAUNCHER = -1 };
static const double most_seconds = 10.0;

struct fault {
    const char *phase;
    int at;             // the rank that comes to it, and fails or waits there
    const char *action; // of fault.c
    int signal, victim; // sent to a rank or to the launcher while that one waits; 0: none
    enum mpirun_kind kind;
    bool quick; // one of the few
};
static const struct fault faults[] = {
    {"read", 1, "wait", SIGKILL, 1, MPIRUN_MPICH, true},
    {"read", 1, "wait", SIGKILL, 0, MPIRUN_MPICH, false},
    {"read", 1, "wait", SIGKILL, LAUNCHER, MPIRUN_MPICH, false},
    {"read", 1, "exit", 0, 0, MPIRUN_MPICH, true},
    {"read", 0, "abort", 0, 0, MPIRUN_MPICH, false},
    {"read", 1, "wait", SIGSTOP, 1, MPIRUN_MPICH, false},
    {"read", 1, "wait", SIGSTOP, 0, MPIRUN_MPICH, false},
    {"draw", 1, "wait", SIGKILL, 1, MPIRUN_MPICH, false},
    {"draw", 1, "wait", SIGKILL, 0, MPIRUN_MPICH, true},
    {"draw", 0, "wait", SIGKILL, LAUNCHER, MPIRUN_MPICH, true},
    {"draw", 1, "exit", 0, 0, MPIRUN_MPICH, false},
    {"draw", 1, "abort", 0, 0, MPIRUN_MPICH, true},
    {"draw", 2, "wait", SIGSTOP, 1, MPIRUN_MPICH, true},
    {"draw", 2, "wait", SIGSTOP, 0, MPIRUN_MPICH, false},
    {"write", 0, "wait", SIGKILL, 1, MPIRUN_MPICH, false},
    {"write", 0, "wait", SIGKILL, 0, MPIRUN_MPICH, true},
    {"write", 0, "wait", SIGKILL, LAUNCHER, MPIRUN_MPICH, false},
    {"write", 0, "exit", 0, 0, MPIRUN_MPICH, false},
    {"write", 0, "wait", SIGSTOP, 1, MPIRUN_MPICH, false},
    {"write", 0, "wait", SIGSTOP, 0, MPIRUN_MPICH, false},
    {"read", 1, "wait", SIGKILL, 0, MPIRUN_OPENMPI, false},
    {"read", 1, "exit", 0, 0, MPIRUN_OPENMPI, false},
    {"read", 1, "wait", SIGSTOP, 0, MPIRUN_OPENMPI, false},
    {"draw", 1, "wait", SIGKILL, 1, MPIRUN_OPENMPI, true},
    {"draw", 0, "wait", SIGKILL, LAUNCHER, MPIRUN_OPENMPI, false},
    {"draw", 1, "abort", 0, 0, MPIRUN_OPENMPI, false},
    {"draw", 2, "wait", SIGSTOP, 1, MPIRUN_OPENMPI, false},
    {"write", 0, "wait", SIGKILL, 1, MPIRUN_OPENMPI, false},
    {"write", 0, "wait", SIGKILL, 0, MPIRUN_OPENMPI, false},
    {"write", 0, "exit", 0, 0, MPIRUN_OPENMPI, false},
    {"write", 0, "wait", SIGSTOP, 0, MPIRUN_OPENMPI, false},
};
enum { FAULT_COUNT = sizeof faults / sizeof *faults };

static double now_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// Files of which ranks tell each other and the test; no outputs.
static void clean(void)
{
    char path[32];
    unlink("here");
    for (int r = 0; r < RANKS; r++) {
        snprintf(path, sizeof path, "rank.%d", r);
        unlink(path);
    }
}

static pid_t process_of(int rank)
{
    char path[32];
    size_t size;
    snprintf(path, sizeof path, "rank.%d", rank);
    char *text = command_read_file(path, &size);
    text[size] = 0;
    const pid_t process = (pid_t)atoi(text);
    free(text);
    assert_true(process > 1);
    return process;
}

static pid_t start(const struct fault *f, int err)
{
    static char fault[64];
    static const char *const reading[] = {
        "accumulate", "frame_%02d.exr", "-o",  "out.exr", "--preview", "out.png",
        "-q",         "--rank-timeout", "0.5", NULL};
    static const char *const drawing[] = {
        "effect",  "antialias", "--size",  "64x48", "--frames",       "24",  "-o",
        "out.exr", "--preview", "out.png", "-q",    "--rank-timeout", "0.5", NULL};
    snprintf(fault, sizeof fault, "WEFT_FAULT=%s %d %s", f->phase, f->at, f->action);
    command_environment(fault);
    command_environment("LD_PRELOAD=" WEFT_FAULT_LIBRARY);
    return mpirun_start(-1, err, f->kind, RANKS, strcmp(f->phase, "read") == 0 ? reading : drawing);
}

static void wait_for(const char *path)
{
    for (int i = 0; i < 2000 && access(path, F_OK) != 0; i++)
        usleep(5000);
    assert_int_equal(access(path, F_OK), 0);
}

// Waits for the end of all; the launcher's exit code.
static int end(const struct fault *f, pid_t launcher, double *seconds)
{
    int status;
    const double before = now_seconds();
    if (f->signal) {
        wait_for("here");
        kill(f->victim == LAUNCHER ? launcher : process_of(f->victim), f->signal);
    }
    *seconds = now_seconds() - before;
    *seconds = command_signal(launcher, 0, &status) + (f->signal ? 0.0 : *seconds);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Of the launcher's death nobody is left to tell.
static bool is_told(const struct fault *f, const char *err)
{
    char name[32];
    const int lines = mpirun_count_lines(err, "weft: ");
    snprintf(name, sizeof name, "weft: error: rank %d ", f->signal ? f->victim : f->at);
    if (f->signal && f->victim == LAUNCHER)
        return lines == 0 || (lines == 1 && strstr(err, "rank 0 of 3"));
    return lines == 1 && mpirun_count_lines(err, name) == 1;
}

static bool run_fault(const struct fault *f)
{
    static char err[65536];
    FILE *file = tmpfile();
    double seconds;
    assert_non_null(file);
    clean();
    const int before = command_folder_size();
    const int code = end(f, start(f, fileno(file)), &seconds);
    rewind(file);
    err[fread(err, 1, sizeof err - 1, file)] = 0;
    fclose(file);
    clean();
    const int after = command_folder_size();
    if (code && seconds < most_seconds && is_told(f, err) && after == before)
        return true;
    print_error("%s, %s rank %d %s, signal %d to %d: code %d, %.1f s, entries %d and %d\n%s\n",
                mpirun_names[f->kind], f->phase, f->at, f->action, f->signal, f->victim, code,
                seconds, before, after, err);
    return false;
}

static void test_faults(void **state)
{
    (void)state;
    const char *asked = getenv("WEFT_RANKS");
    const bool full = asked && strcmp(asked, "full") == 0;
    int ran = 0, failed = 0;
    if (!command_has_gl())
        skip();
    for (int round = 0; round < (full ? ROUNDS : 1); round++)
        for (int i = 0; i < FAULT_COUNT; i++)
            if ((full || faults[i].quick) && mpirun_is_here(faults[i].kind)) {
                failed += !run_fault(&faults[i]);
                ran++;
            }
    if (!ran)
        skip();
    assert_int_equal(failed, 0);
    print_message("%d faults\n", ran);
}

// One rank alone cannot read: rank 0 says so, and which one it is.
static void test_rank_that_cannot_read(void **state)
{
    static struct command_result result;
    (void)state;
    if (!mpirun_is_here(MPIRUN_MPICH))
        skip();
    command_environment("WEFT_FAULT=read 2 refuse");
    command_environment("LD_PRELOAD=" WEFT_FAULT_LIBRARY);
    mpirun(&result, MPIRUN_MPICH, RANKS, "accumulate", "frame_%02d.exr", "-o", "out.exr", "-q");
    clean();
    assert_int_equal(result.code, 3);
    assert_int_equal(mpirun_count_lines(result.err, "weft: "), 1);
    assert_int_equal(mpirun_count_lines(result.err, "weft: error: rank 2 ("), 1);
    assert_int_equal(access("out.exr", F_OK), -1);
}

static int setup(void **state)
{
    char path[32];
    size_t size;
    if (command_setup(state) != 0)
        return -1;
    command_succeeds("slice", "ml.vdb", "--size", "16x16", "-o", "frame_01.exr", "-q");
    char *frame = command_read_file("frame_01.exr", &size);
    for (int f = 2; f <= FRAMES; f++) {
        snprintf(path, sizeof path, "frame_%02d.exr", f);
        command_write_file(path, frame, size);
    }
    free(frame);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_rank_that_cannot_read),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
