// SPDX-License-Identifier: BSD-3-Clause
// weft probe as its users see it: tables of every form, values that are the library's floats to the
// bit, warnings of points outside or without a position, errors with the line's number.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "tests/support/common.h"
#include "weft.h"

enum { COUNT = 40 };
static double position[COUNT][3];
static float gradient[4][COUNT];

static void put(const char *path, const char *text)
{
    command_write_file(path, text, strlen(text));
}

// Points of a curve, with a header or without, and their values by the library.
static void prepare(const char *path, const char *format, const char *header)
{
    char text[COUNT * 100] = "";
    size_t size = (size_t)snprintf(text, sizeof text, "%s", header);
    for (int i = 0; i < COUNT; i++) {
        position[i][0] = 8.0 + 0.11 * i;
        position[i][1] = 7.25 - 0.03125 * i;
        position[i][2] = 3.0 + 0.25 * i;
        size += (size_t)snprintf(text + size, sizeof text - size, format, position[i][0],
                                 position[i][1], position[i][2]);
    }
    command_write_file(path, text, size);
}

static void sample(void)
{
    static const struct weft_derivative all[] = {
        {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    weft_volume *volume = NULL;
    weft_points *points = NULL;
    float out[4 * COUNT];
    assert_int_equal(weft_volume_open(weft_volume_open_params(.path = "ml.vdb"), &volume), WEFT_OK);
    assert_int_equal(weft_points_create(weft_points_params(.volume = volume, .derivative = all,
                                                           .derivative_count = 4),
                                        &points),
                     WEFT_OK);
    assert_int_equal(
        weft_points_run(
            points, weft_points_run_params(.count = COUNT, .position = position, .out = out), NULL),
        WEFT_OK);
    // Voxels of half a unit along the axes.
    for (int o = 0; o < 4; o++)
        for (int i = 0; i < COUNT; i++)
            gradient[o][i] = o ? out[o * COUNT + i] * 2.0f : out[i];
    weft_points_destroy(&points);
    weft_volume_destroy(&volume);
}

// The last four fields of every line are the library's.
static void check_table(const char *text, const char *header, char separator)
{
    int line = 0;
    char *copy = strdup(text), *rest = copy;
    assert_int_equal(strncmp(text, header, strlen(header)), 0);
    strsep(&rest, "\n");
    for (char *at; (at = strsep(&rest, "\n")) && *at; line++) {
        assert_true(line < COUNT);
        for (int o = 3; o >= 0; o--) {
            char *field = strrchr(at, separator);
            assert_non_null(field);
            const float value = strtof(field + 1, NULL);
            assert_memory_equal(&value, &gradient[o][line], sizeof value);
            *field = '\0';
        }
    }
    free(copy);
    assert_int_equal(line, COUNT);
}

static void tables_of_every_form(void **state)
{
    static const struct {
        const char *header, *format, *expected;
        char separator;
    } cases[] = {
        {"", "%.17g,%.17g,%.17g\n", "x,y,z,Y,gradient.X,gradient.Y,gradient.Z\n", ','},
        {"# of a curve\n\nx,y,z,name\n", "%.17g, %.17g ,%.17g,a \"b\"\n# rest\n",
         "x,y,z,name,Y,gradient.X,", ','},
        {"\xef\xbb\xbfX;Y;Z\r\n", "%.17g;%.17g;%.17g\r\n", "X;Y;Z;Y;gradient.X", ';'},
        {"", "%.17g\t%.17g\t%.17g\t7,5\n", "x\ty\tz\tcolumn.4\tY\tgradient.X", '\t'},
        {"", "   %.17g  +%.17g \t %.17g\n", "x y z Y gradient.X", ' '},
        {"name,\"x\",\"y\",\"z\"\n", "p,%.17g,%.17g,%.17g\n", "name,\"x\",\"y\",\"z\",Y,", ','},
    };
    (void)state;
    prepare("points.csv", cases[0].format, "");
    sample();
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        prepare("points.csv", cases[i].format, cases[i].header);
        const char *out = command_succeeds("probe", "ml.vdb", "--points", "points.csv",
                                           "--quantity", "value,gradient");
        check_table(out, cases[i].expected, cases[i].separator);
    }
    // In a file, by other threads, of standard input.
    command_input("points.csv");
    assert_string_equal(command_succeeds("probe", "ml.vdb", "--points", "-", "--quantity",
                                         "value,gradient", "--threads", "3", "-o", "out.csv"),
                        "");
    size_t size;
    char *text = command_read_file("out.csv", &size);
    text = realloc(text, size + 1);
    text[size] = '\0';
    check_table(text, "name,", ',');
    free(text);
    // What is written is read again: its last columns are copied.
    command_succeeds("probe", "ml.vdb", "--points", "out.csv", "--verify", "--sums", "double");
}

static void points_in_json(void **state)
{
    (void)state;
    put("points.csv", "1,2,3\nnan,1,1\n1e4,1,1\n");
    json_error_t error;
    json_t *root = json_loads(command_succeeds("probe", "ml.vdb", "--points", "points.csv",
                                               "--json", "--quantity", "normal", "--verify"),
                              0, &error);
    assert_non_null(root);
    assert_int_equal(json_integer_value(json_object_get(root, "count")), 3);
    assert_int_equal(json_integer_value(json_object_get(root, "bad_positions")), 1);
    assert_int_equal(json_integer_value(json_object_get(root, "outside")), 1);
    assert_int_equal(json_array_size(json_object_get(root, "channels")), 3);
    const json_t *points = json_object_get(root, "points");
    assert_int_equal(json_array_size(points), 3);
    double length = 0.0;
    for (int a = 0; a < 3; a++) {
        const char *name = (const char *[]){"normal.X", "normal.Y", "normal.Z"}[a];
        const double n = json_number_value(json_object_get(json_array_get(points, 0), name));
        length += n * n;
        assert_true(json_is_null(json_object_get(json_array_get(points, 1), name)));
    }
    assert_near(length, 1.0, 1e-6, "normal");
    json_decref(root);
}

static void what_is_odd_is_told(void **state)
{
    struct command_result result;
    (void)state;
    put("points.csv", "1,2,3\nnan,1,1\n1e4,1,1\n1,inf,1e999\n-1e4,0,0\n");
    command_run(&result, "weft", "probe", "ml.vdb", "--points", "points.csv");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.err, "2 of 5 points have no position"));
    assert_non_null(strstr(result.err, "2 of 5 points lie outside"));
    assert_non_null(strstr(result.out, "nan,1,1,nan\n"));
    put("points.csv", "x,y,z\n");
    assert_string_equal(command_succeeds("probe", "ml.vdb", "--points", "points.csv"), "x,y,z,Y\n");
    const char *plan = command_succeeds("probe", "ml.vdb", "--points", "points.csv", "--explain",
                                        "--quantity", "laplacian");
    assert_non_null(strstr(plan, "derivative 200: error at most"));
    assert_non_null(strstr(plan, "channel: laplacian"));
}

static void wrong_requests_are_refused(void **state)
{
    (void)state;
    put("points.csv", "1,2,3\n");
    put("bad.csv", "x,y,z\n1,2,3\n# 4\n\n1,2,three\n");
    put("short.csv", "1,2,3\n1,2\n");
    put("empty.csv", "# nothing\n");
    command_fails(2, "no volume given", "probe", "--points", "points.csv");
    command_fails(2, "no points given", "probe", "ml.vdb");
    command_fails(2, "curvy", "probe", "ml.vdb", "--points", "points.csv", "--quantity", "curvy");
    command_fails(2, "--threads", "probe", "ml.vdb", "--points", "points.csv", "--threads", "0");
    command_fails(3, "kernel linear has no second derivative", "probe", "ml.vdb", "--points",
                  "points.csv", "--quantity", "hessian", "--kernel", "linear");
    command_fails(3, "bad.csv, line 5: column 3 is no number: '1,2,three'", "probe", "ml.vdb",
                  "--points", "bad.csv");
    command_fails(3, "short.csv, line 2: column 3 is no number", "probe", "ml.vdb", "--points",
                  "short.csv");
    command_fails(3, "there is no point in it", "probe", "ml.vdb", "--points", "empty.csv");
    command_fails(3, "nowhere.csv: cannot be opened", "probe", "ml.vdb", "--points", "nowhere.csv");
    command_fails(3, "nowhere.vdb", "probe", "nowhere.vdb", "--points", "points.csv");
    command_fails(2, "points.csv", "probe", "ml.vdb", "--points", "points.csv", "-o", "points.csv");
    command_fails(4, "bad.csv", "probe", "ml.vdb", "--points", "points.csv", "-o", "bad.csv",
                  "--no-clobber");
    command_fails(3, "1000", "probe", "ml.vdb", "--points", "points.csv", "--memory", "1000");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_of_every_form),
        cmocka_unit_test(points_in_json),
        cmocka_unit_test(what_is_odd_is_told),
        cmocka_unit_test(wrong_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
