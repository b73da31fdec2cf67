// SPDX-License-Identifier: BSD-3-Clause
// Where the command's outputs go: endings that tell formats, and standard output.
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "command.h"

enum { MAX_ARGUMENTS = 24, UUID_AT = 21, UUID_SIZE = 36 };

// Before any work: no input is there.
static void endings_are_refused(void **state)
{
    (void)state;
#define refused(text, ...) command_fails(2, text, __VA_ARGS__)
    refused("must end in .exr (--preview writes .png)", "slice", "no.vdb", "-o", "x.png");
    refused("must end in .exr", "slice", "no.vdb", "-o", "x.tif");
    refused("must end in .exr", "slice", "no.vdb", "--output=a.exr/x.jpg", "--verify");
    refused("must end in .png (--output writes .exr)", "slice", "no.vdb", "--preview", "x.exr");
    refused("must end in .exr", "resample", "no.exr", "-o", "x.png", "--explain");
    refused("must end in .exr", "resample", "no.exr", "-o", "x.jpeg");
    refused("must end in .png", "resample", "no.exr", "--preview", "x.EXR");
    refused("must end in .vdb", "make", "ramp", "-o", "s.exr");
    refused("must end in .vdb", "make", "ramp", "-o", "s.vdb.gz");
    refused(".txt, .md, .csv, .json or .tex", "table", "-o", "t.xls");
    refused("must end in .json", "table", "-o", "t.csv", "-f", "json");
    refused("must end in .svg or .png", "table", "-p", "t.pdf");
    refused("must end in .svg or .png", "table", "-p", "-");
    refused("must end in .svg or .png", "kernel", "linear", "-p", "k.jpg");
    refused("must end in .svg or .png", "kernel", "linear", "-p", "svg");
    refused("must end in .svg or .png", "chart", "no.vdb", "-o", "c.csv");
    refused("must end in .png", "chart", "no.vdb", "--png", "c.svg");
    refused("must end in .csv", "chart", "no.vdb", "--csv", "c.json");
    refused("must end in .json", "chart", "no.vdb", "--json", "c.txt");
    refused("must end in .txt", "calibrate", "-o", "costs.json");
}

static void two_things_for_stdout_are_refused(void **state)
{
    (void)state;
#define both(...) command_fails(2, "both go to standard output", __VA_ARGS__)
    both("slice", "no.vdb", "-o", "-", "--preview", "-");
    both("slice", "no.vdb", "-o", "-", "--json");
    both("slice", "no.vdb", "--json", "--preview", "/dev/stdout");
    both("resample", "no.exr", "-o", "/dev/fd/1", "--preview", "/dev/stdout");
    both("resample", "no.exr", "-o", "/proc/self/fd/1", "--json");
    both("chart", "no.vdb", "--csv", "-", "--json", "-");
    both("calibrate", "-o", "-", "--json");
}

static void the_ending_tells_a_tables_format(void **state)
{
    (void)state;
    static const char *const named[][2] = {{"t.txt", "text"},  {"t.md", "markdown"},
                                           {"t.CSV", "csv"},   {"t.json", "json"},
                                           {"t.tex", "latex"}, {"t", "text"}};
    for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
        command_succeeds("table", "--dims", "1", "--resolutions", "4", "-o", named[i][0]);
        size_t size;
        char *file = command_read_file(named[i][0], &size);
        file[size] = 0;
        assert_string_equal(file, command_succeeds("table", "--dims", "1", "--resolutions", "4",
                                                   "-f", named[i][1]));
        free(file);
        unlink(named[i][0]);
    }
}

// ---- standard output ----------------------------------------------------------------------------

static const char *const names_of_stdout[] = {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"};

// Runs the command with its output in place of "OUT" redirected to a file in which something
// stands: it must go on there with the bytes of `expected`, and nothing else.
static void assert_on_stdout(const char *name, const char *const *argv, const char *expected,
                             const char *on_stderr)
{
    const char *with[MAX_ARGUMENTS] = {0};
    for (int i = 0; argv[i]; i++)
        with[i] = strcmp(argv[i], "OUT") == 0 ? name : argv[i];
    int out = open("redirected", O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    int err = open("messages", O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    assert_int_equal(write(out, "head", 4), 4);
    int status;
    pid_t pid = command_start(out, err, with);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
    assert_int_equal(write(out, "tail", 4), 4);
    close(out);
    close(err);
    size_t size, file_size, message_size;
    char *bytes = command_read_file("redirected", &size);
    char *file = command_read_file(expected, &file_size);
    char *messages = command_read_file("messages", &message_size);
    messages[message_size] = 0;
    assert_int_equal(size, file_size + 8);
    assert_memory_equal(bytes, "head", 4);
    if (memcmp(file, " BDV", 4) == 0) { // each has a UUID of its own
        memset(bytes + 4 + UUID_AT, 0, UUID_SIZE);
        memset(file + UUID_AT, 0, UUID_SIZE);
    }
    assert_memory_equal(bytes + 4, file, file_size);
    assert_memory_equal(bytes + 4 + file_size, "tail", 4);
    if (on_stderr)
        assert_non_null(strstr(messages, on_stderr));
    else
        assert_int_equal(message_size, 0);
    free(bytes);
    free(file);
    free(messages);
    unlink("redirected");
    unlink("messages");
}

static void volumes_and_tables_on_stdout(void **state)
{
    (void)state;
    command_succeeds("make", "ramp", "--size", "20", "-o", "r.vdb");
    command_succeeds("table", "--dims", "1", "--resolutions", "4", "-f", "csv", "-o", "t.csv");
    const char *const make[] = {"weft", "make", "ramp", "--size", "20", "-o", "OUT", NULL};
    const char *const table[] = {"weft", "table", "--dims", "1", "--resolutions", "4", "-f",
                                 "csv",  "-o",    "OUT",    NULL};
    for (size_t i = 0; i < 4; i++) {
        assert_on_stdout(names_of_stdout[i], make, "r.vdb", NULL);
        assert_on_stdout(names_of_stdout[i], table, "t.csv", NULL);
    }
    unlink("r.vdb");
    unlink("t.csv");
}

static void images_on_stdout(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    command_succeeds("slice", "ml.vdb", "--size", "40x30", "-o", "s.exr", "--preview", "s.png");
    command_succeeds("resample", "s.exr", "--size", "50x50", "-o", "r.exr");
    const char *const slice[] = {"weft", "slice", "ml.vdb", "--size",   "40x30",
                                 "-o",   "OUT",   "-v",     "--verify", NULL};
    const char *const preview[] = {"weft",  "slice",     "ml.vdb", "--size",
                                   "40x30", "--preview", "OUT",    NULL};
    const char *const resample[] = {"weft", "resample", "s.exr",    "--size", "50x50",
                                    "-o",   "OUT",      "--verify", NULL};
    for (size_t i = 0; i < 4; i++)
        assert_on_stdout(names_of_stdout[i], slice, "s.exr", "max error: ");
    assert_on_stdout("-", preview, "s.png", "values from");
    assert_on_stdout("-", resample, "r.exr", "Y: max error ");
    unlink("s.exr");
    unlink("s.png");
    unlink("r.exr");
}

// What has no format in its name: devices and pipes.
static void special_files_take_any_name(void **state)
{
    (void)state;
    command_succeeds("make", "ramp", "--size", "8", "-o", "/dev/null", "--no-clobber");
    assert_int_equal(mkfifo("pipe.dat", 0600), 0);
    int reader = open("pipe.dat", O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    command_succeeds("make", "ramp", "--size", "8", "-o", "pipe.dat");
    char start[4] = "";
    assert_int_equal(read(reader, start, 3), 3);
    assert_string_equal(start, " BD"); // of OpenVDB's magic number
    close(reader);
    unlink("pipe.dat");
    command_fails(4, "No space left on device", "make", "ramp", "--size", "8", "-o", "/dev/full");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(endings_are_refused),
        cmocka_unit_test(two_things_for_stdout_are_refused),
        cmocka_unit_test(the_ending_tells_a_tables_format),
        cmocka_unit_test(volumes_and_tables_on_stdout),
        cmocka_unit_test(images_on_stdout),
        cmocka_unit_test(special_files_take_any_name),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
