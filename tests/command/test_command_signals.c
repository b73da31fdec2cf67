// SPDX-License-Identifier: BSD-3-Clause
// How signals end the command: whatever it is waiting for, by that signal, and nothing stays.
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/support/command.h"

static const int ending[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGPIPE, SIGALRM,
                             SIGTERM, SIGUSR1, SIGXCPU, SIGXFSZ};
enum { ENDING_COUNT = sizeof ending / sizeof *ending };

static void pause_ms(int ms)
{
    usleep((useconds_t)ms * 1000);
}

// It must die of the signal within a second and leave the folder as it is.
static void assert_dies(pid_t pid, int signal)
{
    int status, before = command_folder_size();
    double seconds = command_signal(pid, signal, &status);
    if (!WIFSIGNALED(status) || WTERMSIG(status) != signal || seconds > 1.0)
        fail_msg("signal %d: status %x after %.2f s", signal, (unsigned)status, seconds);
    assert_int_equal(command_folder_size(), before);
}

static void write_program(const char *path, const char *lines)
{
    char text[1024];
    int size = snprintf(text, sizeof text, "#!/bin/sh\n%s\n", lines);
    command_write_file(path, text, (size_t)size);
    assert_int_equal(chmod(path, 0755), 0);
}

// Programs in the reader's place: stopped; deaf to its socket, with a child of its own.
static void while_a_reader_is_waited_for(void **state)
{
    (void)state;
    static const struct {
        const char *lines;
        int processes; // weft, the program, and its child
    } readers[] = {{"kill -STOP $$", 2}, {"trap '' TERM INT HUP; sleep 99 & sleep 98", 4}};
    char variable[4200], folder[4096];
    assert_non_null(getcwd(folder, sizeof folder));
    snprintf(variable, sizeof variable, "WEFT_LIBEXEC=%s", folder);
    for (size_t r = 0; r < 2; r++) {
        write_program("weft-read-vdb", readers[r].lines);
        for (int i = 0; i < ENDING_COUNT; i++) {
            command_environment(variable);
            pid_t pid = command_start(
                -1, -1, (const char *[]){"weft", "slice", "ml.vdb", "-o", "out.exr", NULL});
            assert_true(command_wait_for_programs(readers[r].processes));
            assert_dies(pid, ending[i]);
        }
    }
    unlink("weft-read-vdb");
}

// A pipe that nobody reads from, as an output; one that nobody writes to, as a plan.
static void while_a_pipe_is_waited_for(void **state)
{
    (void)state;
    assert_int_equal(mkfifo("pipe", 0600), 0);
    static const char *const waiting[][8] = {
        {"weft", "make", "ramp", "--size", "8", "-o", "pipe", NULL},
        {"weft", "validate", "pipe", NULL},
    };
    for (int i = 0; i < ENDING_COUNT; i++) {
        pid_t pid = command_start(-1, -1, waiting[i % 2]);
        pause_ms(100);
        assert_dies(pid, ending[i]);
    }
    unlink("pipe");
}

// At moments all over sampling, handing over and writing.
static void while_it_writes(void **state)
{
    (void)state;
    int ended = 0;
    for (int i = 0; i < 6; i++) {
        pid_t pid = command_start(
            -1, -1,
            (const char *[]){"weft", "make", "chirp", "--size", "150", "-o", "big.vdb", NULL});
        pause_ms(40 + 60 * i);
        int status, before = command_folder_size();
        command_signal(pid, ending[i % ENDING_COUNT], &status);
        assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
        ended += WIFSIGNALED(status);
        // Either it is there, and whole, or it is not.
        assert_true(command_folder_size() <= before + 1);
        if (access("big.vdb", F_OK) == 0)
            command_succeeds("info", "big.vdb");
        unlink("big.vdb");
    }
    assert_true(ended > 0);
}

static void a_drawing_program_goes_along(void **state)
{
    (void)state;
    char variable[8400], folder[4096];
    assert_non_null(getcwd(folder, sizeof folder));
    write_program("gnuplot", "case $2 in --version) exit 0;; esac\nsleep 97 & sleep 96");
    snprintf(variable, sizeof variable, "PATH=%s:%s", folder, getenv("PATH"));
    static const int some[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0; i < 3; i++) {
        command_environment(variable);
        pid_t pid = command_start(
            -1, -1, (const char *[]){"weft", "kernel", "linear", "--plot", "a.svg", NULL});
        assert_true(command_wait_for_programs(4));
        assert_dies(pid, some[i]);
    }
    unlink("gnuplot");
}

// As nohup has it.
static void an_ignored_signal_stays_ignored(void **state)
{
    (void)state;
    signal(SIGHUP, SIG_IGN);
    assert_int_equal(mkfifo("pipe", 0600), 0);
    pid_t pid = command_start(-1, -1, (const char *[]){"weft", "validate", "pipe", NULL});
    signal(SIGHUP, SIG_DFL);
    pause_ms(200);
    kill(pid, SIGHUP);
    pause_ms(200);
    int status;
    assert_int_equal(waitpid(pid, &status, WNOHANG), 0);
    assert_dies(pid, SIGTERM);
    unlink("pipe");
}

// With what nothing can be done about, the kernel and the readers themselves clean up.
static void a_kill_leaves_no_reader_and_no_file(void **state)
{
    (void)state;
    pid_t pid = command_start(
        -1, -1, (const char *[]){"weft", "make", "chirp", "--size", "200", "-o", "big.vdb", NULL});
    assert_true(command_wait_for_programs(2)); // the writer is there, and so is its file
    assert_dies(pid, SIGKILL);
}

static void an_unread_pipe_ends_it(void **state)
{
    (void)state;
    int ends[2], status;
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    close(ends[0]);
    pid_t pid = command_start(ends[1], -1, (const char *[]){"weft", "kernel", "--list", NULL});
    close(ends[1]);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGPIPE);
}

int main(void)
{
    const struct rlimit none = {0, 0}; // SIGQUIT and its like write core files
    setrlimit(RLIMIT_CORE, &none);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(while_a_reader_is_waited_for),
        cmocka_unit_test(while_a_pipe_is_waited_for),
        cmocka_unit_test(while_it_writes),
        cmocka_unit_test(a_drawing_program_goes_along),
        cmocka_unit_test(an_ignored_signal_stays_ignored),
        cmocka_unit_test(a_kill_leaves_no_reader_and_no_file),
        cmocka_unit_test(an_unread_pipe_ends_it),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
