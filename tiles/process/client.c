// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/client.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/pidfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tiles/output/unfinished.h"

extern char **environ;

// What a reader that has hung up is given to end by itself, so that its exit code can be told.
#define GRACE_SECONDS 0.5

struct weft_reader {
    const struct weft_log *log;
    char *program, *path;
    struct weft_limits limits;
    pid_t pid;              // 0: reaped
    int pidfd;              // -1 where the kernel has none
    int socket;             // -1: closed
    int answer_fd;          // of the question that has no answer yet; -1: there is none
    uint32_t op;            // of that question
    enum weft_result ended; // why no further call is possible; WEFT_OK while it lives
};

static void close_fd(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

// ---- finding and starting the program
// ------------------------------------------------------------

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
    char memory[24], output[24], cpu[24];
    snprintf(memory, sizeof memory, "%llu", (unsigned long long)reader->limits.memory_bytes);
    snprintf(output, sizeof output, "%llu", (unsigned long long)reader->limits.output_bytes);
    snprintf(cpu, sizeof cpu, "%u", reader->limits.cpu_seconds);
    char *argv[] = {reader->program, reader->path, memory, output, cpu, NULL};

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

// Above the descriptors 0 to 4, which the child's are copied over.
static int copy_above(int fd)
{
    return fcntl(fd, F_DUPFD_CLOEXEC, WEFT_WIRE_FD + 2);
}

enum weft_result weft_reader_start(const struct weft_log *log, const char *program,
                                   const char *path, int fd, const struct weft_limits *limits,
                                   weft_reader **out)
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
    close_fd(&pair[0]);
    close_fd(&pair[1]);
    close_fd(&theirs);
    close_fd(&file);
    weft_reader_stop(&reader);
    return res;
}

// ---- its end
// -------------------------------------------------------------------------------------

// With all that it may have started. Its number is its own until it is reaped; where somebody else
// may have done that, the descriptor knows.
static void kill_reader(const weft_reader *reader)
{
    if (!reader->pid)
        return;
    if (reader->pidfd < 0 || pidfd_send_signal(reader->pidfd, SIGKILL, NULL, 0) == 0)
        kill(-reader->pid, SIGKILL);
}

// false if somebody else reaped it (the caller ignores SIGCHLD, or waits for any child).
static bool reap(weft_reader *reader, int *status)
{
    pid_t got;
    if (!reader->pid)
        return false;
    weft_unfinished_remove_process(reader->pid);
    do
        got = waitpid(reader->pid, status, 0);
    while (got < 0 && errno == EINTR);
    reader->pid = 0;
    return got > 0;
}

void weft_reader_stop(weft_reader **reader)
{
    if (!reader || !*reader)
        return;
    int status;
    // Every answer has been given, so there is nothing to wait for.
    kill_reader(*reader);
    reap(*reader, &status);
    close_fd(&(*reader)->socket);
    close_fd(&(*reader)->pidfd);
    close_fd(&(*reader)->answer_fd);
    free((*reader)->program);
    free((*reader)->path);
    free(*reader);
    *reader = NULL;
}

static enum weft_result end_reader(weft_reader *reader, enum weft_result why)
{
    int status;
    kill_reader(reader);
    reap(reader, &status);
    close_fd(&reader->socket);
    reader->ended = why;
    return why;
}

static const char *doing(uint32_t op)
{
    switch (op) {
    case WEFT_WIRE_LIST:
        return "listing";
    case WEFT_WIRE_FIND:
        return "searching";
    case WEFT_WIRE_READ:
    case WEFT_WIRE_IMAGE_PIXELS:
        return "reading";
    case WEFT_WIRE_WRITE:
        return "writing";
    default:
        return "opening";
    }
}

// Whether the process ends within the grace; where its descriptor cannot tell, time alone does.
static bool ends_by_itself(const weft_reader *reader)
{
    struct pollfd polled = {.fd = reader->pidfd, .events = POLLIN};
    double end = weft_now_seconds() + GRACE_SECONDS;
    for (double left = GRACE_SECONDS; left > 0; left = end - weft_now_seconds())
        if (poll(&polled, 1, (int)(left * 1e3) + 1) > 0)
            return true;
    return reader->pidfd < 0;
}

// What the reader's limit is, which the caller's own may lie below.
static unsigned long long limit_in_force(int resource, uint64_t asked)
{
    struct rlimit own;
    if (getrlimit(resource, &own) == 0 && own.rlim_cur != RLIM_INFINITY && own.rlim_cur < asked)
        return (unsigned long long)own.rlim_cur;
    return (unsigned long long)asked;
}

static enum weft_result report_signal(const weft_reader *reader, int signal, uint32_t op)
{
    const struct weft_log *log = reader->log;
    const char *program = reader->program, *path = reader->path;
    switch (signal) {
    case SIGXCPU:
        weft_error(log, "%s: %s used more than the limit of %llu s of processor time while %s",
                   path, program, limit_in_force(RLIMIT_CPU, reader->limits.cpu_seconds),
                   doing(op));
        return WEFT_ERR_LIMIT;
    case SIGXFSZ:
        weft_error(log, "%s: %s put out more than the limit of %llu bytes while %s", path, program,
                   limit_in_force(RLIMIT_FSIZE, reader->limits.output_bytes), doing(op));
        return WEFT_ERR_LIMIT;
    default:
        weft_error(log, "%s was killed by signal %d (%s) while %s %s", program, signal,
                   strsignal(signal), doing(op), path);
        return WEFT_ERR_READER;
    }
}

// The reader hung up: reap it and say what became of it.
static enum weft_result report_death(weft_reader *reader, uint32_t op)
{
    const struct weft_log *log = reader->log;
    const char *program = reader->program, *path = reader->path;
    int status = 0;
    enum weft_result res = WEFT_ERR_READER;
    bool ended = ends_by_itself(reader);
    kill_reader(reader); // it may hang up and live on, which is as good as dead
    bool known = reap(reader, &status);
    if (!ended)
        weft_error(log, "%s hung up while %s %s, and had to be killed", program, doing(op), path);
    else if (!known)
        weft_error(log, "%s ended while %s %s", program, doing(op), path);
    else if (WIFSIGNALED(status))
        res = report_signal(reader, WTERMSIG(status), op);
    else
        weft_error(log, "%s ended with exit code %d while %s %s", program, WEXITSTATUS(status),
                   doing(op), path);
    return end_reader(reader, res);
}

static enum weft_result protocol_error(weft_reader *reader, uint32_t op, const char *what)
{
    weft_error(reader->log, "%s broke its protocol while %s %s: %s", reader->program, doing(op),
               reader->path, what);
    return end_reader(reader, WEFT_ERR_READER);
}

// ---- one question, one answer
// --------------------------------------------------------------------

static int make_memfd(const char *name)
{
    return memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
}

static bool write_all(int fd, const void *data, size_t size)
{
    const char *from = data;
    while (size) {
        ssize_t written = write(fd, from, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        from += written;
        size -= (size_t)written;
    }
    return true;
}

// The request, with the answer's memfd and the request's (or -1) attached.
static bool send_request(int socket, const struct weft_wire_request *request, const int fds[2])
{
    size_t count = fds[1] < 0 ? 1 : 2;
    union {
        char bytes[CMSG_SPACE(2 * sizeof(int))];
        struct cmsghdr align;
    } control = {{0}};
    struct iovec part = {(void *)(uintptr_t)request, sizeof *request};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = CMSG_SPACE(count * sizeof(int))};
    struct cmsghdr *header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(count * sizeof(int));
    memcpy(CMSG_DATA(header), fds, count * sizeof(int));
    ssize_t sent;
    do
        sent = sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    while (sent < 0 && errno == EINTR);
    return sent == (ssize_t)sizeof *request;
}

enum arrival { ARRIVED, DIED, LATE };

// Waits until the socket has something, or the reader is gone, or the time is over. A process that
// was forked off elsewhere may hold the reader's end of the socket, so its death is watched as
// well.
static enum arrival wait_for_answer(const weft_reader *reader)
{
    double end = weft_now_seconds() + reader->limits.wall_seconds;
    for (;;) {
        struct pollfd polled[] = {{.fd = reader->socket, .events = POLLIN},
                                  {.fd = reader->pidfd, .events = POLLIN}};
        double left = end - weft_now_seconds();
        if (left <= 0)
            return LATE;
        int n = poll(polled, WEFT_COUNT(polled), left > 1e6 ? INT_MAX : (int)(left * 1e3) + 1);
        if (n <= 0)
            continue;
        if (polled[0].revents & POLLIN)
            return ARRIVED;
        if (polled[0].revents || polled[1].revents) {
            // An answer sent just before the end still counts.
            return poll(polled, 1, 0) > 0 && polled[0].revents & POLLIN ? ARRIVED : DIED;
        }
    }
}

static bool known_result(int32_t result)
{
    static const enum weft_result all[] = {WEFT_OK,         WEFT_ERR_ARGUMENT, WEFT_ERR_UNSUPPORTED,
                                           WEFT_ERR_LIMIT,  WEFT_ERR_MEMORY,   WEFT_ERR_OPEN,
                                           WEFT_ERR_FORMAT, WEFT_ERR_READER,   WEFT_ERR_WRITE};
    for (size_t i = 0; i < WEFT_COUNT(all); i++)
        if (result == (int32_t)all[i])
            return true;
    return false;
}

static enum weft_result receive_answer(weft_reader *reader, uint32_t op,
                                       struct weft_wire_answer *answer)
{
    switch (wait_for_answer(reader)) {
    case DIED:
        return report_death(reader, op);
    case LATE:
        weft_error(reader->log, "%s: %s did not answer within the limit of %u s while %s",
                   reader->path, reader->program, reader->limits.wall_seconds, doing(op));
        return end_reader(reader, WEFT_ERR_LIMIT);
    case ARRIVED:
        break;
    }
    ssize_t size;
    do
        size = recv(reader->socket, answer, sizeof *answer, MSG_DONTWAIT | MSG_TRUNC);
    while (size < 0 && errno == EINTR);
    if (size <= 0)
        return report_death(reader, op);
    if (size != (ssize_t)sizeof *answer)
        return protocol_error(reader, op, "the answer has the wrong size");
    if (answer->magic != WEFT_WIRE_MAGIC || answer->version != WEFT_WIRE_VERSION)
        return protocol_error(reader, op, "it speaks another version");
    if (!known_result(answer->result))
        return protocol_error(reader, op, "unknown result");
    if (!memchr(answer->message, 0, sizeof answer->message))
        return protocol_error(reader, op, "endless message");
    return WEFT_OK;
}

// Sealed first and measured then, so that the reader cannot change it between the two.
static enum weft_result map_payload(weft_reader *reader, uint32_t op, int fd, uint64_t size,
                                    struct weft_payload *payload)
{
    struct stat stat;
    if (fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL))
        return protocol_error(reader, op, "its answer cannot be sealed");
    if (fstat(fd, &stat) || (uint64_t)stat.st_size != size)
        return protocol_error(reader, op, "the data has another size than announced");
    if (size > reader->limits.output_bytes)
        return protocol_error(reader, op, "the data exceeds the output limit");
    if (!size)
        return WEFT_OK;
    void *data = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED) {
        weft_error(reader->log, "%s: cannot map %llu bytes: %s", reader->path,
                   (unsigned long long)size, strerror(errno));
        return WEFT_ERR_MEMORY;
    }
    *payload = (struct weft_payload){data, size};
    return WEFT_OK;
}

void weft_reader_set_log(weft_reader *reader, const struct weft_log *log)
{
    reader->log = log;
}

enum weft_result weft_reader_ask(weft_reader *reader, const struct weft_wire_request *request,
                                 const struct iovec *parts, int part_count)
{
    enum weft_result res = WEFT_ERR_MEMORY;
    struct weft_wire_request sent = *request;
    int fds[2] = {-1, -1};
    if (reader->ended) {
        weft_error(reader->log, "%s: %s has ended before", reader->path, reader->program);
        return reader->ended;
    }
    sent.magic = WEFT_WIRE_MAGIC;
    sent.version = WEFT_WIRE_VERSION;
    sent.payload_bytes = 0;
    fds[0] = make_memfd("weft-answer");
    if (fds[0] < 0 || (part_count && (fds[1] = make_memfd("weft-request")) < 0))
        goto fail;
    for (int i = 0; i < part_count; i++) {
        if (!write_all(fds[1], parts[i].iov_base, parts[i].iov_len))
            goto fail;
        sent.payload_bytes += parts[i].iov_len;
    }
    // A request that cannot be sent at once meets a dead reader, since there is one at a time.
    if (!send_request(reader->socket, &sent, fds)) {
        res = report_death(reader, sent.op);
        goto done;
    }
    reader->answer_fd = fds[0];
    reader->op = sent.op;
    fds[0] = -1;
    res = WEFT_OK;
    goto done;
fail:
    weft_error(reader->log, "%s: no shared memory for %s: %s", reader->path, reader->program,
               strerror(errno));
done:
    close_fd(&fds[0]);
    close_fd(&fds[1]);
    return res;
}

enum weft_result weft_reader_answer(weft_reader *reader, struct weft_wire_answer *answer,
                                    struct weft_payload *payload)
{
    *payload = (struct weft_payload){0};
    memset(answer, 0, sizeof *answer);
    enum weft_result res = receive_answer(reader, reader->op, answer);
    if (res)
        goto done;
    res = (enum weft_result)answer->result;
    if (res)
        weft_error(reader->log, "%s: %s", reader->path,
                   *answer->message ? answer->message : weft_result_text(res));
    else
        res = map_payload(reader, reader->op, reader->answer_fd, answer->payload_bytes, payload);
done:
    close_fd(&reader->answer_fd);
    return res;
}

enum weft_result weft_reader_call_parts(weft_reader *reader,
                                        const struct weft_wire_request *request,
                                        const struct iovec *parts, int part_count,
                                        struct weft_wire_answer *answer,
                                        struct weft_payload *payload)
{
    *payload = (struct weft_payload){0};
    memset(answer, 0, sizeof *answer);
    const enum weft_result res = weft_reader_ask(reader, request, parts, part_count);
    return res == WEFT_OK ? weft_reader_answer(reader, answer, payload) : res;
}

enum weft_result weft_reader_call(weft_reader *reader, const struct weft_wire_request *request,
                                  const void *request_payload, struct weft_wire_answer *answer,
                                  struct weft_payload *payload)
{
    struct iovec part = {(void *)(uintptr_t)request_payload, request->payload_bytes};
    return weft_reader_call_parts(reader, request, &part, part.iov_len ? 1 : 0, answer, payload);
}

void weft_payload_release(struct weft_payload *payload)
{
    if (payload->data)
        munmap((void *)(uintptr_t)payload->data, payload->size);
    *payload = (struct weft_payload){0};
}
