// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/volume_cache.h"

#include <stdlib.h>
#include <string.h>

#include "tiles/volume/cell_map.h"
#include "tiles/volume/volume_impl.h"

enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float) };

struct cache {
    weft_volume *base; // the caller's
    uint64_t memory_bytes;
    struct weft_cell_map map; // of the bricks that are kept
    float **values;           // by number
    size_t capacity;
    struct weft_volume_cache_info info;
};

static struct weft_cell_key key_of(const int32_t origin[3])
{
    return (struct weft_cell_key){{origin[0] >> 3, origin[1] >> 3, origin[2] >> 3}};
}

static void drop(struct cache *c)
{
    for (size_t i = 0; i < c->map.count; i++)
        free(c->values[i]);
    weft_cell_map_destroy(&c->map);
    c->info.kept_bytes = 0;
}

// Without memory a brick is not kept, and read again.
static void keep(struct cache *c, const int32_t origin[3], const float *values)
{
    if (c->info.kept_bytes + BRICK_BYTES > c->memory_bytes ||
        weft_cell_map_find(&c->map, key_of(origin)) != WEFT_CELL_NONE)
        return;
    if (c->map.count == c->capacity) {
        const size_t capacity = c->capacity ? 2 * c->capacity : 256;
        void *list = realloc(c->values, capacity * sizeof *c->values);
        if (!list)
            return;
        c->values = list;
        c->capacity = capacity;
    }
    float *own = malloc(BRICK_BYTES);
    if (!own)
        return;
    memcpy(own, values, BRICK_BYTES);
    const int64_t number = weft_cell_map_add(&c->map, key_of(origin));
    if (number == WEFT_CELL_NONE) {
        free(own);
        return;
    }
    c->values[number] = own;
    c->info.kept_bytes += BRICK_BYTES;
}

// Hands out what is kept; returns how many are missing, whose places are noted.
static size_t copy_kept(const struct cache *c, size_t count, const int32_t (*origin)[3],
                        float *values, size_t *missing)
{
    size_t missed = 0;
    for (size_t i = 0; i < count; i++) {
        const int64_t number = weft_cell_map_find(&c->map, key_of(origin[i]));
        if (number == WEFT_CELL_NONE)
            missing[missed++] = i;
        else
            memcpy(values + i * WEFT_BRICK_VOXELS, c->values[number], BRICK_BYTES);
    }
    return missed;
}

// Reads the missing ones, at once, and puts them in their places.
static enum weft_result read_missing(struct cache *c, size_t count, const int32_t (*origin)[3],
                                     float *values, const size_t *missing, size_t missed)
{
    enum weft_result res = WEFT_ERR_MEMORY;
    int32_t(*own)[3] = malloc(missed * sizeof *own);
    float *read = missed == count ? values : malloc(missed * BRICK_BYTES);
    if (own && read) {
        for (size_t i = 0; i < missed; i++)
            memcpy(own[i], origin[missing[i]], sizeof own[i]);
        res = weft_volume_read(c->base, missed, (const int32_t(*)[3])own, read);
    }
    for (size_t i = 0; res == WEFT_OK && i < missed && read != values; i++)
        memcpy(values + missing[i] * WEFT_BRICK_VOXELS, read + i * WEFT_BRICK_VOXELS, BRICK_BYTES);
    if (read != values)
        free(read);
    free(own);
    return res;
}

static enum weft_result read(weft_volume *volume, size_t count, const int32_t (*brick_origin)[3],
                             float *values)
{
    struct cache *c = volume->data;
    enum weft_result res = WEFT_ERR_MEMORY;
    size_t *missing = malloc(count * sizeof *missing + 1);
    const size_t missed = missing ? copy_kept(c, count, brick_origin, values, missing) : 0;
    if (missing)
        res = missed ? read_missing(c, count, brick_origin, values, missing, missed) : WEFT_OK;
    if (res == WEFT_ERR_MEMORY)
        weft_error(volume->log, "not enough memory to read %zu bricks", count);
    if (res == WEFT_OK) {
        c->info.bricks_read += missed;
        if (c->info.kept_bytes + missed * BRICK_BYTES > c->memory_bytes)
            drop(c);
        if (count * BRICK_BYTES <= c->memory_bytes)
            for (size_t i = 0; i < count; i++)
                keep(c, brick_origin[i], values + i * WEFT_BRICK_VOXELS);
    }
    free(missing);
    return res;
}

static enum weft_result find(weft_volume *volume, const struct weft_region *region,
                             struct weft_brick_list *out)
{
    const struct cache *c = volume->data;
    return weft_volume_find(c->base, region, out);
}

static void clear(void *data)
{
    struct cache *c = data;
    drop(c);
    free(c->values);
}

static const struct weft_volume_backend backend = {
    .data_bytes = sizeof(struct cache), .find = find, .read = read, .clear = clear};

enum weft_result weft_volume_cache(weft_volume *volume, const struct weft_log *log,
                                   weft_volume **out)
{
    const enum weft_result res = weft_volume_make(log, &backend, out);
    if (res != WEFT_OK)
        return res;
    (*out)->info = volume->info;
    (*out)->info.metadata_count = 0;
    (*out)->info.metadata = NULL;
    ((struct cache *)(*out)->data)->base = volume;
    return WEFT_OK;
}

void weft_volume_cache_limit(weft_volume *cache, uint64_t memory_bytes)
{
    struct cache *c = cache->data;
    c->memory_bytes = memory_bytes;
    if (c->info.kept_bytes > memory_bytes)
        drop(c);
}

const struct weft_volume_cache_info *weft_volume_cache_get_info(const weft_volume *cache)
{
    return &((const struct cache *)cache->data)->info;
}
