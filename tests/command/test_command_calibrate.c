// SPDX-License-Identifier: BSD-3-Clause
// weft calibrate as its users see it, and what it refuses. It measures once here, for some ten
// seconds; tests/tools/test_calibrate.c has what it prints of any numbers.
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "weft.h"

// The output.
static const char *path_of(const json_t *root)
{
    const json_t *file = json_array_get(json_object_get(root, "output"), 0);
    return json_string_value(json_object_get(file, "path"));
}

static void wrong_requests_are_refused(void **state)
{
    (void)state;
    command_fails(2, "takes no file", "calibrate", "file");
    command_fails(2, "exclude each other", "calibrate", "-q", "-v");
    command_fails(2, "auto, osmesa, egl", "calibrate", "--context", "glx");
    assert_non_null(strstr(command_succeeds("calibrate", "--help=all"), "XDG_CACHE_HOME"));
}

static void what_cannot_be_written_is_told_at_once(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1); // which would complain of the folder too
    command_fails(4, "nowhere", "calibrate", "-o", "nowhere/costs.txt");
    command_fails(4, "folder", "calibrate", "-o", ".");
    command_environment("XDG_CACHE_HOME=/proc/nowhere");
    command_fails(4, "/proc/nowhere", "calibrate");
    command_write_file("file", "x", 1);
    char here[4000], variable[4100];
    assert_non_null(getcwd(here, sizeof here));
    snprintf(variable, sizeof variable, "XDG_CACHE_HOME=%s/file", here);
    command_environment(variable);
    command_fails(4, "file", "calibrate");
    unlink("file");
}

static void assert_all_positive(const struct weft_cost_model *model)
{
    const size_t first = offsetof(struct weft_cost_model, start);
    const double *values = (const double *)(const void *)((const char *)model + first);
    const size_t count = (sizeof *model - first) / sizeof *values;
    assert_true(count > 40);
    for (size_t i = 0; i < count; i++)
        assert_true(isfinite(values[i]) && values[i] > 0.0);
}

static void costs_are_kept(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    char here[4000], variable[4100];
    assert_non_null(getcwd(here, sizeof here));
    snprintf(variable, sizeof variable, "XDG_CACHE_HOME=%s/cache/deep", here);
    command_environment(variable);
    json_error_t error;
    json_t *root = json_loads(command_succeeds("calibrate", "--json"), 0, &error);
    assert_non_null(root);
    const char *path = path_of(root);
    assert_non_null(path);
    assert_non_null(strstr(path, "/cache/deep/weft/cost-"));
    assert_null(strchr(strrchr(path, '/'), ' '));
    size_t size;
    char *text = command_read_file(path, &size);
    text = realloc(text, size + 1);
    text[size] = 0;
    struct weft_cost_model model;
    assert_int_equal(weft_cost_parse(NULL, text, &model), WEFT_OK);
    free(text);
    assert_all_positive(&model);
    assert_string_equal(model.renderer, json_string_value(json_object_get(
                                            json_object_get(root, "context"), "renderer")));
    assert_string_equal(weft_instruction_set_names[model.instructions],
                        json_string_value(json_object_get(root, "instructions")));
    assert_int_equal(model.threads, json_integer_value(json_object_get(root, "threads")));
    const json_t *costs = json_object_get(root, "nanoseconds");
    assert_true(json_number_value(json_object_get(costs, "voxel")) == model.voxel);
    assert_int_equal(json_array_size(json_object_get(costs, "fetch")), 12);
    unlink(path);
    json_decref(root);
    rmdir("cache/deep/weft");
    rmdir("cache/deep");
    assert_int_equal(rmdir("cache"), 0);
}

// Without OpenGL the CPU engine alone is measured, and auto then asks for nothing else.
static void the_cpu_is_measured_alone(void **state)
{
    (void)state;
    char here[4000], variable[4100];
    struct command_result r;
    assert_non_null(getcwd(here, sizeof here));
    snprintf(variable, sizeof variable, "XDG_CACHE_HOME=%s/cache", here);
    setenv("XDG_CACHE_HOME", variable + strlen("XDG_CACHE_HOME="), 1);
    command_environment("GALLIUM_DRIVER=nonsense");
    command_run(&r, "weft", "calibrate", "--json");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.err, "going on with the CPU engine"));
    json_error_t error;
    json_t *root = json_loads(r.out, 0, &error);
    assert_non_null(root);
    assert_true(json_is_null(json_object_get(root, "context")));
    command_succeeds("make", "sphere", "-o", "s.vdb", "--size", "24");
    json_t *slice =
        json_loads(command_succeeds("slice", "s.vdb", "--json", "--size", "64x64"), 0, &error);
    assert_string_equal(json_string_value(json_object_get(slice, "engine")), "cpu");
    // What an older weft kept is refused, and said to be measured anew.
    command_write_file(path_of(root), "weft-cost 1\n", 12);
    command_run(&r, "weft", "slice", "s.vdb", "--explain", "--size", "64x64");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.err, "another version of weft"));
    assert_non_null(strstr(r.err, "weft calibrate makes it anew"));
    assert_ptr_equal(strstr(r.out, "OpenGL\n"), r.out);
    unlink(path_of(root));
    unlink("s.vdb");
    rmdir("cache/weft");
    assert_int_equal(rmdir("cache"), 0);
    unsetenv("XDG_CACHE_HOME");
    json_decref(slice);
    json_decref(root);
}

static void an_interrupt_leaves_nothing(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    const int before = command_folder_size();
    assert_int_equal(
        command_interrupt(1.5, SIGINT,
                          (const char *[]){"weft", "calibrate", "-o", "costs.txt", NULL}),
        128 + SIGINT);
    assert_int_equal(command_folder_size(), before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_requests_are_refused),
        cmocka_unit_test(what_cannot_be_written_is_told_at_once),
        cmocka_unit_test(costs_are_kept),
        cmocka_unit_test(the_cpu_is_measured_alone),
        cmocka_unit_test(an_interrupt_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
