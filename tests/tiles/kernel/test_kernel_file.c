// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/common.h"
#include "filter/check.h"
#include "tiles/kernel/kernel_file.h"

static char folder[] = "/tmp/weft-kernel-file-XXXXXX", path[64], text[96];
static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder))
        return 1;
    snprintf(path, sizeof path, "%s/k", folder);
    snprintf(text, sizeof text, "table:%s", path);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(folder);
}

static void write_file(const char *content, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(content, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void test_good_files(void **state)
{
    static const struct {
        const char *content;
        double support, x, weight;
    } cases[] = {
        {"support 1 linear 1 0.5 0", 1, -0.25, 0.75},
        {"# a tent\nsupport 1\n1#end\n.5\r\n0", 1, 0.75, 0.25},
        {"whole\nsupport 2\n0 0.25 1 0.25 0\n", 2, -1, 0.25},
        {"\tcubic half support 1.5e0 1 +.5 -0 ", 1.5, 0.75, 0.5},
        {"1 0 support 8", 8, 4, 0.5},
        {"\xef\xbb\xbfsupport 1 1 0.5 0", 1, -0.25, 0.75}, // behind a byte order mark
        {"support 1\n0.9 0.9\n# no line end", 1, 0.3, 0.9},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel kernel;
        weft_kernel_file *file = NULL;
        char formatted[128];
        write_file(cases[i].content, strlen(cases[i].content));
        assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_OK);
        assert_non_null(file);
        assert_true(kernel.support == cases[i].support);
        assert_true(fabs(weft_kernel_weight(&kernel, cases[i].x) - cases[i].weight) < 1e-15);
        weft_kernel_format(&kernel, formatted, sizeof formatted);
        assert_string_equal(formatted, text);
        weft_kernel_file_destroy(&file);
        assert_null(file);
    }
}

static void test_normalised_file(void **state)
{
    struct weft_kernel kernel;
    weft_kernel_file *file = NULL;
    char unit[128], formatted[128];
    (void)state;
    write_file("support 1 4 2 0", 15);
    snprintf(unit, sizeof unit, "%s+unit", text);
    assert_int_equal(weft_kernel_load(&remember_log, unit, &kernel, &file), WEFT_OK);
    assert_true(weft_kernel_weight(&kernel, 0.25) == 0.75);
    weft_kernel_format(&kernel, formatted, sizeof formatted);
    assert_string_equal(formatted, unit);
    weft_kernel_file_destroy(&file);
    snprintf(unit, sizeof unit, "%s+radial+unit", text);
    assert_int_equal(weft_kernel_load(&remember_log, unit, &kernel, &file), WEFT_OK);
    assert_true(kernel.radial && kernel.normalised);
    weft_kernel_format(&kernel, formatted, sizeof formatted);
    assert_string_equal(formatted, unit);
    weft_kernel_file_destroy(&file);
}

static void test_catalogue(void **state)
{
    struct weft_kernel kernel;
    weft_kernel_file *file = (weft_kernel_file *)&kernel;
    (void)state;
    assert_int_equal(weft_kernel_load(&remember_log, "lanczos:2", &kernel, &file), WEFT_OK);
    assert_null(file);
    assert_string_equal(kernel.info->name, "lanczos");
    assert_int_equal(weft_kernel_load(&remember_log, "tables", &kernel, &file), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_load(&remember_log, NULL, &kernel, &file), WEFT_ERR_ARGUMENT);
    weft_kernel_file_destroy(&file);
    weft_kernel_file_destroy(NULL);
}

#define CONTENT(string) string, sizeof(string) - 1

static void test_bad_files(void **state)
{
    static const struct {
        const char *content;
        size_t size;
        const char *message;
    } cases[] = {
        {CONTENT(""), "fewer than 2 samples"},
        {CONTENT("support 1 1"), "fewer than 2 samples"},
        {CONTENT("1 0.5 0"), "no support is given"},
        {CONTENT("support"), ":1: '' is not a half-width in (0, 8]"},
        {CONTENT("support x 1 0"), "'x' is not a half-width"},
        {CONTENT("support 0 1 0"), "'0' is not a half-width"},
        {CONTENT("support -1 1 0"), "'-1' is not a half-width"},
        {CONTENT("support 8.01 1 0"), "'8.01' is not a half-width"},
        {CONTENT("support 1\n1 nan 0"), ":2: 'nan' is not support, half, whole"},
        {CONTENT("support 1\n\n1 inf 0"), ":3: 'inf' is not"},
        {CONTENT("support 1 1 1e999 0"), "'1e999' is not"},
        {CONTENT("support 1 1,0"), "'1,0' is not"},
        {CONTENT("support 1 1 0.5x 0"), "'0.5x' is not"},
        {CONTENT("support 1 Half 1 0"), "'Half' is not"},
        {CONTENT("support 1 1\0 0"), "byte 11 is NUL"},
        {CONTENT("\x7f"
                 "ELF\x02\x01"),
         "is not support"},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel kernel;
        weft_kernel_file *file;
        write_file(cases[i].content, cases[i].size);
        assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_ERR_FORMAT);
        assert_null(file);
        assert_null(kernel.info);
        if (!strstr(last.text, cases[i].message))
            fail_msg("case %zu logs '%s', not '%s'", i, last.text, cases[i].message);
    }
}

static void test_no_file(void **state)
{
    struct weft_kernel kernel;
    weft_kernel_file *file;
    char bad[128];
    (void)state;
    unlink(path);
    assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_ERR_OPEN);
    assert_non_null(strstr(last.text, "No such file"));
    snprintf(bad, sizeof bad, "table:%s", folder);
    assert_int_equal(weft_kernel_load(&remember_log, bad, &kernel, &file), WEFT_ERR_OPEN);
    assert_non_null(strstr(last.text, "not a regular file"));
    assert_int_equal(weft_kernel_load(&remember_log, "table:", &kernel, &file), WEFT_ERR_OPEN);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_ERR_OPEN);
    unlink(path);
}

static void test_limits(void **state)
{
    struct weft_kernel kernel;
    weft_kernel_file *file;
    const size_t count = (1 << 20) + 1;
    char *content = malloc(2 * count + 10);
    (void)state;
    assert_non_null(content);
    memcpy(content, "support 1 ", 10);
    for (size_t i = 0; i < count; i++)
        memcpy(content + 10 + 2 * i, "1 ", 2);
    write_file(content, 2 * count + 8);
    assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_OK);
    weft_kernel_file_destroy(&file);
    write_file(content, 2 * count + 10);
    assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_ERR_LIMIT);
    assert_non_null(strstr(last.text, "more than 1048576 samples"));
    free(content);
    assert_int_equal(truncate(path, WEFT_KERNEL_FILE_MAX_BYTES + 1L), 0);
    assert_int_equal(weft_kernel_load(&remember_log, text, &kernel, &file), WEFT_ERR_LIMIT);
    assert_non_null(strstr(last.text, "33554433 bytes, the limit is 33554432"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_good_files), cmocka_unit_test(test_normalised_file),
        cmocka_unit_test(test_catalogue),  cmocka_unit_test(test_bad_files),
        cmocka_unit_test(test_no_file),    cmocka_unit_test(test_limits),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
