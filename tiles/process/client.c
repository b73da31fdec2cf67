// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/client.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/pidfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tiles/output/unfinished.h"
#include "tiles/process/client_impl.h"

// What a reader that has hung up is given to end by itself, so that its exit code can be told.
#define GRACE_SECONDS 0.5

// ---- its end ------------------------------------------------------------------------------------

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
    weft_close_fd(&(*reader)->socket);
    weft_close_fd(&(*reader)->pidfd);
    weft_close_fd(&(*reader)->answer_fd);
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
    weft_close_fd(&reader->socket);
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
    case WEFT_WIRE_IMAGE_FRAME:
    case WEFT_WIRE_MESH:
        return "reading";
    case WEFT_WIRE_WRITE_BEGIN:
    case WEFT_WIRE_WRITE_ADD:
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
static enum weft_result report_death(weft_reader *reader)
{
    const struct weft_log *log = reader->log;
    const char *program = reader->program, *path = reader->path;
    const uint32_t op = reader->op;
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

enum weft_result weft_reader_protocol_error(weft_reader *reader, const char *what)
{
    weft_error(reader->log, "%s broke its protocol while %s %s: %s", reader->program,
               doing(reader->op), reader->path, what);
    return end_reader(reader, WEFT_ERR_READER);
}

// ---- one question, one answer -------------------------------------------------------------------

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

bool weft_reader_send(weft_reader *reader, struct weft_wire_request *request, const int *fds,
                      int fd_count)
{
    union {
        char bytes[CMSG_SPACE(WEFT_WIRE_ATTACHED_COUNT * sizeof(int))];
        struct cmsghdr align;
    } control = {{0}};
    const size_t size = (size_t)fd_count * sizeof(int);
    request->magic = WEFT_WIRE_MAGIC;
    request->version = WEFT_WIRE_VERSION;
    struct iovec part = {request, sizeof *request};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = CMSG_SPACE(size)};
    struct cmsghdr *header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(size);
    memcpy(CMSG_DATA(header), fds, size);
    ssize_t sent;
    do
        sent = sendmsg(reader->socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    while (sent < 0 && errno == EINTR);
    return sent == (ssize_t)sizeof *request;
}

enum arrival { ARRIVED, DIED, LATE };

// Waits until the socket has something, or the reader is gone, or the time is over. A process that
// was forked off elsewhere may hold the reader's end of the socket, so its death is watched as
// well.
static enum arrival wait_for_answer(const weft_reader *reader)
{
    const double end = reader->since + reader->limits.wall_seconds;
    for (;;) {
        struct pollfd polled[] = {{.fd = reader->socket, .events = POLLIN},
                                  {.fd = reader->pidfd, .events = POLLIN}};
        const double left = end - weft_now_seconds();
        const int n = poll(polled, WEFT_COUNT(polled),
                           left <= 0.0  ? 0
                           : left > 1e6 ? INT_MAX
                                        : (int)(left * 1e3) + 1);
        if (n == 0 && left <= 0.0)
            return LATE;
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

// A reader that ends with questions unread resets the connection, which is told once, before the
// answers that it had sent.
static ssize_t receive_message(int socket, void *out, size_t size)
{
    ssize_t got;
    int resets = 0;
    do
        got = recv(socket, out, size, MSG_DONTWAIT | MSG_TRUNC);
    while (got < 0 && (errno == EINTR || (errno == ECONNRESET && !resets++)));
    return got;
}

enum weft_result weft_reader_receive(weft_reader *reader, struct weft_wire_answer *answer)
{
    switch (wait_for_answer(reader)) {
    case DIED:
        return report_death(reader);
    case LATE:
        weft_error(reader->log, "%s: %s did not answer within the limit of %u s while %s",
                   reader->path, reader->program, reader->limits.wall_seconds, doing(reader->op));
        return end_reader(reader, WEFT_ERR_LIMIT);
    case ARRIVED:
        break;
    }
    const ssize_t size = receive_message(reader->socket, answer, sizeof *answer);
    if (size <= 0)
        return report_death(reader);
    if (size != (ssize_t)sizeof *answer)
        return weft_reader_protocol_error(reader, "the answer has the wrong size");
    if (answer->magic != WEFT_WIRE_MAGIC || answer->version != WEFT_WIRE_VERSION)
        return weft_reader_protocol_error(reader, "it speaks another version");
    if (!known_result(answer->result))
        return weft_reader_protocol_error(reader, "unknown result");
    if (answer->verdict >= WEFT_WIRE_VERDICT_COUNT)
        return weft_reader_protocol_error(reader, "unknown verdict");
    if (!memchr(answer->message, 0, sizeof answer->message))
        return weft_reader_protocol_error(reader, "endless message");
    return WEFT_OK;
}

// Sealed first and measured then, so that the reader cannot change it between the two.
static enum weft_result map_payload(weft_reader *reader, int fd, uint64_t size,
                                    struct weft_payload *payload)
{
    struct stat stat;
    if (fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL))
        return weft_reader_protocol_error(reader, "its answer cannot be sealed");
    if (fstat(fd, &stat) || (uint64_t)stat.st_size != size)
        return weft_reader_protocol_error(reader, "the data has another size than announced");
    if (size > reader->limits.output_bytes)
        return weft_reader_protocol_error(reader, "the data exceeds the output limit");
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
    reader->op = request->op;
    reader->since = weft_now_seconds();
    sent.attached = WEFT_WIRE_ATTACHED_ANSWER | (part_count ? WEFT_WIRE_ATTACHED_PAYLOAD : 0);
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
    if (!weft_reader_send(reader, &sent, fds, part_count ? 2 : 1)) {
        res = report_death(reader);
        goto done;
    }
    reader->answer_fd = fds[0];
    fds[0] = -1;
    res = WEFT_OK;
    goto done;
fail:
    weft_error(reader->log, "%s: no shared memory for %s: %s", reader->path, reader->program,
               strerror(errno));
done:
    weft_close_fd(&fds[0]);
    weft_close_fd(&fds[1]);
    return res;
}

enum weft_result weft_reader_answer(weft_reader *reader, struct weft_wire_answer *answer,
                                    struct weft_payload *payload)
{
    *payload = (struct weft_payload){0};
    memset(answer, 0, sizeof *answer);
    enum weft_result res = weft_reader_receive(reader, answer);
    if (res)
        goto done;
    res = (enum weft_result)answer->result;
    if (res)
        weft_error(reader->log, "%s: %s", reader->path,
                   *answer->message ? answer->message : weft_result_text(res));
    else
        res = map_payload(reader, reader->answer_fd, answer->payload_bytes, payload);
done:
    weft_close_fd(&reader->answer_fd);
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
