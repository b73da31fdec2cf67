// SPDX-License-Identifier: BSD-3-Clause
// What filters, as the options say it: OpenGL or the CPU engine, threads and sums.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

static const char *text(const json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    if (!value)
        fail_msg("no text %s", key);
    return value;
}

#define SLICE "slice", "ml.vdb", "--size", "16x16", "--json"

static void contradictions_are_refused(void **state)
{
    (void)state;
    command_fails(2, "auto, gl, cpu", SLICE, "--engine", "opengl");
    command_fails(2, "float, double", SLICE, "--sums", "half");
    command_fails(2, "--context is of OpenGL", SLICE, "--engine", "cpu", "--context", "osmesa");
    command_fails(2, "--context makes no sense with --sums double", SLICE, "--sums", "double",
                  "--context", "auto");
    command_fails(2, "--engine gl makes no sense with --sums double", SLICE, "--sums", "double",
                  "--engine", "gl");
    command_fails(2, "--threads is of the CPU engine", SLICE, "--threads", "2", "--engine", "gl");
    command_fails(2, "--max-error chooses what --sums says", SLICE, "--sums", "double",
                  "--max-error", "8bit");
    static const char *const of_gl[][2] = {{"--profile", "unorm8"},
                                           {"--layout", "plain"},
                                           {"--source", "16f"},
                                           {"--lookup", "polynomial"}};
    for (size_t i = 0; i < sizeof of_gl / sizeof *of_gl; i++) {
        command_fails(2, of_gl[i][0], SLICE, of_gl[i][0], of_gl[i][1], "--engine", "cpu");
        command_fails(2, of_gl[i][0], SLICE, of_gl[i][0], of_gl[i][1], "--sums", "double");
    }
    static const char *const threads[] = {"0", "-1", "1.5", "1025", "1e9"};
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
        char option[32];
        snprintf(option, sizeof option, "--threads=%s", threads[i]);
        command_fails(2, "not a whole number from 1 to 1024", SLICE, option);
    }
}

// ---- slices -------------------------------------------------------------------------------------

// Across an axis, and along none.
static const char *const planes[][6] = {
    {"--axis", "y", "--at", "7.1", NULL},
    {"--origin=0,0,1", "--u=14,1,2", "--v=1,13,-.5", "--kernel=mitchell", NULL}};

static void slices_run_on_the_cpu(void **state)
{
    (void)state;
    static const char *const sums[] = {"float", "double"};
    for (size_t p = 0; p < sizeof planes / sizeof *planes; p++) {
        const char *const *plane = planes[p];
        double error[2];
        for (size_t i = 0; i < 2; i++) {
            json_t *root = parse(command_succeeds(
                "slice", "ml.vdb", "--size", "90x80", plane[0], plane[1], plane[2], plane[3],
                "--engine", "cpu", "--sums", sums[i], "--threads", "2", "--verify", "--json"));
            assert_string_equal(text(root, "engine"), "cpu");
            assert_string_equal(text(root, "sums"), sums[i]);
            assert_int_equal((int)number(root, "threads"), 2);
            assert_true(json_is_null(json_object_get(root, "context")));
            error[i] = number(json_object_get(root, "error"), "max");
            json_decref(root);
        }
        assert_true(error[1] < 0.5 * error[0]);
    }
    const char *out = command_succeeds("slice", "ml.vdb", "--engine", "cpu", "--explain");
    assert_non_null(strstr(out, "CPU engine, "));
    assert_non_null(strstr(out, " float sums"));
    command_succeeds("slice", "ml.vdb", "--sums", "double", "-o", "cpu.exr");
    assert_non_null(strstr(command_succeeds("info", "cpu.exr"), "weft.sums = double"));
    remove("cpu.exr");
}

static void small_budgets_of_slices_take_double_sums(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--size", "50x50", "--max-error",
                                          "2e-7", "--verify", "--json"));
    assert_string_equal(text(root, "engine"), "cpu");
    assert_string_equal(text(root, "sums"), "double");
    assert_string_equal(text(json_object_get(root, "budget"), "method"), "separable cpu double");
    json_decref(root);
}

// ---- resampling ---------------------------------------------------------------------------------

// Noise from 0 to 1.
static int make_photo(void)
{
    enum { WIDTH = 37, HEIGHT = 23 };
    static float plane[WIDTH * HEIGHT];
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        plane[i] = (float)((uint32_t)i * 2654435761u >> 8) * 0x1p-24f;
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    const struct weft_image image = {.width = WIDTH,
                                     .height = HEIGHT,
                                     .display_max = {WIDTH - 1, HEIGHT - 1},
                                     .channel_count = 1,
                                     .channels = &channel};
    return weft_image_save_parts(&image, 1, &(struct weft_image_save_params){.path = "photo.exr"},
                                 NULL) == WEFT_OK
               ? 0
               : -1;
}

#define RESAMPLE "resample", "photo.exr", "--size", "70x50"

static void resampling_runs_on_the_cpu(void **state)
{
    (void)state;
    static const char *const sums[] = {"float", "double"};
    for (size_t i = 0; i < 2; i++) {
        json_t *root = parse(command_succeeds(RESAMPLE, "--engine", "cpu", "--sums", sums[i],
                                              "--threads", "3", "--verify", "--json"));
        assert_string_equal(text(root, "engine"), "cpu");
        assert_string_equal(text(root, "sums"), sums[i]);
        assert_string_equal(text(root, "instructions"),
                            weft_instruction_set_names[weft_instruction_set_best()]);
        assert_int_equal((int)number(root, "threads"), 3);
        assert_false(json_boolean_value(json_object_get(root, "emulated")));
        assert_true(json_is_null(json_object_get(root, "context")));
        json_decref(root);
    }
    // The files tell what they were made by, and not with how many threads.
    size_t one_size, many_size;
    command_succeeds(RESAMPLE, "-o", "one.exr", "--engine", "cpu", "--threads", "1");
    command_succeeds(RESAMPLE, "-o", "many.exr", "--engine", "cpu", "--threads", "5");
    char *one = command_read_file("one.exr", &one_size);
    char *many = command_read_file("many.exr", &many_size);
    assert_int_equal(one_size, many_size);
    assert_memory_equal(one, many, one_size);
    free(one);
    free(many);
    assert_non_null(strstr(command_succeeds("info", "one.exr"), "weft.engine = cpu"));
    remove("one.exr");
    remove("many.exr");
}

static void passes_are_not_for_the_cpu_engine(void **state)
{
    (void)state;
    static const char *const of_gl[][2] = {{"--profile", "unorm8"}, {"--bits", "8"}};
    for (size_t i = 0; i < sizeof of_gl / sizeof *of_gl; i++)
        command_fails(2, "no sense with --engine cpu", RESAMPLE, "--json", of_gl[i][0], of_gl[i][1],
                      "--engine", "cpu");
    command_fails(2, "no sense with --engine cpu", RESAMPLE, "--json", "--kernel",
                  "catmull-rom+radial", "--engine", "cpu");
    command_fails(2, "--emulate runs passes", RESAMPLE, "--json", "--emulate", "--engine", "cpu");
    command_fails(2, "--max-error chooses what --sums says", RESAMPLE, "--json", "--max-error",
                  "8bit", "--sums", "double");
}

// Budgets that single precision does not meet ask for sums in double.
static void small_budgets_take_double_sums(void **state)
{
    (void)state;
    json_t *root = parse(command_succeeds(RESAMPLE, "--max-error", "1.5e-7", "--verify", "--json"));
    assert_string_equal(text(root, "engine"), "cpu");
    assert_string_equal(text(root, "sums"), "double");
    assert_int_equal(json_array_size(json_object_get(root, "choices")), 3);
    json_decref(root);
    command_fails(1, "separable cpu double", RESAMPLE, "--json", "--max-error", "1e-9");
}

// ---- no OpenGL ----------------------------------------------------------------------------------

#define NO_GL "GALLIUM_DRIVER=nonsense"

// Exit code 5 is for what needs it.
static void without_opengl_the_cpu_goes_on(void **state)
{
    (void)state;
    static const char *const resample[] = {"weft", RESAMPLE, "--json", "-o", "out.exr", NULL};
    static const char *const quiet[] = {"weft", RESAMPLE, "-q", "-o", "out.exr", NULL};
    static const char *const budget[] = {"weft", RESAMPLE, "--json",  "--max-error",
                                         "8bit", "-o",     "out.exr", NULL};
    static const char *const slice[] = {"weft", SLICE, "-o", "out.exr", NULL};
    static const char *const *const runs[] = {resample, quiet, budget, slice};
    struct command_result r;
    for (size_t i = 0; i < sizeof runs / sizeof *runs; i++) {
        command_environment(NO_GL);
        command_run_list(&r, runs[i]);
        assert_int_equal(r.code, 0);
        assert_int_equal(remove("out.exr"), 0);
        if (runs[i] == quiet) {
            assert_string_equal(r.err, "");
            continue;
        }
        // Once, whether it was tried at all or costs said that the CPU is faster.
        const char *line = strstr(r.err, "going on with the CPU engine\n");
        assert_true(line ? !strstr(line + 29, "CPU engine") : !strstr(r.err, "warning"));
        assert_true(line || runs[i] == budget);
        json_t *root = parse(r.out);
        assert_string_equal(text(root, "engine"), "cpu");
        json_decref(root);
    }
    static const char *const needs_it[][3] = {
        {"--engine", "gl", NULL}, {"--context", "auto", NULL}, {"--profile", "fp32", NULL}};
    for (size_t i = 0; i < sizeof needs_it / sizeof *needs_it; i++) {
        command_environment(NO_GL);
        command_fails(5, "no usable GL context", RESAMPLE, "--json", needs_it[i][0],
                      needs_it[i][1]);
        command_environment(NO_GL);
        command_fails(5, "no usable GL context", SLICE, needs_it[i][0], needs_it[i][1]);
    }
}

static int setup(void **state)
{
    return command_setup(state) == 0 ? make_photo() : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contradictions_are_refused),
        cmocka_unit_test(slices_run_on_the_cpu),
        cmocka_unit_test(small_budgets_of_slices_take_double_sums),
        cmocka_unit_test(resampling_runs_on_the_cpu),
        cmocka_unit_test(passes_are_not_for_the_cpu_engine),
        cmocka_unit_test(small_budgets_take_double_sums),
        cmocka_unit_test(without_opengl_the_cpu_goes_on),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
