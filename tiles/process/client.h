// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/client.h - starts a reader program, asks it, receives its data (not installed).
#ifndef WEFT_TILES_PROCESS_CLIENT_H
#define WEFT_TILES_PROCESS_CLIENT_H

#include <sys/uio.h>

#include "filter/check.h"
#include "tiles/process/limits.h"
#include "tiles/process/wire.h"

WEFT_BEGIN_DECLS

typedef struct weft_reader weft_reader; // Thread-safety: one thread at a time.

// Opens a file for a reader; folders, pipes and devices are refused without being waited for.
// Returns WEFT_ERR_OPEN, or WEFT_ERR_FORMAT where it is empty.
enum weft_result weft_reader_open(const struct weft_log *log, const char *path, int *out);

// Starts `program` ("weft-read-vdb") with an input or output file, already open, as descriptor 4
// and its path for messages. Programs are looked for in $WEFT_LIBEXEC if set, else beside the
// library (or the program it is linked into), else in the installed libexec folder.
// The reader's stderr is discarded unless $WEFT_READER_DEBUG is set.
// Returns WEFT_ERR_READER (missing: the log names the places), _MEMORY, _ARGUMENT.
enum weft_result weft_reader_start(const struct weft_log *log, const char *program,
                                   const char *path, int fd, const struct weft_limits *limits,
                                   weft_reader **out);

// The limits of a reader whose memory grows with the file: where none is set, 256 MiB and 256 times
// the file's bytes, at most 4 GiB. A small file that needs much more is hostile.
struct weft_limits weft_reader_limits(const struct weft_limits *limits, uint64_t file_bytes);

// Shared memory mapped read-only, sealed against any further change.
struct weft_payload {
    const void *data; // NULL when size is 0
    size_t size;
};
void weft_payload_release(struct weft_payload *payload);

// Sends a request (magic and version are filled in) with a payload of request->payload_bytes, waits
// for the answer within the limits, logs "path: message" if it failed, and maps the payload.
// A reader that crashes, is killed, exceeds a limit or breaks the protocol is reported with what
// happened ("weft-read-vdb was killed by signal 11 (Segmentation fault) while reading smoke.vdb")
// as WEFT_ERR_READER or _LIMIT; every later call fails likewise.
enum weft_result weft_reader_call(weft_reader *reader, const struct weft_wire_request *request,
                                  const void *request_payload, struct weft_wire_answer *answer,
                                  struct weft_payload *payload);

// The same with a request payload in parts, one after the other; payload_bytes is filled in.
enum weft_result weft_reader_call_parts(weft_reader *reader,
                                        const struct weft_wire_request *request,
                                        const struct iovec *parts, int part_count,
                                        struct weft_wire_answer *answer,
                                        struct weft_payload *payload);

// The two halves of a call: what is done between them is done while the reader starts and works. A
// question is answered before the next one is asked. Errors as of the call: of asking only that the
// reader is gone, or that there is no shared memory.
enum weft_result weft_reader_ask(weft_reader *reader, const struct weft_wire_request *request,
                                 const struct iovec *parts, int part_count);
enum weft_result weft_reader_answer(weft_reader *reader, struct weft_wire_answer *answer,
                                    struct weft_payload *payload);

// Who hears of failures from now on; may be NULL, and is borrowed for the reader's life.
void weft_reader_set_log(weft_reader *reader, const struct weft_log *log);

// Kills the process, with whatever it started in its process group, and reaps it. Accepts &NULL,
// leaves NULL behind.
void weft_reader_stop(weft_reader **reader);

WEFT_END_DECLS
#endif
