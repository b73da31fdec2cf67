// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/server.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

// Exit codes; the caller's log shows them.
enum { EXIT_USAGE = 2, EXIT_PROTOCOL = 3, EXIT_SETUP = 4 };

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif
#else
enum { SANITIZED = 0 };
#endif

bool weft_server_append(struct weft_server *server, const void *data, size_t size)
{
    struct weft_wire_answer *answer = &server->answer;
    const char *from = data;
    if (size > server->limits.output_bytes - answer->payload_bytes) {
        weft_server_fail(server, WEFT_ERR_LIMIT,
                         "the answer has more than %llu bytes, the output limit is %llu",
                         (unsigned long long)(answer->payload_bytes + size - 1),
                         (unsigned long long)server->limits.output_bytes);
        return false;
    }
    while (size) {
        ssize_t written = write(server->payload_fd, from, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) {
            weft_server_fail(server, WEFT_ERR_MEMORY, "no shared memory for the answer: %s",
                             strerror(errno));
            return false;
        }
        from += written;
        size -= (size_t)written;
        answer->payload_bytes += (uint64_t)written;
    }
    return true;
}

// The caller's and ours since an earlier request; what lay there must not show through.
static void *use_room(struct weft_server *server, size_t size)
{
    const struct weft_server_room *room = &server->room[server->request->room];
    server->answer.payload_bytes = size;
    if (size <= room->size)
        return memset(room->data, 0, size);
    server->answer.payload_bytes = 0;
    server->answer.verdict = WEFT_WIRE_NO_ROOM;
    server->answer.count[0] = size;
    return NULL;
}

void *weft_server_map(struct weft_server *server, size_t size)
{
    if (size > server->limits.output_bytes) {
        weft_server_fail(server, WEFT_ERR_LIMIT,
                         "the answer has %zu bytes, the output limit is %llu", size,
                         (unsigned long long)server->limits.output_bytes);
        return NULL;
    }
    if (server->payload_fd < 0)
        return use_room(server, size);
    void *map = ftruncate(server->payload_fd, (off_t)size)
                    ? MAP_FAILED
                    : mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, server->payload_fd, 0);
    if (map == MAP_FAILED) {
        weft_server_fail(server, WEFT_ERR_LIMIT,
                         "%zu bytes of the answer do not fit in the memory limit of %llu bytes: %s",
                         size, (unsigned long long)server->limits.memory_bytes, strerror(errno));
        return NULL;
    }
    server->answer.payload_bytes = size;
    server->payload_map = map;
    return map;
}

enum weft_result weft_server_fail(struct weft_server *server, enum weft_result result,
                                  const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(server->answer.message, sizeof server->answer.message, format, args);
    va_end(args);
    server->answer.result = (int32_t)result;
    return result;
}

static bool parse(const char *text, uint64_t *out)
{
    char *end;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return *text >= '0' && *text <= '9' && !*end && !errno;
}

// Lowers limits only: those that the caller has are somebody's wish, too.
static bool limit(int resource, uint64_t soft, uint64_t hard)
{
    struct rlimit old, new = {soft, hard};
    if (getrlimit(resource, &old))
        return false;
    if (new.rlim_max > old.rlim_max)
        new.rlim_max = old.rlim_max;
    if (new.rlim_cur > old.rlim_cur)
        new.rlim_cur = old.rlim_cur;
    return setrlimit(resource, &new) == 0;
}

// A file may be mapped whole, beside the memory that it takes to read it. Sanitizers reserve
// terabytes of address space for their shadow memory.
static bool limit_memory(uint64_t bytes)
{
    struct stat file;
    if (SANITIZED)
        return true;
    if (fstat(WEFT_WIRE_FD + 1, &file) == 0 && file.st_size > 0)
        bytes += (uint64_t)file.st_size;
    return limit(RLIMIT_AS, bytes, bytes);
}

static uint64_t in_force(int resource, uint64_t asked)
{
    struct rlimit now;
    return getrlimit(resource, &now) == 0 && now.rlim_cur < asked ? now.rlim_cur : asked;
}

// What messages tell is what holds then.
static bool apply_limits(struct weft_limits *limits, uint32_t files)
{
    const uint64_t cpu = limits->cpu_seconds;
    bool good = limit_memory(limits->memory_bytes) && limit(RLIMIT_CPU, cpu, cpu * files + 1) &&
                limit(RLIMIT_FSIZE, limits->output_bytes, limits->output_bytes) &&
                limit(RLIMIT_CORE, 0, 0) && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0;
    limits->memory_bytes = in_force(RLIMIT_AS, limits->memory_bytes);
    limits->output_bytes = in_force(RLIMIT_FSIZE, limits->output_bytes);
    return good;
}

// The socket tells when the caller is gone, unless something that it forked still holds it. The
// signal that can tell, PR_SET_PDEATHSIG, comes when the caller's thread ends, too.
static void *watch(void *unused)
{
    enum { LOOK_MS = 500 };
    (void)unused;
    struct pollfd polled = {.fd = WEFT_WIRE_FD, .events = POLLRDHUP};
    pid_t caller = getppid();
    while (poll(&polled, 1, LOOK_MS) <= 0 && getppid() == caller)
        ;
    _exit(0);
}

static bool start_watch(void)
{
    pthread_attr_t attributes;
    pthread_t thread;
    sigset_t all, old;
    if (pthread_attr_init(&attributes))
        return false;
    pthread_attr_setstacksize(&attributes, 256 << 10);
    pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &old);
    bool started = pthread_create(&thread, &attributes, watch, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    pthread_attr_destroy(&attributes);
    return started;
}

// Processor time is for each file: what those before have used does not count. The process cannot
// be given more than what it was started with, and a lower limit of the caller's stays.
static void limit_next_file(struct weft_server *server)
{
    struct rlimit now;
    struct rusage used;
    if (getrlimit(RLIMIT_CPU, &now) || getrusage(RUSAGE_SELF, &used) || server->cpu_is_low)
        return;
    const rlim_t soft =
        (rlim_t)(used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1) + server->limits.cpu_seconds;
    now.rlim_cur = soft < now.rlim_max ? soft : now.rlim_max;
    setrlimit(RLIMIT_CPU, &now);
}

// Descriptors by the place of their bit in enum weft_wire_attached; -1: not attached.
struct attached {
    int fd[WEFT_WIRE_ATTACHED_COUNT];
};
enum { ANSWER, PAYLOAD, INPUT, ROOM };

static bool take_descriptors(const struct msghdr *message, uint32_t which, struct attached *out)
{
    int fds[WEFT_WIRE_ATTACHED_COUNT];
    const struct cmsghdr *header = CMSG_FIRSTHDR(message);
    if (!header || header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS)
        return false;
    const size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    if (which >> WEFT_WIRE_ATTACHED_COUNT || count != (size_t)__builtin_popcount(which))
        return false;
    memcpy(fds, CMSG_DATA(header), count * sizeof(int));
    for (int i = 0, next = 0; i < WEFT_WIRE_ATTACHED_COUNT; i++)
        out->fd[i] = which >> i & 1 ? fds[next++] : -1;
    return true;
}

// false: the caller hung up, or sent what no caller sends.
static bool receive(struct weft_wire_request *request, struct attached *attached, int *exit_code)
{
    union {
        char bytes[CMSG_SPACE(WEFT_WIRE_ATTACHED_COUNT * sizeof(int))];
        struct cmsghdr align;
    } control;
    struct iovec part = {request, sizeof *request};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    ssize_t size;
    do
        size = recvmsg(WEFT_WIRE_FD, &message, MSG_CMSG_CLOEXEC);
    while (size < 0 && errno == EINTR);
    *exit_code = size <= 0 ? 0 : EXIT_PROTOCOL;
    return size == (ssize_t)sizeof *request && !(message.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) &&
           request->magic == WEFT_WIRE_MAGIC && request->version == WEFT_WIRE_VERSION &&
           request->room < WEFT_WIRE_ROOMS &&
           take_descriptors(&message, request->attached, attached);
}

static bool map_request(struct weft_server *server, int fd, uint64_t size)
{
    struct stat stat;
    server->request_payload = NULL;
    if (!size)
        return true;
    if (fstat(fd, &stat) || (uint64_t)stat.st_size < size) {
        weft_server_fail(server, WEFT_ERR_READER, "the request is cut short");
        return false;
    }
    void *data = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED) {
        weft_server_fail(server, WEFT_ERR_LIMIT,
                         "cannot map %llu bytes within the memory limit of %llu bytes",
                         (unsigned long long)size, (unsigned long long)server->limits.memory_bytes);
        return false;
    }
    server->request_payload = data;
    return true;
}

static bool change_room(struct weft_server *server, int fd, const struct weft_wire_request *request)
{
    struct weft_server_room *room = &server->room[request->room];
    if (fd < 0)
        return true;
    if (room->size)
        munmap(room->data, room->size);
    *room = (struct weft_server_room){NULL, 0};
    void *data = mmap(NULL, request->room_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (data == MAP_FAILED) {
        weft_server_fail(server, WEFT_ERR_LIMIT,
                         "%llu bytes of the answer do not fit in the memory limit of %llu bytes: "
                         "%s",
                         (unsigned long long)request->room_bytes,
                         (unsigned long long)server->limits.memory_bytes, strerror(errno));
        return false;
    }
    *room = (struct weft_server_room){data, request->room_bytes};
    return true;
}

static void change_input(struct weft_server *server, int fd)
{
    if (fd < 0)
        return;
    close(server->input_fd);
    server->input_fd = fd;
    limit_next_file(server);
}

static bool answer_request(struct weft_server *server, const struct weft_wire_request *request,
                           struct attached *attached,
                           enum weft_result (*handle)(struct weft_server *server))
{
    server->request = request;
    server->payload_fd = attached->fd[ANSWER];
    server->payload_map = NULL;
    server->answer =
        (struct weft_wire_answer){.magic = WEFT_WIRE_MAGIC, .version = WEFT_WIRE_VERSION};
    change_input(server, attached->fd[INPUT]);
    attached->fd[INPUT] = -1;
    if (change_room(server, attached->fd[ROOM], request) &&
        map_request(server, attached->fd[PAYLOAD], request->payload_bytes)) {
        enum weft_result res = handle(server);
        if (!server->answer.result)
            server->answer.result = (int32_t)res;
    }
    if (server->payload_map) // the caller seals what nobody can write any more
        munmap(server->payload_map, server->answer.payload_bytes);
    if (server->request_payload)
        munmap((void *)(uintptr_t)server->request_payload, request->payload_bytes);
    for (int i = 0; i < WEFT_WIRE_ATTACHED_COUNT; i++)
        if (attached->fd[i] >= 0)
            close(attached->fd[i]);
    ssize_t sent;
    do
        sent = send(WEFT_WIRE_FD, &server->answer, sizeof server->answer, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent == (ssize_t)sizeof server->answer;
}

int weft_server_run(int argc, char **argv, enum weft_result (*handle)(struct weft_server *server),
                    void *priv)
{
    struct weft_server server = {.input_fd = WEFT_WIRE_FD + 1, .priv = priv};
    uint64_t cpu_seconds, files;
    if (argc != 6 || !parse(argv[2], &server.limits.memory_bytes) ||
        !parse(argv[3], &server.limits.output_bytes) || !parse(argv[4], &cpu_seconds) ||
        !parse(argv[5], &files) || cpu_seconds > UINT32_MAX || files > UINT32_MAX) {
        fprintf(stderr, "%s is started by libweft; it is of no use by itself\n", argv[0]);
        return EXIT_USAGE;
    }
    server.path = argv[1];
    server.limits.cpu_seconds = (uint32_t)cpu_seconds;
    server.cpu_is_low = in_force(RLIMIT_CPU, cpu_seconds) < cpu_seconds;
    if (!start_watch() || !apply_limits(&server.limits, (uint32_t)files))
        _exit(EXIT_SETUP);
    for (;;) {
        struct weft_wire_request request;
        struct attached attached;
        int exit_code;
        // Leaving by _exit spares taking large trees apart, and trusting damaged ones to survive
        // it.
        if (!receive(&request, &attached, &exit_code))
            _exit(exit_code);
        if (!answer_request(&server, &request, &attached, handle))
            _exit(0);
    }
}
