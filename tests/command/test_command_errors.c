// SPDX-License-Identifier: BSD-3-Clause
// Bad usage and bad input: one error line, the documented exit code, nothing left behind.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/support/command.h"

static void wrong_usage(void **state)
{
    (void)state;
    struct command_result r;
    command_run(&r, "weft");
    assert_int_equal(r.code, 2);
    command_fails(2, "slice, probe, lattice, convert, make, info", "carve");
    command_fails(2, "slice, probe, lattice, convert, make, info", "help", "carve");
    command_fails(2, "--frobnicate", "slice", "ml.vdb", "--frobnicate");
    command_fails(2, "-x", "slice", "ml.vdb", "-x");
    command_fails(2, "needs a value", "slice", "ml.vdb", "-o");
    command_fails(2, "needs a value", "slice", "ml.vdb", "--grid", "--json");
    command_fails(2, "takes no value", "slice", "ml.vdb", "--verify=yes");
    command_fails(2, "must end in .json", "slice", "ml.vdb", "--json=yes.txt");
    command_fails(2, "is empty", "slice", "ml.vdb", "--output=");
    command_fails(2, "twice", "slice", "ml.vdb", "-o", "a.exr", "-o", "b.exr");
    command_fails(2, "too many", "slice", "ml.vdb", "sphere.vdb", "-o", "a.exr");
    command_fails(2, "no volume", "slice", "-o", "a.exr");
    command_fails(2, "nothing to do", "slice", "ml.vdb");
    command_fails(2, "exclude", "slice", "ml.vdb", "-o", "a.exr", "-q", "-v");
    command_fails(2, "--preview", "slice", "ml.vdb", "-o", "a.exr", "--range", "0,1");
    command_fails(2, "no file", "info");
    command_fails(2, "marschner-lobb", "make");
    command_fails(2, "marschner-lobb", "make", "cube", "-o", "a.vdb");
    command_fails(2, "no output", "make", "ramp");
}

static void bad_values(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"--size", "0x0"},
        {"--size", "-5x64"},
        {"--size", "64x1000000000"},
        {"--size", "99999999999999999999x1"},
        {"--size", "64x"},
        {"--size", "64x64x64"},
        {"--size", "64x64 "},
        {"--size", "axb"},
        {"--axis", "w"},
        {"--at", "nan"},
        {"--at", "inf"},
        {"--at", "1e999"},
        {"--at", "3m"},
        {"--space", "outer"},
        {"--layout", "dense"},
        {"--context", "glx"},
        {"--memory", "0"},
        {"--memory", "-1"},
        {"--memory", "12Q"},
        {"--memory", "9999999999G"},
        {"--kernel", "lanczos-of-mars"},
        {"--kernel", "cubic:x"},
        {"--kernel", "cubic:0,0.5,7"},
        {"--kernel", "cubic:1e9,0"},
        {"--kernel", "cubic:nan,0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char option[128];
        snprintf(option, sizeof option, "%s=%s", cases[i][0], cases[i][1]);
        command_fails(2, "", "slice", "ml.vdb", "-o", "a.exr", option);
    }
    command_fails(2, "catmull-rom", "slice", "ml.vdb", "-o", "a.exr", "--kernel", "nothing");
    command_fails(2, "grey", "slice", "ml.vdb", "--preview", "a.png", "--colour-map", "puce");
    command_fails(2, "LO", "slice", "ml.vdb", "--preview", "a.png", "--range", "1,1");
    command_fails(2, "LO", "slice", "ml.vdb", "--preview", "a.png", "--range", "1");
}

static void bad_planes(void **state)
{
    (void)state;
#define slice_fails(text, ...) command_fails(2, text, "slice", "ml.vdb", "-o", "a.exr", __VA_ARGS__)
    slice_fails("together", "--origin", "0,0,0", "--u", "1,0,0");
    slice_fails("together", "--v", "1,0,0");
    slice_fails("exclude", "--origin", "0,0,0", "--u", "1,0,0", "--v", "0,1,0", "--axis", "x");
    slice_fails("exclude", "--at", "3", "--u", "1,0,0");
    slice_fails("", "--origin", "0,0,0", "--u", "0,0,0", "--v", "0,1,0");
    slice_fails("", "--origin", "0,0,0", "--u", "1,0,0", "--v", "0,0,0");
    slice_fails("", "--origin", "0,0,0", "--u", "1,2,3", "--v", "2,4,6");
    slice_fails("", "--origin", "0,0,0", "--u", "1,2,3", "--v=-2,-4,-6");
    slice_fails("finite", "--origin", "0,0,0", "--u", "nan,0,0", "--v", "0,1,0");
    slice_fails("finite", "--origin", "0,0,inf", "--u", "1,0,0", "--v", "0,1,0");
    slice_fails("", "--origin", "0,0", "--u", "1,0,0", "--v", "0,1,0");
#undef slice_fails
    command_fails(3, "", "slice", "ml.vdb", "-o", "a.exr", "--origin", "1e300,0,0", "--u", "1,0,0",
                  "--v", "0,1,0");
}

static void bad_outputs(void **state)
{
    (void)state;
    command_fails(2, "must end in .exr", "slice", "ml.vdb", "-o", "ml.vdb");
    assert_int_equal(symlink("ml.vdb", "link.exr"), 0);
    assert_int_equal(link("ml.vdb", "hard.exr"), 0);
    command_fails(2, "is the input", "slice", "ml.vdb", "-o", "link.exr");
    command_fails(2, "is the input", "slice", "link.exr", "-o", "./link.exr");
    command_fails(2, "is the input", "resample", "hard.exr", "-o", "link.exr");
    command_fails(2, "is the input", "slice", "ml.vdb", "-o", "hard.exr");
    unlink("link.exr");
    unlink("hard.exr");
    command_fails(2, "same file", "slice", "ml.vdb", "-o", "a", "--preview", "./a");
    static const char no_fonts[] = "<fontconfig><dir>/nowhere</dir></fontconfig>";
    command_write_file("fonts.conf", no_fonts, strlen(no_fonts));
    char *whole = realpath("fonts.conf", NULL);
    assert_non_null(whole);
    setenv("FONTCONFIG_FILE", whole, 1);
    free(whole);
    command_fails(1, "fonts-dejavu-core", "slice", "no.vdb", "--preview", "a.png", "--annotate");
    unsetenv("FONTCONFIG_FILE");
    unlink("fonts.conf");
    command_fails(4, "nowhere", "slice", "ml.vdb", "-o", "nowhere/a.exr");
    command_fails(4, "ml.vdb", "slice", "ml.vdb", "-o", "ml.vdb/a.exr");
    command_fails(4, "folder", "slice", "ml.vdb", "-o", ".");
    command_fails(4, "folder", "slice", "ml.vdb", "--preview", "/");
    command_fails(4, "nowhere", "make", "ramp", "-o", "nowhere/a.vdb");
    assert_int_equal(mkdir("locked", 0500), 0);
    if (geteuid() != 0)
        command_fails(4, "locked", "slice", "ml.vdb", "-o", "locked/a.exr");
    rmdir("locked");
    if (command_has_gl()) // a folder that looks writable to root, and is not
        command_fails(4, "/proc/weft.exr", "slice", "ml.vdb", "--size", "8x8", "-o",
                      "/proc/weft.exr");
}

static void bad_make(void **state)
{
    (void)state;
    static const char *const cases[] = {"--size=0",
                                        "--size=-4",
                                        "--size=4x4",
                                        "--size=1e3",
                                        "--size=1000000000",
                                        "--size=100000",
                                        "--voxel=0",
                                        "--voxel=-1",
                                        "--voxel=nan",
                                        "--voxel=1,2",
                                        "--offset=1,2",
                                        "--offset=1.5,0,0",
                                        "--offset=0,0,2000000000"};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        command_fails(2, "", "make", "ramp", "-o", "a.vdb", cases[i]);
    command_fails(2, "4000000000", "make", "ramp", "-o", "a.vdb", "--size", "1000");
    command_fails(2, "level set", "make", "sphere", "-o", "a.vdb", "--size", "8x8x9");
    command_fails(2, "level set", "make", "sphere", "-o", "a.vdb", "--voxel", "1,1,2");
    command_fails(2, "precision", "make", "sphere", "-o", "a.vdb", "--voxel", "1e-60");
    command_environment("WEFT_LIBEXEC=/nonexistent");
    command_fails(4, "weft-write-vdb", "make", "ramp", "-o", "a.vdb");
}

// As input of slice and of info, which must agree that it is no good.
static void refused(const char *path, const char *text)
{
    command_fails(3, text, "slice", path, "-o", "a.exr");
    command_fails(3, text, "info", path);
}

static void bad_files(void **state)
{
    (void)state;
    refused("missing.vdb", "missing.vdb");
    refused(".", "");
    command_write_file("empty.vdb", "", 0);
    refused("empty.vdb", "empty.vdb");
    unlink("empty.vdb");
    size_t size;
    char *good = command_read_file("ml.vdb", &size);
    command_write_file("cut.vdb", good, 300);
    refused("cut.vdb", "cut.vdb");
    command_write_file("cut.vdb", good, size / 2);
    command_fails(3, "cut.vdb", "slice", "cut.vdb", "-o", "a.exr");
    unlink("cut.vdb");
    unsigned seed = 1;
    for (size_t i = 0; i < size; i++)
        good[i] = (char)((seed = seed * 1664525u + 1013904223u) >> 24);
    command_write_file("random.vdb", good, size);
    refused("random.vdb", "random.vdb");
    memcpy(good, " BDV\0\0\0\0", 8);
    command_write_file("random.vdb", good, size);
    refused("random.vdb", "random.vdb");
    unlink("random.vdb");
    free(good);
    command_fails(2, "marschner-lobb", "slice", "ml.vdb", "-o", "a.exr", "--grid", "fog");
    command_environment("WEFT_LIBEXEC=/nonexistent");
    command_fails(3, "weft-read-vdb", "slice", "ml.vdb", "-o", "a.exr");
}

// Flipped bits may go unnoticed (voxel values have no checksum), but never crash or leave anything.
static void flipped_bits(void **state)
{
    (void)state;
    size_t size;
    char *bytes = command_read_file("sphere.vdb", &size);
    unsigned seed = 7;
    for (int i = 0; i < 16; i++) {
        seed = seed * 1664525u + 1013904223u;
        // Half of them in the first KiB, where the header, the metadata and the tree are.
        size_t at = (seed >> 8) % (i % 2 ? 1024 : size);
        bytes[at] = (char)(bytes[at] ^ (1 << (i % 8)));
        command_write_file("flip.vdb", bytes, size);
        bytes[at] = (char)(bytes[at] ^ (1 << (i % 8)));
        struct command_result r;
        int before = command_folder_size();
        command_run(&r, "weft", "slice", "flip.vdb", "--explain", "-q");
        if (r.code != 0 && r.code != 3)
            print_error("bit %d of byte %zu: exit code %d: %s\n", i % 8, at, r.code, r.err);
        assert_true(r.code == 0 || r.code == 3);
        if (r.code)
            assert_ptr_equal(strchr(r.err, '\n'), r.err + strlen(r.err) - 1);
        assert_int_equal(command_folder_size(), before);
    }
    unlink("flip.vdb");
    free(bytes);
}

static void no_gl_context(void **state)
{
    (void)state;
    command_environment("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent");
    command_environment("LIBGL_DRIVERS_PATH=/nonexistent");
    command_fails(5, "EGL", "slice", "ml.vdb", "-o", "a.exr", "--context", "egl");
    // A missing volume is reported before.
    command_environment("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent");
    command_fails(3, "missing.vdb", "slice", "missing.vdb", "-o", "a.exr", "--context", "egl");
}

static void too_many_pixels(void **state)
{
    (void)state;
    command_fails(2, "2147483648", "slice", "ml.vdb", "-o", "a.exr", "--size", "1048576x1048576");
    command_fails(2, "2147483648", "slice", "ml.vdb", "--explain", "--size", "1048576x1048576");
}

static void full_device(void **state)
{
    (void)state;
    if (access("/dev/full", W_OK) != 0)
        skip();
    char line[4200];
    snprintf(line, sizeof line, "'%s/weft' info ml.vdb 2>full.txt >/dev/full", WEFT_BINARY_DIR);
    int status = system(line);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 4);
    unlink("full.txt");
}

// A file may hold any transform: what it cannot be sliced with is the file's fault, not the user's.
static void transforms_at_the_limits(void **state)
{
    (void)state;
    static const char *const axes[] = {"x", "y", "z"}, *const spaces[] = {"world", "index"};
    command_succeeds("make", "ramp", "--size", "8", "-o", "t.vdb", "--voxel", "1e160,1e-160,1");
    for (size_t i = 0; i < 6; i++)
        command_succeeds("slice", "t.vdb", "--explain", "--axis", axes[i % 3], "--space",
                         spaces[i / 3]);
    command_succeeds("make", "ramp", "--size", "8", "-o", "t.vdb", "--voxel", "1e100");
    command_succeeds("slice", "t.vdb", "--explain", "--origin", "0,0,0", "--u", "1,0,0", "--v",
                     "0,1,0");
    command_fails(2, "span no plane", "slice", "t.vdb", "--explain", "--origin", "0,0,0", "--u",
                  "1,0,0", "--v", "2,0,0");
    command_succeeds("make", "ramp", "--size", "8", "-o", "t.vdb", "--voxel", "1e302,1e-160,1e-140",
                     "--offset", "10000000,0,0");
    command_fails(3, "leaves no box", "slice", "t.vdb", "--explain", "--axis", "y");
    command_fails(3, "leaves no box", "slice", "t.vdb", "-o", "t.exr", "--axis", "x");
    command_fails(3, "lengths", "slice", "t.vdb", "--explain", "--space", "index", "--origin",
                  "0,0,0", "--u", "10000000,0,0", "--v", "0,1,0");
    unlink("t.vdb");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage),
        cmocka_unit_test(bad_values),
        cmocka_unit_test(bad_planes),
        cmocka_unit_test(bad_outputs),
        cmocka_unit_test(bad_make),
        cmocka_unit_test(bad_files),
        cmocka_unit_test(flipped_bits),
        cmocka_unit_test(no_gl_context),
        cmocka_unit_test(too_many_pixels),
        cmocka_unit_test(full_device),
        cmocka_unit_test(transforms_at_the_limits),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
