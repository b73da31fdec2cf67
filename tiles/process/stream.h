// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/stream.h - a reader process that is asked about one file after another, the next
// ones while it works on the first (not installed).
#ifndef WEFT_TILES_PROCESS_STREAM_H
#define WEFT_TILES_PROCESS_STREAM_H

#include "tiles/process/client.h"

WEFT_BEGIN_DECLS

// Memory that an answer is put into, mapped read-only; whoever reads it must bear that the reader
// writes what it likes into it. Its size cannot be changed by the reader.
struct weft_room {
    const void *data;
    size_t size; // 0: there is none
    bool known;  // to the process that runs
};

// {0} has no process and no rooms.
struct weft_stream {
    weft_reader *reader; // NULL: none was started, or it has ended
    const char *program;
    uint32_t asked, answered; // files in the process's life
    struct weft_room room[WEFT_WIRE_ROOMS];
    int pending;                 // questions without an answer
    char *path[WEFT_WIRE_ROOMS]; // of those, the oldest first
};

// Starts a process for up to `files` files. Returns as weft_reader_start.
enum weft_result weft_stream_start(struct weft_stream *stream, const struct weft_log *log,
                                   const char *program, const struct weft_limits *limits,
                                   uint32_t files);
// Ends the process, and all questions with it; rooms can still be read.
void weft_stream_stop(struct weft_stream *stream);
// Likewise, and gives the rooms back.
void weft_stream_clear(struct weft_stream *stream);

// Asks for a FRAME of a file, which is open, into request->room, which gets new memory of
// request->room_bytes where it has less; there are fewer than WEFT_WIRE_ROOMS questions. A reader
// that is gone is found when it is to answer. Returns WEFT_ERR_MEMORY, after a line in the log.
enum weft_result weft_stream_ask(struct weft_stream *stream, const struct weft_log *log,
                                 struct weft_wire_request *request, int fd, const char *path);

// Waits until one of these has something to tell, a signal comes, or so many seconds are over
// (< 0: as long as the limits of those that are asked allow). Returns whether one has; ready[i]
// says which: an answer, its end, or that it is late.
bool weft_streams_wait(const struct weft_stream *streams, int count, double seconds, bool *ready);

// Receives the answer to the oldest question. Returns what it says, or WEFT_ERR_READER or _LIMIT
// where the reader has ended, which ends all its questions; either after a line in the log.
enum weft_result weft_stream_answer(struct weft_stream *stream, const struct weft_log *log,
                                    struct weft_wire_answer *answer);

WEFT_END_DECLS
#endif
