// SPDX-License-Identifier: BSD-3-Clause
// tiles/output/unfinished.h - what is to go when the process ends too soon (not installed).
// Kept for weft_unfinished_discard(), which a signal handler may call at any moment: a file is
// added before it is made, a process while signals are blocked, and each is removed once it is gone
// or, for processes, before it is waited for.
#ifndef WEFT_TILES_OUTPUT_UNFINISHED_H
#define WEFT_TILES_OUTPUT_UNFINISHED_H

#include <sys/types.h>

#include "tiles/output/output.h"

WEFT_BEGIN_DECLS

// path is borrowed until it is removed. Both may be called by several threads.
void weft_unfinished_add_file(const char *path);
void weft_unfinished_remove_file(const char *path);

// leader: of a process group of its own.
void weft_unfinished_add_process(pid_t leader);
void weft_unfinished_remove_process(pid_t leader);

WEFT_END_DECLS
#endif
