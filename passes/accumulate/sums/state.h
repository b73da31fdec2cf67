// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/sums/state.h - the bytes of a state, written one after another and taken back
// in the same order (not installed). Failures stay until the end, so that not every call has to be
// checked: whoever saves or loads looks once.
#ifndef WEFT_PASSES_ACCUMULATE_SUMS_STATE_H
#define WEFT_PASSES_ACCUMULATE_SUMS_STATE_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// Bytes that grow, or that are read. Starts as {0}, or with bytes and size of what is read.
typedef struct weft_state {
    unsigned char *bytes; // of one that grows: to be freed
    size_t size;          // that there are
    size_t capacity;      // that fit; 0 of one that is read
    size_t at;            // that were taken
    bool failed;          // no memory, or more was taken than there is
} weft_state;

// Adds `size` bytes as they are in memory.
void weft_state_put(weft_state *state, const void *bytes, size_t size);
// Takes the next `size` bytes; where there are fewer, zeros, and returns false.
bool weft_state_take(weft_state *state, void *bytes, size_t size);

WEFT_END_DECLS
#endif
