// SPDX-License-Identifier: BSD-3-Clause
// The weft command as its users see it: help, make, info, slice and what they leave behind.
#include <math.h>
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
#include <png.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

#define skip_without_gl()                                                                          \
    do {                                                                                           \
        if (!command_has_gl())                                                                     \
            skip();                                                                                \
    } while (0)

static double element(const json_t *object, const char *key, size_t index)
{
    const json_t *value = json_array_get(json_object_get(object, key), index);
    if (!json_is_number(value))
        fail_msg("no number %s[%zu]", key, index);
    return json_number_value(value);
}

static const char *text(const json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    if (!value)
        fail_msg("no text %s", key);
    return value;
}

// ---- help ---------------------------------------------------------------------------------------

// Lines, none longer than a terminal's but for commands to copy.
static int count_lines(const char *text)
{
    int count = 0;
    for (const char *line = text; *line; line += strcspn(line, "\n") + 1, count++)
        if (strcspn(line, "\n") > 79 && strncmp(line, "  weft ", 7) != 0)
            fail_msg("%.*s", (int)strcspn(line, "\n"), line);
    return count;
}

static void help_is_short(const char *verb)
{
    char *help = strdup(command_succeeds("help", verb));
    assert_non_null(help);
    if (count_lines(help) > 25)
        fail_msg("%s", help);
    assert_string_equal(help, command_succeeds(verb, "--help"));
    assert_true(strlen(command_succeeds("help", verb, "all")) > strlen(help));
    free(help);
}

// The first line is the version alone.
static void version_tells_what_it_is(void **state)
{
    static const char first[] = "weft " WEFT_TEST_VERSION "\n";
    static const char *const lines[] = {"compiler   ", "libraries  OpenEXR 3.",
                                        "readers    OpenVDB 1", "contexts   ",
                                        "engines    gl, cpu (", "ranks      "};
    (void)state;
    char *version = strdup(command_succeeds("version"));
    assert_non_null(version);
    assert_memory_equal(version, first, sizeof first - 1);
    const char *place = version;
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        place = strstr(place, lines[i]);
        if (!place || place[-1] != '\n')
            fail_msg("%s: not in\n%s", lines[i], version);
    }
    assert_string_equal(command_succeeds("--version"), version);
    free(version);
    assert_non_null(strstr(command_succeeds("help", "version"), "usage: weft version"));
    command_fails(2, "takes no options", "version", "--json");
}

static void help_names_everything(void **state)
{
    (void)state;
    assert_non_null(strstr(command_succeeds("help", "all"), "exit codes"));
    char *verbs = strdup(command_succeeds("--help"));
    assert_non_null(verbs);
    assert_string_equal(command_succeeds("help", "help"), verbs);
    assert_true(count_lines(verbs) < 40);
    int count = 0;
    for (char *line = verbs; *line; line += strcspn(line, "\n") + 1) {
        char verb[16];
        if (sscanf(line, "  %15s ", verb) == 1 && strncmp(line, "  ", 2) == 0 && ++count)
            help_is_short(verb);
    }
    assert_true(count >= 17);
    free(verbs);
    const char *signals = command_succeeds("make", "help");
    for (int i = 0; weft_signal_list[i]; i++)
        assert_non_null(strstr(signals, weft_signal_list[i]->name));
    const char *kernels = command_succeeds("slice", "--kernel", "help");
    for (int i = 0; weft_kernel_list[i]; i++)
        assert_non_null(strstr(kernels, weft_kernel_list[i]->name));
    const char *maps = command_succeeds("slice", "--colour-map=help");
    for (int i = 0; weft_colour_map_list[i]; i++)
        assert_non_null(strstr(maps, weft_colour_map_list[i]->name));
}

// ---- make and info ------------------------------------------------------------------------------

static json_t *first_grid(json_t *info)
{
    assert_string_equal(text(info, "format"), "vdb");
    json_t *grid = json_array_get(json_object_get(info, "grids"), 0);
    assert_non_null(grid);
    return grid;
}

static void every_signal_can_be_made(void **state)
{
    (void)state;
    for (int i = 0; weft_signal_list[i]; i++) {
        const struct weft_signal_info *signal = weft_signal_list[i];
        command_succeeds("make", signal->name, "-o", "any.vdb", "--size", "24");
        json_t *info = parse(command_succeeds("info", "--json", "any.vdb"));
        json_t *grid = first_grid(info);
        assert_string_equal(text(grid, "name"), signal->name);
        assert_string_equal(text(grid, "class"), signal->level_set ? "level set" : "fog volume");
        assert_true(number(grid, "active_voxels") > 0);
        if (signal->lattice)
            assert_true(number(grid, "active_voxels") == 1);
        json_decref(info);
        unlink("any.vdb");
    }
}

static void make_options_reach_the_file(void **state)
{
    (void)state;
    command_succeeds("make", "constant", "--output=c.vdb", "--size", "9x10x11", "--voxel=1,2,0.5",
                     "--offset", "-3,1000000,5");
    json_t *info = parse(command_succeeds("info", "c.vdb", "--json"));
    json_t *grid = first_grid(info);
    static const double min[] = {-3, 1000000, 5}, size[] = {9, 10, 11}, voxel[] = {1, 2, 0.5};
    for (size_t c = 0; c < 3; c++) {
        assert_true(element(grid, "active_min", c) == min[c]);
        assert_true(element(grid, "size", c) == size[c]);
        assert_true(element(grid, "voxel_size", c) == voxel[c]);
    }
    assert_true(number(grid, "active_voxels") == 9 * 10 * 11);
    json_decref(info);
    command_fails(4, "no-clobber", "make", "constant", "-o", "c.vdb", "--no-clobber");
    unlink("c.vdb");
}

static void sphere_is_a_thin_band(void **state)
{
    (void)state;
    command_succeeds("make", "sphere", "-o", "big.vdb", "--size", "512", "--voxel", "0.25");
    json_t *info = parse(command_succeeds("info", "big.vdb", "--json"));
    json_t *grid = first_grid(info);
    assert_true(number(grid, "background") == 0.75);
    // The shell of half-width 3 around a sphere of radius 0.75 * 256 voxels holds
    // 4 pi r^2 * 6 (1 + 3/r^2) voxels.
    double r = 0.75 * 256, expected = 4 * M_PI * r * r * 6 + 4 * M_PI * 2 * 27 / 3;
    assert_true(fabs(number(grid, "active_voxels") / expected - 1) < 0.001);
    assert_true(number(grid, "bricks") < 64 * 64 * 64 / 4);
    json_decref(info);
    unlink("big.vdb");
}

static void info_reads_for_people(void **state)
{
    (void)state;
    const char *out = command_succeeds("info", "ml.vdb");
    assert_non_null(strstr(out, "grid 'marschner-lobb': float, fog volume"));
    assert_non_null(strstr(out, "32 x 32 x 32"));
    assert_non_null(strstr(out, "0.5 x 0.5 x 0.5"));
}

// ---- slice --------------------------------------------------------------------------------------

static void defaults_are_as_documented(void **state)
{
    (void)state;
    json_t *plan = parse(command_succeeds("slice", "ml.vdb", "--explain", "--json"));
    assert_string_equal(text(plan, "kernel"), "catmull-rom");
    assert_string_equal(text(plan, "space"), "world");
    assert_string_equal(text(plan, "grid"), "marschner-lobb");
    json_t *world = json_object_get(plan, "geometry");
    assert_true(number(world, "width") == 1024 && number(world, "height") == 1024);
    // 32 voxels at distance 0.5: from -0.25 to 15.75; the middle of the box in z is 7.75.
    static const double origin[] = {-0.25, -0.25, 7.75}, u[] = {16, 0, 0}, v[] = {0, 16, 0};
    for (size_t c = 0; c < 3; c++) {
        assert_true(fabs(element(world, "origin", c) - origin[c]) < 1e-12);
        assert_true(fabs(element(world, "u", c) - u[c]) < 1e-12);
        assert_true(fabs(element(world, "v", c) - v[c]) < 1e-12);
    }
    assert_true(strlen(text(plan, "plan")) > 0);
    json_decref(plan);
    assert_non_null(strstr(command_succeeds("slice", "ml.vdb", "--explain"), "catmull-rom"));
}

static void oblique_slices_get_square_pixels(void **state)
{
    (void)state;
    json_t *plan =
        parse(command_succeeds("slice", "ml.vdb", "--explain", "--json", "--space", "index",
                               "--origin", "-1,0,3", "--u", "30,0,10", "--v", "0,10,0"));
    json_t *geometry = json_object_get(plan, "geometry");
    assert_true(number(geometry, "width") == 1024);
    assert_true(number(geometry, "height") == round(1024 * 10 / sqrt(1000)));
    json_decref(plan);
}

static void slice_writes_readable_files(void **state)
{
    (void)state;
    skip_without_gl();
    const char *out =
        command_succeeds("slice", "ml.vdb", "-o", "s.exr", "--preview", "s.png", "--size", "70x50",
                         "--kernel", "cubic:0,0.25", "--axis", "x", "--at", "4");
    assert_non_null(strstr(out, "s.png: values from "));
    json_t *info = parse(command_succeeds("info", "s.exr", "--json"));
    assert_string_equal(text(info, "format"), "exr");
    assert_true(number(info, "width") == 70 && number(info, "height") == 50);
    json_t *channel = json_array_get(json_object_get(info, "channels"), 0);
    assert_string_equal(text(channel, "name"), "Y");
    assert_string_equal(text(channel, "type"), "float");
    json_t *metadata = json_object_get(info, "metadata");
    assert_string_equal(text(metadata, "weft.kernel"), "cubic:0,0.25");
    assert_string_equal(text(metadata, "weft.volume"), "ml.vdb");
    assert_string_equal(text(metadata, "weft.grid"), "marschner-lobb");
    assert_string_equal(text(metadata, "weft.size"), "70x50");
    assert_string_equal(text(metadata, "weft.version"), WEFT_TEST_VERSION);
    assert_non_null(text(metadata, "weft.plan"));
    assert_non_null(text(metadata, "weft.renderer"));
    json_decref(info);
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, "s.png"));
    assert_int_equal(png.width, 70);
    assert_int_equal(png.height, 50);
    png_image_free(&png);
    command_fails(4, "no-clobber", "slice", "ml.vdb", "-o", "s.exr", "--no-clobber");
    command_fails(4, "no-clobber", "slice", "ml.vdb", "--preview", "s.png", "--no-clobber");
    assert_string_equal(command_succeeds("slice", "ml.vdb", "--preview", "s.png", "-q", "--size",
                                         "8x8", "--range", "-1,1", "--colour-map", "grey"),
                        "");
    unlink("s.exr");
    unlink("s.png");
}

static void kernels_from_files_slice(void **state)
{
    (void)state;
    skip_without_gl();
    static const char tent[] = "support 1\n4 2 0\n";
    command_write_file("tent.txt", tent, sizeof tent - 1);
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--kernel", "table:tent.txt+unit",
                                          "--size", "20x20", "--verify", "--json"));
    assert_string_equal(text(root, "kernel"), "table:tent.txt+unit");
    assert_true(number(json_object_get(root, "error"), "relative_max") <= 2e-6);
    const double maximum = number(root, "maximum");
    json_decref(root);
    root = parse(
        command_succeeds("slice", "ml.vdb", "--kernel", "linear", "--size", "20x20", "--json"));
    assert_true(fabs(number(root, "maximum") - maximum) < 1e-6);
    json_decref(root);
    unlink("tent.txt");
}

static void json_tells_everything(void **state)
{
    (void)state;
    skip_without_gl();
    json_t *root = parse(command_succeeds(
        "slice", "sphere.vdb", "--json", "--verify", "--size", "64x48", "--kernel", "mitchell",
        "--layout", "aligned", "--memory", "64M", "--context", "auto", "--grid", "sphere"));
    assert_string_equal(text(root, "layout"), "aligned");
    static const char *const counts[] = {"bricks_read", "cells", "passes", "mpixels_per_second"};
    static const char *const bytes[] = {"tiles", "uploaded", "peak", "process_peak"};
    for (size_t i = 0; i < 4; i++)
        assert_true(number(root, counts[i]) > 0);
    for (size_t i = 0; i < 4; i++)
        assert_true(number(json_object_get(root, "bytes"), bytes[i]) > 0);
    json_t *seconds = json_object_get(root, "seconds");
    static const char *const times[] = {"open",   "plan",   "context", "read",
                                        "layout", "upload", "passes",  "readback",
                                        "verify", "write",  "total"};
    double sum = 0;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        assert_true(number(seconds, times[i]) >= 0);
        sum += i < 10 ? number(seconds, times[i]) : 0;
    }
    assert_true(sum <= number(seconds, "total"));
    json_t *error = json_object_get(root, "error");
    assert_true(number(error, "samples") == 64 * 48);
    assert_true(number(error, "samples_total") == 64 * 48);
    assert_true(number(error, "relative_max") <= number(root, "relative_bound"));
    assert_true(number(error, "relative_max") <= 2e-6);
    assert_true(number(error, "rms") <= number(error, "max"));
    assert_true(number(root, "minimum") < 0 && number(root, "maximum") > 0);
    assert_true(strlen(text(json_object_get(root, "context"), "renderer")) > 0);
    json_decref(root);
}

static void same_bytes_from_any_number_of_threads(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const threads[] = {"LP_NUM_THREADS=0", "LP_NUM_THREADS=1",
                                          "LP_NUM_THREADS=2"};
    char *first = NULL;
    size_t first_size = 0;
    for (size_t i = 0; i < 3; i++) {
        command_environment(threads[i]);
        command_succeeds("slice", "ml.vdb", "-o", "t.exr", "--origin=0,0,1", "--u", "14,1,2", "--v",
                         "1,13,-.5", "--size", "200x150");
        size_t size;
        char *bytes = command_read_file("t.exr", &size);
        if (i == 0) {
            first = bytes;
            first_size = size;
            continue;
        }
        assert_int_equal(size, first_size);
        assert_memory_equal(bytes, first, size);
        free(bytes);
    }
    free(first);
    unlink("t.exr");
}

static void a_slice_beside_the_volume_is_background(void **state)
{
    (void)state;
    skip_without_gl();
    struct command_result r;
    command_run(&r, "weft", "slice", "sphere.vdb", "--at", "500", "--size", "16x16", "--json");
    assert_int_equal(r.code, 0);
    assert_int_equal(strncmp(r.err, "weft: warning: ", 15), 0);
    assert_ptr_equal(strchr(r.err, '\n'), r.err + strlen(r.err) - 1);
    json_t *root = parse(r.out);
    assert_true(json_is_true(json_object_get(root, "misses_volume")));
    assert_true(number(root, "minimum") == 3 && number(root, "maximum") == 3);
    json_decref(root);
}

// The first plane of an EXR file, to be freed.
static float *load_plane(const char *path, int width, int height)
{
    struct weft_image image;
    assert_int_equal(weft_image_load(&(struct weft_image_load_params){.path = path}, &image),
                     WEFT_OK);
    assert_true(image.width == width && image.height == height);
    float *plane = image.channels[0].plane;
    image.channels[0].plane = NULL;
    weft_image_clear(&image);
    return plane;
}

static double largest(const float *plane, int count)
{
    double most = 0.0;
    for (int i = 0; i < count; i++)
        most = fmax(most, fabs((double)plane[i]));
    return most;
}

// What the result is off at every pixel: of a slice also less what double sums make, which are off
// by one rounding to a float.
static void errors_are_pictures(void **state)
{
    enum { WIDTH = 40, HEIGHT = 30, COUNT = WIDTH * HEIGHT };
    (void)state;
    json_t *root =
        parse(command_succeeds("slice", "ml.vdb", "--engine", "cpu", "--size", "40x30", "-o",
                               "s.exr", "--verify", "--error-image", "e.exr", "--json"));
    command_succeeds("slice", "ml.vdb", "--engine", "cpu", "--sums", "double", "--size", "40x30",
                     "-o", "d.exr");
    float *result = load_plane("s.exr", WIDTH, HEIGHT), *exact = load_plane("d.exr", WIDTH, HEIGHT),
          *error = load_plane("e.exr", WIDTH, HEIGHT);
    const double most = number(json_object_get(root, "error"), "max");
    assert_true(most > 0.0 && fabs(largest(error, COUNT) - most) <= 0x1p-23 * most);
    for (int i = 0; i < COUNT; i++)
        assert_true(fabs((double)result[i] - (double)exact[i] - (double)error[i]) <=
                    0x1p-23 * fabs((double)exact[i]));
    json_decref(root);
    free(result);
    free(exact);
    free(error);
    root = parse(command_succeeds("resample", "s.exr", "--engine", "cpu", "--size", "80x60",
                                  "--verify", "--error-image", "e.exr", "--json"));
    json_t *group = json_array_get(json_object_get(root, "groups"), 0);
    error = load_plane("e.exr", 2 * WIDTH, 2 * HEIGHT);
    const double own = number(json_object_get(group, "error"), "max");
    assert_true(own > 0.0 && fabs(largest(error, 4 * COUNT) - own) <= 0x1p-23 * own);
    json_decref(root);
    free(error);
    command_succeeds("slice", "ml.vdb", "--size", "40x30", "--verify", "--engine", "cpu",
                     "--error-image", "e.png");
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, "e.png"));
    assert_true(png.width > WIDTH && png.height > HEIGHT);
    png_image_free(&png);
    command_fails(2, "--verify", "slice", "ml.vdb", "--error-image", "f.exr", "-o", "g.exr");
    command_fails(2, "--verify", "resample", "s.exr", "--error-image", "f.exr", "-o", "g.exr");
    command_fails(2, "of one grid", "slice", "ml.vdb", "--error-image", "f.exr", "--verify",
                  "--quantity", "gradient");
    command_fails(2, "must end in", "slice", "ml.vdb", "--error-image", "f.tif", "--verify");
    command_fails(2, "same file", "slice", "ml.vdb", "--error-image", "f.exr", "--verify", "-o",
                  "./f.exr");
    command_fails(4, "no-clobber", "slice", "ml.vdb", "--error-image", "e.png", "--verify",
                  "--no-clobber");
    static const char *const made[] = {"s.exr", "d.exr", "e.exr", "e.png"};
    for (size_t i = 0; i < sizeof made / sizeof *made; i++)
        unlink(made[i]);
}

static void verify_prints_where(void **state)
{
    (void)state;
    skip_without_gl();
    const char *out =
        command_succeeds("slice", "ml.vdb", "--verify", "--size", "32x32", "--axis=y", "-v");
    assert_non_null(strstr(out, "verified: 1024 of 1024 pixels"));
    assert_non_null(strstr(out, "max error: "));
    assert_non_null(strstr(out, "at pixel ("));
    assert_non_null(strstr(out, "rms error: "));
}

static void an_interrupt_leaves_nothing(void **state)
{
    (void)state;
    skip_without_gl();
    static const int signals[] = {SIGINT, SIGTERM};
    for (size_t i = 0; i < 2; i++) {
        int before = command_folder_size();
        int code = command_interrupt(1.0, signals[i],
                                     (const char *[]){"weft", "slice", "ml.vdb", "-o", "long.exr",
                                                      "--preview", "long.png", "--verify", "--size",
                                                      "16384x8192", "--kernel", "bspline5", NULL});
        assert_int_equal(code, 128 + signals[i]);
        assert_int_equal(command_folder_size(), before);
    }
    int before = command_folder_size();
    int code = command_interrupt(
        0.5, SIGINT,
        (const char *[]){"weft", "make", "chirp", "-o", "long.vdb", "--size", "600", NULL});
    assert_int_equal(code, 128 + SIGINT);
    assert_int_equal(command_folder_size(), before);
}

// What they print is what can be said by hand of what they make.
static void programs_of_the_library_page_work(void **state)
{
    (void)state;
    static const struct {
        const char *program, *operand, *out;
        bool gl;
    } cases[] = {
        {"library_file", "sphere.vdb", "in the middle: -3\n", false}, // the band's inner value
        // Pixels lie 1/8 apart, the first one 1/16 beside a voxel: 2 (1/16)^2.
        {"library_memory", NULL, "done: from 0.0078125 to ", false},
        {"library_kernel", NULL, "4 taps: -0.09375 0.59375 0.59375 -0.09375\n", false},
        {"library_points", NULL, "90.75, gradient 15 2 3\n33.5, gradient 6 2 3\n", false},
        {"library_budget", "ml.vdb", "separable cpu float: off by ", false},
        {"library_sweep", "ml.vdb", "8 frames: ", false},
        {"library_images", "s.exr", "Y: 40x20, done\n", false},
        {"library_draw", NULL, "done: 0.0625 at the left, 0.5 in the middle of the blur\n", true},
    };
    command_succeeds("slice", "ml.vdb", "--size", "20x10", "--engine", "cpu", "-o", "s.exr");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct command_result r;
        if (cases[i].gl && !command_has_gl())
            continue;
        command_run(&r, cases[i].program, cases[i].operand);
        assert_string_equal(r.err, "");
        assert_int_equal(r.code, 0);
        if (strncmp(r.out, cases[i].out, strlen(cases[i].out)) != 0)
            fail_msg("%s: %s", cases[i].program, r.out);
    }
    unlink("s.exr");
}

static void the_antialias_example_works(void **state)
{
    (void)state;
    skip_without_gl();
    struct command_result r;
    command_run(&r, "antialias_example", "example.png");
    assert_string_equal(r.err, "");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(command_succeeds("info", "example.png"), "128 x 128"));
    unlink("example.png");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(version_tells_what_it_is),
        cmocka_unit_test(help_names_everything),
        cmocka_unit_test(every_signal_can_be_made),
        cmocka_unit_test(make_options_reach_the_file),
        cmocka_unit_test(sphere_is_a_thin_band),
        cmocka_unit_test(info_reads_for_people),
        cmocka_unit_test(defaults_are_as_documented),
        cmocka_unit_test(oblique_slices_get_square_pixels),
        cmocka_unit_test(slice_writes_readable_files),
        cmocka_unit_test(kernels_from_files_slice),
        cmocka_unit_test(json_tells_everything),
        cmocka_unit_test(same_bytes_from_any_number_of_threads),
        cmocka_unit_test(a_slice_beside_the_volume_is_background),
        cmocka_unit_test(errors_are_pictures),
        cmocka_unit_test(verify_prints_where),
        cmocka_unit_test(an_interrupt_leaves_nothing),
        cmocka_unit_test(programs_of_the_library_page_work),
        cmocka_unit_test(the_antialias_example_works),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
