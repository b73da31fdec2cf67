// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/ranks.h - the ranks that a command runs on. One command runs per process, so the
// state is the process's own. Verbs are the same program on every rank: every rank reads the
// options and opens what it needs, rank 0 tells and writes. Thread-safety: the thread that runs the
// verb.
#ifndef WEFT_TOOLS_RANKS_RANKS_H
#define WEFT_TOOLS_RANKS_RANKS_H

#include "tools/common/report.h"

// Ranks of a launcher, or the one that there is without: never NULL while a verb runs. Alone
// nothing is started for them, and what all ranks do together returns at once.
weft_ranks *ranks_get(void);
// Sets them, for the time of a command (NULL: alone again, as before the first call). On other
// ranks than 0 nothing is shown from then on; their errors are kept for ranks_agree.
void ranks_set(weft_ranks *ranks);

int ranks_rank(void);
int ranks_size(void);    // 1: alone
bool ranks_tells(void);  // this is rank 0, which tells and writes
int ranks_threads(void); // that this rank may keep busy; alone 0, the default of what asks

// Whether all is well with all ranks, to be asked by all at the same places: after options, after
// inputs were opened, after each work. Where it is not, the first failed rank's error is the one
// that is told, once, by rank 0, with its rank and node if rank 0 itself had none; all ranks get
// its result and end. Alone: `result`.
enum weft_result ranks_agree(enum weft_result result);

// The exit code of this rank's process, once its verb has returned `code`; asked by all ranks, at
// the end. Rank 0 has its own, or that of the first rank that failed, which it then tells; others
// have EXIT_CODE_DONE, so that the launcher has one process to speak of.
int ranks_end(int code);

// That all ranks have the same version of weft, instructions and renderer (of `context`; NULL: the
// CPU), or an error; mixed: a warning, and WEFT_OK.
enum weft_result ranks_check_alike(const weft_context *context, bool mixed);

// What rank 0 chose (a method, an engine, a size), given to all as bytes of a known size, without
// pointers in it. Alone nothing is done.
enum weft_result ranks_share(void *data, size_t size);

#endif
