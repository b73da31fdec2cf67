// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/server.h - the reader program's side of the protocol (not installed).
#ifndef WEFT_TILES_PROCESS_SERVER_H
#define WEFT_TILES_PROCESS_SERVER_H

#include "tiles/process/limits.h"
#include "tiles/process/wire.h"

WEFT_BEGIN_DECLS

// Memory for answers that both sides keep mapped.
struct weft_server_room {
    void *data;
    size_t size; // 0: there is none
};

struct weft_server {
    int input_fd;     // the file, read-only (for the writer: the output file); a request may have
                      // brought another one than before
    const char *path; // name of the one that it was started with: for messages, and for
                      // weft-read-mesh to find the files that lie beside it
    struct weft_limits limits;
    const struct weft_wire_request *request;
    const void *request_payload; // mapped; request->payload_bytes long
    int payload_fd;    // where the answer's payload is written, by weft_server_append; -1: a room
    void *payload_map; // of weft_server_map
    struct weft_server_room room[WEFT_WIRE_ROOMS];
    bool cpu_is_low; // the caller's own limit of processor time is lower than the one asked for
    struct weft_wire_answer answer;
    void *priv;
};

// Appends to the answer's payload. false when the output limit is passed (the answer then says so).
bool weft_server_append(struct weft_server *server, const void *data, size_t size);

// Makes the answer's payload `size` bytes of 0, at least one, and maps them to be written until the
// handler returns; nothing may have been appended. Where the answer goes into a room, the first
// bytes of that. NULL where they do not fit (the answer then says so).
void *weft_server_map(struct weft_server *server, size_t size);

// Sets result and message (printf style); returns the result.
enum weft_result weft_server_fail(struct weft_server *server, enum weft_result result,
                                  const char *format, ...) __attribute__((format(printf, 3, 4)));

// Applies the limits given on the command line to this process (address space, CPU seconds, file
// size, no core dump, no new privileges), ends the process when the caller goes away (a thread
// watches the socket), then answers requests through `handle` until the socket closes. Processor
// time is limited again for each file that a request brings.
int weft_server_run(int argc, char **argv, enum weft_result (*handle)(struct weft_server *server),
                    void *priv);

WEFT_END_DECLS
#endif
