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

void *weft_server_map(struct weft_server *server, size_t size)
{
    if (size > server->limits.output_bytes) {
        weft_server_fail(server, WEFT_ERR_LIMIT,
                         "the answer has %zu bytes, the output limit is %llu", size,
                         (unsigned long long)server->limits.output_bytes);
        return NULL;
    }
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
static bool apply_limits(struct weft_limits *limits)
{
    bool good = limit_memory(limits->memory_bytes) &&
                limit(RLIMIT_CPU, limits->cpu_seconds, (uint64_t)limits->cpu_seconds + 1) &&
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

// false: the caller hung up, or sent what no caller sends.
static bool receive(struct weft_wire_request *request, int fds[2], int *exit_code)
{
    union {
        char bytes[CMSG_SPACE(2 * sizeof(int))];
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
    if (size != (ssize_t)sizeof *request || message.msg_flags & (MSG_TRUNC | MSG_CTRUNC))
        return false;
    const struct cmsghdr *header = CMSG_FIRSTHDR(&message);
    if (!header || header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS)
        return false;
    size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    if (count != (request->payload_bytes ? 2 : 1))
        return false;
    memcpy(fds, CMSG_DATA(header), count * sizeof(int));
    return request->magic == WEFT_WIRE_MAGIC && request->version == WEFT_WIRE_VERSION;
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

static bool answer_request(struct weft_server *server, const struct weft_wire_request *request,
                           int fds[2], enum weft_result (*handle)(struct weft_server *server))
{
    server->request = request;
    server->payload_fd = fds[0];
    server->payload_map = NULL;
    server->answer =
        (struct weft_wire_answer){.magic = WEFT_WIRE_MAGIC, .version = WEFT_WIRE_VERSION};
    if (map_request(server, fds[1], request->payload_bytes)) {
        enum weft_result res = handle(server);
        if (!server->answer.result)
            server->answer.result = (int32_t)res;
    }
    if (server->payload_map) // the caller seals what nobody can write any more
        munmap(server->payload_map, server->answer.payload_bytes);
    if (server->request_payload)
        munmap((void *)(uintptr_t)server->request_payload, request->payload_bytes);
    for (int i = 0; i < 2; i++)
        if (fds[i] >= 0)
            close(fds[i]);
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
    uint64_t cpu_seconds;
    if (argc != 5 || !parse(argv[2], &server.limits.memory_bytes) ||
        !parse(argv[3], &server.limits.output_bytes) || !parse(argv[4], &cpu_seconds) ||
        cpu_seconds > UINT32_MAX) {
        fprintf(stderr, "%s is started by libweft; it is of no use by itself\n", argv[0]);
        return EXIT_USAGE;
    }
    server.path = argv[1];
    server.limits.cpu_seconds = (uint32_t)cpu_seconds;
    if (!start_watch() || !apply_limits(&server.limits))
        _exit(EXIT_SETUP);
    for (;;) {
        struct weft_wire_request request;
        int fds[2] = {-1, -1}, exit_code;
        // Leaving by _exit spares taking large trees apart, and trusting damaged ones to survive
        // it.
        if (!receive(&request, fds, &exit_code))
            _exit(exit_code);
        if (!answer_request(&server, &request, fds, handle))
            _exit(0);
    }
}
