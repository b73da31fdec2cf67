// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/guard.h - who sees a rank die: a child process of each, out of the launcher's reach.
// Where the first of a node's ranks to end does so without a farewell (killed, crashed, or ended by
// a library), its guard says so in one line; the launcher then ends the others, whose guards are
// silent. Where the launcher is gone the guard ends the rank. One command runs per process, so the
// state is the process's own.
#ifndef WEFT_TOOLS_RANKS_GUARD_H
#define WEFT_TOOLS_RANKS_GUARD_H

#include <stdbool.h>
#include <sys/types.h>

// A rank of the node, and its guard; 0: it has none.
struct guard_peer {
    pid_t rank, guard;
};
enum { GUARD_MOST_PEERS = 1024 };

// Starts it, before MPI is initialised; rank and size as the launcher's environment has them. Where
// it cannot be started there is none.
void guard_start(int rank, int size);
struct guard_peer guard_self(void);

// Tells it of all ranks of the node, its own among them, at most GUARD_MOST_PEERS; asked once MPI
// is initialised, so that a call of exit is seen before MPI sees it. Before that more than one
// guard may speak.
void guard_meet(const struct guard_peer *peers, int count);

// The rank's work is done, or a signal that it was sent ends it: the guard says nothing from now
// on. Async-signal-safe.
void guard_farewell(void);
// What ends all ranks is to be told: no guard of the node says anything from now on. False: it was
// told already.
bool guard_dismiss_all(void);

// Farewell, and waits until the guard has ended.
void guard_end(void);

#endif
