// SPDX-License-Identifier: BSD-3-Clause
// Preloaded: what goes wrong on one rank of weft. $WEFT_FAULT is "PHASE RANK ACTION":
// phase   read: a reader program is to be started; draw: the GL is to draw; write: a whole output
// is
//         to be put in place
// action  wait: writes the file "here" and sleeps, for who then sends a signal; exit: ends with
//         code 3; abort; refuse (read): the reader cannot be started
// Every rank writes its process into the file "rank.NUMBER".
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char phase[16], action[16];
static int rank = -1, faulty = -1;

static void write_file(const char *path, int number)
{
    char part[64];
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "w");
    if (file) {
        fprintf(file, "%d", number);
        fclose(file);
        rename(part, path);
    }
}

__attribute__((constructor)) static void begin(void)
{
    char program[4096] = "", path[32];
    const char *fault = getenv("WEFT_FAULT"), *number = getenv("PMI_RANK");
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    number = number ? number : getenv("OMPI_COMM_WORLD_RANK");
    if (!fault || !number || length < 0 || !strstr(program, "/weft-") ||
        strstr(program, "/weft-read") || sscanf(fault, "%15s %d %15s", phase, &faulty, action) != 3)
        return;
    rank = atoi(number);
    snprintf(path, sizeof path, "rank.%d", rank);
    write_file(path, getpid());
}

// Whether what was to be done is refused.
static bool fail_in(const char *where)
{
    if (rank < 0 || rank != faulty || strcmp(where, phase) != 0)
        return false;
    if (strcmp(action, "exit") == 0)
        exit(3);
    if (strcmp(action, "abort") == 0)
        abort();
    if (strcmp(action, "refuse") == 0)
        return true;
    write_file("here", getpid());
    for (;;)
        sleep(60);
}

int posix_spawn(pid_t *pid, const char *path, const posix_spawn_file_actions_t *actions,
                const posix_spawnattr_t *attributes, char *const argv[], char *const environment[])
{
    int (*const next)(pid_t *, const char *, const posix_spawn_file_actions_t *,
                      const posix_spawnattr_t *, char *const[], char *const[]) =
        dlsym(RTLD_NEXT, "posix_spawn");
    return fail_in("read") ? EACCES : next(pid, path, actions, attributes, argv, environment);
}

int linkat(int from_folder, const char *from, int folder, const char *path, int flags)
{
    int (*const next)(int, const char *, int, const char *, int) = dlsym(RTLD_NEXT, "linkat");
    fail_in("write");
    return next(from_folder, from, folder, path, flags);
}

// ---- the GL is loaded when it is needed, and its functions are asked for by name
// ------------------

typedef void (*gl_function)(void);
static gl_function (*find_function)(const char *name);
static void (*draw_arrays)(unsigned, int, int);
static void (*draw_elements)(unsigned, int, unsigned, const void *);

static void DrawArrays(unsigned mode, int first, int count)
{
    fail_in("draw");
    draw_arrays(mode, first, count);
}

static void DrawElements(unsigned mode, int count, unsigned type, const void *indices)
{
    fail_in("draw");
    draw_elements(mode, count, type, indices);
}

static gl_function find(const char *name)
{
    const gl_function found = find_function(name);
    if (found && strcmp(name, "glDrawArrays") == 0) {
        draw_arrays = (void (*)(unsigned, int, int))found;
        return (gl_function)DrawArrays;
    }
    if (found && strcmp(name, "glDrawElements") == 0) {
        draw_elements = (void (*)(unsigned, int, unsigned, const void *))found;
        return (gl_function)DrawElements;
    }
    return found;
}

void *dlsym(void *handle, const char *name)
{
    static void *(*next)(void *, const char *);
    if (!next)
        next = (void *(*)(void *, const char *))dlvsym(RTLD_NEXT, "dlsym", "GLIBC_2.2.5");
    void *found = next(handle, name);
    if (found && rank >= 0 && strcmp(name, "OSMesaGetProcAddress") == 0) {
        find_function = (gl_function(*)(const char *))found;
        return (void *)find;
    }
    return found;
}
