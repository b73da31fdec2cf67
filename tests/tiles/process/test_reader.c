// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/client.h"

#include <ctype.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cmocka.h>

#include "tests/support/vdb_files.h"
#include "tiles/volume/volume_wire.h"

#if defined(__SANITIZE_ADDRESS__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

// State letter and parent of a process; 0 if there is none.
static char process_state(pid_t pid, pid_t *parent)
{
    char path[64], line[512];
    snprintf(path, sizeof path, "/proc/%d/stat", (int)pid);
    FILE *file = fopen(path, "r");
    if (!file)
        return 0;
    char *end = fgets(line, sizeof line, file) ? strrchr(line, ')') : NULL;
    fclose(file);
    int ppid = 0;
    char state = 0;
    if (!end || sscanf(end + 1, " %c %d", &state, &ppid) != 2)
        return 0;
    *parent = ppid;
    return state;
}

static pid_t find_child(void)
{
    pid_t found = 0, parent;
    DIR *folder = opendir("/proc");
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        if (isdigit((unsigned char)*entry->d_name) && process_state(atoi(entry->d_name), &parent) &&
            parent == getpid())
            found = atoi(entry->d_name);
    if (folder)
        closedir(folder);
    return found;
}

static const char *sphere_path(void)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/sphere.vdb", test_folder);
    return path;
}

static int make_files(void **state)
{
    if (make_folder(state))
        return -1;
    weft_volume *sphere = make_sphere(50, (int32_t[3]){0}, NULL);
    struct weft_volume_save_params params = {.path = sphere_path(), .log = &test_log};
    enum weft_result res = weft_volume_save(sphere, &params);
    weft_volume_destroy(&sphere);
    if (res)
        print_message("%s\n", last_error.message);
    return res ? -1 : 0;
}

static enum weft_result open_limited(const char *path, struct weft_limits limits,
                                     weft_volume **volume)
{
    struct weft_volume_open_params params = {.path = path, .limits = limits, .log = &test_log};
    *last_error.message = 0;
    return weft_volume_open(&params, volume);
}

static weft_volume *open_sphere(struct weft_limits limits)
{
    weft_volume *volume = NULL;
    enum weft_result res = open_limited(sphere_path(), limits, &volume);
    if (res)
        print_message("%s\n", last_error.message);
    assert_int_equal(res, WEFT_OK);
    return volume;
}

static void assert_message(const char *part)
{
    if (!strstr(last_error.message, part))
        fail_msg("'%s' lacks '%s'", last_error.message, part);
}

static enum weft_result find_all(weft_volume *volume)
{
    struct weft_brick_list list;
    *last_error.message = 0;
    enum weft_result res = weft_volume_find(volume, &everywhere, &list);
    weft_brick_list_clear(&list);
    return res;
}

static void test_signals(void **state)
{
    (void)state;
    static const struct {
        int signal;
        enum weft_result result;
        const char *message;
    } cases[] = {{SIGKILL, WEFT_ERR_READER, "killed by signal 9 (Killed) while searching"},
                 {SIGSEGV, WEFT_ERR_READER, "weft-read-vdb"},
                 {SIGXCPU, WEFT_ERR_LIMIT, "limit of 600 s of processor time"},
                 {SIGXFSZ, WEFT_ERR_LIMIT, "limit of 4294967296 bytes"}};
    int fds = count_fds();
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_volume *volume = open_sphere((struct weft_limits){0});
        pid_t reader = find_child();
        assert_true(reader > 0);
        kill(reader, cases[i].signal);
        assert_int_equal(find_all(volume), cases[i].result);
        assert_message(cases[i].message);
        assert_message("sphere.vdb");
        assert_int_equal(find_all(volume), cases[i].result);
        assert_message("has ended before");
        weft_volume_destroy(&volume);
        assert_int_equal(find_child(), 0);
    }
    assert_int_equal(count_fds(), fds);
}

static void test_killed_during_call(void **state)
{
    (void)state;
    weft_volume *volume = open_sphere((struct weft_limits){0});
    pid_t reader = find_child();
    kill(reader, SIGSTOP);
    pid_t killer = fork();
    if (killer == 0) {
        usleep(300000);
        kill(reader, SIGKILL);
        _exit(0);
    }
    assert_int_equal(find_all(volume), WEFT_ERR_READER);
    assert_message("killed by signal 9");
    assert_int_equal(waitpid(killer, NULL, 0), killer);
    weft_volume_destroy(&volume);
}

static void test_wall_limit(void **state)
{
    (void)state;
    weft_volume *volume = open_sphere((struct weft_limits){.wall_seconds = 1});
    kill(find_child(), SIGSTOP);
    assert_int_equal(find_all(volume), WEFT_ERR_LIMIT);
    assert_message("within the limit of 1 s");
    assert_int_equal(find_child(), 0);
    weft_volume_destroy(&volume);
}

static void test_output_limit(void **state)
{
    (void)state;
    float values[512];
    struct weft_brick_list list;
    weft_volume *volume = open_sphere((struct weft_limits){.output_bytes = 20000});
    struct weft_region small = {{40, -10, -10}, {60, 10, 10}, 0, {{{0}, 0, 0}}};
    assert_int_equal(find_all(volume), WEFT_ERR_LIMIT);
    assert_message("output limit is 20000");
    assert_int_equal(weft_volume_find(volume, &small, &list), WEFT_OK);
    assert_true(list.brick_count > 0);
    const int32_t(*origin)[3] = (const int32_t(*)[3])list.brick_origin;
    assert_int_equal(weft_volume_read(volume, 1, origin, values), WEFT_OK);
    weft_volume_destroy(&volume);
    // The description of the grid alone is longer than this.
    assert_int_equal(
        open_limited(sphere_path(), (struct weft_limits){.output_bytes = 100}, &volume),
        WEFT_ERR_LIMIT);
    assert_message("output limit is 100");
    weft_brick_list_clear(&list);
}

static void test_memory_limit(void **state)
{
    (void)state;
    if (SANITIZED)
        skip();
    weft_volume *volume = NULL;
    struct weft_limits limits = {.memory_bytes = 16 << 20};
    assert_int_equal(open_limited(sphere_path(), limits, &volume), WEFT_ERR_LIMIT);
    assert_message("16777216");
}

static void test_missing_program(void **state)
{
    (void)state;
    weft_volume *volume = NULL;
    setenv("WEFT_LIBEXEC", "/nonexistent", 1);
    assert_int_equal(open_limited(sphere_path(), (struct weft_limits){0}, &volume),
                     WEFT_ERR_READER);
    assert_message("weft-read-vdb is not in /nonexistent");
    // Beside the test there may or may not be readers; a clear answer is due either way.
    setenv("WEFT_LIBEXEC", "", 1);
    enum weft_result res = open_limited(sphere_path(), (struct weft_limits){0}, &volume);
    assert_true(res == WEFT_OK || res == WEFT_ERR_READER);
    weft_volume_destroy(&volume);
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
}

// Of the number in the file "child": it has ended, and may wait for whoever inherited it.
static void assert_child_is_gone(void)
{
    FILE *file = fopen(file_path("child"), "r");
    int child = 0;
    pid_t parent;
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%d", &child), 1);
    fclose(file);
    char now = 'R';
    for (int i = 0; i < 100 && now && now != 'Z'; i++, usleep(20000))
        now = process_state(child, &parent);
    assert_true(now == 0 || now == 'Z');
}

// The limit that is told is the one that held, which may be the caller's own.
static void test_limit_in_force(void **state)
{
    (void)state;
    struct rlimit old, low;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    low = old;
    low.rlim_cur = 4000;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &low), 0);
    weft_volume *volume = open_sphere((struct weft_limits){0});
    enum weft_result found = find_all(volume);
    char answer[1024];
    snprintf(answer, sizeof answer, "%s", last_error.message);
    weft_volume_destroy(&volume);
    volume = open_sphere((struct weft_limits){0});
    kill(find_child(), SIGXFSZ);
    enum weft_result killed = find_all(volume);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_int_equal(killed, WEFT_ERR_LIMIT);
    assert_message("limit of 4000 bytes");
    assert_int_equal(found, WEFT_ERR_LIMIT);
    assert_non_null(strstr(answer, "output limit is 4000"));
    weft_volume_destroy(&volume);
}

// Programs that are no readers.
static void test_impostors(void **state)
{
    (void)state;
    static const struct {
        const char *script, *message;
    } cases[] = {{"exit 7", "exit code 7"},
                 {"exec 3>&-; sleep 0.1; exit 99", "exit code 99"},
                 {"exec 3>&-; kill -TERM $$; sleep 9", "killed by signal 15"},
                 {"printf garbage >&3; sleep 100", "wrong size"},
                 {"exec 3>&-; exec sleep 100", "hung up while opening"},
                 {"sleep 99 & echo $! >child; printf garbage >&3; sleep 100", "wrong size"},
                 {"head -c 568 /dev/zero >&3; sleep 100", "weft-read-vdb"}};
    int fds = count_fds();
    char path[512];
    snprintf(path, sizeof path, "%s/weft-read-vdb", test_folder);
    setenv("WEFT_LIBEXEC", test_folder, 1);
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fprintf(file, "#!/bin/sh\ncd %s\n%s\n", test_folder, cases[i].script);
        fclose(file);
        chmod(path, 0755);
        weft_volume *volume = NULL;
        assert_int_equal(
            open_limited(sphere_path(), (struct weft_limits){.wall_seconds = 5}, &volume),
            WEFT_ERR_READER);
        assert_message(cases[i].message);
        assert_null(volume);
    }
    assert_child_is_gone();
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    assert_int_equal(count_fds(), fds);
}

static void test_damaged_files(void **state)
{
    (void)state;
    struct stat stat_buffer;
    assert_int_equal(stat(sphere_path(), &stat_buffer), 0);
    size_t size = (size_t)stat_buffer.st_size;
    char *data = malloc(size);
    assert_non_null(data);
    FILE *file = fopen(sphere_path(), "rb");
    assert_non_null(file);
    assert_int_equal(fread(data, 1, size, file), size);
    fclose(file);
    int fds = count_fds();
    char path[512];
    snprintf(path, sizeof path, "%s/damaged.vdb", test_folder);
    const size_t lengths[] = {0, 1, 7, 8, 20, 60, 100, 200, 1000, size / 2, size - 1};
    for (size_t i = 0; i <= WEFT_COUNT(lengths); i++) {
        bool random = i == WEFT_COUNT(lengths);
        size_t length = random ? size : lengths[i];
        for (size_t n = 0; random && n < size; n++)
            data[n] = (char)rand();
        file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(data, 1, length, file), length);
        fclose(file);
        weft_volume *volume = NULL;
        assert_int_equal(open_limited(path, (struct weft_limits){0}, &volume), WEFT_ERR_FORMAT);
        assert_message("damaged.vdb: ");
    }
    free(data);
    assert_int_equal(count_fds(), fds);
}

static void test_no_orphan(void **state)
{
    (void)state;
    int ends[2];
    pid_t reader = 0, parent;
    assert_int_equal(pipe(ends), 0);
    pid_t caller = fork();
    if (caller == 0) {
        weft_volume *volume = open_sphere((struct weft_limits){0});
        reader = volume ? find_child() : 0;
        if (write(ends[1], &reader, sizeof reader) < 0)
            _exit(1);
        pause();
        _exit(0);
    }
    assert_int_equal(read(ends[0], &reader, sizeof reader), sizeof reader);
    assert_true(reader > 0 && process_state(reader, &parent));
    kill(caller, SIGKILL);
    assert_int_equal(waitpid(caller, NULL, 0), caller);
    char now = 'R';
    for (int i = 0; i < 100 && now && now != 'Z'; i++) {
        usleep(50000);
        now = process_state(reader, &parent);
    }
    // Whoever inherited it may not have reaped it yet.
    assert_true(now == 0 || now == 'Z');
    close(ends[0]);
    close(ends[1]);
}

// Begins to open a file; the texts are gone afterwards.
static weft_volume_opening *begin(const char *path)
{
    char copy[512];
    weft_volume_opening *opening = NULL;
    const struct weft_volume_open_params params = {.path = copy, .log = &test_log};
    snprintf(copy, sizeof copy, "%s", path);
    *last_error.message = 0;
    assert_int_equal(weft_volume_begin(&params, &opening), WEFT_OK);
    memset(copy, 'x', sizeof copy);
    assert_string_equal(last_error.message, "");
    return opening;
}

static void test_begun(void **state)
{
    (void)state;
    const int fds = count_fds();
    weft_volume *volume = NULL;
    weft_volume_opening *opening = begin(sphere_path());
    assert_true(find_child() != 0);
    assert_int_equal(weft_volume_await(&opening, &volume), WEFT_OK);
    assert_null(opening);
    assert_int_equal(find_all(volume), WEFT_OK);
    weft_volume_destroy(&volume);

    // What fails is told when it is awaited, in the words of weft_volume_open.
    opening = begin("/nonexistent.vdb");
    assert_int_equal(weft_volume_await(&opening, &volume), WEFT_ERR_OPEN);
    assert_message("cannot open /nonexistent.vdb");
    assert_null(volume);
    opening = begin(sphere_path());
    kill(find_child(), SIGKILL);
    assert_int_equal(weft_volume_await(&opening, &volume), WEFT_ERR_READER);
    assert_message("killed by signal 9");
    assert_null(volume);

    // What nobody waits for leaves nothing behind.
    opening = begin(sphere_path());
    weft_volume_abandon(&opening);
    assert_null(opening);
    opening = begin("/nonexistent.vdb");
    weft_volume_abandon(&opening);
    assert_int_equal(count_fds(), fds);
    assert_int_equal(find_child(), 0);
}

static void test_nothing_left_open(void **state)
{
    (void)state;
    int fds = count_fds();
    for (int i = 0; i < 5; i++) {
        weft_volume *volume = open_sphere((struct weft_limits){0});
        assert_int_equal(find_all(volume), WEFT_OK);
        weft_volume_destroy(&volume);
        assert_null(volume);
    }
    assert_int_equal(count_fds(), fds);
    assert_int_equal(find_child(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_signals),         cmocka_unit_test(test_killed_during_call),
        cmocka_unit_test(test_wall_limit),      cmocka_unit_test(test_limit_in_force),
        cmocka_unit_test(test_output_limit),    cmocka_unit_test(test_memory_limit),
        cmocka_unit_test(test_missing_program), cmocka_unit_test(test_impostors),
        cmocka_unit_test(test_damaged_files),   cmocka_unit_test(test_no_orphan),
        cmocka_unit_test(test_begun),           cmocka_unit_test(test_nothing_left_open),
    };
    return cmocka_run_group_tests(tests, make_files, remove_folder);
}
