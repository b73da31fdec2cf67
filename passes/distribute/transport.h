// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/transport.h - what carries messages between ranks: MPI
// (passes/distribute/mpi/distribute.h), or whatever else a program has. weft has no network code of
// its own.
#ifndef WEFT_PASSES_DISTRIBUTE_TRANSPORT_H
#define WEFT_PASSES_DISTRIBUTE_TRANSPORT_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// Every call is made by one thread, the one that called weft_distribute_over; none waits for
// another rank. Messages from one rank to another come in the order in which they were sent, whole,
// and are at most WEFT_TRANSPORT_MAX bytes: larger ones are sent in pieces by what calls.
enum { WEFT_TRANSPORT_MAX = 1 << 20 };
struct weft_transport {
    int rank, size; // 0 <= rank < size
    // Of the ranks on this rank's node, ordered: the first one, which is the node's number; which
    // one it is, and how many there are.
    int node, node_rank, node_size;
    int threads;      // that this rank may keep busy, at least 1 (weft_ranks_info.threads)
    const char *host; // the node's name, for messages; borrowed
    void *priv;

    // Begins to send; data stays where it is until `sent` says so. *request is the transport's own,
    // given to `sent` until that returns true. False: it cannot be sent, and the job is to end.
    bool (*send)(void *priv, int to, const void *data, size_t size, void **request);
    bool (*sent)(void *priv, void *request);
    // A message that has come, from any rank: its size, or -1 while there is none. *from is set;
    // then `take` is called once, with room for it.
    int64_t (*probe)(void *priv, int *from);
    bool (*take)(void *priv, int from, void *data, size_t size);
    // Ends all ranks, at once and without a word; does not return where it can. Where it does, what
    // is asked of the ranks from then on gives WEFT_ERR_CANCELLED, and the calling rank ends when
    // its body does.
    void (*abort)(void *priv, int exit_code);
};

WEFT_END_DECLS
#endif
