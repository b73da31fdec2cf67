// SPDX-License-Identifier: BSD-3-Clause
// weft slice on ranks: the files of one process, in every byte, and what is told of them.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/command/ranks/mpirun.h"
#include "filter/check.h"
#include "tests/support/json.h"

enum { MOST = MPIRUN_MOST };

// Adds words separated by blanks to a list; `text` stays with it.
static void add_words(const char *list[MOST], char *text)
{
    int at = 0;
    while (list[at])
        at++;
    for (char *word = strtok(text, " "); word; word = strtok(NULL, " ")) {
        assert_true(at < MOST - 1);
        list[at++] = word;
    }
    list[at] = NULL;
}

// "weft slice WORDS MORE" on ranks, or without a launcher where ranks is 0.
static void run(struct command_result *result, int ranks, const char *words, const char *more)
{
    char text[1024], own[512];
    const char *list[MOST] = {"slice"};
    snprintf(text, sizeof text, "%s", words);
    snprintf(own, sizeof own, "%s", more);
    add_words(list, text);
    add_words(list, own);
    mpirun_list(result, MPIRUN_MPICH, ranks, list);
}

static void run_well(int ranks, const char *words, const char *more)
{
    static struct command_result result;
    run(&result, ranks, words, more);
    if (result.code != 0)
        fail_msg("%d ranks: slice %s %s: exit code %d, %s", ranks, words, more, result.code,
                 result.err);
}

static void assert_same(const char *words, int ranks, const char *more, const char *a,
                        const char *b)
{
    size_t size[2];
    char *bytes[2] = {command_read_file(a, &size[0]), command_read_file(b, &size[1])};
    if (size[0] != size[1] || memcmp(bytes[0], bytes[1], size[0]) != 0)
        fail_msg("%s: %d ranks, %s: %s is not %s", words, ranks, more, b, a);
    free(bytes[0]);
    free(bytes[1]);
}

static int make_volume(void **state)
{
    if (command_setup_folder(state) != 0)
        return -1;
    command_succeeds("make", "marschner-lobb", "-o", "ml.vdb", "--size", "40", "-q");
    return 0;
}

// ---- one slice ----------------------------------------------------------------------------------

#define OBLIQUE "ml.vdb --origin 3,3,5 --u 33,9,6 --v -3,32,10 --size 70x90 -q "
static const char *const slices[] = {
    OBLIQUE "--engine cpu --annotate --preview PNG",
    "ml.vdb --size 83x66 -q --engine cpu --compression piz --type half",
    OBLIQUE "--engine gl",
    OBLIQUE "--source unorm8 --kernel bspline3",
    OBLIQUE "--max-error 8bit",
    OBLIQUE "--profile unorm8 --kernel linear",
    OBLIQUE "--hardware --kernel mitchell",
    "ml.vdb --size 83x66 -q --kernel bspline3i --compression none",
};

// What covers all that is to be told apart, and all of it.
static const struct {
    int ranks; // 0: no launcher
    const char *options;
    bool always;
} ways[] = {
    {0, "--region 7", true},
    {0, "--region 1", false},
    {0, "--region rows:1", false},
    {0, "--schedule static", false},
    {1, "", false},
    {2, "", true},
    {2, "--region 1 --schedule static", false},
    {2, "--region 7 --schedule pull", false},
    {2, "--region 64x3 --schedule dynamic", false},
    {3, "--region 64 --schedule static", true},
    {3, "--region rows:5", false},
    {3, "--granularity 3 --verify", true},
    {7, "", false},
    {7, "--region rows:1 --schedule dynamic --verify", true},
    {7, "--region frame", false},
};

static void with_files(char *out, size_t size, const char *words, const char *name)
{
    const char *png = strstr(words, "PNG");
    snprintf(out, size, "%.*s%s%s -o %s.exr", (int)(png ? png - words : (int)strlen(words)), words,
             png ? name : "", png ? ".png" : "", name);
}

static void check_slice(size_t s, size_t w)
{
    char words[512];
    with_files(words, sizeof words, slices[s], "ranks");
    run_well(ways[w].ranks, words, ways[w].options);
    assert_same(slices[s], ways[w].ranks, ways[w].options, "alone.exr", "ranks.exr");
    if (strstr(slices[s], "PNG"))
        assert_same(slices[s], ways[w].ranks, ways[w].options, "alone.png", "ranks.png");
}

// By default each slice has one way, and the first one all of those that are always gone.
static void slices_are_those_of_one_process(void **state)
{
    int checked = 0;
    (void)state;
    if (!mpirun_is_here(MPIRUN_MPICH))
        skip();
    for (size_t s = 0, next = 0; s < WEFT_COUNT(slices); s++) {
        char words[512];
        with_files(words, sizeof words, slices[s], "alone");
        run_well(0, words, "");
        while (!ways[next % WEFT_COUNT(ways)].always)
            next++;
        for (size_t w = 0; w < WEFT_COUNT(ways); w++) {
            if (!mpirun_is_full() && !(s == 0 && ways[w].always) && w != next % WEFT_COUNT(ways))
                continue;
            check_slice(s, w);
            checked++;
        }
        next++;
    }
    assert_true(checked >= 12);
}

static json_t *read_json(int ranks, const char *words, const char *more)
{
    static struct command_result result;
    run(&result, ranks, words, more);
    assert_int_equal(result.code, 0);
    return parse(result.out);
}

// Counts are those of all ranks together, and bricks are shared among them.
static void what_is_told_is_of_all_ranks(void **state)
{
    static const char words[] = OBLIQUE "--engine cpu --json --verify";
    (void)state;
    if (!mpirun_is_here(MPIRUN_MPICH))
        skip();
    json_t *alone = read_json(0, words, ""), *ranks = read_json(2, words, "--region rows:45");
    static const char *const same[] = {"minimum", "maximum", "not_finite", "exact_pixels"};
    for (size_t i = 0; i < WEFT_COUNT(same); i++)
        assert_true(number(alone, same[i]) == number(ranks, same[i]));
    const json_t *a = json_object_get(alone, "error"), *b = json_object_get(ranks, "error");
    assert_true(number(a, "samples") == 70 * 90);
    assert_true(number(b, "samples") == 70 * 90);
    assert_true(number(a, "max") == number(b, "max"));
    assert_true(json_equal(json_object_get(a, "where"), json_object_get(b, "where")));
    // What lies on the border is read twice.
    assert_true(number(ranks, "bricks_read") >= number(alone, "bricks_read"));
    assert_true(number(ranks, "bricks_read") < 1.7 * number(alone, "bricks_read"));
    assert_null(json_object_get(alone, "ranks"));
    const json_t *told = json_object_get(ranks, "ranks");
    assert_int_equal(json_integer_value(json_object_get(told, "count")), 2);
    assert_int_equal(json_integer_value(json_object_get(told, "items")), 2);
    assert_int_equal(json_array_size(json_object_get(told, "each")), 2);
    json_decref(alone);
    json_decref(ranks);
}

// ---- frames -------------------------------------------------------------------------------------

static const char frames[] = "ml.vdb --frames 3-11:2 --at 10..30 --size 40x30 -q --engine cpu "
                             "--annotate ";

static void check_frames(int ranks, const char *options)
{
    char words[512];
    snprintf(words, sizeof words, "%s-o r_%%04d.exr --preview r_%%04d.png", frames);
    run_well(ranks, words, options);
    for (int f = 3; f <= 11; f += 2) {
        for (int k = 0; k < 2; k++) {
            char a[32], b[32];
            snprintf(a, sizeof a, "a_%04d.%s", f, k ? "png" : "exr");
            snprintf(b, sizeof b, "r_%04d.%s", f, k ? "png" : "exr");
            assert_same(frames, ranks, options, a, b);
            unlink(b);
        }
    }
}

static void frames_are_those_of_one_process(void **state)
{
    char words[512];
    (void)state;
    if (!mpirun_is_here(MPIRUN_MPICH))
        skip();
    snprintf(words, sizeof words, "%s-o a_%%04d.exr --preview a_%%04d.png", frames);
    run_well(0, words, "");
    check_frames(0, "--region frame");
    check_frames(2, "");
    check_frames(3, "--schedule dynamic");
    if (!mpirun_is_full())
        return;
    check_frames(2, "--region 7");
    check_frames(3, "--schedule static --region frame --verify");
    check_frames(7, "--schedule pull");
    check_frames(7, "--region frame");
    check_frames(2, "--max-error 8bit");
}

// A bad frame is left out by whoever has it, or ends the work with one line; others stay.
static void bad_frames_are_told_once(void **state)
{
    static struct command_result result;
    static const char words[] = "v_%04d.vdb --frames 1-5 --size 30x20 --engine cpu -o s_%04d.exr";
    (void)state;
    if (!mpirun_is_here(MPIRUN_MPICH))
        skip();
    for (int f = 1; f <= 5; f++) {
        char name[32];
        snprintf(name, sizeof name, "v_%04d.vdb", f);
        if (f == 4)
            command_succeeds("kernel", "mitchell", "--plot", "plot.svg");
        else
            command_succeeds("make", "sphere", "-o", name, "--size", "20", "-q");
    }
    assert_int_equal(rename("plot.svg", "v_0004.vdb"), 0);
    for (int skips = 0; skips < 2; skips++) {
        run(&result, 2, words, skips ? "--skip-bad" : "");
        assert_int_equal(result.code, 3);
        assert_int_equal(mpirun_count_lines(result.err, "weft: error:"), 1);
        assert_non_null(strstr(result.err, "frame 4"));
        assert_non_null(
            strstr(result.err, skips ? "1 of 5 frames were skipped" : "frames are complete"));
        assert_int_equal(access("s_0004.exr", F_OK), -1);
        assert_int_equal(access("s_0001.exr", F_OK), 0);
        assert_true(!skips || access("s_0005.exr", F_OK) == 0);
    }
    run(&result, 3, "missing.vdb -o x.exr", "");
    assert_int_equal(result.code, 3);
    assert_int_equal(mpirun_count_lines(result.err, "weft: error:"), 1);
    run(&result, 2, "ml.vdb --frames 1-9 --at 10..20 -o x_%04d.exr", "--region frame --cost-map m");
    assert_int_equal(result.code, 2);
    assert_int_equal(mpirun_count_lines(result.err, "weft: error:"), 1);
    run(&result, 2, "ml.vdb --explain", "");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.out, "kernel catmull-rom"));
}

static void open_mpi_has_the_same(void **state)
{
    (void)state;
    if (!mpirun_is_here(MPIRUN_OPENMPI))
        skip();
    command_succeeds("slice", "ml.vdb", "--size", "50x40", "-o", "alone.exr", "--engine", "cpu");
    mpirun_succeeds(MPIRUN_OPENMPI, 3, "slice", "ml.vdb", "--size", "50x40", "-o", "ranks.exr",
                    "--engine", "cpu");
    assert_same("50x40", 3, "Open MPI", "alone.exr", "ranks.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_are_those_of_one_process),
        cmocka_unit_test(what_is_told_is_of_all_ranks),
        cmocka_unit_test(frames_are_those_of_one_process),
        cmocka_unit_test(bad_frames_are_told_once),
        cmocka_unit_test(open_mpi_has_the_same),
    };
    return cmocka_run_group_tests(tests, make_volume, command_teardown);
}
