// SPDX-License-Identifier: BSD-3-Clause
// Every command that README.md and some pages of docs/ show is run as it stands there, in a folder
// with a smoke.vdb, a photo.exr, frames of both kinds, a model.obj and keyframes, and must end with
// 0, or with 1 where its remark says so; what the pages quote must be printed. Open MPI may be
// asked by root for more ranks than there are processors.
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

#include "tests/support/command.h"

enum { LEAST_COMMANDS = 16, MAX_COMMAND = 1000 };

// Minutes in all; tests of their own run these. WEFT_README=all runs them here, too, and
// more pages.
static const char *const long_ones[] = {"weft chart ", "weft calibrate",   "weft stability ",
                                        "weft table",  "weft make sphere", NULL};

static bool starts_with(const char *line, const char *word)
{
    return strncmp(line, word, strlen(word)) == 0;
}

static bool wants_all(void)
{
    const char *wanted = getenv("WEFT_README");
    return wanted && strcmp(wanted, "all") == 0;
}

static bool takes_long(const char *line)
{
    for (int i = 0; long_ones[i]; i++)
        if (starts_with(line, long_ones[i]))
            return !wants_all();
    return false;
}

static bool has_mpi(void)
{
    return system("command -v mpirun >/dev/null") == 0 &&
           (access(WEFT_BINARY_DIR "/weft-openmpi", X_OK) == 0 ||
            access(WEFT_BINARY_DIR "/weft-mpich", X_OK) == 0);
}

static int run_line(const char *line)
{
    char command[MAX_COMMAND + 4200];
    snprintf(command, sizeof command,
             "PATH='%s':\"$PATH\" XDG_CACHE_HOME=. sh -c '%s' >out.txt 2>err.txt </dev/null",
             WEFT_BINARY_DIR, "eval \"$LINE\"");
    setenv("LINE", line, 1);
    const int status = system(command);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static void fail_line(const char *page, const char *line, int code)
{
    size_t size;
    char *err = command_read_file("err.txt", &size);
    fail_msg("%s: %s\nended with %d: %.*s", page, line, code, (int)size, err);
}

static void put(const char *path, const char *text)
{
    command_write_file(path, text, strlen(text));
}

static void prepare(void)
{
    command_succeeds("make", "chirp", "-o", "smoke.vdb", "--size", "112x223x113", "--voxel", "0.5");
    command_succeeds("make", "chirp", "-o", "puff_0001.vdb", "--size", "64");
    command_succeeds("make", "chirp", "-o", "puff_0002.vdb", "--size", "64");
    command_succeeds("slice", "smoke.vdb", "-o", "photo.exr", "--preview", "photo.png", "--size",
                     "320x240");
    command_succeeds("slice", "smoke.vdb", "-o", "render_%04d.exr", "--preview", "photo_%04d.png",
                     "--frames", "1-20", "--at", "10..40", "--size", "64x48");
    assert_int_equal(mkdir("docs", 0755), 0); // where pages have their pictures
    put("model.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    put("track.csv", "x,y,z,t\n10,20,30,0\n11.5,20,30.25,1\n");
    put("ct.raw", "");
    assert_int_equal(truncate("ct.raw", 64 * 64 * 30 * 2), 0);
    put("keys.txt", "* 0 0,0,0\n* 1 0.5,0,0 0,0,1,90\n");
}

// What a page shows behind its commands without a language is what the last one prints, or a part
// of each line of that.
static void check_quote(const char *page, const char *line)
{
    size_t size;
    char *out = command_read_file("out.txt", &size);
    if (!strstr(out, line))
        fail_msg("%s: not printed: %s\nbut: %s", page, line, out);
    free(out);
}

struct counts {
    int commands, quoted; // lines
};

static void run_page(const char *page, bool quotes, struct counts *counts)
{
    char path[1000];
    snprintf(path, sizeof path, "%s/%s", WEFT_SOURCE_DIR, page);
    size_t size;
    char *text = command_read_file(path, &size), *rest = text;
    bool shell = false, plain = false, ran = false;
    for (char *line; (line = strsep(&rest, "\n"));) {
        if (strncmp(line, "```", 3) == 0) {
            const bool opens = !shell && !plain;
            shell = opens && strcmp(line, "```sh") == 0;
            plain = opens && !shell;
            continue;
        }
        if (plain && quotes && ran) {
            check_quote(page, line);
            counts->quoted++;
        }
        if (!shell || !(starts_with(line, "weft ") || starts_with(line, "mpirun ")))
            continue;
        assert_true(strlen(line) < MAX_COMMAND);
        ran = !takes_long(line) && (!starts_with(line, "mpirun ") || has_mpi());
        if (!ran) {
            print_message("not run here: %s\n", line);
            continue;
        }
        const int code = run_line(line);
        if (code != 0 && !(code == 1 && strstr(line, "ends with 1")))
            fail_line(page, line, code);
        counts->commands++;
    }
    free(text);
}

static void every_command_works(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 1);
    prepare();
    struct counts readme = {0}, pages = {0};
    run_page("README.md", false, &readme);
    assert_true(readme.commands >= LEAST_COMMANDS);
    static const char *const quoting[] = {"docs/errors.md", "docs/targets.md",
                                          "docs/coordinates.md", "docs/pictures.md"};
    for (size_t i = 0; i < sizeof quoting / sizeof *quoting; i++)
        run_page(quoting[i], true, &pages);
    assert_true(pages.commands >= 16 && pages.quoted >= 16);
    static const char *const others[] = {
        "docs/slices.md", "docs/points.md",    "docs/accumulation.md", "docs/effects.md",
        "docs/chart.md",  "docs/stability.md", "docs/table1.md"};
    for (size_t i = 0; wants_all() && i < sizeof others / sizeof *others; i++)
        run_page(others[i], false, &pages);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_command_works)};
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
