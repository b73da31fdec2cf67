// SPDX-License-Identifier: BSD-3-Clause
// tests/support/command.h - runs the built programs in a scratch folder and looks at what they
// leave behind.
#ifndef WEFT_TESTS_SUPPORT_COMMAND_H
#define WEFT_TESTS_SUPPORT_COMMAND_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

struct command_result {
    int code;        // exit code; 128 + signal when killed
    char out[65536]; // cut there
    char err[65536];
};

// cmocka group fixtures: makes a scratch folder, changes into it, and makes ml.vdb (Marschner-Lobb,
// 32^3, voxel 0.5) and sphere.vdb (32^3); afterwards removes it. Costs that weft calibrate has left
// on the machine are not read.
int command_setup(void **state);
int command_setup_folder(void **state); // the folder only
int command_teardown(void **state);

// Runs the program in the build folder, or that of a path from the root, with arguments up to NULL.
// Variables for its environment
// ("NAME=value") are set by command_environment, for the next run only. The test fails if a process
// that the program started is still there afterwards.
#define command_run(result, ...) command_run_list(result, (const char *[]){__VA_ARGS__, NULL})
void command_run_list(struct command_result *result, const char *const *argv);
void command_environment(const char *variable);
void command_input(const char *path); // its standard input, likewise; default: the null device

// Starts without waiting, output to the null device; then: sends the signal after some time, waits,
// and returns the code as above. -1: it had ended before the signal.
int command_interrupt(double seconds, int signal, const char *const *argv);

// The parts of that. Standard output and errors go to descriptors, < 0: to the null device. Waits
// until so many processes that are children of the test, or theirs, run. Sends a signal, waits for
// the end, and returns the seconds that took; the test fails if a process is still there
// afterwards.
pid_t command_start(int out, int err, const char *const *argv);
bool command_wait_for_programs(int count);
double command_signal(pid_t pid, int signal, int *status);

// `weft ...` must end with the code, print nothing on stdout, one line on stderr that starts with
// "weft: error: " and contains `text`, and leave the scratch folder as it was.
#define command_fails(code, text, ...)                                                             \
    command_fails_list(__FILE__, __LINE__, code, text, (const char *[]){"weft", __VA_ARGS__, NULL})
void command_fails_list(const char *file, int line, int code, const char *text,
                        const char *const *argv);

// `weft ...` must succeed; returns its stdout, valid until the next run.
#define command_succeeds(...)                                                                      \
    command_succeeds_list(__FILE__, __LINE__, (const char *[]){"weft", __VA_ARGS__, NULL})
const char *command_succeeds_list(const char *file, int line, const char *const *argv);

// Number of entries in the scratch folder.
int command_folder_size(void);

// Whether OpenGL can be had at all; says so once if not. Tests that need it skip() then.
bool command_has_gl(void);

// The whole file, malloc'ed, and its size.
char *command_read_file(const char *path, size_t *size);
void command_write_file(const char *path, const void *data, size_t size);

#endif
