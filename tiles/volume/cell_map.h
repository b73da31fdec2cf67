// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/cell_map.h - numbers cells by their coordinates in the order of first sight (not
// installed).
#ifndef WEFT_TILES_VOLUME_CELL_MAP_H
#define WEFT_TILES_VOLUME_CELL_MAP_H

#include "filter/check.h"

struct weft_cell_key {
    int32_t at[3];
};

// {0} is an empty map.
struct weft_cell_map {
    struct weft_cell_key *keys; // count of them, by number
    size_t count, capacity;
    uint32_t *slots; // open addressing; number + 1, 0 = vacant
    size_t slot_count;
};

enum { WEFT_CELL_NONE = -1 };

// Mixes three coordinates so that neighbours spread over any power of two of slots.
static inline size_t weft_cell_hash(const int32_t at[3])
{
    uint64_t h = (uint64_t)(uint32_t)at[0] * UINT64_C(0x9e3779b97f4a7c15);
    h ^= (uint64_t)(uint32_t)at[1] * UINT64_C(0xc2b2ae3d27d4eb4f);
    h ^= (uint64_t)(uint32_t)at[2] * UINT64_C(0x165667b19e3779f9);
    h = (h ^ h >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return (size_t)(h ^ h >> 29);
}

// The cell's number, a new one when it was not there; WEFT_CELL_NONE when memory ran out.
int64_t weft_cell_map_add(struct weft_cell_map *map, struct weft_cell_key key);
// The cell's number or WEFT_CELL_NONE.
int64_t weft_cell_map_find(const struct weft_cell_map *map, struct weft_cell_key key);
void weft_cell_map_destroy(struct weft_cell_map *map);

#endif
