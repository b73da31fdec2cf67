// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/guard.h - who sees a rank die: a child process of each, in its process group. Where
// the rank ends without a farewell (killed, crashed, or ended by a library) the guard says so in
// one line; the launcher then ends the others with their guards, who are silent. Where the launcher
// is gone the guard ends the rank. One command runs per process, so the state is the process's own.
#ifndef WEFT_TOOLS_RANKS_GUARD_H
#define WEFT_TOOLS_RANKS_GUARD_H

// Starts it, before MPI is initialised; rank and size as the launcher's environment has them. Where
// it cannot be started there is none.
void guard_start(int rank, int size);

// The rank's work is done, or its end was told of: the guard says nothing from now on.
// Async-signal-safe.
void guard_farewell(void);

// Farewell, and waits until the guard has ended.
void guard_end(void);

#endif
