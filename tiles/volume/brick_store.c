// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/brick_store.h"

#include <stdlib.h>
#include <string.h>

#include "tiles/volume/cell_map.h"

// Node sizes as powers of two: bricks and 8-voxel tiles, then tiles of 128 and 4096.
static const int level_shift[] = {3, 7, 12};
enum { LEVELS = 3 };

struct slot {
    int32_t key[3]; // origin >> shift
    float constant;
    const float *values; // NULL: constant; `vacant`: no entry
};

struct table {
    struct slot *slots;
    size_t size, count; // size is a power of two or 0; at most half full
};

struct weft_brick_store {
    const struct weft_log *log;
    struct table level[LEVELS];
    float background;
    bool clamped;
    int32_t min[3], max[3];
};

static const float vacant[1];

static bool same_key(const int32_t a[3], const int32_t b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

// The slot that holds the key, or the vacant one where it belongs. The table is not empty.
static struct slot *find_slot(const struct table *table, const int32_t key[3])
{
    size_t mask = table->size - 1;
    for (size_t i = weft_cell_hash(key) & mask;; i = (i + 1) & mask) {
        struct slot *slot = &table->slots[i];
        if (slot->values == vacant || same_key(slot->key, key))
            return slot;
    }
}

static const struct slot *look_up(const struct table *table, const int32_t key[3])
{
    if (!table->count)
        return NULL;
    const struct slot *slot = find_slot(table, key);
    return slot->values == vacant ? NULL : slot;
}

static bool resize(struct table *table, size_t size)
{
    size_t bytes;
    struct table fresh = {.size = size};
    if (!weft_size_mul(size, sizeof *fresh.slots, &bytes) || !(fresh.slots = malloc(bytes)))
        return false;
    for (size_t i = 0; i < size; i++)
        fresh.slots[i].values = vacant;
    for (size_t i = 0; i < table->size; i++)
        if (table->slots[i].values != vacant) {
            *find_slot(&fresh, table->slots[i].key) = table->slots[i];
            fresh.count++;
        }
    free(table->slots);
    *table = fresh;
    return true;
}

enum weft_result weft_brick_store_create(const struct weft_log *log, size_t capacity,
                                         float background, weft_brick_store **out)
{
    *out = NULL;
    weft_brick_store *store = calloc(1, sizeof *store);
    if (!store)
        goto fail;
    store->log = log;
    store->background = background;
    size_t size = 16;
    while (size / 2 < capacity && size <= SIZE_MAX / 4)
        size *= 2;
    if (!resize(&store->level[0], size))
        goto fail;
    *out = store;
    return WEFT_OK;
fail:
    weft_error(log, "not enough memory for a table of %zu bricks", capacity);
    weft_brick_store_destroy(&store);
    return WEFT_ERR_MEMORY;
}

void weft_brick_store_destroy(weft_brick_store **store)
{
    if (!store || !*store)
        return;
    for (int i = 0; i < LEVELS; i++)
        free((*store)->level[i].slots);
    free(*store);
    *store = NULL;
}

static void make_key(const int32_t origin[3], int level, int32_t key[3])
{
    for (int i = 0; i < 3; i++)
        key[i] = origin[i] >> level_shift[level];
}

static enum weft_result add(weft_brick_store *store, int level, const int32_t origin[3],
                            const float *values, float constant)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct table *table = &store->level[level];
    for (int i = 0; i < 3; i++) {
        weft_require(store->log, origin[i] % (1 << level_shift[level]) == 0);
        weft_require(store->log, origin[i] >= -WEFT_INDEX_LIMIT && origin[i] < WEFT_INDEX_LIMIT);
    }
    if (table->count >= table->size / 2 && !resize(table, table->size ? table->size * 2 : 16)) {
        weft_error(store->log, "not enough memory for a table of %zu bricks", table->count);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    int32_t key[3];
    make_key(origin, level, key);
    struct slot *slot = find_slot(table, key);
    if (slot->values != vacant) {
        weft_error(store->log, "the brick or tile at (%d, %d, %d) is there twice", origin[0],
                   origin[1], origin[2]);
        goto fail;
    }
    *slot = (struct slot){{key[0], key[1], key[2]}, constant, values};
    table->count++;
    return WEFT_OK;
fail:
    return res;
}

enum weft_result weft_brick_store_add_brick(weft_brick_store *store, const int32_t origin[3],
                                            const float *values)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(store->log, values != NULL);
    return add(store, 0, origin, values, NAN);
fail:
    return res;
}

enum weft_result weft_brick_store_add_tile(weft_brick_store *store,
                                           const struct weft_volume_tile *tile)
{
    for (int level = 0; level < LEVELS; level++)
        if (tile->size == 1 << level_shift[level])
            return add(store, level, tile->origin, NULL, tile->value);
    weft_error(store->log, "a tile has %d voxels a side; 8, 128 and 4096 are possible", tile->size);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_brick_store_add_list(weft_brick_store *store,
                                           const struct weft_brick_list *list, const float *values)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < list->brick_count && !res; i++)
        res = weft_brick_store_add_brick(store, list->brick_origin[i],
                                         values + i * WEFT_BRICK_VOXELS);
    for (size_t i = 0; i < list->tile_count && !res; i++)
        res = weft_brick_store_add_tile(store, &list->tiles[i]);
    return res;
}

static const struct slot *find_cover(const weft_brick_store *store, int first,
                                     const int32_t origin[3])
{
    const struct slot *slot = NULL;
    for (int level = first; level < LEVELS && !slot; level++) {
        int32_t key[3];
        make_key(origin, level, key);
        slot = look_up(&store->level[level], key);
    }
    return slot;
}

enum weft_result weft_brick_store_check_disjoint(const weft_brick_store *store)
{
    for (int level = 0; level + 1 < LEVELS; level++)
        for (size_t i = 0; i < store->level[level].size; i++) {
            const struct slot *slot = &store->level[level].slots[i];
            if (slot->values == vacant)
                continue;
            int32_t origin[3];
            for (int c = 0; c < 3; c++)
                origin[c] = slot->key[c] * (1 << level_shift[level]);
            if (!find_cover(store, level + 1, origin))
                continue;
            weft_error(store->log, "the brick or tile at (%d, %d, %d) lies inside a larger tile",
                       origin[0], origin[1], origin[2]);
            return WEFT_ERR_ARGUMENT;
        }
    return WEFT_OK;
}

void weft_brick_store_clamp(weft_brick_store *store, const int32_t min[3], const int32_t max[3])
{
    store->clamped = true;
    memcpy(store->min, min, sizeof store->min);
    memcpy(store->max, max, sizeof store->max);
}

static bool outside(const weft_brick_store *store, const int32_t origin[3])
{
    for (int i = 0; i < 3; i++)
        if (origin[i] > store->max[i] || origin[i] < store->min[i] - (WEFT_BRICK_SIZE - 1))
            return true;
    return false;
}

enum weft_brick_kind weft_brick_store_find(const weft_brick_store *store, const int32_t origin[3],
                                           const float **values, float *constant)
{
    *values = NULL;
    *constant = NAN;
    if (store->clamped && outside(store, origin))
        return WEFT_BRICK_EDGE;
    const struct slot *slot = find_cover(store, 0, origin);
    if (slot && slot->values) {
        *values = slot->values;
        return WEFT_BRICK_VALUES;
    }
    *constant = slot ? slot->constant : store->background;
    return WEFT_BRICK_CONSTANT;
}

void weft_brick_store_copy(const weft_brick_store *store, const int32_t origin[3], float *out)
{
    const float *values;
    float constant;
    switch (weft_brick_store_find(store, origin, &values, &constant)) {
    case WEFT_BRICK_VALUES:
        memcpy(out, values, WEFT_BRICK_VOXELS * sizeof *out);
        break;
    case WEFT_BRICK_CONSTANT:
        for (int i = 0; i < WEFT_BRICK_VOXELS; i++)
            out[i] = constant;
        break;
    case WEFT_BRICK_EDGE: {
        struct weft_brick_cursor cursor = {.store = store};
        for (int i = 0; i < WEFT_BRICK_VOXELS; i++)
            out[i] = weft_brick_cursor_voxel(&cursor, origin[0] + (i & 7), origin[1] + (i >> 3 & 7),
                                             origin[2] + (i >> 6));
        break;
    }
    }
}

static int32_t clamp(int32_t x, int32_t low, int32_t high)
{
    return x < low ? low : x > high ? high : x;
}

float weft_brick_cursor_voxel(struct weft_brick_cursor *cursor, int32_t i, int32_t j, int32_t k)
{
    const weft_brick_store *store = cursor->store;
    if (store->clamped) {
        i = clamp(i, store->min[0], store->max[0]);
        j = clamp(j, store->min[1], store->max[1]);
        k = clamp(k, store->min[2], store->max[2]);
    }
    int32_t origin[3] = {i & ~7, j & ~7, k & ~7};
    if (!cursor->valid || !same_key(cursor->origin, origin)) {
        const struct slot *slot = find_cover(store, 0, origin);
        cursor->values = slot ? slot->values : NULL;
        cursor->constant = slot ? slot->constant : store->background;
        memcpy(cursor->origin, origin, sizeof origin);
        cursor->valid = true;
    }
    return cursor->values ? cursor->values[(k & 7) << 6 | (j & 7) << 3 | (i & 7)]
                          : cursor->constant;
}
