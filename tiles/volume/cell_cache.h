// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/cell_cache.h - a limited number of places for cells, of which those least recently
// used give way to new ones (not installed). What lies in a place is its owner's, who keeps it by
// number.
#ifndef WEFT_TILES_VOLUME_CELL_CACHE_H
#define WEFT_TILES_VOLUME_CELL_CACHE_H

#include "tiles/volume/cell_map.h"

// A cell, and its neighbours in the order of use. Places that are free have only `older`.
struct weft_cell_place {
    struct weft_cell_key key;
    uint32_t newer, older; // number + 1; 0: none
};

// {.limit = n} is an empty cache of up to n places, which are numbered from 0; tables grow as they
// are taken. Finding and using takes a constant time on average.
struct weft_cell_cache {
    size_t limit;                   // may change while no more places than that are taken
    struct weft_cell_place *places; // `known` of them, `capacity` allocated
    size_t known, capacity;
    size_t count;                  // places taken
    uint32_t newest, oldest, free; // number + 1; 0: none
    uint32_t *slots;               // open addressing: number + 1, 0 = vacant
    size_t slot_count;
};

// The cell's number, or WEFT_CELL_NONE. Looking is no use.
int64_t weft_cell_cache_find(const struct weft_cell_cache *cache, const int32_t at[3]);

// From now on this place is the one most recently used.
void weft_cell_cache_use(struct weft_cell_cache *cache, int64_t number);

// A place for a cell that has none, the most recently used one from now on: a free one, or that of
// the cell least recently used, which it loses; *evicted says whether one did. WEFT_CELL_NONE when
// memory ran out, or the limit is 0; nothing has changed then.
int64_t weft_cell_cache_add(struct weft_cell_cache *cache, struct weft_cell_key key, bool *evicted);

// Frees a place that is taken.
void weft_cell_cache_remove(struct weft_cell_cache *cache, int64_t number);

// Frees the place least recently used and returns its number; WEFT_CELL_NONE where none is taken.
int64_t weft_cell_cache_remove_oldest(struct weft_cell_cache *cache);

void weft_cell_cache_clear(struct weft_cell_cache *cache); // the limit stays

#endif
