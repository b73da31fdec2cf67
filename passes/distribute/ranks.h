// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/ranks.h - work of several processes, ranks, that know of each other.
// All ranks run the same function, body, each in a thread of its own, while the thread that called
// talks to the other ranks: it hands messages over, answers who asks for work, and tells its
// neighbour that it lives. So a rank that computes for minutes is alive, and one that was killed or
// stopped is found. What the functions below do together is asked for by all ranks in the same
// order, as collective operations are; where one asks for something else, or has ended while others
// wait for it, the job ends as with a rank that is lost. Rank 0 is the one that tells and writes.
#ifndef WEFT_PASSES_DISTRIBUTE_RANKS_H
#define WEFT_PASSES_DISTRIBUTE_RANKS_H

#include "transport.h"

WEFT_BEGIN_DECLS

// What a rank knows of all. Thread-safety: the thread that body is called in.
typedef struct weft_ranks weft_ranks;

struct weft_distribute_params {
    // Seconds without a sign of life after which a rank counts as lost, and the job is ended
    // (default 6; at least 0.5). A job that is stopped as a whole and goes on later loses none.
    double timeout;
    // Called once, in the thread that talks, on the rank that finds that another one is lost or
    // that it cannot go on itself (a message cannot be sent), before all are ended: `line` names
    // rank, node and process. NULL: a line on stderr.
    void (*lost)(void *priv, const char *line);
    void *priv;
    int exit_code;              // of the ranks that are ended then (default 1)
    const struct weft_log *log; // may be NULL
};
#define WEFT_DISTRIBUTE_DEFAULTS
#define weft_distribute_params(...)                                                                \
    (&(struct weft_distribute_params){WEFT_DISTRIBUTE_DEFAULTS __VA_ARGS__})

typedef enum weft_result (*weft_body)(void *priv, weft_ranks *ranks);

// Calls body on every rank, in a thread of its own that signals do come to as before, and returns
// what it returned on this rank, once all ranks have ended theirs. All ranks call it within the
// time-out. A caller's GL context must not be current in the calling thread if body uses it. With
// transport NULL there is one rank, and body is called by the calling thread. Returns
// WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY as well.
WEFT_API enum weft_result weft_distribute_over(const struct weft_transport *transport,
                                               const struct weft_distribute_params *params,
                                               weft_body body, void *priv);

struct weft_ranks_info {
    int rank, size;
    // The first rank of this rank's node, which is the node's number; which one this is there, and
    // of how many.
    int node, node_rank, node_size;
    // Threads that this rank may keep busy: its share of the processors that it may run on; ranks
    // times threads are the processors of a node, at least one each.
    int threads;
    const char *host;
    // Seconds since the last sign of life that may pass; may be changed by weft_ranks_set_timeout.
    double timeout;
};
WEFT_API void weft_ranks_get_info(const weft_ranks *ranks, struct weft_ranks_info *out);
// Changes weft_distribute_params.timeout, on all ranks alike. Returns WEFT_ERR_ARGUMENT.
WEFT_API enum weft_result weft_ranks_set_timeout(weft_ranks *ranks, double seconds);

// ---- what all ranks do together -----------------------------------------------------------------

// Gives every rank what rank 0 has: *data and *size, there borrowed, elsewhere set to memory that
// the caller frees. Returns WEFT_ERR_MEMORY, on all ranks alike.
WEFT_API enum weft_result weft_ranks_share(weft_ranks *ranks, void **data, size_t *size);

// Gives rank 0 what every rank has. On rank 0 parts[rank] are set, to be freed with
// weft_ranks_free_parts; elsewhere they are left alone. Returns WEFT_ERR_MEMORY, on all ranks
// alike.
struct weft_ranks_part {
    void *data;
    size_t size;
};
WEFT_API enum weft_result weft_ranks_gather(weft_ranks *ranks, const void *data, size_t size,
                                            struct weft_ranks_part *parts);
WEFT_API void weft_ranks_free_parts(int count, struct weft_ranks_part *parts);

// Whether all is well with all: WEFT_OK, or the result of the lowest rank with another one and
// something to say (or of the lowest, if none has), which all ranks return alike. On rank 0 `line`
// (of `size` bytes, at least 1) is that rank's, cut where it is longer; what a rank has to say, a
// line without its end, was given as `line` there. *failed: that rank, -1 if none; may be NULL.
WEFT_API enum weft_result weft_ranks_agree(weft_ranks *ranks, enum weft_result result, char *line,
                                           size_t size, int *failed);

// Whether all ranks have the same text, as the renderer, the version, the set of instructions: the
// log of rank 0 names what differs, and which rank has it. Returns WEFT_ERR_UNSUPPORTED where one
// differs, on all ranks alike.
WEFT_API enum weft_result weft_ranks_compare(weft_ranks *ranks, const char *what, const char *text);

WEFT_END_DECLS
#endif
