// SPDX-License-Identifier: BSD-3-Clause
// weft slice --frames: each frame has the bytes of a slice of its own, what cannot be made is told
// and leaves the others, and interrupts leave finished frames and nothing else.
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
#include "tests/support/json.h"

static struct command_result result;

static void write_text(const char *path, const char *text)
{
    command_write_file(path, text, strlen(text));
}

static bool exists(const char *path)
{
    return access(path, F_OK) == 0;
}

// Removes the files of a pattern with a number, and returns how many there were.
static int remove_numbered(const char *pattern, int count)
{
    int removed = 0;
    for (int i = 0; i < count; i++) {
        char path[128];
        snprintf(path, sizeof path, pattern, i);
        removed += unlink(path) == 0;
    }
    return removed;
}

static void assert_same_file(const char *a, const char *b)
{
    size_t size_a, size_b;
    char *of_a = command_read_file(a, &size_a), *of_b = command_read_file(b, &size_b);
    if (size_a != size_b || memcmp(of_a, of_b, size_a) != 0)
        fail_msg("%s (%zu bytes) and %s (%zu bytes) differ", a, size_a, b, size_b);
    free(of_a);
    free(of_b);
}

// ---- usage --------------------------------------------------------------------------------------

static void frames_and_names_go_together(void **state)
{
    (void)state;
    static const struct {
        const char *text, *args[12];
    } cases[] = {
        {"need --frames", {"ml.vdb", "-o", "a.exr", "--step", "0,0,1"}},
        {"need --frames", {"ml.vdb", "-o", "a.exr", "--planes", "p.txt"}},
        {"need --frames", {"ml.vdb", "-o", "a.exr", "--skip-bad"}},
        {"needs --frames", {"ml.vdb", "-o", "a.exr", "--at", "1..2"}},
        {"needs --frames", {"ml.vdb", "-o", "a_%04d.exr"}},
        {"needs --frames", {"ml.vdb", "--preview", "a_%d.png"}},
        {"needs --frames", {"ml_%03d.vdb", "-o", "a.exr"}},
        {"put its number in", {"ml.vdb", "-o", "a.exr", "--frames", "0-3", "--at", "1..2"}},
        {"put its number in", {"ml.vdb", "-o", "-", "--frames", "0-3", "--at", "1..2"}},
        {"put its number in", {"ml.vdb", "-o", "a%%d.exr", "--frames", "0-3", "--at", "1..2"}},
        {"put its number in",
         {"ml.vdb", "-o", "a%d.exr", "--preview", "a.png", "--frames", "0-3", "--at", "1..2"}},
        {"2 times", {"ml.vdb", "-o", "a%d-%d.exr", "--frames", "0-3", "--at", "1..2"}},
        {"2 times", {"a%d-%d.vdb", "-o", "a%d.exr", "--frames", "0-3"}},
        {"neither", {"ml.vdb", "-o", "a%4d.exr", "--frames", "0-3", "--at", "1..2"}},
        {"neither", {"ml.vdb", "-o", "a%d%s.exr", "--frames", "0-3", "--at", "1..2"}},
        {"neither", {"ml.vdb", "-o", "a%d%00d.exr", "--frames", "0-3", "--at", "1..2"}},
        {"neither", {"ml.vdb", "-o", "a%.d%d.exr", "--frames", "0-3", "--at", "1..2"}},
        {"neither", {"100%.vdb", "-o", "a%d.exr", "--frames", "0-3", "--at", "1..2"}},
        {"all frames would be the same", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3"}},
        {"all frames would be the same",
         {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--at", "1"}},
        {"does not move",
         {"ml.vdb", "--origin", "0,0,1", "--u", "9,0,0", "--v", "0,9,0", "--step", "0,0,0",
          "--frames", "0-3"}},
        {"--step goes with", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--step", "0,0,1"}},
        {"excludes", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--planes", "p", "--at", "1"}},
        {"excludes", {"ml.vdb", "--frames", "0-3", "--planes", "p", "--u", "1,0,0"}},
        {"excludes", {"ml.vdb", "--frames", "0-3", "--planes", "p", "--step", "1,0,0"}},
        {"--at", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--at", "1.."}},
        {"--at", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--at", "..1"}},
        {"--at", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--at", "1..nan"}},
        {"--at", {"ml.vdb", "-o", "a%d.exr", "--frames", "0-3", "--at", "1..2..3"}},
        {"nothing to do", {"ml.vdb", "--frames", "0-3", "--at", "1..2"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *args[16] = {"weft", "slice"};
        for (int j = 0; cases[i].args[j]; j++)
            args[j + 2] = cases[i].args[j];
        command_fails_list(__FILE__, __LINE__, 2, cases[i].text, args);
    }
}

static void frames_are_whole_numbers(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"7", "FIRST-LAST"},
        {"", "empty"},
        {"1-", "FIRST-LAST"},
        {"-1-5", "FIRST-LAST"},
        {"1-5:", "FIRST-LAST"},
        {"1-5:x", "FIRST-LAST"},
        {"1-5:-1", "FIRST-LAST"},
        {"1-5:2:3", "FIRST-LAST"},
        {"1.5-3", "FIRST-LAST"},
        {"1 -3", "FIRST-LAST"},
        {"1-1000000000", "999999999"},
        {"5-4", "more than LAST"},
        {"1-5:0", "STEP"},
        {"0-10000", "10001 frames; there may be at most 10000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char option[64];
        snprintf(option, sizeof option, "--frames=%s", cases[i][0]);
        command_fails(2, cases[i][1], "slice", "ml.vdb", "-o", "a%d.exr", "--at", "1..2", option);
    }
}

static void wrong_planes_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *text, *lines;
    } cases[] = {
        {"p.txt, line 2: not a plane", "0,0,1 9,0,0 0,9,0\n0,0,1 9,0,0 0,9\n"},
        {"p.txt, line 1: not a plane", "0,0,nan 9,0,0 0,9,0\n"},
        {"p.txt, line 1: not a plane", "0,0,inf 9,0,0 0,9,0\n"},
        {"p.txt, line 1: not a plane", "0, 0,1 9,0,0 0,9,0\n"},
        {"p.txt, line 1: not a plane", "0,0,1 9,0,0\n"},
        {"p.txt, line 1: not a plane", "0,0,1;9,0,0;0,9,0\n"},
        {"p.txt, line 4: more than", "# a\n\n0,0,1 9,0,0 0,9,0\n0,0,1 9,0,0 0,9,0 5\n"},
        {"p.txt, line 1: u and v", "0,0,1 0,0,0 0,9,0\n"},
        {"p.txt, line 1: u and v", "0,0,1 1,2,3 2,4,6\n"},
        {"has 0 planes", ""},
        {"has 1 planes; --frames needs 2", "0,0,1 9,0,0 0,9,0"},
        {"has 3 planes", "0,0,1 9,0,0 0,9,0\n0,0,1 9,0,0 0,9,0\n0,0,1 9,0,0 0,9,0\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text("p.txt", cases[i].lines);
        command_fails(3, cases[i].text, "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "5-6",
                      "--planes", "p.txt");
    }
    command_write_file("p.txt", "0,0,1 9,0,0 0,9,0\n\0", 19);
    command_fails(3, "line 2: a NUL byte", "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "5-6",
                  "--planes", "p.txt");
    command_fails(3, "line 1", "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "5-6", "--planes",
                  "/dev/zero");
    command_fails(3, "cannot be opened", "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "5-6",
                  "--planes", "none.txt");
    command_fails(3, "cannot be read", "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "5-6",
                  "--planes", ".");
    unlink("p.txt");
}

// Every name is looked at before anything runs.
static void names_are_checked_before_the_first(void **state)
{
    (void)state;
    write_text("a3.exr", "mine");
    command_fails(4, "a3.exr exists", "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "0-5", "--at",
                  "1..2", "--no-clobber");
    assert_int_equal(symlink("a3.exr", "a5.exr"), 0);
    command_fails(2, "a3.exr is written by frame 3, and written by frame 5", "slice", "ml.vdb",
                  "-o", "a%d.exr", "--frames", "0-5", "--at", "1..2");
    unlink("a3.exr");
    unlink("a5.exr");
    assert_int_equal(link("ml.vdb", "a4.exr"), 0);
    command_fails(2, "the output a4.exr is the input", "slice", "ml.vdb", "-o", "a%d.exr",
                  "--frames", "0-5", "--at", "1..2");
    unlink("a4.exr");
    command_fails(2, "x11 is written by frame 11, and read by frame 1", "slice", "x1%d", "-o",
                  "x%d", "--frames", "1-11:10");
    command_fails(2, "x11 is written by frame 1, and written by frame 11", "slice", "ml.vdb", "-o",
                  "x1%d", "--preview", "x%d", "--frames", "1-11:10", "--at", "1..2");
    command_fails(4, "folder f3/", "slice", "ml.vdb", "-o", "f%d/a.exr", "--frames", "3-4", "--at",
                  "1..2");
}

// ---- the same as one by one ---------------------------------------------------------------------

// A frame against a slice of its own with these arguments beside `common`.
static void assert_as_alone(const char *path, const char *const *common, const char *const *plane)
{
    const char *args[40] = {"weft", "slice", "ml.vdb", "-o", "alone.exr", "-q"};
    int count = 6;
    for (int i = 0; common[i]; i++)
        args[count++] = common[i];
    for (int i = 0; plane[i]; i++)
        args[count++] = plane[i];
    command_run_list(&result, args);
    if (result.code != 0)
        fail_msg("%s", result.err);
    assert_same_file(path, "alone.exr");
    unlink("alone.exr");
}

static void run_frames(const char *const *common, const char *const *sweep)
{
    const char *args[40] = {"weft", "slice", "ml.vdb", "-o", "a%d.exr", "-q"};
    int count = 6;
    for (int i = 0; common[i]; i++)
        args[count++] = common[i];
    for (int i = 0; sweep[i]; i++)
        args[count++] = sweep[i];
    command_run_list(&result, args);
    if (result.code != 0)
        fail_msg("%s", result.err);
}

static void frames_are_as_slices_alone(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    static const char *const methods[][8] = {
        {"--size", "48x40"},
        {"--size", "32x32", "--kernel", "bspline3i", "--verify"},
        {"--size", "32x32", "--profile", "unorm8", "--kernel", "linear"},
        {"--size", "32x32", "--max-error", "12bit"},
        {"--size", "32x32", "--engine", "cpu", "--kernel", "bspline"},
        {"--size", "32x32", "--source", "unorm8", "--memory", "300K"},
    };
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        // From 2 to 10 in 4 steps.
        run_frames(methods[m],
                   (const char *[]){"--axis", "x", "--at", "2..10", "--frames", "3-7", NULL});
        assert_as_alone("a3.exr", methods[m], (const char *[]){"--axis", "x", "--at", "2", NULL});
        assert_as_alone("a6.exr", methods[m], (const char *[]){"--axis", "x", "--at", "8", NULL});
        assert_as_alone("a7.exr", methods[m], (const char *[]){"--axis", "x", "--at", "10", NULL});
        assert_int_equal(remove_numbered("a%d.exr", 10), 5);
        // By a step, every other one.
        run_frames(methods[m],
                   (const char *[]){"--origin", "1,2,3", "--u", "12,0,3", "--v", "0,12,1", "--step",
                                    "0.5,0,0.25", "--frames", "0-4:2", NULL});
        assert_as_alone(
            "a4.exr", methods[m],
            (const char *[]){"--origin", "3,2,4", "--u", "12,0,3", "--v", "0,12,1", NULL});
        assert_int_equal(remove_numbered("a%d.exr", 10), 3);
    }
}

// A volume that stays has blocks; beside constant cells they round otherwise than a slice alone.
static void what_stays_is_within_the_bound(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    json_t *root = parse(command_succeeds(
        "slice", "sphere.vdb", "--space", "index", "--origin", "1,2,9", "--u", "30,0,5", "--v",
        "0,30,3", "--step", "0,0,0.5", "--frames", "0-9", "--size", "40x40", "--verify", "--json"));
    const json_t *frames = json_object_get(root, "frames");
    const json_t *resident = json_object_get(root, "resident");
    assert_int_equal(json_array_size(frames), 10);
    for (size_t i = 0; i < 10; i++) {
        const json_t *verify = json_object_get(json_array_get(frames, i), "error");
        assert_true(number(verify, "samples") == 1600.0);
        assert_true(number(verify, "max") <= number(json_array_get(frames, i), "bound"));
    }
    assert_true(number(resident, "laid_out") > 0.0);
    assert_true(number(resident, "reused") > number(resident, "laid_out"));
    json_decref(root);
    // Planes too far apart to share a block.
    root = parse(command_succeeds("slice", "sphere.vdb", "--at", "1..31", "--frames", "0-2",
                                  "--size", "8x8", "--json"));
    assert_true(json_is_null(json_object_get(root, "resident")));
    json_decref(root);
}

// Comments, blanks, line ends of other systems; a step takes every so manieth line.
static void planes_come_from_a_file(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    static const char *const common[] = {"--space", "index", "--size", "24x20", NULL};
    write_text("p.txt", "# origin u v\r\n\r\n  1,2,3 20,0,0\t0,20,0  \r\n"
                        "1,2,4 20,0,0 0,20,0\n\n1e0,2,5 20,0,7 0,+20,0");
    run_frames(common, (const char *[]){"--planes", "p.txt", "--frames", "7-9:2", NULL});
    assert_as_alone("a7.exr", common,
                    (const char *[]){"--origin", "1,2,3", "--u", "20,0,0", "--v", "0,20,0", NULL});
    assert_as_alone("a9.exr", common,
                    (const char *[]){"--origin", "1,2,5", "--u", "20,0,7", "--v", "0,20,0", NULL});
    assert_int_equal(remove_numbered("a%d.exr", 10), 2);
    unlink("p.txt");
}

// ---- what is told -------------------------------------------------------------------------------

static void json_lists_every_frame(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "-o", "a%02d.exr", "--preview",
                                          "b%d.png", "--size", "16x16", "--at", "1..9", "--frames",
                                          "8-16:4", "--verify", "--json"));
    const json_t *frames = json_object_get(root, "frames");
    assert_int_equal(json_array_size(frames), 3);
    assert_int_equal((int)number(root, "complete"), 3);
    assert_int_equal((int)number(root, "skipped"), 0);
    double writing = 0.0;
    for (size_t i = 0; i < 3; i++) {
        const json_t *frame = json_array_get(frames, i);
        const json_t *geometry = json_object_get(frame, "geometry");
        const json_t *origin = json_object_get(geometry, "origin");
        char output[16];
        snprintf(output, sizeof output, "a%02d.exr", 8 + 4 * (int)i);
        assert_int_equal((int)number(frame, "frame"), 8 + 4 * (int)i);
        assert_string_equal(json_string_value(json_object_get(
                                json_array_get(json_object_get(frame, "output"), 0), "path")),
                            output);
        assert_true(json_number_value(json_array_get(origin, 2)) == 1.0 + 4.0 * (double)i);
        assert_true(number(json_object_get(frame, "file"), "verified") == 256.0);
        assert_true(number(json_object_get(frame, "error"), "samples") == 256.0);
        writing += number(json_object_get(frame, "seconds"), "write");
        assert_true(exists(output));
    }
    assert_true(writing > 0.0);
    assert_float_equal(writing, number(json_object_get(root, "seconds"), "write"), 1e-9);
    json_decref(root);
    assert_int_equal(remove_numbered("a%02d.exr", 20) + remove_numbered("b%d.png", 20), 6);
    // One slice is told as ever.
    root = parse(command_succeeds("slice", "ml.vdb", "--size", "16x16", "--json"));
    assert_null(json_object_get(root, "frames"));
    assert_null(json_object_get(root, "frame"));
    json_decref(root);
}

// A picture that flickers is of no use: one range for all, here from the background to the one
// voxel that most frames do not reach.
static void previews_have_one_range(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    command_succeeds("make", "impulse", "--size", "32", "-o", "impulse.vdb");
    const char *out =
        command_succeeds("slice", "impulse.vdb", "--preview", "b%d.png", "--kernel", "linear",
                         "--size", "32x32", "--at", "10..16.25", "--frames", "0-2");
    assert_string_equal(out, "b%d.png: values from 0 to 1\n");
    command_succeeds("slice", "impulse.vdb", "--preview", "one.png", "--kernel", "linear", "--size",
                     "32x32", "--at", "16.25", "--range", "0,1");
    assert_same_file("b2.png", "one.png");
    assert_int_equal(remove_numbered("b%d.png", 3), 3);
    unlink("one.png");
    unlink("impulse.vdb");
}

static void plans_of_all_frames_are_explained(void **state)
{
    (void)state;
    const char *out =
        command_succeeds("slice", "ml.vdb", "--explain", "--at", "1..2", "--frames", "1-3");
    assert_non_null(strstr(out, "frame 1\n"));
    assert_non_null(strstr(out, "frame 3\n"));
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--explain", "--json", "--at", "1..2",
                                          "-o", "a%d.exr", "--frames", "1-3"));
    assert_int_equal(json_array_size(json_object_get(root, "frames")), 3);
    json_decref(root);
    assert_false(exists("a1.exr"));
}

// ---- sequences of files -------------------------------------------------------------------------

// s0.vdb to s4.vdb, of which 2 is damaged and 3 is not there.
static void make_sequence(void)
{
    command_succeeds("make", "ramp", "--size", "16", "-o", "s0.vdb");
    command_succeeds("make", "ramp", "--size", "16", "--voxel", "1.0625", "-o", "s1.vdb");
    command_succeeds("make", "chirp", "--size", "16", "-o", "s4.vdb");
    size_t size;
    char *data = command_read_file("s1.vdb", &size);
    command_write_file("s2.vdb", data, size / 2);
    free(data);
}

static void assert_frame_of_sequence(const char *path, const char *volume)
{
    // The plane of the first volume: 16 voxels with half a voxel around them.
    command_succeeds("slice", volume, "-o", "alone.exr", "--size", "32x32", "--origin",
                     "-0.5,-0.5,3", "--u", "16,0,0", "--v", "0,16,0");
    assert_same_file(path, "alone.exr");
    unlink("alone.exr");
}

static void a_bad_frame_ends_the_sweep(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    make_sequence();
    command_run(&result, "weft", "slice", "s%d.vdb", "-o", "a%d.exr", "--size", "32x32", "--at",
                "3", "--frames", "0-4", "--box", "first");
    assert_int_equal(result.code, 3);
    assert_non_null(strstr(result.err, "weft: error: frame 2: s2.vdb"));
    assert_non_null(strstr(result.err, "2 of 5 frames are complete, the last is 1"));
    assert_null(strstr(result.err, "frame 3"));
    assert_frame_of_sequence("a0.exr", "s0.vdb");
    assert_frame_of_sequence("a1.exr", "s1.vdb");
    assert_int_equal(remove_numbered("a%d.exr", 5), 2);
    assert_int_equal(remove_numbered("s%d.vdb", 5), 4);
}

static void bad_frames_can_be_skipped(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    make_sequence();
    command_run(&result, "weft", "slice", "s%d.vdb", "-o", "a%d.exr", "--size", "32x32", "--at",
                "3", "--frames", "0-4", "--skip-bad", "--json", "--box", "first");
    assert_int_equal(result.code, 3);
    assert_non_null(strstr(result.err, "weft: error: frame 2: s2.vdb"));
    assert_non_null(strstr(result.err, "weft: error: frame 3: cannot open s3.vdb"));
    assert_non_null(strstr(result.err, "2 of 5 frames were skipped"));
    json_t *root = parse(result.out);
    const json_t *frames = json_object_get(root, "frames");
    assert_int_equal(json_array_size(frames), 5);
    for (size_t i = 0; i < 5; i++) {
        const json_t *problem = json_object_get(json_array_get(frames, i), "problem");
        assert_int_equal((int)number(json_array_get(frames, i), "frame"), (int)i);
        assert_int_equal(json_is_string(problem), i == 2 || i == 3);
    }
    assert_int_equal((int)number(root, "complete"), 3);
    assert_int_equal((int)number(root, "skipped"), 2);
    json_decref(root);
    assert_frame_of_sequence("a4.exr", "s4.vdb");
    assert_int_equal(remove_numbered("a%d.exr", 5), 3);
    // Where all are bad; and a grid that is not in the file.
    command_run(&result, "weft", "slice", "s%d.vdb", "-o", "a%d.exr", "--frames", "2-3",
                "--skip-bad");
    assert_int_equal(result.code, 3);
    command_run(&result, "weft", "slice", "s%d.vdb", "-o", "a%d.exr", "--size", "8x8", "--grid",
                "chirp", "--frames", "1-4:3", "--skip-bad");
    assert_int_equal(result.code, 3);
    assert_int_equal(remove_numbered("a%d.exr", 5), 1);
    // One file for all frames is no frame's own.
    command_fails(3, "frame 0: s2.vdb", "slice", "s2.vdb", "-o", "a%d.exr", "--at", "1..2",
                  "--frames", "0-9", "--skip-bad");
    assert_int_equal(remove_numbered("s%d.vdb", 5), 4);
}

// A frame that is too large to be written: those before it stay.
static void a_frame_that_cannot_be_written_ends_it(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    // Pixels follow the planes' edges: 1024 x 16, and 1024 x 1024.
    write_text("p.txt", "0,0,3 15,0,0 0,0.25,0\n0,0,3 15,0,0 0,15,0\n0,0,3 15,0,0 0,0.25,0\n");
    struct rlimit before, small = {400000, 400000};
    getrlimit(RLIMIT_FSIZE, &before);
    small.rlim_max = before.rlim_max;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    command_run(&result, "weft", "slice", "ml.vdb", "-o", "a%d.exr", "--frames", "0-2", "--planes",
                "p.txt", "--skip-bad");
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(result.code, 4);
    assert_non_null(strstr(result.err, "weft: error: frame 1: "));
    assert_non_null(strstr(result.err, "1 of 3 frames are complete, the last is 0"));
    assert_true(exists("a0.exr"));
    assert_int_equal(remove_numbered("a%d.exr", 3), 1);
    unlink("p.txt");
}

static void no_method_for_a_frame_ends_it(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    command_fails(1, "frame 0: no method is within", "slice", "ml.vdb", "-o", "a%d.exr", "--size",
                  "16x16", "--at", "1..2", "--frames", "0-3", "--max-error", "1e-30", "--skip-bad");
}

// ---- interrupts ---------------------------------------------------------------------------------

enum { MANY = 40 };

// What an interrupted run leaves: some frames from the first on, each as it is to be.
static int check_left(void)
{
    int count = 0;
    for (int i = 0; i < MANY; i++) {
        char path[32], whole[32];
        snprintf(path, sizeof path, "a%d.exr", i);
        snprintf(whole, sizeof whole, "whole%d.exr", i);
        if (!exists(path))
            continue;
        assert_same_file(path, whole);
        assert_int_equal(count++, i);
    }
    return count;
}

static void interrupts_leave_finished_frames(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    // A file for each frame, though they are one: volumes are opened, and files written, aside.
    char name[32];
    for (int i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "v%d.vdb", i);
        assert_int_equal(link("ml.vdb", name), 0);
    }
    command_succeeds("slice", "v%d.vdb", "-o", "whole%d.exr", "--size", "200x200", "--at", "1..14",
                     "--frames", "0-39");
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    int interrupted = 0, with_frames = 0;
    for (int i = 0; i < 9; i++) {
        FILE *err = tmpfile();
        assert_non_null(err);
        const int before = command_folder_size();
        const pid_t pid =
            command_start(-1, fileno(err),
                          (const char *[]){"weft", "slice", "v%d.vdb", "-o", "a%d.exr", "--size",
                                           "200x200", "--at", "1..14", "--frames", "0-39", NULL});
        usleep((useconds_t)(20000 + 45000 * i));
        int status, told = -1;
        command_signal(pid, signals[i % 3], &status);
        const int left = check_left();
        assert_int_equal(command_folder_size(), before + left);
        if (WIFSIGNALED(status)) {
            char line[256] = "";
            rewind(err);
            while (fgets(line, sizeof line, err))
                if (sscanf(line, "weft: ended with %d of 40 frames complete", &told) != 1 &&
                    strstr(line, "ended with none of 40"))
                    told = 0;
            // Nothing is told while options are read. One is in place before it is counted.
            assert_true(told == left || told == left - 1 || (told < 0 && left == 0));
            assert_int_equal(WTERMSIG(status), signals[i % 3]);
            interrupted++;
            with_frames += left > 0;
        } else {
            assert_int_equal(left, MANY);
        }
        fclose(err);
        remove_numbered("a%d.exr", MANY);
    }
    assert_true(interrupted > 0);
    print_message("%d of 9 interrupted, %d with frames\n", interrupted, with_frames);
    assert_int_equal(remove_numbered("whole%d.exr", MANY), MANY);
    assert_int_equal(remove_numbered("v%d.vdb", MANY), MANY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_and_names_go_together),
        cmocka_unit_test(frames_are_whole_numbers),
        cmocka_unit_test(wrong_planes_are_named),
        cmocka_unit_test(names_are_checked_before_the_first),
        cmocka_unit_test(frames_are_as_slices_alone),
        cmocka_unit_test(what_stays_is_within_the_bound),
        cmocka_unit_test(planes_come_from_a_file),
        cmocka_unit_test(json_lists_every_frame),
        cmocka_unit_test(previews_have_one_range),
        cmocka_unit_test(plans_of_all_frames_are_explained),
        cmocka_unit_test(a_bad_frame_ends_the_sweep),
        cmocka_unit_test(bad_frames_can_be_skipped),
        cmocka_unit_test(a_frame_that_cannot_be_written_ends_it),
        cmocka_unit_test(no_method_for_a_frame_ends_it),
        cmocka_unit_test(interrupts_leave_finished_frames),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
