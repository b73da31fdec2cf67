// SPDX-License-Identifier: BSD-3-Clause
// Where the command's outputs go: endings that tell formats, and standard output.
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/support/command.h"

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
    refused("must end in .exr", "resample", "no.exr", "-o", "x.gif", "--explain");
    refused("must end in .exr", "resample", "no.exr", "-o", "x.jpeg");
    refused("must end in .png", "resample", "no.exr", "--preview", "x.EXR");
    refused("must end in .vdb", "make", "ramp", "-o", "s.exr");
    refused("must end in .vdb", "make", "ramp", "-o", "s.vdb.gz");
    refused(".txt, .md, .csv, .json or .tex", "table", "-o", "t.xls");
    refused("must end in .json", "table", "-o", "t.csv", "-f", "json");
    refused("must end in .svg, .png, .pdf or .eps", "table", "-p", "t.gif");
    refused("must end in .svg, .png, .pdf or .eps", "kernel", "linear", "-p", "k.jpg");
    refused("must end in .svg, .png, .pdf or .eps", "kernel", "linear", "-p", "svg");
    refused("must end in .svg, .png, .pdf or .eps", "chart", "no.vdb", "-o", "c.csv");
    refused("must end in .png", "chart", "no.vdb", "--png", "c.svg");
    refused("must end in .csv", "chart", "no.vdb", "--csv", "c.json");
    refused("must end in .json", "chart", "no.vdb", "--json=c.txt");
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
    both("chart", "no.vdb", "--csv", "-", "--json");
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
        const char *told =
            command_succeeds("table", "--dims", "1", "--resolutions", "4", "-f", named[i][1]);
        const bool json = strcmp(named[i][1], "json") == 0; // times come before
        assert_string_equal(json ? strstr(file, "\"error\"") : file,
                            json ? strstr(told, "\"error\"") : told);
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

static int run_by_shell(const char *arguments)
{
    char line[512];
    snprintf(line, sizeof line, "exec " WEFT_BINARY_DIR "/weft %s", arguments);
    int status = system(line);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

// No file takes their descriptors and gets what is printed.
static void closed_streams_stay_out_of_files(void **state)
{
    (void)state;
    assert_int_equal(run_by_shell("make ramp --size 8 -v -o r.vdb <&- >&- 2>&-"), 0);
    command_succeeds("info", "r.vdb");
    assert_int_equal(run_by_shell("make ramp --size 8 --no-clobber -o r.vdb 2>&-"), 4);
    assert_int_equal(run_by_shell("make ramp --size 8 -o - >&- 2>&-"), 4);
    assert_int_equal(run_by_shell("info r.vdb >&- 2>&-"), 4);
    assert_int_equal(run_by_shell("info no.vdb >&- 2>&-"), 3);
    unlink("r.vdb");
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

// ---- progress -----------------------------------------------------------------------------------

// What the command shows on a terminal.
static char *run_on_a_terminal(const char *const *argv)
{
    int terminal = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC), status;
    assert_true(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
    int theirs = open(ptsname(terminal), O_RDWR | O_NOCTTY | O_CLOEXEC);
    assert_true(theirs >= 0);
    pid_t pid = command_start(-1, theirs, argv);
    close(theirs);
    char *shown = calloc(1, 1 << 16);
    ssize_t count;
    for (size_t size = 0; (count = read(terminal, shown + size, (1 << 16) - 1 - size)) > 0;)
        size += (size_t)count; // until the other end is closed
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
    close(terminal);
    return shown;
}

static void assert_ends_erased(const char *shown)
{
    static const char erase[] = "\r\033[K";
    assert_true(strlen(shown) > strlen(erase));
    assert_string_equal(shown + strlen(shown) - strlen(erase), erase);
    assert_null(strstr(shown, "100 %"));
}

static void progress_tells_of_files(void **state)
{
    (void)state;
    const char *const make[] = {"weft", "make", "chirp", "--size", "64", "-o", "p.vdb", NULL};
    char *shown = run_on_a_terminal(make);
    assert_non_null(strstr(shown, "weft: sampling  "));
    assert_non_null(strstr(shown, "weft: writing p.vdb"));
    assert_ends_erased(shown);
    free(shown);
    if (command_has_gl()) {
        const char *const slice[] = {"weft",     "slice", "p.vdb",  "-o",      "p.exr",
                                     "--verify", "-q",    "--size", "100x100", NULL};
        shown = run_on_a_terminal(slice);
        assert_string_equal(shown, "");
        free(shown);
        const char *const loud[] = {"weft",   "slice",   "p.vdb",     "-o",    "p.exr", "--verify",
                                    "--size", "100x100", "--preview", "p.png", NULL};
        shown = run_on_a_terminal(loud);
        assert_non_null(strstr(shown, "weft: reading p.vdb"));
        assert_non_null(strstr(shown, "weft: writing p.exr   0 %"));
        assert_non_null(strstr(shown, "weft: writing p.exr  85 %")); // 6 of 7 blocks of 16 lines
        assert_non_null(strstr(shown, "weft: finishing p.exr"));
        assert_non_null(strstr(shown, "weft: writing p.png"));
        assert_ends_erased(shown);
        free(shown);
        const char *const resample[] = {"weft",  "resample", "p.exr", "-o",
                                        "q.exr", "--size",   "50x50", NULL};
        shown = run_on_a_terminal(resample);
        assert_non_null(strstr(shown, "weft: writing q.exr  75 %")); // 3 of 4
        assert_non_null(strstr(shown, "weft: finishing q.exr"));
        assert_ends_erased(shown);
        free(shown);
        unlink("q.exr");
        unlink("p.exr");
        unlink("p.png");
    }
    unlink("p.vdb");
}

// A writer's word is not enough.
static void a_lying_writer_is_found_out(void **state)
{
    (void)state;
    static const char *const lies[] = {"WEFT_LIE=0 0", "WEFT_LIE=500 0", "WEFT_LIE=500 500",
                                       "WEFT_LIE=vdb 500 300", "WEFT_LIE=vdb 300 500"};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        command_environment("WEFT_LIBEXEC=" WEFT_BINARY_DIR "/liars");
        command_environment(lies[i]);
        command_fails(4, "weft-write-vdb tells of", "make", "ramp", "--size", "8", "-o", "r.vdb");
    }
}

// A small file system, which takes a name space of our own to mount.
static void a_full_disk_is_told(void **state)
{
    (void)state;
    assert_int_equal(mkdir("full", 0700), 0);
    if (unshare(geteuid() == 0 ? CLONE_NEWNS : CLONE_NEWUSER | CLONE_NEWNS) != 0 ||
        mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0 ||
        mount("weft-test", "full", "tmpfs", 0, "size=64k,mode=777") != 0) {
        print_message("no file system can be mounted here: %s\n", strerror(errno));
        rmdir("full");
        skip();
    }
    command_fails(4, "No space left on device", "make", "chirp", "--size", "64", "-o",
                  "full/c.vdb");
    if (command_has_gl()) {
        command_fails(4, "No space left on device", "slice", "ml.vdb", "-o", "full/c.exr");
        command_fails(4, "No space left on device", "slice", "ml.vdb", "--preview", "full/c.png");
    }
    char left[8] = "";
    int fd = open("full/small", O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    assert_int_equal(write(fd, left, sizeof left), sizeof left); // nothing of it stayed
    close(fd);
    assert_int_equal(umount("full"), 0);
    rmdir("full");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(endings_are_refused),
        cmocka_unit_test(two_things_for_stdout_are_refused),
        cmocka_unit_test(the_ending_tells_a_tables_format),
        cmocka_unit_test(volumes_and_tables_on_stdout),
        cmocka_unit_test(images_on_stdout),
        cmocka_unit_test(closed_streams_stay_out_of_files),
        cmocka_unit_test(special_files_take_any_name),
        cmocka_unit_test(progress_tells_of_files),
        cmocka_unit_test(a_lying_writer_is_found_out),
        cmocka_unit_test(a_full_disk_is_told),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
