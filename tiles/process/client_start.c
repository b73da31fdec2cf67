// SPDX-License-Identifier: BSD-3-Clause
// Finding and starting reader programs, and opening what they read.
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/pidfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tiles/output/unfinished.h"
#include "tiles/process/client_impl.h"

extern char **environ;

// ---- finding ------------------------------------------------------------------------------------

static bool folder_of(const char *file, char *out)
{
    if (!realpath(file, out))
        return false;
    char *slash = strrchr(out, '/');
    if (!slash)
        return false;
    *slash = 0;
    return true;
}

// The folder of the module that holds this function. For a program that links the library
// statically dladdr knows only argv[0], which may be relative to a folder that was left long ago.
static bool own_folder(char *out)
{
    Dl_info own, program;
    bool found = dladdr((void *)(uintptr_t)&own_folder, &own) != 0;
    bool in_program =
        found && dladdr((void *)getauxval(AT_PHDR), &program) && own.dli_fbase == program.dli_fbase;
    if (!found || in_program)
        return folder_of("/proc/self/exe", out);
    return folder_of(own.dli_fname, out);
}

static bool runnable(const char *folder, const char *program, char *out)
{
    int length = snprintf(out, PATH_MAX, "%s/%s", folder, program);
    return length > 0 && length < PATH_MAX && access(out, X_OK) == 0;
}

static enum weft_result find_program(const struct weft_log *log, const char *program, char *out)
{
    const char *forced = secure_getenv("WEFT_LIBEXEC");
    if (forced && *forced) {
        if (runnable(forced, program, out))
            return WEFT_OK;
        weft_error(log, "the reader %s is not in %s (WEFT_LIBEXEC)", program, forced);
        return WEFT_ERR_READER;
    }
    // Beside us in the build tree; where an installed tree that was moved has it; where it was
    // configured to be.
    char folder[PATH_MAX] = "", moved[2 * PATH_MAX];
    bool known = own_folder(folder);
    snprintf(moved, sizeof moved, "%s/" WEFT_LIBEXEC_FROM_LIB, folder);
    if ((known && (runnable(folder, program, out) || runnable(moved, program, out))) ||
        runnable(WEFT_LIBEXEC_DIR, program, out))
        return WEFT_OK;
    weft_error(log, "the reader %s is neither in %s nor in %s", program,
               known ? folder : "(unknown folder of libweft)", WEFT_LIBEXEC_DIR);
    return WEFT_ERR_READER;
}

// ---- opening ----------------------------------------------------------------------------------

enum weft_result weft_reader_open(const struct weft_log *log, const char *path, int *out)
{
    struct stat st;
    // Without O_NONBLOCK a pipe would wait for a writer.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0 || fstat(fd, &st)) {
        weft_error(log, "cannot open %s: %s", path, strerror(errno));
    } else if (S_ISDIR(st.st_mode)) {
        weft_error(log, "cannot open %s: %s", path, strerror(EISDIR));
    } else if (!S_ISREG(st.st_mode)) {
        weft_error(log, "cannot open %s: not a regular file", path);
    } else if (st.st_size == 0) {
        weft_error(log, "%s: the file is empty", path);
        close(fd);
        return WEFT_ERR_FORMAT;
    } else {
        *out = fd;
        return WEFT_OK;
    }
    if (fd >= 0)
        close(fd);
    return WEFT_ERR_OPEN;
}

// ---- starting -----------------------------------------------------------------------------------

// Input and output are shut off; the error stream too, since decoders write about damaged files
// what they like. WEFT_READER_DEBUG keeps it, for sanitizers and for debugging.
static int add_actions(posix_spawn_file_actions_t *actions, int socket, int fd)
{
    const char *debug = secure_getenv("WEFT_READER_DEBUG");
    int error = posix_spawn_file_actions_addopen(actions, 0, "/dev/null", O_RDONLY, 0);
    if (!error)
        error = posix_spawn_file_actions_addopen(actions, 1, "/dev/null", O_WRONLY, 0);
    if (!error && !(debug && *debug))
        error = posix_spawn_file_actions_addopen(actions, 2, "/dev/null", O_WRONLY, 0);
    if (!error)
        error = posix_spawn_file_actions_adddup2(actions, socket, WEFT_WIRE_FD);
    if (!error)
        error = posix_spawn_file_actions_adddup2(actions, fd, WEFT_WIRE_FD + 1);
    if (!error)
        error = posix_spawn_file_actions_addclosefrom_np(actions, WEFT_WIRE_FD + 2);
    return error;
}

// Its own process group, so that Ctrl-C reaches the caller alone; the reader sees the hang-up.
static int set_attributes(posix_spawnattr_t *attributes)
{
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(attributes, &none);
    posix_spawnattr_setsigdefault(attributes, &all);
    posix_spawnattr_setpgroup(attributes, 0);
    return posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                    POSIX_SPAWN_SETPGROUP);
}

// No signal comes between the start and the moment from which a handler finds the process.
static int spawn_known(weft_reader *reader, const char *file,
                       const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const *argv)
{
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    int error = posix_spawn(&reader->pid, file, actions, attributes, argv, environ);
    if (error)
        reader->pid = 0;
    else
        weft_unfinished_add_process(reader->pid);
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    return error;
}

static int spawn(weft_reader *reader, const char *file, int socket, int fd)
{
    char memory[24], output[24], cpu[24], files[24];
    snprintf(memory, sizeof memory, "%llu", (unsigned long long)reader->limits.memory_bytes);
    snprintf(output, sizeof output, "%llu", (unsigned long long)reader->limits.output_bytes);
    snprintf(cpu, sizeof cpu, "%u", reader->limits.cpu_seconds);
    snprintf(files, sizeof files, "%u", reader->files);
    char *argv[] = {reader->program, reader->path, memory, output, cpu, files, NULL};

    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    int error = posix_spawn_file_actions_init(&actions);
    if (error)
        return error;
    error = posix_spawnattr_init(&attributes);
    if (!error) {
        error = add_actions(&actions, socket, fd);
        if (!error)
            error = set_attributes(&attributes);
        if (!error)
            error = spawn_known(reader, file, &actions, &attributes, argv);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&actions);
    return error;
}

static struct weft_limits with_defaults(const struct weft_limits *limits)
{
    struct weft_limits all = limits ? *limits : (struct weft_limits){0};
    if (!all.memory_bytes)
        all.memory_bytes = UINT64_C(4) << 30;
    if (!all.output_bytes)
        all.output_bytes = UINT64_C(4) << 30;
    if (!all.cpu_seconds)
        all.cpu_seconds = 600;
    if (!all.wall_seconds)
        all.wall_seconds = 300;
    return all;
}

struct weft_limits weft_reader_limits(const struct weft_limits *limits, uint64_t file_bytes)
{
    const uint64_t most = UINT64_C(4) << 30, least = UINT64_C(256) << 20;
    struct weft_limits out = *limits;
    if (!out.memory_bytes)
        out.memory_bytes = file_bytes < (most - least) / 256 ? least + 256 * file_bytes : most;
    return out;
}

// Above the descriptors 0 to 4, which the child's are copied over.
static int copy_above(int fd)
{
    return fcntl(fd, F_DUPFD_CLOEXEC, WEFT_WIRE_FD + 2);
}

enum weft_result weft_reader_start_for(const struct weft_log *log, const char *program,
                                       const char *path, int fd, const struct weft_limits *limits,
                                       uint32_t files, weft_reader **out)
{
    *out = NULL;
    weft_reader *reader = NULL;
    int pair[2] = {-1, -1}, theirs = -1, file = -1, error;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, program && path && fd >= 0);

    res = WEFT_ERR_MEMORY;
    reader = calloc(1, sizeof *reader);
    if (!reader)
        goto fail;
    reader->pidfd = reader->socket = reader->answer_fd = -1;
    reader->log = log;
    reader->files = files;
    reader->limits = with_defaults(limits);
    reader->program = strdup(program);
    reader->path = strdup(path);
    if (!reader->program || !reader->path)
        goto fail;

    char name[PATH_MAX];
    res = find_program(log, program, name);
    if (res)
        goto fail;
    res = WEFT_ERR_READER;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) ||
        (theirs = copy_above(pair[1])) < 0 || (file = copy_above(fd)) < 0) {
        weft_error(log, "cannot connect to %s: %s", program, strerror(errno));
        goto fail;
    }
    error = spawn(reader, name, theirs, file);
    if (error) {
        weft_error(log, "cannot start %s: %s", name, strerror(error));
        goto fail;
    }
    reader->pidfd = pidfd_open(reader->pid, 0);
    reader->socket = pair[0];
    pair[0] = -1;
    *out = reader;
    reader = NULL;
    res = WEFT_OK;
fail:
    if (res == WEFT_ERR_MEMORY)
        weft_error(log, "cannot start %s: out of memory", program);
    weft_close_fd(&pair[0]);
    weft_close_fd(&pair[1]);
    weft_close_fd(&theirs);
    weft_close_fd(&file);
    weft_reader_stop(&reader);
    return res;
}

enum weft_result weft_reader_start(const struct weft_log *log, const char *program,
                                   const char *path, int fd, const struct weft_limits *limits,
                                   weft_reader **out)
{
    return weft_reader_start_for(log, program, path, fd, limits, 1, out);
}
