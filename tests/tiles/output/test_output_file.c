// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/wait.h>

#include "tests/support/files.h"
#include "tiles/output/output_file.h"

// Linked with --wrap: as on a file system that makes no files without a name.
static bool names_only;
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, mode_t mode);

int __wrap_open(const char *path, int flags, mode_t mode)
{
    if (names_only && (flags & O_TMPFILE) == O_TMPFILE) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return __real_open(path, flags, mode);
}

static enum weft_result write_text(const char *path, bool no_clobber, const char *text)
{
    struct weft_output_file file;
    test_forget();
    enum weft_result res = weft_output_file_create(&test_log, path, no_clobber, &file);
    if (res == WEFT_OK)
        res = weft_output_file_write(&file, 0, text, strlen(text));
    if (res == WEFT_OK)
        res = weft_output_file_commit(&file);
    weft_output_file_discard(&file);
    assert_int_equal(test_errors, res == WEFT_OK ? 0 : 1);
    return res;
}

static void assert_content(const char *path, const char *text)
{
    char *content = test_read_file(path, NULL);
    assert_string_equal(content, text);
    free(content);
}

static void test_new_file(void **state)
{
    (void)state;
    struct stat st;
    mode_t old = umask(027);
    assert_int_equal(write_text(test_path("new"), false, "one"), WEFT_OK);
    umask(old);
    assert_content(test_path("new"), "one");
    assert_int_equal(stat(test_path("new"), &st), 0);
    assert_int_equal(st.st_mode & 0777, 0640);
}

static void test_replaced_file_keeps_permissions(void **state)
{
    (void)state;
    struct stat st;
    assert_int_equal(write_text(test_path("old"), false, "one, long"), WEFT_OK);
    assert_int_equal(chmod(test_path("old"), 0600), 0);
    assert_int_equal(write_text(test_path("old"), false, "two"), WEFT_OK);
    assert_content(test_path("old"), "two");
    assert_int_equal(stat(test_path("old"), &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
}

static void test_no_clobber(void **state)
{
    (void)state;
    const char *path = test_path("kept");
    assert_int_equal(write_text(path, true, "one"), WEFT_OK);
    assert_int_equal(write_text(path, true, "two"), WEFT_ERR_WRITE);
    assert_non_null(strstr(test_message, "exists"));
    assert_content(path, "one");
}

static void test_no_clobber_of_a_late_comer(void **state)
{
    (void)state;
    struct weft_output_file file;
    const char *path = test_path("late");
    test_forget();
    assert_int_equal(weft_output_file_create(&test_log, path, true, &file), WEFT_OK);
    test_write_file(path, "other", 5);
    assert_int_equal(weft_output_file_commit(&file), WEFT_ERR_WRITE);
    assert_int_equal(test_errors, 1);
    assert_non_null(strstr(test_message, "File exists"));
    assert_content(path, "other");
}

static void test_discard_leaves_nothing(void **state)
{
    (void)state;
    struct weft_output_file file, none = {0};
    assert_int_equal(weft_output_file_create(NULL, test_path("gone"), false, &file), WEFT_OK);
    assert_int_equal(test_count_entries(test_folder), names_only ? 3 : 2);
    assert_int_equal(access(test_path("gone"), F_OK), -1);
    weft_output_file_discard(&file);
    weft_output_file_discard(&file);
    weft_output_file_discard(&none);
    assert_int_equal(test_count_entries(test_folder), 2);
}

static void test_links(void **state)
{
    (void)state;
    struct stat st;
    test_write_file(test_path("target"), "one", 3);
    assert_int_equal(symlink("target", test_path("link")), 0);
    assert_int_equal(write_text(test_path("link"), false, "two"), WEFT_OK);
    assert_content(test_path("target"), "two");
    assert_int_equal(lstat(test_path("link"), &st), 0);
    assert_true(S_ISLNK(st.st_mode));

    assert_int_equal(symlink("nowhere", test_path("dangling")), 0);
    assert_int_equal(write_text(test_path("dangling"), false, "x"), WEFT_ERR_WRITE);
    assert_non_null(strstr(test_message, "symbolic link to nothing"));
}

static void test_bad_targets(void **state)
{
    (void)state;
    static const struct {
        const char *name, *message;
    } cases[] = {
        {"", "Is a directory"},
        {"missing/file", "No such file or directory"},
        {"new/", "Is a directory"},
        {"plain/file", "Not a directory"},
    };
    test_write_file(test_path("plain"), "x", 1);
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        assert_int_equal(write_text(test_path(cases[i].name), false, "x"), WEFT_ERR_WRITE);
        assert_non_null(strstr(test_message, cases[i].message));
    }
    assert_int_equal(write_text("", false, "x"), WEFT_ERR_WRITE);
    struct weft_output_file file;
    assert_int_equal(weft_output_file_create(NULL, NULL, false, &file), WEFT_ERR_ARGUMENT);
}

static void test_read_only_target(void **state)
{
    (void)state;
    if (geteuid() == 0)
        skip(); // root may write anything
    test_write_file(test_path("read-only"), "one", 3);
    assert_int_equal(chmod(test_path("read-only"), 0444), 0);
    assert_int_equal(write_text(test_path("read-only"), false, "two"), WEFT_ERR_WRITE);
    assert_non_null(strstr(test_message, "Permission denied"));
    assert_content(test_path("read-only"), "one");
}

static void test_long_name(void **state)
{
    (void)state;
    char name[300];
    memset(name, 'n', sizeof name);
    name[255] = '\0'; // NAME_MAX
    assert_int_equal(write_text(test_path(name), false, "x"), WEFT_OK);
    assert_content(test_path(name), "x");
    name[255] = 'n';
    name[256] = '\0';
    assert_int_equal(write_text(test_path(name), false, "x"), WEFT_ERR_WRITE);
    assert_non_null(strstr(test_message, "File name too long"));
}

static void test_devices_and_pipes(void **state)
{
    (void)state;
    struct stat st;
    assert_int_equal(write_text("/dev/null", false, "x"), WEFT_OK);
    assert_int_equal(write_text("/dev/null", true, "x"), WEFT_OK);
    assert_int_equal(stat("/dev/null", &st), 0);
    assert_true(S_ISCHR(st.st_mode));
    assert_int_equal(write_text("/dev/full", false, "x"), WEFT_ERR_WRITE);
    assert_non_null(strstr(test_message, "No space left on device"));

    int ends[2];
    char path[32], text[8] = "";
    assert_int_equal(pipe(ends), 0);
    snprintf(path, sizeof path, "/dev/fd/%d", ends[1]);
    assert_int_equal(write_text(path, false, "piped"), WEFT_OK);
    assert_int_equal(read(ends[0], text, sizeof text), 5);
    assert_string_equal(text, "piped");
    close(ends[0]);
    close(ends[1]);
}

// What is redirected to a file goes on where the file stands.
static void test_descriptor_of_a_file(void **state)
{
    (void)state;
    char path[32];
    int fd = open(test_path("redirected"), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    assert_true(fd >= 0);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    assert_int_equal(write(fd, "a", 1), 1);
    assert_int_equal(write_text(path, false, "b"), WEFT_OK);
    assert_int_equal(write(fd, "c", 1), 1);
    close(fd);
    assert_content(test_path("redirected"), "abc");
}

static void test_save(void **state)
{
    (void)state;
    const char *path = test_path("saved");
    assert_int_equal(weft_file_save(&test_log, path, false, "one, long", 9), WEFT_OK);
    assert_int_equal(weft_file_save(&test_log, path, false, "two", 3), WEFT_OK);
    assert_content(path, "two");
    assert_int_equal(weft_file_save(&test_log, path, true, "three", 5), WEFT_ERR_WRITE);
    assert_content(path, "two");
    assert_int_equal(weft_file_save(&test_log, test_path("empty"), true, NULL, 0), WEFT_OK);
    assert_content(test_path("empty"), "");
    static const struct weft_bytes parts[] = {{"one, ", 5}, {NULL, 0}, {"two", 3}, {NULL, 1}};
    assert_int_equal(weft_file_save_parts(&test_log, path, false, parts, 3), WEFT_OK);
    assert_content(path, "one, two");
    assert_int_equal(weft_file_save_parts(&test_log, path, false, parts, 4), WEFT_ERR_ARGUMENT);
    assert_content(path, "one, two");
    assert_int_equal(weft_file_save_parts(&test_log, path, false, NULL, 0), WEFT_OK);
    assert_content(path, "");
    assert_int_equal(weft_file_save(&test_log, path, false, NULL, 1), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_file_save(&test_log, NULL, false, "x", 1), WEFT_ERR_ARGUMENT);
}

// What a signal handler removes is its own process's, not the parent's.
static void test_unfinished(void **state)
{
    (void)state;
    struct weft_output_file file;
    assert_int_equal(weft_output_file_create(NULL, test_path("gone"), false, &file), WEFT_OK);
    pid_t child = fork();
    if (child == 0) {
        weft_unfinished_discard();
        _exit(0);
    }
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_int_equal(test_count_entries(test_folder), names_only ? 3 : 2);
    weft_unfinished_discard();
    assert_int_equal(test_count_entries(test_folder), 2);
    weft_output_file_discard(&file);
    weft_unfinished_discard();
    assert_int_equal(write_text(test_path("kept"), false, "x"), WEFT_OK);
    weft_unfinished_discard();
    assert_content(test_path("kept"), "x");
}

static int use_names_only(void **state)
{
    names_only = true;
    return test_enter_folder(state);
}

static int leave_names_only(void **state)
{
    names_only = false;
    return test_leave_folder(state);
}

#define NAMED(name) cmocka_unit_test_setup_teardown(name, use_names_only, leave_names_only)
#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, test_enter_folder, test_leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_new_file),
        IN_FOLDER(test_replaced_file_keeps_permissions),
        IN_FOLDER(test_no_clobber),
        IN_FOLDER(test_no_clobber_of_a_late_comer),
        IN_FOLDER(test_discard_leaves_nothing),
        IN_FOLDER(test_links),
        IN_FOLDER(test_bad_targets),
        IN_FOLDER(test_read_only_target),
        IN_FOLDER(test_long_name),
        IN_FOLDER(test_devices_and_pipes),
        IN_FOLDER(test_descriptor_of_a_file),
        IN_FOLDER(test_save),
        IN_FOLDER(test_unfinished),
        NAMED(test_new_file),
        NAMED(test_replaced_file_keeps_permissions),
        NAMED(test_no_clobber),
        NAMED(test_no_clobber_of_a_late_comer),
        NAMED(test_discard_leaves_nothing),
        NAMED(test_long_name),
        NAMED(test_save),
        NAMED(test_unfinished),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
