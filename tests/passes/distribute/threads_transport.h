// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/distribute/threads_transport.h - ranks that are threads of one process, with a
// transport between them that is as bad as one may be: messages are late by random times, those of
// different ranks overtake each other, large ones are read only when they are taken, and ranks fall
// silent or cannot send.
#ifndef WEFT_TESTS_THREADS_TRANSPORT_H
#define WEFT_TESTS_THREADS_TRANSPORT_H

#include "passes/distribute/items.h"

enum { THREADS_RANKS_MAX = 16 };

struct threads_params {
    int ranks;      // 1 to THREADS_RANKS_MAX
    int node_ranks; // so many of them share a node; 0: all
    unsigned seed;  // of delays and orders
    double delay;   // seconds a message is late at most
    double timeout; // as weft_distribute_params; 0: its default
    // From its sends_before-th message on, a rank cannot send or is stopped in a call (until all
    // are ended, or for stop_seconds). -1: none.
    int failing_rank, stopping_rank;
    int sends_before;
    double stop_seconds;
    bool stop_all; // stopping_rank stops all ranks
    weft_body body;
    void *priv[THREADS_RANKS_MAX];
    const struct weft_log *log; // of rank 0
};

struct threads_outcome {
    enum weft_result result[THREADS_RANKS_MAX];
    int lines;      // that were said before the job was ended
    char line[512]; // the first
    int line_rank;  // who said it
    int exit_code;  // the job was ended with; -1: it ended by itself
    int left;       // messages that nobody took, of a job that ended by itself
    double seconds;
};

// For the threads of ranks: what does not hold is printed and counted.
#define THREADS_CHECK(condition) threads_check(condition, __FILE__, __LINE__, #condition)
void threads_check(bool good, const char *file, int line, const char *what);
int threads_faults(void); // since the program began

void threads_run(const struct threads_params *params, struct threads_outcome *out);

#endif
