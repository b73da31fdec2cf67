// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/client_impl.h - what the caller's sides of the protocol share (not installed).
#ifndef WEFT_TILES_PROCESS_CLIENT_IMPL_H
#define WEFT_TILES_PROCESS_CLIENT_IMPL_H

#include <sys/types.h>
#include <unistd.h>

#include "tiles/process/client.h"

WEFT_BEGIN_DECLS

struct weft_reader {
    const struct weft_log *log;
    char *program;
    char *path; // of the file that it works on, for messages
    struct weft_limits limits;
    uint32_t files;         // that it may be asked about
    pid_t pid;              // 0: reaped
    int pidfd;              // -1 where the kernel has none
    int socket;             // -1: closed
    int answer_fd;          // of the question that has no answer yet; -1: there is none
    uint32_t op;            // of that question
    double since;           // when the reader could begin with it, on the monotonic clock
    enum weft_result ended; // why no further call is possible; WEFT_OK while it lives
};

static inline void weft_close_fd(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

// weft_reader_start of a reader that may be asked about so many files: its processor time in all is
// limited to that of as many.
enum weft_result weft_reader_start_for(const struct weft_log *log, const char *program,
                                       const char *path, int fd, const struct weft_limits *limits,
                                       uint32_t files, weft_reader **out);

// Sends a request, with descriptors attached, at once. false: the reader is gone.
bool weft_reader_send(weft_reader *reader, struct weft_wire_request *request, const int *fds,
                      int fd_count);

// Receives the answer to the oldest request, which there must be, within the wall limit, and checks
// its form. Returns WEFT_ERR_READER or _LIMIT after a line in the log; the reader has then ended.
enum weft_result weft_reader_receive(weft_reader *reader, struct weft_wire_answer *answer);

// Ends it, after a line in the log. Returns WEFT_ERR_READER.
enum weft_result weft_reader_protocol_error(weft_reader *reader, const char *what);

WEFT_END_DECLS
#endif
