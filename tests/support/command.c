// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/command.h"

#include <dirent.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

extern char **environ;

enum { MAX_VARIABLES = 8 };
static const char *variables[MAX_VARIABLES];
static int variable_count;
static char folder[] = "/tmp/weft-command-XXXXXX";
static char mark[64]; // in the environment of everything started here
static struct command_result last;

void command_environment(const char *variable)
{
    assert_true(variable_count < MAX_VARIABLES);
    variables[variable_count++] = variable;
}

static void pause_seconds(double seconds)
{
    struct timespec time = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&time, NULL);
}

static const char *input; // of the next run; NULL: none

void command_input(const char *path)
{
    input = path;
}

static pid_t start(const char *const *argv, int out, int err)
{
    char path[4096];
    if (argv[0][0] == '/')
        snprintf(path, sizeof path, "%s", argv[0]);
    else
        snprintf(path, sizeof path, "%s/%s", WEFT_BINARY_DIR, argv[0]);
    int count = 0;
    while (environ[count])
        count++;
    char **env = calloc((size_t)count + MAX_VARIABLES + 2, sizeof *env);
    assert_non_null(env);
    int at = 0;
    for (int i = 0; i < variable_count; i++) // the first of a name holds
        env[at++] = (char *)variables[i];
    env[at++] = mark;
    for (int i = 0; i < count; i++)
        env[at++] = environ[i];
    variable_count = 0;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, input ? input : "/dev/null", O_RDONLY, 0);
    input = NULL;
    posix_spawn_file_actions_adddup2(&actions, out, 1);
    posix_spawn_file_actions_adddup2(&actions, err, 2);
    pid_t pid = -1;
    assert_int_equal(posix_spawn(&pid, path, &actions, NULL, (char *const *)argv, env), 0);
    posix_spawn_file_actions_destroy(&actions);
    free(env);
    return pid;
}

static int exit_code(int status)
{
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static bool has_mark(const char *pid)
{
    char path[300], text[65536];
    snprintf(path, sizeof path, "/proc/%s/environ", pid);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t size = fd < 0 ? 0 : read(fd, text, sizeof text);
    if (fd >= 0)
        close(fd);
    return size > 0 && memmem(text, (size_t)size, mark, strlen(mark) + 1);
}

static int count_marked(void)
{
    int count = 0;
    DIR *proc = opendir("/proc");
    assert_non_null(proc);
    for (struct dirent *entry; (entry = readdir(proc));)
        count += entry->d_name[0] >= '1' && entry->d_name[0] <= '9' && has_mark(entry->d_name);
    closedir(proc);
    return count;
}

// Readers end when their socket closes; that may take a moment.
static void assert_no_orphan(void)
{
    for (int i = 0; i < 100 && count_marked(); i++)
        pause_seconds(0.05);
    assert_int_equal(count_marked(), 0);
}

static void read_back(FILE *file, char *text, size_t size)
{
    rewind(file);
    size_t count = fread(text, 1, size - 1, file);
    text[count] = 0;
    fclose(file);
}

void command_run_list(struct command_result *result, const char *const *argv)
{
    FILE *out = tmpfile(), *err = tmpfile();
    assert_non_null(out);
    assert_non_null(err);
    pid_t pid = start(argv, fileno(out), fileno(err));
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    result->code = exit_code(status);
    read_back(out, result->out, sizeof result->out);
    read_back(err, result->err, sizeof result->err);
    assert_no_orphan();
}

pid_t command_start(int out, int err, const char *const *argv)
{
    int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    pid_t pid = start(argv, out < 0 ? null : out, err < 0 ? null : err);
    close(null);
    return pid;
}

bool command_wait_for_programs(int count)
{
    for (int i = 0; i < 200; i++, pause_seconds(0.05))
        if (count_marked() >= count)
            return true;
    return false;
}

double command_signal(pid_t pid, int signal, int *status)
{
    struct timespec before, after;
    clock_gettime(CLOCK_MONOTONIC, &before);
    kill(pid, signal);
    assert_int_equal(waitpid(pid, status, 0), pid);
    clock_gettime(CLOCK_MONOTONIC, &after);
    assert_no_orphan();
    return (double)(after.tv_sec - before.tv_sec) + 1e-9 * (double)(after.tv_nsec - before.tv_nsec);
}

int command_interrupt(double seconds, int signal, const char *const *argv)
{
    pid_t pid = command_start(-1, -1, argv);
    pause_seconds(seconds);
    int status;
    bool ended = waitpid(pid, &status, WNOHANG) == pid;
    if (!ended)
        command_signal(pid, signal, &status);
    return ended ? -1 : exit_code(status);
}

int command_folder_size(void)
{
    int count = 0;
    DIR *dir = opendir(".");
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return count;
}

static void print_command(const char *const *argv, const struct command_result *result)
{
    for (int i = 0; argv[i]; i++)
        print_error("%s ", argv[i]);
    print_error("\nexit code %d\nstdout: %s\nstderr: %s\n", result->code, result->out, result->err);
}

void command_fails_list(const char *file, int line, int code, const char *text,
                        const char *const *argv)
{
    static const char start_of_line[] = "weft: error: ";
    int before = command_folder_size();
    command_run_list(&last, argv);
    const char *end = strchr(last.err, '\n');
    bool good = last.code == code && !last.out[0] &&
                strncmp(last.err, start_of_line, strlen(start_of_line)) == 0 && end && !end[1] &&
                strstr(last.err, text) && command_folder_size() == before;
    if (good)
        return;
    print_error("expected exit code %d and one line with \"%s\"\n", code, text);
    print_command(argv, &last);
    print_error("entries in the folder: %d before, %d after\n", before, command_folder_size());
    _fail(file, line);
}

const char *command_succeeds_list(const char *file, int line, const char *const *argv)
{
    command_run_list(&last, argv);
    if (last.code != 0) {
        print_command(argv, &last);
        _fail(file, line);
    }
    return last.out;
}

bool command_has_gl(void)
{
    static int known = -1;
    if (known < 0) {
        command_run(&last, "weft", "slice", "ml.vdb", "--size", "4x4", "--json");
        known = last.code != 5;
        if (!known)
            print_message("no GL context here: tests that need one are skipped\n%s", last.err);
    }
    return known;
}

char *command_read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char *data = malloc(*size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *size, file), *size);
    fclose(file);
    return data;
}

void command_write_file(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

int command_setup_folder(void **state)
{
    (void)state;
    snprintf(mark, sizeof mark, "WEFT_TEST_MARK=%ld.%ld", (long)getpid(), (long)time(NULL));
    // An allocation that is too large fails under AddressSanitizer as it does elsewhere.
    setenv("ASAN_OPTIONS", "allocator_may_return_null=1", 0);
    // What weft calibrate has left on this machine decides nothing here. Mesa keeps shaders there.
    setenv("XDG_CACHE_HOME", WEFT_BINARY_DIR "/cache", 1);
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

int command_setup(void **state)
{
    if (command_setup_folder(state) != 0)
        return -1;
    command_succeeds("make", "marschner-lobb", "-o", "ml.vdb", "--size", "32", "--voxel", "0.5");
    command_succeeds("make", "sphere", "-o", "sphere.vdb", "--size", "32");
    return 0;
}

static void remove_folder(const char *path)
{
    DIR *dir = opendir(path);
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char inner[600];
        snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 &&
            unlink(inner) != 0)
            remove_folder(inner);
    }
    if (dir)
        closedir(dir);
    rmdir(path);
}

int command_teardown(void **state)
{
    (void)state;
    if (chdir("/") != 0)
        return -1;
    remove_folder(folder);
    return 0;
}
