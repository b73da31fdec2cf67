// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/schedule/load.h - how busy ranks were.
#ifndef WEFT_PASSES_DISTRIBUTE_SCHEDULE_LOAD_H
#define WEFT_PASSES_DISTRIBUTE_SCHEDULE_LOAD_H

#include "../../../filter/base.h"

WEFT_BEGIN_DECLS

// Of one or several works: what ranks did between the first beginning and the last end.
struct weft_rank_load {
    double busy;    // seconds in items
    double taking;  // seconds in which rank 0 put results together; else 0
    int64_t items;  // that it did
    uint64_t bytes; // of results that it sent; 0 of rank 0
    int threads;    // that it was given to keep busy (weft_ranks_info.threads)
    char host[64];  // the name of its node
};
struct weft_load {
    int ranks;                   // P; 0: there was no work
    double seconds;              // T, from beginning to end, barriers between frames included
    struct weft_rank_load *rank; // [ranks]
};

// All zero but `ranks`, >= 1. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY; *out is then {0}.
WEFT_API enum weft_result weft_load_create(int ranks, struct weft_load *out);
WEFT_API void weft_load_clear(struct weft_load *load); // accepts {0}
// Adds what another work of the same ranks took: seconds add up. Hosts and threads are taken over
// where there were none.
WEFT_API void weft_load_add(struct weft_load *load, const struct weft_load *other);

// The figures of parallel work, as Lin et al. 1997 count them.
struct weft_load_figures {
    double idle_share; // 1 - sum busy / (P T), the paper's average idle time / completion time; 0
                       // where T is 0
    double imbalance;  // largest busy / mean busy; 1 where nobody was busy
    double mean_busy, largest_busy; // seconds, of all ranks
};
// Of one rank too, of none all zero but an imbalance of 1.
WEFT_API void weft_load_compute(const struct weft_load *load, struct weft_load_figures *out);

WEFT_END_DECLS
#endif
