// SPDX-License-Identifier: BSD-3-Clause
// weft stability as its users see it, and what it refuses.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "weft.h"

static void wrong_requests_are_refused(void **state)
{
    (void)state;
    command_fails(2, "no case 'clamping'", "stability", "--case", "clamping");
    command_fails(2, "no case ''", "stability", "--case", "order-2d,,no-data");
    command_fails(2, "the value is empty", "stability", "--case=");
    command_fails(2, "no case ''", "stability", "--case", "order-2d,");
    command_fails(2, "no case 'order'", "stability", "--list", "--case", "order");
    command_fails(2, "auto, osmesa, egl", "stability", "--context", "glx");
    command_fails(2, "takes no file", "stability", "image.exr");
    command_fails(2, "exclude each other", "stability", "-q", "-v");
    command_fails(3, "nowhere is no folder", "stability", "--data", "nowhere");
    command_write_file("file", "x", 1);
    command_fails(3, "file is no folder", "stability", "--data", "file");
}

static void the_list_names_every_case(void **state)
{
    (void)state;
    const char *list = command_succeeds("stability", "--list");
    for (int i = 0; weft_stability_list[i]; i++) {
        assert_non_null(strstr(list, weft_stability_list[i]->name));
        assert_non_null(strstr(list, weft_stability_list[i]->failure));
        assert_non_null(strstr(list, weft_stability_list[i]->ours));
    }
    json_error_t error;
    json_t *root = json_loads(command_succeeds("stability", "--list", "--json"), 0, &error);
    const json_t *cases = json_object_get(root, "cases");
    size_t count = 0;
    while (weft_stability_list[count])
        count++;
    assert_int_equal(json_array_size(cases), count);
    for (size_t i = 0; i < count; i++) {
        const json_t *c = json_array_get(cases, i);
        assert_string_equal(json_string_value(json_object_get(c, "name")),
                            weft_stability_list[i]->name);
        assert_true(json_is_string(json_object_get(c, "our_way")));
        assert_null(json_object_get(c, "verdict"));
    }
    json_decref(root);
}

static void the_table_is_readable(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    const char *out = command_succeeds("stability", "--case", "no-data,order-2d,zero-weight");
    assert_non_null(strstr(out, "holds"));
    assert_non_null(strstr(out, "\n3 cases on "));
    assert_null(strstr(out, "ripple"));
    // Nothing to tell but the table and the summary: cases keep the order of the list.
    assert_true(strstr(out, "order-2d") < strstr(out, "no-data"));
    for (const char *line = out; *line; line += strcspn(line, "\n") + 1)
        assert_true(strcspn(line, "\n") <= 100);
    out = command_succeeds("stability", "-v", "--case", "no-data");
    assert_non_null(strstr(out, "\nno-data: FLT_MAX"));
}

static void json_has_it_all(void **state)
{
    (void)state;
    if (!command_has_gl())
        skip();
    json_error_t error;
    json_t *root = json_loads(command_succeeds("stability", "--json", "--case", "order-2d,no-data"),
                              0, &error);
    assert_non_null(root);
    assert_int_equal(json_integer_value(json_object_get(root, "failed")), 0);
    assert_true(json_is_string(json_object_get(json_object_get(root, "context"), "renderer")));
    const json_t *cases = json_object_get(root, "cases");
    assert_int_equal(json_array_size(cases), 2);
    const json_t *order = json_array_get(cases, 0), *no_data = json_array_get(cases, 1);
    assert_string_equal(json_string_value(json_object_get(order, "name")), "order-2d");
    assert_string_equal(json_string_value(json_object_get(order, "verdict")), "holds");
    assert_string_equal(json_string_value(json_object_get(order, "unit")), "LSB");
    assert_true(json_number_value(json_object_get(order, "ours")) <=
                json_number_value(json_object_get(order, "limit")));
    assert_true(json_number_value(json_object_get(order, "naive")) > 20.0);
    assert_true(json_is_null(json_object_get(no_data, "naive"))); // infinite
    assert_true(json_is_string(json_object_get(no_data, "text")));
    json_decref(root);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_requests_are_refused),
        cmocka_unit_test(the_list_names_every_case),
        cmocka_unit_test(the_table_is_readable),
        cmocka_unit_test(json_has_it_all),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
