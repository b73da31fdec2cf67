// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/items.h - items of work done by ranks: regions of a picture, frames, files.
// Which rank does which item does not matter to what comes of it: an item's result depends on the
// item alone, and results are put together where they belong, or by operations without an order.
#ifndef WEFT_PASSES_DISTRIBUTE_ITEMS_H
#define WEFT_PASSES_DISTRIBUTE_ITEMS_H

#include "ranks.h"
#include "schedule/load.h"
#include "schedule/schedule.h"

WEFT_BEGIN_DECLS

// Borrowed until the call returns. All ranks give the same, but for the callbacks' priv.
struct weft_items {
    int64_t count;               // items, 0 to count - 1
    enum weft_schedule schedule; // static: item i is of rank i mod ranks (default auto)
    const double *cost;          // expected of each item, in any unit, > 0: pull begins with the
                                 // dearest (default NULL: not known, in their order)
    // Does an item. *data is allocated with malloc and taken over; NULL of size 0: nothing is to be
    // told. Called in body's thread. Anything but WEFT_OK ends the work on all ranks.
    enum weft_result (*run)(void *priv, int64_t item, void **data, size_t *size);
    // Takes what came of an item, if there is something: on rank 0 only, in body's thread between
    // items of its own, once an item and in any order. At most two results of a rank wait for it,
    // or 64 that are at most 4 MiB together; a rank that has more goes on once they were taken.
    enum weft_result (*take)(void *priv, int64_t item, const void *data, size_t size);
    void *priv;
    const struct weft_progress *progress; // of all items; asked on rank 0 only; may be NULL
};

// What came of the work, on rank 0; on other ranks what they did themselves.
// A rank is busy while it runs items; taking results is counted apart.
struct weft_items_report {
    struct weft_load load;       // freed by weft_load_clear
    int64_t count;               // items: weft_items.count
    double *item_seconds;        // [count] that run took, for cost maps and models; freed likewise
    int *item_rank;              // [count] that did it; freed likewise
    enum weft_schedule schedule; // never auto
    int failed_rank;             // whose result is returned; -1: none
};
WEFT_API void weft_items_report_clear(struct weft_items_report *report); // accepts {0}

// Does all items, each once. Collective. With pull a rank asks for an item when it is free, or,
// while its items take less than 20 ms, one ahead. report may be NULL. Returns, on all ranks alike,
// WEFT_OK, or the result of the item with the lowest number among those that had failed when work
// was ended, or of `take`; WEFT_ERR_CANCELLED (progress), WEFT_ERR_ARGUMENT or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_ranks_do_items(weft_ranks *ranks, const struct weft_items *work,
                                              struct weft_items_report *report);

WEFT_END_DECLS
#endif
