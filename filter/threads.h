// SPDX-License-Identifier: BSD-3-Clause
// filter/threads.h - work in parts on several threads (not installed).
// Threads live as long as a call. They block all signals, so that handlers run where they did. A
// part is done by one thread, and which one does not matter: results do not depend on how many
// there are, if no part writes what another one reads or writes.
#ifndef WEFT_FILTER_THREADS_H
#define WEFT_FILTER_THREADS_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// Processors that the calling thread may use, at least 1; at most $WEFT_THREADS where that is set
// to a number above 0, as it is for processes that share a machine.
int weft_threads_available(void);

// Calls part(priv, thread, i) once for every i from 0 to count - 1, from up to `threads` threads at
// once, of which the caller's is number 0; thread < threads. Parts are begun in order; once one
// returns false no more are begun. Returns whether all were done. Where a thread cannot be started
// the others do its parts.
bool weft_threads_run(int threads, size_t count, bool (*part)(void *priv, int thread, size_t i),
                      void *priv);

WEFT_END_DECLS
#endif
