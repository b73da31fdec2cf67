// SPDX-License-Identifier: BSD-3-Clause
// Texts that a terminal would obey, numbers that no float holds, grids that cannot be read: what
// the command prints of them.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "weft.h"

// What a terminal would obey, or what is no UTF-8, is in no line that weft prints.
static void assert_clean(const char *text)
{
    char *clean = strdup(text);
    assert_non_null(clean);
    if (strcmp(weft_text_clean(clean, true), text))
        fail_msg("not clean: %s", clean);
    free(clean);
}

// Runs `weft ...`, looks at all that it prints, and returns its exit code.
#define prints_clean(...) prints_clean_list((const char *[]){"weft", __VA_ARGS__, NULL})
static int prints_clean_list(const char *const *argv)
{
    static struct command_result r;
    command_run_list(&r, argv);
    assert_clean(r.out);
    assert_clean(r.err);
    if (*r.out == '{') {
        json_t *root = json_loads(r.out, JSON_REJECT_DUPLICATES, NULL);
        assert_non_null(root);
        json_decref(root);
    }
    return r.code;
}

#define HOSTILE                                                                                    \
    "\x1b]0;owned\x07\x1b[31m\xc2\x9b"                                                             \
    "2J\xff\xe2\x80\xae"

static void hostile_texts(void **state)
{
    (void)state;
    char line[4200];
    snprintf(line, sizeof line, "'%s/make_vdb_fixtures' .", WEFT_BINARY_DIR);
    assert_int_equal(system(line), 0);
    assert_int_equal(prints_clean("info", "names.vdb"), 0);
    assert_int_equal(prints_clean("info", "names.vdb", "--json"), 0);
    const char *grid = "?]0;owned??[31m??2Jweft: error: ??"; // as info prints it
    assert_int_equal(prints_clean("slice", "names.vdb", "--explain", "--grid", grid), 0);
    assert_int_equal(prints_clean("slice", "names.vdb", "--explain", "--json", "--grid", grid), 0);
    assert_int_equal(prints_clean("slice", "names.vdb", "--explain", "--grid", HOSTILE), 2);
    assert_int_equal(prints_clean("slice", HOSTILE ".vdb", "-o", "a.exr"), 3);
    assert_int_equal(prints_clean("slice", "ml.vdb", "-o", "a.exr", "--kernel", HOSTILE), 2);
    assert_int_equal(prints_clean(HOSTILE), 2);
    assert_int_equal(prints_clean("info", "--" HOSTILE), 2);
    // Good files of bad names.
    assert_int_equal(link("ml.vdb", HOSTILE "\n.vdb"), 0);
    assert_int_equal(prints_clean("info", HOSTILE "\n.vdb"), 0);
    assert_int_equal(prints_clean("info", HOSTILE "\n.vdb", "--json"), 0);
    const char table[] = "support 1  1 0.5 0";
    command_write_file(HOSTILE ".txt", table, sizeof table - 1);
    assert_int_equal(prints_clean("kernel", "table:" HOSTILE ".txt"), 0);
    assert_int_equal(prints_clean("kernel", "table:" HOSTILE ".txt", "--json"), 0);
    assert_int_equal(
        prints_clean("slice", "ml.vdb", "--explain", "--kernel", "table:" HOSTILE ".txt"), 0);
    // Channels and attributes of images.
    float plane[4] = {0, 1, 2, 3};
    static const char text[] = HOSTILE "\ntwo lines";
    struct weft_image_channel channel = {.name = HOSTILE "\n", .plane = plane};
    struct weft_image_attribute attribute = {HOSTILE, "string", text, sizeof text - 1};
    const struct weft_image image = {.width = 2,
                                     .height = 2,
                                     .display_max = {1, 1},
                                     .channel_count = 1,
                                     .channels = &channel,
                                     .attribute_count = 1,
                                     .attributes = &attribute};
    const struct weft_image_save_params save = {.path = "names.exr"};
    assert_int_equal(weft_image_save(&image, &save), WEFT_OK);
    assert_int_equal(prints_clean("info", "names.exr"), 0);
    assert_int_equal(prints_clean("info", "names.exr", "--json"), 0);
    assert_int_equal(prints_clean("resample", "names.exr", "--size", "4x4", "--explain"), 0);
    assert_int_equal(prints_clean("resample", "names.exr", "--size", "4x4", "--explain", "--json"),
                     0);
}

// Numbers that no float holds are told, and where nothing else is left refused; a grid that cannot
// be read does not hide the others.
static void told_values(void **state)
{
    (void)state;
    struct command_result r;
    command_run(&r, "weft", "info", "values.vdb");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.out, "257 integers, off by up to 1\n"));
    assert_non_null(strstr(r.out, "201 values too large, 0 too small\n"));
    assert_non_null(strstr(r.out, "0 values too large, 100 too small\n"));
    command_run(&r, "weft", "info", "far.vdb");
    assert_int_equal(r.code, 3);
    assert_non_null(strstr(r.out, "not readable   a node at (1073741824, 0, 0)"));
    assert_non_null(strstr(r.err, "grid 'far' cannot be read: a node at (1073741824, 0, 0)"));
    command_run(&r, "weft", "info", "far.vdb", "--json");
    assert_int_equal(r.code, 3);
    assert_non_null(strstr(r.out, "\"problem\": \"a node at (1073741824, 0, 0)"));
    if (!command_has_gl())
        skip();
    command_fails(3, "512 values of grid 'all'", "slice", "values.vdb", "--grid", "all", "-q",
                  "--size", "8x8", "-o", "a.exr");
    command_run(&r, "weft", "slice", "values.vdb", "--grid", "integers", "--size", "8x8", "--json",
                "-o", "a.exr");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.out, "\"values_rounded\": 257"));
    assert_non_null(strstr(r.err, "weft: warning: "));
    assert_non_null(strstr(r.err, "257 integers are changed by up to 1"));
    // Row 0, from the left: voxels (x, 7, 0), that is 2^24 + 56 + x; the float of each second one
    // is off by 1. Verified with the integers, not with the floats that were sliced.
    command_run(&r, "weft", "slice", "values.vdb", "--grid", "integers", "--kernel", "nearest",
                "--space", "index", "--origin=-0.5,-0.5,0", "--u", "8,0,0", "--v", "0,8,0",
                "--size", "8x8", "--verify", "--json", "-o", "a.exr");
    json_t *root = json_loads(r.out, 0, NULL);
    const json_t *error = json_object_get(root, "error");
    if (!error)
        fail_msg("no verify in %s %s", r.out, r.err);
    assert_true(json_number_value(json_object_get(error, "max")) == 1.0);
    assert_true(fabs(json_number_value(json_object_get(error, "rms")) - sqrt(0.5)) < 1e-12);
    // The bound has it.
    assert_int_equal(r.code, 0);
    assert_true(json_number_value(json_object_get(root, "error_rounding")) == 1.0);
    assert_true(json_number_value(json_object_get(root, "bound")) >= 1.0);
    json_decref(root);
    command_fails(1, ", 1 of it by integers that no float holds", "slice", "values.vdb", "-q",
                  "--grid", "integers", "--kernel", "nearest", "--size", "8x8", "--max-error",
                  "0.5", "-o", "a.exr");
    command_succeeds("slice", "values.vdb", "--grid", "integers", "--kernel", "nearest", "--size",
                     "8x8", "--max-error", "5", "--verify");
    unlink("a.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hostile_texts),
        cmocka_unit_test(told_values),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
