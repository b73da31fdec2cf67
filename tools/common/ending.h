// SPDX-License-Identifier: BSD-3-Clause
// tools/common/ending.h - how a signal ends the command: at once, by that signal, with nothing left
// behind. Unfinished outputs and reader programs are the library's to remove
// (weft_unfinished_discard), the program that draws plots is ours. One command runs per process, so
// the state is the process's own.
#ifndef WEFT_TOOLS_COMMON_ENDING_H
#define WEFT_TOOLS_COMMON_ENDING_H

#include <pthread.h>
#include <stdbool.h>
#include <sys/types.h>

// Catches what ends a process by default; a signal that is ignored stays so (nohup). clean_up is
// called before the process dies of one, and must be async-signal-safe.
void ending_start(void (*clean_up)(void));

// Starts a thread that signals do not come to: they are for those that were there before. False
// where that fails.
bool ending_start_thread(pthread_t *thread, void *(*call)(void *priv), void *priv);

// A program to be killed with us, the leader of its process group; 0: it has ended.
void ending_set_child(pid_t leader);

// For a verb that has a use for unfinished work: the first SIGINT is only noted from now on, the
// verb asks for it, and ending_finish lets the process die of it.
void ending_defer_interrupt(void);
bool ending_is_due(void);
void ending_finish(void);

// For a verb that tells on request what it has so far: SIGUSR1 is only noted from now on.
void ending_note_requests(void);
// Whether one was noted; taking it forgets it.
bool ending_has_request(void);
bool ending_take_request(void);

#endif
