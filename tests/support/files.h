// SPDX-License-Identifier: BSD-3-Clause
// tests/support/files.h - what tests of files share: a scratch folder, a log that keeps the last line.
// Include after cmocka.h.
#ifndef WEFT_TESTS_SUPPORT_FILES_H
#define WEFT_TESTS_SUPPORT_FILES_H

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/base.h"

static char test_folder[64];
static char test_message[1024];
static int test_errors;

static inline void test_keep(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level != WEFT_LOG_ERROR)
        return;
    test_errors++;
    snprintf(test_message, sizeof test_message, "%s", message);
}

static const struct weft_log test_log = {.write = test_keep};

static inline void test_forget(void)
{
    test_message[0] = '\0';
    test_errors = 0;
}

// Static storage; the next but three calls overwrite it.
static inline const char *test_path(const char *name)
{
    static char path[4][512];
    static int next;
    char *out = path[next++ % 4];
    snprintf(out, sizeof path[0], "%s/%s", test_folder, name);
    return out;
}

static inline int test_enter_folder(void **state)
{
    (void)state;
    snprintf(test_folder, sizeof test_folder, "/tmp/weft-test-XXXXXX");
    return mkdtemp(test_folder) ? 0 : -1;
}

static inline int test_count_entries(const char *folder)
{
    int count = 0;
    DIR *dir = opendir(folder);
    while (dir && readdir(dir))
        count++;
    if (dir)
        closedir(dir);
    return count;
}

static inline int test_leave_folder(void **state)
{
    (void)state;
    DIR *dir = opendir(test_folder);
    struct dirent *entry;
    while (dir && (entry = readdir(dir)))
        if (strcmp(entry->d_name, ".") && strcmp(entry->d_name, ".."))
            remove(test_path(entry->d_name));
    if (dir)
        closedir(dir);
    return rmdir(test_folder);
}

static inline void test_write_file(const char *path, const void *data, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

// Ended with a zero; to be freed.
static inline char *test_read_file(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    assert_int_equal(fseek(f, 0, SEEK_END), 0);
    long length = ftell(f);
    assert_true(length >= 0);
    rewind(f);
    char *data = malloc((size_t)length + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, (size_t)length, f), length);
    data[length] = '\0';
    fclose(f);
    if (size)
        *size = (size_t)length;
    return data;
}

#endif
