// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/stream.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "tiles/process/client_impl.h"

enum { MOST_STREAMS = 64 }; // that are waited for at once

// ---- processes ----------------------------------------------------------------------------------

enum weft_result weft_stream_start(struct weft_stream *stream, const struct weft_log *log,
                                   const char *program, const struct weft_limits *limits,
                                   uint32_t files)
{
    weft_stream_stop(stream);
    int none = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (none < 0) {
        weft_error(log, "cannot start %s: /dev/null: %s", program, strerror(errno));
        return WEFT_ERR_READER;
    }
    const enum weft_result res =
        weft_reader_start_for(log, program, "many files", none, limits, files, &stream->reader);
    weft_close_fd(&none);
    stream->program = program;
    return res;
}

void weft_stream_stop(struct weft_stream *stream)
{
    weft_reader_stop(&stream->reader);
    for (int i = 0; i < stream->pending; i++)
        free(stream->path[i]);
    stream->pending = 0;
    stream->asked = stream->answered = 0;
    for (int r = 0; r < WEFT_WIRE_ROOMS; r++)
        stream->room[r].known = false;
}

static void release_room(struct weft_room *room)
{
    if (room->size)
        munmap((void *)(uintptr_t)room->data, room->size);
    *room = (struct weft_room){NULL, 0, false};
}

void weft_stream_clear(struct weft_stream *stream)
{
    weft_stream_stop(stream);
    for (int r = 0; r < WEFT_WIRE_ROOMS; r++)
        release_room(&stream->room[r]);
}

// ---- questions ----------------------------------------------------------------------------------

// Sealed against another size, so that what is mapped stays there.
static int make_memory(size_t size, const void **map)
{
    int fd = memfd_create("weft-room", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (fd < 0)
        return -1;
    void *data = MAP_FAILED;
    if (size <= INT64_MAX && ftruncate(fd, (off_t)size) == 0 &&
        fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) == 0)
        data = mmap(NULL, size, PROT_READ, MAP_SHARED, fd, 0);
    if (data == MAP_FAILED)
        weft_close_fd(&fd);
    *map = data;
    return fd;
}

enum weft_result weft_stream_ask(struct weft_stream *stream, const struct weft_log *log,
                                 struct weft_wire_request *request, int fd, const char *path)
{
    struct weft_room *room = &stream->room[request->room];
    int fds[2] = {fd, -1};
    char *copy = strdup(path);
    if (!copy) {
        weft_error(log, "%s: out of memory for a name", path);
        return WEFT_ERR_MEMORY;
    }
    if (!room->known || room->size < request->room_bytes) {
        release_room(room);
        fds[1] = make_memory(request->room_bytes, &room->data);
        if (fds[1] < 0) {
            weft_error(log, "%s: no shared memory of %llu bytes: %s", path,
                       (unsigned long long)request->room_bytes, strerror(errno));
            free(copy);
            return WEFT_ERR_MEMORY;
        }
        room->size = request->room_bytes;
        room->known = true;
    }
    request->op = stream->reader->op = WEFT_WIRE_IMAGE_FRAME;
    request->attached = WEFT_WIRE_ATTACHED_FILE | (fds[1] < 0 ? 0 : WEFT_WIRE_ATTACHED_ROOM);
    if (!stream->pending)
        stream->reader->since = weft_now_seconds();
    stream->path[stream->pending++] = copy;
    stream->asked++;
    weft_reader_send(stream->reader, request, fds, fds[1] < 0 ? 1 : 2);
    weft_close_fd(&fds[1]);
    return WEFT_OK;
}

// ---- answers ------------------------------------------------------------------------------------

static double seconds_left(const struct weft_stream *stream)
{
    const weft_reader *reader = stream->reader;
    return reader->since + reader->limits.wall_seconds - weft_now_seconds();
}

bool weft_streams_wait(const struct weft_stream *streams, int count, double seconds, bool *ready)
{
    // Those that are asked alone: poll takes no more entries than the process may have descriptors.
    struct pollfd polled[2 * MOST_STREAMS];
    nfds_t used = 0;
    double left = seconds < 0.0 ? 1e6 : seconds;
    for (int i = 0; i < count; i++) {
        const struct weft_stream *s = &streams[i];
        if (!s->pending)
            continue;
        polled[used++] = (struct pollfd){s->reader->socket, POLLIN, 0};
        polled[used++] = (struct pollfd){s->reader->pidfd, POLLIN, 0};
        if (seconds_left(s) < left)
            left = seconds_left(s);
    }
    const int n = poll(polled, used, left > 0.0 ? (int)(left * 1e3) + 1 : 0);
    const struct pollfd *next = polled;
    bool any = false;
    for (int i = 0; i < count; i++) {
        ready[i] = false;
        if (!streams[i].pending)
            continue;
        ready[i] =
            n > 0 ? next[0].revents || next[1].revents : n == 0 && seconds_left(&streams[i]) <= 0.0;
        any |= ready[i];
        next += 2;
    }
    return any;
}

enum weft_result weft_stream_answer(struct weft_stream *stream, const struct weft_log *log,
                                    struct weft_wire_answer *answer)
{
    weft_reader *reader = stream->reader;
    free(reader->path);
    reader->path = stream->path[0];
    memmove(stream->path, stream->path + 1, (size_t)--stream->pending * sizeof *stream->path);
    weft_reader_set_log(reader, log);
    memset(answer, 0, sizeof *answer);
    enum weft_result res = weft_reader_receive(reader, answer);
    reader->since = weft_now_seconds();
    const uint64_t most = reader->limits.output_bytes;
    if (res == WEFT_OK && answer->result == WEFT_OK &&
        (answer->payload_bytes > most ||
         (answer->verdict == WEFT_WIRE_NO_ROOM && answer->count[0] > most)))
        res = weft_reader_protocol_error(reader, "the data exceeds the output limit");
    if (res != WEFT_OK) {
        weft_stream_stop(stream);
        return res;
    }
    stream->answered++;
    res = (enum weft_result)answer->result;
    if (res != WEFT_OK)
        weft_error(log, "%s: %s", reader->path,
                   *answer->message ? answer->message : weft_result_text(res));
    weft_reader_set_log(reader, NULL);
    return res;
}
