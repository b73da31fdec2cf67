// SPDX-License-Identifier: BSD-3-Clause
// tiles/output/order.h - what is made by several threads and put out in its order (not installed).
// While some items are made, those that are ready are taken, one after the other as they are
// numbered: no thread waits for the output alone, and no more than `slots` items are held at once.
#ifndef WEFT_TILES_OUTPUT_ORDER_H
#define WEFT_TILES_OUTPUT_ORDER_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

struct weft_order {
    int threads;         // at once, the caller's among them, >= 1
    size_t count, slots; // items; places for those that are made and not yet taken, >= 1
    // Makes item i in a slot that is free; thread < threads, 0 the caller's. At once for many i.
    bool (*make)(void *priv, int thread, size_t i, size_t slot);
    // Takes item i out of its slot, in any thread, one call at a time, i from 0 upwards.
    bool (*take)(void *priv, size_t i, size_t slot);
    // Called in the caller's thread before each item that it makes, with what has been taken; NULL:
    // nobody asks.
    bool (*ask)(void *priv, size_t taken);
    void *priv;
};

// Returns whether all items were taken: not where a call returned false, after which none is begun,
// or where there is no memory for the list of slots.
bool weft_order_run(const struct weft_order *order);

WEFT_END_DECLS
#endif
