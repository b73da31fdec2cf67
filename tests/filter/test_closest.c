// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/support/common.h"
#include "filter/closest.h"
#include "filter/kernels/kernel.h"

static const char *const names[] = {"slice", "resample", "stability", "table", "u", NULL};

static void slips_are_found(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"slice", "slice"},
        {"slcie", "slice"},
        {"sliec", "slice"},
        {"slic", "slice"},
        {"slices", "slice"},
        {"SLICE", "slice"},
        {"clice", "slice"},
        {"resampel", "resample"},
        {"resam", "resample"},
        {"stabilty", "stability"},
        {"tabel", "table"},
        {"stab", "stability"},
        {"slix", NULL},
        {"zebra", NULL},
        {"", NULL},
        {"ta", NULL},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const char *found = weft_closest_find(cases[i][0], strlen(cases[i][0]), names);
        if (!cases[i][1])
            assert_null(found);
        else
            assert_string_equal(found, cases[i][1]);
    }
}

// Only `length` bytes are looked at, and long texts are near to nothing.
static void lengths_hold(void **state)
{
    (void)state;
    char text[200];
    memset(text, 'x', sizeof text);
    assert_string_equal(weft_closest_find("tablexyz", 5, names), "table");
    assert_null(weft_closest_find(text, sizeof text, names));
    assert_null(weft_closest_find("table", 5, (const char *const[]){NULL}));
}

// Every name of the catalogue with one letter wrong, missing or doubled is answered with a name of
// the catalogue, and most with that very one (bspline2 and bspline3 are a letter apart).
static void kernels_are_recognised(void **state)
{
    (void)state;
    struct message last;
    const struct weft_log log = {keep_message, &last};
    size_t tried = 0, same = 0;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        const char *name = weft_kernel_list[i]->name;
        const size_t length = strlen(name);
        for (size_t at = 0; at < length; at++) {
            char text[64], meant[80];
            struct weft_kernel kernel;
            memcpy(text, name, at);
            strcpy(text + at, name + at + 1);
            if (weft_kernel_find(text) || strlen(text) < 3)
                continue;
            if (weft_kernel_parse(&log, text, &kernel) == WEFT_OK)
                continue;
            assert_non_null(strstr(last.text, "did you mean "));
            snprintf(meant, sizeof meant, "did you mean %s?", name);
            same += strstr(last.text, meant) != NULL;
            tried++;
        }
    }
    assert_true(tried > 500);
    assert_true(10 * same > 7 * tried);
}

// What other programs call them, where that is one kernel.
static void other_names_are_taken(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"bilinear", "linear"},
        {"Trilinear", "linear"},
        {"POINT", "nearest"},
        {"catrom", "catmull-rom"},
        {"d-catrom", "d-catmull-rom"},
        {"Catmull_Rom", "catmull-rom"},
        {"Mitchell", "mitchell"},
        {"BSPLINE3I", "bspline3i"},
        {"cubic B-spline", "bspline"},
        {"gauss:3,0.8", "gaussian:3,0.8"},
        {"keys", "catmull-rom"},
        {"lanczos3", "lanczos:3"},
        {"Lanczos2", "lanczos:2"},
        {"Lanczos:2.5", "lanczos:2.5"},
        {"hann4+unit", "hann-sinc:4+unit"},
        {"kaiser:2,5", "kaiser-sinc:2,5"},
        {"dd-hermite", "dd-cubic:0,0"},
        {"triangle+radial+unit", "linear+radial+unit"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel kernel;
        char text[80];
        assert_int_equal(weft_kernel_parse(&log_to_stderr, cases[i][0], &kernel), WEFT_OK);
        weft_kernel_format(&kernel, text, sizeof text);
        assert_string_equal(text, cases[i][1]);
    }
}

// Aliases are no names of the catalogue, and each is one of it, or names some that are meant.
static void aliases_are_kernels(void **state)
{
    (void)state;
    struct message last;
    const struct weft_log log = {keep_message, &last};
    size_t taken = 0, refused = 0;
    for (const struct weft_kernel_alias *alias = weft_kernel_aliases; alias->name; alias++) {
        struct weft_kernel kernel, meant;
        char text[80];
        assert_null(weft_kernel_find(alias->name));
        assert_int_equal(weft_kernel_parse(&log, alias->kernel, &meant), WEFT_OK);
        assert_ptr_equal(weft_kernel_translate(alias->name, text, sizeof text),
                         alias->taken ? alias->sentence : NULL);
        assert_string_equal(text, alias->taken ? alias->kernel : "");
        assert_int_equal(weft_kernel_parse(&log, alias->name, &kernel),
                         alias->taken ? WEFT_OK : WEFT_ERR_ARGUMENT);
        assert_true(alias->taken ? kernel.info == meant.info
                                 : strstr(last.text, alias->sentence) != NULL);
        taken += alias->taken;
        refused += !alias->taken;
    }
    assert_true(taken > 30 && refused > 10);
}

static void other_names_are_answered(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"bicubic", "catmull-rom (a = -0.5: MATLAB, Pillow), cardinal:0.75"},
        {"bicubik", "catmull-rom (a = -0.5: MATLAB, Pillow), cardinal:0.75"},
        {"d-bicubic", "d-catmull-rom (a = -0.5"},
        {"tricubic+unit", "catmull-rom"},
        {"box", "nearest (one sample) or area"},
        {"spline", "bspline3i"},
        {"blackman-harris3", "blackman-sinc (three"},
        {"catrum", "catmull-rom?"},
    };
    struct message last;
    const struct weft_log log = {keep_message, &last};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel kernel;
        char meant[80];
        snprintf(meant, sizeof meant, "did you mean %s", cases[i][1]);
        assert_int_equal(weft_kernel_parse(&log, cases[i][0], &kernel), WEFT_ERR_ARGUMENT);
        if (!strstr(last.text, meant))
            fail_msg("%s: %s", cases[i][0], last.text);
    }
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_parse(&log, "gargoyle", &kernel), WEFT_ERR_ARGUMENT);
    assert_null(strstr(last.text, "did you mean"));
    assert_non_null(strstr(last.text, "bspline3i")); // the catalogue, prefiltered ones too
}

// B = -0.5 is a kernel of the family, but a = -0.5 is more likely meant.
static void a_negative_b_is_questioned(void **state)
{
    (void)state;
    struct message last = {0};
    const struct weft_log log = {keep_message, &last};
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_parse(&log, "cubic:-0.5", &kernel), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last.text, "a = -0.5 meant, which is catmull-rom, or B = -0.5, which "
                                      "is cubic:-0.5,0.5?"));
    assert_int_equal(weft_kernel_parse(&log, "d-cubic:-0.75", &kernel), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(last.text, "d-cardinal:0.75"));
    last = (struct message){0};
    assert_int_equal(weft_kernel_parse(&log, "cubic:-0.5,0.5", &kernel), WEFT_OK);
    assert_int_equal(weft_kernel_parse(&log, "cubic:0.5", &kernel), WEFT_OK);
    assert_true(last.text[0] == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slips_are_found),
        cmocka_unit_test(lengths_hold),
        cmocka_unit_test(kernels_are_recognised),
        cmocka_unit_test(other_names_are_taken),
        cmocka_unit_test(aliases_are_kernels),
        cmocka_unit_test(other_names_are_answered),
        cmocka_unit_test(a_negative_b_is_questioned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
