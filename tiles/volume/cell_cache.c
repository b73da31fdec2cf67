// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/cell_cache.h"

#include <stdlib.h>
#include <string.h>

static bool same(const struct weft_cell_key *key, const int32_t at[3])
{
    return key->at[0] == at[0] && key->at[1] == at[1] && key->at[2] == at[2];
}

// ---- the table ----------------------------------------------------------------------------------

// The slot that holds the cell, or the vacant one where it belongs; the table is not empty.
static size_t find_slot(const struct weft_cell_cache *c, const int32_t at[3])
{
    const size_t mask = c->slot_count - 1;
    size_t i = weft_cell_hash(at) & mask;
    while (c->slots[i] && !same(&c->places[c->slots[i] - 1].key, at))
        i = (i + 1) & mask;
    return i;
}

// Vacates a slot; those after it that it kept from their own move up.
static void vacate(struct weft_cell_cache *c, size_t hole)
{
    const size_t mask = c->slot_count - 1;
    for (size_t i = (hole + 1) & mask; c->slots[i]; i = (i + 1) & mask) {
        const size_t home = weft_cell_hash(c->places[c->slots[i] - 1].key.at) & mask;
        if (((i - home) & mask) < ((i - hole) & mask))
            continue;
        c->slots[hole] = c->slots[i];
        hole = i;
    }
    c->slots[hole] = 0;
}

// Room for twice as many places.
static bool grow(struct weft_cell_cache *c)
{
    const size_t twice = c->capacity ? 2 * c->capacity : 256;
    const size_t capacity = twice < c->limit ? twice : c->limit;
    size_t slot_count = 16;
    while (slot_count < 2 * capacity)
        slot_count *= 2;
    void *places = realloc(c->places, capacity * sizeof *c->places);
    if (places)
        c->places = places;
    uint32_t *slots = places ? calloc(slot_count, sizeof *slots) : NULL;
    if (!slots)
        return false;
    free(c->slots);
    c->slots = slots;
    c->slot_count = slot_count;
    c->capacity = capacity;
    for (uint32_t n = c->newest; n; n = c->places[n - 1].older)
        c->slots[find_slot(c, c->places[n - 1].key.at)] = n;
    return true;
}

// ---- the order of use ---------------------------------------------------------------------------

static void take_out(struct weft_cell_cache *c, const struct weft_cell_place *place)
{
    *(place->newer ? &c->places[place->newer - 1].older : &c->newest) = place->older;
    *(place->older ? &c->places[place->older - 1].newer : &c->oldest) = place->newer;
}

static void put_first(struct weft_cell_cache *c, uint32_t n)
{
    struct weft_cell_place *place = &c->places[n - 1];
    place->newer = 0;
    place->older = c->newest;
    *(c->newest ? &c->places[c->newest - 1].newer : &c->oldest) = n;
    c->newest = n;
}

// ---- the calls ----------------------------------------------------------------------------------

int64_t weft_cell_cache_find(const struct weft_cell_cache *c, const int32_t at[3])
{
    return c->slot_count ? (int64_t)c->slots[find_slot(c, at)] - 1 : WEFT_CELL_NONE;
}

void weft_cell_cache_use(struct weft_cell_cache *c, int64_t number)
{
    const uint32_t n = (uint32_t)number + 1;
    if (c->newest == n)
        return;
    take_out(c, &c->places[number]);
    put_first(c, n);
}

int64_t weft_cell_cache_add(struct weft_cell_cache *c, struct weft_cell_key key, bool *evicted)
{
    *evicted = false;
    if (c->limit == 0)
        return WEFT_CELL_NONE;
    if (c->count >= c->limit) {
        weft_cell_cache_remove_oldest(c);
        *evicted = true;
    }
    if (!c->free && c->known == c->capacity && !grow(c))
        return WEFT_CELL_NONE;
    uint32_t n = c->free;
    if (n)
        c->free = c->places[n - 1].older;
    else
        n = (uint32_t)++c->known;
    c->places[n - 1].key = key;
    c->slots[find_slot(c, key.at)] = n;
    put_first(c, n);
    c->count++;
    return (int64_t)n - 1;
}

void weft_cell_cache_remove(struct weft_cell_cache *c, int64_t number)
{
    struct weft_cell_place *place = &c->places[number];
    vacate(c, find_slot(c, place->key.at));
    take_out(c, place);
    place->older = c->free;
    c->free = (uint32_t)number + 1;
    c->count--;
}

int64_t weft_cell_cache_remove_oldest(struct weft_cell_cache *c)
{
    const int64_t number = (int64_t)c->oldest - 1;
    if (number != WEFT_CELL_NONE)
        weft_cell_cache_remove(c, number);
    return number;
}

void weft_cell_cache_clear(struct weft_cell_cache *c)
{
    free(c->places);
    free(c->slots);
    *c = (struct weft_cell_cache){.limit = c->limit};
}
