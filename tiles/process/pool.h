// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/pool.h - several readers that work through one list of files (not installed).
// A process that crashes, is over a limit, or contradicts itself is ended, and costs the file that
// it worked on alone: other files that it was to read go to another process. Nor is a file given up
// for what the files before it did to the process: where it was not the process's first one it is
// tried once more, as the first one of a fresh process, and that is what counts. So what becomes of
// a file does not depend on which process met it, and when.
#ifndef WEFT_TILES_PROCESS_POOL_H
#define WEFT_TILES_PROCESS_POOL_H

#include "tiles/process/stream.h"

WEFT_BEGIN_DECLS

enum {
    WEFT_POOL_STREAMS = 32, // at most
    // That a process reads, at most: its start-up is then a small part of its life, and one that a
    // file took over cannot make up what is in others for long.
    WEFT_POOL_FILES = 256,
};

enum weft_job_state {
    WEFT_JOB_NEW,    // to be placed
    WEFT_JOB_PLACED, // a process has it
    WEFT_JOB_GIVEN,  // its answer lies in a room
    WEFT_JOB_FAILED, // for good
};

// One file. The caller fills in the first members and keeps the job where it is until it is done.
struct weft_job {
    const char *path;    // for messages
    const char *program; // that reads it
    uint32_t part, info_only;
    enum weft_job_state state;
    enum weft_result result; // FAILED: why
    char message[1024];      // FAILED: in words
    bool other_program;      // NEW: it needs another program than this one, which said so
    // GIVEN: the answer. The process may change it while it is read.
    const void *data;
    size_t size;
    // The pool's.
    bool alone, first; // as the first file of a fresh process: to be asked, was asked
    size_t need;       // bytes of its answer; 0: not known
    int asked;         // how often
    int stream, room;
    uint64_t process; // that it was given to
};

// {0} with limits, readers, memory_bytes and log filled in is ready.
struct weft_pool {
    const struct weft_log *log;
    struct weft_limits limits;
    int readers; // 1 to WEFT_POOL_STREAMS; fewer where more cannot be started
    uint64_t memory_bytes;
    size_t usual; // bytes of the latest answer
    struct weft_stream stream[WEFT_POOL_STREAMS];
    bool closed[WEFT_POOL_STREAMS];                             // no process could be started
    uint64_t process[WEFT_POOL_STREAMS];                        // number of the one that runs
    uint64_t started;                                           // processes so far
    struct weft_job *asked[WEFT_POOL_STREAMS][WEFT_WIRE_ROOMS]; // the oldest first
    int count[WEFT_POOL_STREAMS];                               // of those
    bool taken[WEFT_POOL_STREAMS][WEFT_WIRE_ROOMS];             // rooms, by jobs
};

// Gives a NEW job to a process, which is started where there is none; fd is its file. Where no
// process can have it now, or memory for it is short, nothing happens: it stays NEW. Memory is
// never short for an urgent one. Returns WEFT_ERR_READER (the program is missing) or _MEMORY.
enum weft_result weft_pool_place(struct weft_pool *pool, struct weft_job *job, int fd, bool urgent);
// Whether a place would be found.
bool weft_pool_has_place(const struct weft_pool *pool, const struct weft_job *job, bool urgent);

// Waits for answers as weft_streams_wait does, and takes them: jobs become GIVEN, FAILED, or NEW
// again.
void weft_pool_wait(struct weft_pool *pool, double seconds);

// What a job was given contradicts itself: ends its process. The job becomes FAILED, or NEW again.
void weft_pool_refuse(struct weft_pool *pool, struct weft_job *job);
// The room of a GIVEN job is free again.
void weft_pool_release(struct weft_pool *pool, struct weft_job *job);

// Ends all processes.
void weft_pool_clear(struct weft_pool *pool);

WEFT_END_DECLS
#endif
