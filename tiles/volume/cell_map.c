// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/cell_map.h"

#include <stdlib.h>
#include <string.h>

// The slot that holds the key, or the vacant one where it belongs; the table is not empty.
static uint32_t *find_slot(const struct weft_cell_map *map, struct weft_cell_key key)
{
    size_t mask = map->slot_count - 1;
    for (size_t i = weft_cell_hash(key.at) & mask;; i = (i + 1) & mask) {
        uint32_t *slot = &map->slots[i];
        if (*slot == 0 || memcmp(&map->keys[*slot - 1], &key, sizeof key) == 0)
            return slot;
    }
}

static bool grow(struct weft_cell_map *map)
{
    size_t capacity = map->capacity ? 2 * map->capacity : 256;
    struct weft_cell_key *keys = realloc(map->keys, capacity * sizeof *keys);
    if (!keys)
        return false;
    map->keys = keys;
    uint32_t *slots = calloc(2 * capacity, sizeof *slots);
    if (!slots)
        return false;
    free(map->slots);
    map->slots = slots;
    map->slot_count = 2 * capacity;
    map->capacity = capacity;
    for (size_t i = 0; i < map->count; i++)
        *find_slot(map, map->keys[i]) = (uint32_t)i + 1;
    return true;
}

int64_t weft_cell_map_add(struct weft_cell_map *map, struct weft_cell_key key)
{
    if (map->count == map->capacity && !(map->count < UINT32_MAX / 4 && grow(map)))
        return WEFT_CELL_NONE;
    uint32_t *slot = find_slot(map, key);
    if (*slot == 0) {
        map->keys[map->count++] = key;
        *slot = (uint32_t)map->count;
    }
    return (int64_t)*slot - 1;
}

int64_t weft_cell_map_find(const struct weft_cell_map *map, struct weft_cell_key key)
{
    return map->count ? (int64_t)*find_slot(map, key) - 1 : WEFT_CELL_NONE;
}

void weft_cell_map_destroy(struct weft_cell_map *map)
{
    free(map->keys);
    free(map->slots);
    *map = (struct weft_cell_map){0};
}
