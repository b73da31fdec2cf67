// SPDX-License-Identifier: BSD-3-Clause
// weft chart as its users see it, and what it refuses.
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#include <math.h>

#include "tests/support/command.h"
#include "weft.h"

static const char points[] = "technique,label,seconds,bytes,max_error,rms_error\n"
                             "sage,\"an \"\"other\"\", slow one\",1000,1024,0.5,0.25\n";

static void wrong_requests_are_refused(void **state)
{
    (void)state;
    command_write_file("few.csv", points, strlen(points) - 6);
    command_write_file("none.csv", points, strcspn(points, "\n") + 1);
    command_write_file("head.csv", points, 20);
    command_fails(2, "oblique, x, y, z", "chart", "--plane", "w");
    command_fails(2, "oblique, x, y, z", "chart", "--plane", "0,0,0,1,0,0,0,1");
    command_fails(2, "a name is missing", "chart", "--kernel", "linear;;nearest");
    command_fails(2, "no kernel 'liner'", "chart", "--kernel", "liner");
    command_fails(2, "from 1 to", "chart", "--size", "0x4");
    command_fails(2, ".pdf or .eps", "chart", "-o", "chart.gif");
    command_fails(2, "must end in", "chart", "-o", ".svg");
    command_fails(2, "must end in .png", "chart", "--png", "chart.svg");
    command_fails(2, "same file", "chart", "--csv", "a", "--json=./a");
    command_fails(2, "auto, osmesa, egl", "chart", "--context", "glx");
    command_fails(2, "exclude each other", "chart", "-q", "-v");
    command_fails(2, "takes a signal", "chart", "volume.vdb", "--truth");
    command_fails(2, "--plane", "chart", "--truth", "--plane", "x");
    command_fails(2, "impulse", "chart", "impulse");
    command_fails(2, "--grid", "chart", "ramp", "--grid", "density");
    command_fails(2, "its own frames", "chart", "--accumulate", "ramp");
    command_fails(2, "of slices", "chart", "--accumulate", "--kernel", "linear");
    command_fails(2, "of slices", "chart", "--accumulate", "--truth");
    command_fails(2, "of --accumulate", "chart", "--frames", "4,8");
    command_fails(2, "what --scene names", "chart", "--antialias", "ramp");
    command_fails(2, "of slices", "chart", "--antialias", "--kernel", "linear");
    command_fails(2, "of --accumulate", "chart", "--antialias", "--frames", "4");
    command_fails(2, "two charts", "chart", "--antialias", "--accumulate");
    command_fails(2, "of --antialias", "chart", "--scene", "cube");
    command_fails(2, "ascending", "chart", "--accumulate", "--frames", "8,4");
    command_fails(2, "ascending", "chart", "--accumulate", "--frames", "0");
    command_fails(2, "ascending", "chart", "--accumulate", "--frames", "4,");
    command_fails(2, "ascending", "chart", "--accumulate", "--frames", "16777217");
    command_fails(3, "line 2", "chart", "--points", "few.csv");
    command_fails(3, "no points", "chart", "--points", "none.csv");
    command_fails(3, "line 1", "chart", "--points", "head.csv");
    command_fails(3, "nowhere.csv", "chart", "--points", "nowhere.csv");
    command_fails(4, "nowhere", "chart", "--csv", "nowhere/a.csv");
}

static void a_missing_volume_is_one_line(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    command_fails(3, "nowhere.vdb", "chart", "nowhere.vdb");
    command_fails(2, "misses", "chart", "ml.vdb", "--plane", "900,0,0,1,0,0,0,1,0");
}

// Members of objects by short names.
static double number(const json_t *point, const char *key)
{
    static const char *const parts[][3] = {
        {"seconds", "seconds", "total"},       {"bytes", "bytes", "held"},
        {"formula_bytes", "bytes", "formula"}, {"max_error", "error", "max"},
        {"rms_error", "error", "rms"},         {"mean_error", "error", "mean"},
    };
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        if (strcmp(key, parts[i][0]) == 0)
            return json_number_value(
                json_object_get(json_object_get(point, parts[i][1]), parts[i][2]));
    return json_number_value(json_object_get(point, key));
}

// By the definition, from what the file says: errors within a thousandth are the same.
static bool is_beaten(const json_t *all, const json_t *point, const char *error)
{
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *other = json_array_get(all, i);
        const double faster = number(point, "seconds") - number(other, "seconds");
        const double own = number(point, error), others = number(other, error);
        if (faster >= 0.0 && others <= 1.001 * own && (faster > 0.0 || others < own))
            return true;
    }
    return false;
}

static void check_points(const json_t *chart, const char *error)
{
    const json_t *all = json_object_get(chart, "points");
    assert_true(json_array_size(all) > 4);
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *p = json_array_get(all, i);
        const json_t *bound = json_object_get(p, "bound");
        assert_true(number(p, "seconds") > 0.0);
        assert_true(number(p, "rms_error") <= number(p, "max_error"));
        assert_true(json_is_null(bound) || number(p, "max_error") <= json_number_value(bound));
        assert_int_equal(json_boolean_value(json_object_get(p, "front")),
                         !is_beaten(all, p, error));
    }
    const json_t *skipped = json_object_get(chart, "skipped");
    for (size_t i = 0; i < json_array_size(skipped); i++)
        assert_true(*json_string_value(json_object_get(json_array_get(skipped, i), "reason")));
}

static size_t count_lines(const char *path)
{
    size_t size, lines = 0;
    char *text = command_read_file(path, &size);
    for (size_t i = 0; i < size; i++)
        lines += text[i] == '\n';
    free(text);
    return lines;
}

static void files_agree(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    command_write_file("peers.csv", points, strlen(points));
    const char *out = command_succeeds("chart", "marschner-lobb", "--quick", "--size", "48x32",
                                       "--kernel", "catmull-rom", "--points", "peers.csv", "--csv",
                                       "chart.csv", "--json=chart.json");
    assert_non_null(strstr(out, "none is faster and more accurate"));
    json_error_t error;
    json_t *root = json_load_file("chart.json", 0, &error);
    assert_non_null(root);
    assert_false(json_boolean_value(json_object_get(root, "interrupted")));
    const json_t *methods = json_object_get(root, "methods"),
                 *truth = json_object_get(root, "truth");
    check_points(methods, "max_error");
    check_points(truth, "rms_error");
    const json_t *peer = json_array_get(json_object_get(methods, "points"), 0);
    assert_string_equal(json_string_value(json_object_get(peer, "label")),
                        "an \"other\", slow one");
    assert_int_equal(count_lines("chart.csv"),
                     1 + json_array_size(json_object_get(methods, "points")) +
                         json_array_size(json_object_get(truth, "points")));
    // An oblique slice is not for separable filtering, and says so.
    const json_t *first = json_array_get(json_object_get(methods, "skipped"), 0);
    assert_string_equal(json_string_value(json_object_get(first, "label")), "separable");
    json_decref(root);
}

// Of frames: no other point of as many frames is both as fast and as accurate.
static bool frames_beaten(const json_t *all, const json_t *point)
{
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *other = json_array_get(all, i);
        const double faster = number(point, "seconds") - number(other, "seconds");
        const double better = number(point, "max_error") - number(other, "max_error");
        if (number(point, "frames") == number(other, "frames") && faster >= 0.0 && better >= 0.0 &&
            (faster > 0.0 || better > 0.0))
            return true;
    }
    return false;
}

static void averages_of_frames_agree(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    const char *out =
        command_succeeds("chart", "--accumulate", "--quick", "--size", "24x16", "--frames", "4,9",
                         "--csv", "frames.csv", "--json=frames.json");
    assert_non_null(strstr(out, "averages of frames of 24 x 16 pixels"));
    json_error_t error;
    json_t *root = json_load_file("frames.json", 0, &error);
    const json_t *frames = json_object_get(root, "frames");
    const json_t *all = json_object_get(frames, "points");
    // Exact, float, two buffers, four blends and trees of four branchings: two roundings of 8 bits,
    // 16 bits, floats.
    const json_t *skipped = json_object_get(frames, "skipped"); // where time was up
    assert_int_equal(json_array_size(all) + json_array_size(skipped), 2 * (1 + 1 + 2 + 4 + 4 * 4));
    assert_true(json_array_size(all) > 0);
    for (size_t i = 0; i < json_array_size(skipped); i++)
        assert_non_null(strstr(
            json_string_value(json_object_get(json_array_get(skipped, i), "reason")), "are over"));
    assert_int_equal(count_lines("frames.csv"), 1 + json_array_size(all));
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *p = json_array_get(all, i);
        assert_true(number(p, "seconds") > 0.0);
        assert_true(number(p, "max_error") <= number(p, "bound"));
        assert_true(number(p, "rms_error") <= number(p, "max_error"));
        assert_true(fabs(number(p, "mean_error")) <= number(p, "rms_error"));
        assert_int_equal(json_boolean_value(json_object_get(p, "front")), !frames_beaten(all, p));
    }
    json_decref(root);
}

// By the same filter no other point is both as fast and as accurate.
static bool edges_beaten(const json_t *all, const json_t *point)
{
    const char *filter = json_string_value(json_object_get(point, "filter"));
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *other = json_array_get(all, i);
        const double faster = number(point, "seconds") - number(other, "seconds");
        const double better = number(point, "rms_error") - number(other, "rms_error");
        if (strcmp(json_string_value(json_object_get(other, "filter")), filter) == 0 &&
            faster >= 0.0 && better >= 0.0 && (faster > 0.0 || better > 0.0))
            return true;
    }
    return false;
}

static const json_t *find_label(const json_t *all, const char *label)
{
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *point = json_array_get(all, i);
        if (strcmp(json_string_value(json_object_get(point, "label")), label) == 0)
            return point;
    }
    fail_msg("%s is missing", label);
    return NULL;
}

static void check_edges(const json_t *all)
{
    for (size_t i = 0; i < json_array_size(all); i++) {
        const json_t *p = json_array_get(all, i);
        assert_true(number(p, "seconds") > 0.0);
        assert_true(number(p, "bytes") > 0.0);
        assert_true(number(p, "formula_bytes") > 0.0);
        assert_true(number(p, "rms_error") > 0.0);
        assert_true(number(p, "rms_error") <= number(p, "max_error"));
        assert_int_equal(json_boolean_value(json_object_get(p, "front")), !edges_beaten(all, p));
    }
}

static void ways_of_antialiasing_agree(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    const char *out =
        command_succeeds("chart", "--antialias", "--quick", "--size", "48x32", "--scene",
                         "polygons:20,200", "--csv", "edges.csv", "--json=edges.json");
    assert_non_null(strstr(out, "polygons:20,200, 48 x 32 pixels"));
    json_error_t error;
    json_t *root = json_load_file("edges.json", 0, &error);
    const json_t *edges = json_object_get(root, "antialias");
    const json_t *all = json_object_get(edges, "points");
    check_edges(all);
    assert_int_equal(count_lines("edges.csv"), 1 + json_array_size(all));
    // More samples are closer to it, and where all edges
    // are marked adaptive pictures are those of all pixels.
    assert_true(number(edges, "exact_error") < 1e-6);
    const json_t *full = find_label(all, "4 x 4"), *adaptive = find_label(all, "adaptive 4 x 4");
    assert_true(number(full, "rms_error") < 0.5 * number(find_label(all, "none"), "rms_error"));
    assert_true(number(find_label(all, "ACAA 64"), "rms_error") < number(full, "rms_error"));
    assert_true(number(adaptive, "rms_error") == number(full, "rms_error"));
    assert_true(number(adaptive, "marked") > 0.0 && number(adaptive, "marked") <= 1.0);
    json_decref(root);
    command_fails(3, "colour", "chart", "--antialias", "--quick", "--size", "16x16", "--scene",
                  "cornell");
}

static void the_script_stays_without_gnuplot(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    command_environment("PATH=/nonexistent");
    struct command_result result;
    command_run(&result, "weft", "chart", "ramp", "--truth", "--quick", "-q", "--size", "16x16",
                "--kernel", "linear", "-o", "alone.svg");
    assert_int_equal(result.code, 1);
    assert_non_null(strstr(result.err, "gnuplot"));
    size_t size;
    char *text = command_read_file("alone.svg.gp", &size);
    text[size] = 0;
    assert_non_null(strstr(text, "set output 'alone.svg'"));
    assert_non_null(strstr(text, "EOD\n"));
    free(text);
    assert_int_not_equal(access("alone.svg", F_OK), 0);
    command_environment("PATH=/nonexistent");
    command_run(&result, "weft", "chart", "--accumulate", "--quick", "-q", "--size", "8x8",
                "--frames", "4", "-o", "frames.svg");
    assert_int_equal(result.code, 1);
    assert_int_equal(access("frames.svg.gp", F_OK), 0);
}

// However far it comes: what there is is written whole.
static void interruption_keeps_results(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    const char *const argv[] = {
        "weft", "chart", "marschner-lobb", "--csv", "cut.csv", "--json=cut.json", NULL};
    assert_int_equal(command_interrupt(4.0, SIGINT, argv), 128 + SIGINT);
    json_error_t error;
    json_t *root = json_load_file("cut.json", 0, &error);
    assert_non_null(root);
    assert_true(json_boolean_value(json_object_get(root, "interrupted")));
    assert_int_equal(count_lines("cut.csv"), 1 + json_array_size(json_object_get(
                                                     json_object_get(root, "methods"), "points")));
    json_decref(root);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_requests_are_refused),
        cmocka_unit_test(a_missing_volume_is_one_line),
        cmocka_unit_test(files_agree),
        cmocka_unit_test(averages_of_frames_agree),
        cmocka_unit_test(ways_of_antialiasing_agree),
        cmocka_unit_test(the_script_stays_without_gnuplot),
        cmocka_unit_test(interruption_keeps_results),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
