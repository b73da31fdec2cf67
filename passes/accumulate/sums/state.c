// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/state.h"

#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

static bool make_room(weft_state *state, size_t size)
{
    size_t needed = 0, capacity = state->capacity;
    if (state->failed || !weft_size_add(state->size, size, &needed))
        return false;
    if (needed <= capacity)
        return true;
    if (!weft_size_add(needed, needed / 2, &capacity))
        return false;
    unsigned char *bytes = realloc(state->bytes, capacity);
    if (!bytes)
        return false;
    state->bytes = bytes;
    state->capacity = capacity;
    return true;
}

void weft_state_put(weft_state *state, const void *bytes, size_t size)
{
    if (size == 0)
        return;
    if (!make_room(state, size)) {
        state->failed = true;
        return;
    }
    memcpy(state->bytes + state->size, bytes, size);
    state->size += size;
}

bool weft_state_take(weft_state *state, void *bytes, size_t size)
{
    if (size == 0)
        return true;
    if (state->failed || size > state->size - state->at) {
        state->failed = true;
        memset(bytes, 0, size);
        return false;
    }
    memcpy(bytes, state->bytes + state->at, size);
    state->at += size;
    return true;
}
