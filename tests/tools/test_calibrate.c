// SPDX-License-Identifier: BSD-3-Clause
// What weft calibrate prints and keeps, of numbers that are known: measuring is not repeated for
// every form of output.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <jansson.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/support/files.h"
#include "tools/verbs/verb.h"
#include "weft.h"

static int calibrations;

// The linker calls this instead of the library's.
enum weft_result __wrap_weft_cost_calibrate(const struct weft_log *log, weft_context *context,
                                            const struct weft_progress *progress,
                                            struct weft_cost_model *out)
{
    (void)log;
    (void)progress;
    *out = weft_cost_default;
    snprintf(out->renderer, sizeof out->renderer, "%s", weft_context_get_info(context)->renderer);
    out->instructions = WEFT_INSTRUCTIONS_SSE2;
    out->threads = 3;
    calibrations++;
    return WEFT_OK;
}

static void give(struct option_value *values, const char *name, const char *text)
{
    for (int i = 0; i < verb_calibrate.option_count; i++)
        if (strcmp(verb_calibrate.options[i].name, name) == 0)
            values[i] = (struct option_value){.given = true, .text = text};
}

// Standard output of `weft calibrate -o FILE` with a flag, or none (to be freed).
static char *output_of(const char *flag)
{
    struct option_value *values = calloc((size_t)verb_calibrate.option_count, sizeof *values);
    assert_non_null(values);
    give(values, "output", test_path("costs.txt"));
    if (flag)
        give(values, flag, "");
    fflush(stdout);
    const int kept = dup(1);
    assert_non_null(freopen(test_path("out.txt"), "w", stdout));
    const int code = verb_calibrate.run((const char *const[]){NULL}, values);
    fflush(stdout);
    assert_int_equal(dup2(kept, 1), 1);
    close(kept);
    assert_int_equal(code, 0);
    free(values);
    return test_read_file(test_path("out.txt"), NULL);
}

// The number behind a row's name.
static double row(const char *text, const char *name)
{
    const char *at = strstr(text, name);
    if (!at)
        fail_msg("no row %s", name);
    return strtod(at + strlen(name), NULL);
}

static void assert_digits(double actual, double expected, const char *what)
{
    assert_near(actual, expected, 0.005 * expected, what); // three digits
}

static void the_table_has_all_numbers(void **state)
{
    (void)state;
    const struct weft_cost_model *m = &weft_cost_default;
    char *text = output_of(NULL);
    assert_ptr_equal(strstr(text, weft_context_get_info(contexts[0])->renderer), text);
    assert_digits(row(text, "a voxel read"), m->voxel, "voxel");
    assert_digits(row(text, "separable: a tap"), m->tap, "tap");
    assert_digits(row(text, "passes: an exact weight"), m->pass_weight, "weight");
    assert_digits(row(text, "interleaved 32f"), m->fetch[WEFT_LAYOUT_INTERLEAVED - 1][0], "fetch");
    assert_digits(row(text, "unorm16 dot4"), m->pass[WEFT_TARGET_UNORM16], "pass");
    assert_digits(row(text, "fused: a row of 6 taps"), m->cpu_row[WEFT_SUMS_FLOAT][2],
                  "row of taps");
    assert_non_null(strstr(text, "; sse2 instructions, 3 threads, measured in"));
    char kept[600];
    snprintf(kept, sizeof kept, "\nkept in %s\n", test_path("costs.txt"));
    assert_non_null(strstr(text, kept));
    free(text);
}

static void json_has_all_numbers(void **state)
{
    (void)state;
    char *text = output_of("json");
    json_error_t error;
    json_t *root = json_loads(text, 0, &error);
    assert_non_null(root);
    const json_t *costs = json_object_get(root, "nanoseconds");
    assert_near(json_number_value(json_object_get(costs, "voxel")), weft_cost_default.voxel,
                1e-5 * weft_cost_default.voxel, "voxel");
    assert_int_equal(json_array_size(json_object_get(costs, "fetch")), 12);
    assert_int_equal(json_array_size(json_object_get(costs, "cpu_row")), 8);
    assert_string_equal(json_string_value(json_object_get(root, "instructions")), "sse2");
    assert_int_equal(json_integer_value(json_object_get(root, "threads")), 3);
    assert_string_equal(json_string_value(json_object_get(
                            json_array_get(json_object_get(root, "output"), 0), "path")),
                        test_path("costs.txt"));
    json_decref(root);
    free(text);
}

static void quiet_prints_nothing(void **state)
{
    (void)state;
    char *text = output_of("quiet");
    assert_string_equal(text, "");
    free(text);
}

static void what_is_kept_is_what_was_measured(void **state)
{
    (void)state;
    size_t size;
    char *text = test_read_file(test_path("costs.txt"), &size), *expected;
    struct weft_cost_model model = weft_cost_default;
    snprintf(model.renderer, sizeof model.renderer, "%s",
             weft_context_get_info(contexts[0])->renderer);
    model.instructions = WEFT_INSTRUCTIONS_SSE2;
    model.threads = 3;
    expected = weft_cost_format(&model);
    assert_non_null(expected);
    assert_int_equal(size, strlen(expected));
    assert_memory_equal(text, expected, size);
    assert_int_equal(calibrations, 3);
    free(expected);
    free(text);
}

static int setup(void **state)
{
    return create_contexts(state) == 0 ? test_enter_folder(state) : -1;
}

static int teardown(void **state)
{
    return test_leave_folder(state) == 0 ? destroy_contexts(state) : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_has_all_numbers),
        cmocka_unit_test(json_has_all_numbers),
        cmocka_unit_test(quiet_prints_nothing),
        cmocka_unit_test(what_is_kept_is_what_was_measured),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
