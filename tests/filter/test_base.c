// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/version.h"

struct record {
    int count;
    enum weft_log_level level;
    char message[4096];
};

static void keep(void *priv, enum weft_log_level level, const char *message)
{
    struct record *record = priv;
    record->count++;
    record->level = level;
    snprintf(record->message, sizeof record->message, "%s", message);
}

static void test_result_text(void **state)
{
    static const enum weft_result results[] = {
        WEFT_OK,         WEFT_ERR_ARGUMENT, WEFT_ERR_CANCELLED, WEFT_ERR_UNSUPPORTED,
        WEFT_ERR_LIMIT,  WEFT_ERR_MEMORY,   WEFT_ERR_OPEN,      WEFT_ERR_FORMAT,
        WEFT_ERR_READER, WEFT_ERR_WRITE,    WEFT_ERR_CONTEXT,   WEFT_ERR_GL,
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(results); i++) {
        const char *text = weft_result_text(results[i]);
        assert_true(text && strlen(text) > 0);
        assert_string_not_equal(text, "unknown result");
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(text, weft_result_text(results[j]));
    }
    assert_string_equal(weft_result_text((enum weft_result)7), "unknown result");
}

static void test_version(void **state)
{
    int major, minor, patch;
    (void)state;
    assert_int_equal(sscanf(weft_version(), "%d.%d.%d", &major, &minor, &patch), 3);
    assert_int_equal(major, WEFT_VERSION_MAJOR);
    assert_int_equal(minor, WEFT_VERSION_MINOR);
    assert_int_equal(patch, WEFT_VERSION_PATCH);
    // As CMake, and with it packages and file names, have it.
    assert_string_equal(weft_version(), WEFT_TEST_VERSION);
    assert_string_equal(WEFT_VERSION_TEXT, WEFT_TEST_VERSION);
#if WEFT_VERSION != WEFT_VERSION_NUMBER(WEFT_VERSION_MAJOR, WEFT_VERSION_MINOR, WEFT_VERSION_PATCH)
#error "the number is not made of its parts"
#endif
    assert_true(WEFT_VERSION_NUMBER(0, 2, 0) > WEFT_VERSION_NUMBER(0, 1, 99));
    assert_true(WEFT_VERSION_NUMBER(1, 0, 0) > WEFT_VERSION_NUMBER(0, 999, 999));
}

static void test_log_levels(void **state)
{
    struct record record = {0};
    const struct weft_log log = {.write = keep, .priv = &record};
    (void)state;
    weft_error(&log, "%d of %s", 3, "x");
    assert_string_equal(record.message, "3 of x");
    assert_int_equal(record.level, WEFT_LOG_ERROR);
    weft_warn(&log, "w");
    assert_int_equal(record.level, WEFT_LOG_WARNING);
    weft_note(&log, "n");
    assert_int_equal(record.level, WEFT_LOG_INFO);
    weft_debug(&log, "d");
    assert_int_equal(record.level, WEFT_LOG_DEBUG);
    assert_int_equal(record.count, 4);
}

// What a terminal obeys, what breaks lines or their direction, and what is no UTF-8 (RFC 3629,
// section 3 and 4) becomes '?'; all else stays to the byte.
static void test_text_clean(void **state)
{
    static const struct {
        const char *text, *clean;
    } cases[] = {
        {"", ""},
        {"density[1] ~", "density[1] ~"},
        {"\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80 \xc2\xa0",
         "\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80 \xc2\xa0"},
        {"\x1b]0;title\x07\x1b[31m", "?]0;title??[31m"},
        {"a\tb\nc\rd\x7f", "a?b?c?d?"},
        {"\xc2\x9b"
         "31m \xc2\x80 \xc2\x9f",
         "?31m ? ?"}, // C1 as UTF-8
        {"\x9b"
         "31m \xff\xfe",
         "?31m ??"},                                               // C1 as a byte; never UTF-8
        {"\xc0\xaf \xe0\x80\xaf \xf0\x80\x80\x9b", "?? ??? ????"}, // overlong
        {"\xed\xa0\x80 \xf4\x90\x80\x80 \xf8\x88\x80\x80\x80", "??? ???? ?????"},
        {"\xe2\x82", "??"}, // cut short
        {"\xe2\x82x", "??x"},
        {"\xe2\x80\xa8 \xe2\x80\xa9 \xe2\x80\xae"
         "fdp.exe \xe2\x81\xa7 \xd8\x9c",
         "? ? ?fdp.exe ? ?"},
        {"\xed\x9f\xbf \xee\x80\x80 \xf4\x8f\xbf\xbf",
         "\xed\x9f\xbf \xee\x80\x80 \xf4\x8f\xbf\xbf"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        char text[64];
        snprintf(text, sizeof text, "%s", cases[i].text);
        assert_ptr_equal(weft_text_clean(text, false), text);
        assert_string_equal(text, cases[i].clean);
        weft_text_clean(text, false);
        assert_string_equal(text, cases[i].clean);
    }
    char lines[] = "a\tb\nc\rd\x1b";
    assert_string_equal(weft_text_clean(lines, true), "a\tb\nc?d?");
}

static void test_silence(void **state)
{
    const struct weft_log log = {0};
    (void)state;
    weft_error(NULL, "%s", "nobody hears");
    weft_error(&log, "%s", "nobody hears");
}

static void test_log_cut(void **state)
{
    struct record record = {0};
    const struct weft_log log = {.write = keep, .priv = &record};
    char longer[3000];
    (void)state;
    memset(longer, 'a', sizeof longer);
    longer[sizeof longer - 1] = '\0';
    weft_error(&log, "%s", longer);
    assert_int_equal(strlen(record.message), 1023);
    longer[1023] = '\0';
    weft_error(&log, "%s", longer);
    assert_string_equal(record.message, longer);
}

static void test_log_control_characters(void **state)
{
    struct record record = {0};
    const struct weft_log log = {.write = keep, .priv = &record};
    (void)state;
    weft_error(&log, "a\nb\tc\x1b[31md\x7f\r %s", "gr\xc3\xbc\xc3\x9f");
    assert_string_equal(record.message, "a?b?c?[31md?? gr\xc3\xbc\xc3\x9f");
}

static enum weft_result require_positive(const struct weft_log *log, int value)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, value > 0);
    res = WEFT_OK;
fail:
    return res;
}

static void test_require(void **state)
{
    struct record record = {0};
    const struct weft_log log = {.write = keep, .priv = &record};
    (void)state;
    assert_int_equal(require_positive(&log, 1), WEFT_OK);
    assert_int_equal(record.count, 0);
    assert_int_equal(require_positive(&log, 0), WEFT_ERR_ARGUMENT);
    assert_string_equal(record.message, "require_positive: required: value > 0");
}

static void test_sizes(void **state)
{
    size_t out;
    (void)state;
    assert_true(weft_size_mul(SIZE_MAX / 2, 2, &out));
    assert_true(out == SIZE_MAX - 1);
    assert_false(weft_size_mul(SIZE_MAX / 2 + 1, 2, &out));
    assert_true(weft_size_mul(0, SIZE_MAX, &out) && out == 0);
    assert_true(weft_size_add(SIZE_MAX - 1, 1, &out) && out == SIZE_MAX);
    assert_false(weft_size_add(SIZE_MAX, 1, &out));
}

static void test_numbers(void **state)
{
    static const struct {
        const char *text;
        double value;
        int length; // 0: none
    } cases[] = {
        {"1", 1, 1},     {"-0.5,2", -0.5, 4}, {"+.25e1 ", 2.5, 6}, {"3+unit", 3, 1},
        {"", 0, 0},      {" 1", 0, 0},        {"nan", 0, 0},       {"-inf", 0, 0},
        {"1e999", 0, 0}, {"-", 0, 0},         {"e5", 0, 0},        {".", 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        double value = 0.0;
        const char *end = weft_number_parse(cases[i].text, &value);
        assert_ptr_equal(end, cases[i].length ? cases[i].text + cases[i].length : NULL);
        assert_true(!end || value == cases[i].value);
    }
}

static void test_clock(void **state)
{
    (void)state;
    const double before = weft_now_seconds();
    assert_true(before > 0.0);
    assert_true(weft_now_seconds() >= before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_result_text),
        cmocka_unit_test(test_version),
        cmocka_unit_test(test_log_levels),
        cmocka_unit_test(test_text_clean),
        cmocka_unit_test(test_silence),
        cmocka_unit_test(test_log_cut),
        cmocka_unit_test(test_log_control_characters),
        cmocka_unit_test(test_require),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_clock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
