// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/volume_cache.h"

#include <stdlib.h>
#include <string.h>

#include "tiles/volume/cell_cache.h"
#include "tiles/volume/volume_impl.h"

enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float) };

struct cache {
    weft_volume *base;             // the caller's
    struct weft_cell_cache places; // of the bricks that are kept, as many as may be
    float **values;                // by place; NULL: free
    size_t capacity;
    struct weft_volume_cache_info info;
};

static void key_of(const int32_t origin[3], struct weft_cell_key *key)
{
    for (int a = 0; a < 3; a++)
        key->at[a] = origin[a] >> 3;
}

static int64_t find_brick(const struct cache *c, const int32_t origin[3])
{
    struct weft_cell_key key;
    key_of(origin, &key);
    return weft_cell_cache_find(&c->places, key.at);
}

// A place's own memory; NULL: there is none.
static float *place_values(struct cache *c, int64_t place)
{
    if ((size_t)place >= c->capacity) {
        const size_t capacity = c->capacity ? 2 * c->capacity : 256;
        float **values = realloc(c->values, capacity * sizeof *values);
        if (!values)
            return NULL;
        memset(values + c->capacity, 0, (capacity - c->capacity) * sizeof *values);
        c->values = values;
        c->capacity = capacity;
    }
    if (!c->values[place] && (c->values[place] = malloc(BRICK_BYTES)))
        c->info.kept_bytes += BRICK_BYTES;
    return c->values[place];
}

// Without memory a brick is not kept, and read again.
static void keep(struct cache *c, const int32_t origin[3], const float *values)
{
    struct weft_cell_key key;
    bool evicted;
    key_of(origin, &key);
    if (weft_cell_cache_find(&c->places, key.at) != WEFT_CELL_NONE) // asked for twice
        return;
    const int64_t place = weft_cell_cache_add(&c->places, key, &evicted);
    if (place == WEFT_CELL_NONE)
        return;
    float *own = place_values(c, place);
    if (own)
        memcpy(own, values, BRICK_BYTES);
    else
        weft_cell_cache_remove(&c->places, place);
}

// Hands out what is kept; returns how many are missing, whose places are noted.
static size_t copy_kept(struct cache *c, size_t count, const int32_t (*origin)[3], float *values,
                        size_t *missing)
{
    size_t missed = 0;
    for (size_t i = 0; i < count; i++) {
        const int64_t place = find_brick(c, origin[i]);
        if (place == WEFT_CELL_NONE) {
            missing[missed++] = i;
            continue;
        }
        weft_cell_cache_use(&c->places, place);
        memcpy(values + i * WEFT_BRICK_VOXELS, c->values[place], BRICK_BYTES);
    }
    return missed;
}

// Reads the missing ones, at once, and puts them in their places.
static enum weft_result read_missing(weft_volume *volume, size_t count, const int32_t (*origin)[3],
                                     float *values, const size_t *missing, size_t missed)
{
    struct cache *c = volume->data;
    enum weft_result res = WEFT_ERR_MEMORY;
    int32_t(*own)[3] = malloc(missed * sizeof *own);
    float *read = missed == count ? values : malloc(missed * BRICK_BYTES);
    if (own && read) {
        for (size_t i = 0; i < missed; i++)
            memcpy(own[i], origin[missing[i]], sizeof own[i]);
        res = weft_volume_read(c->base, missed, (const int32_t(*)[3])own, read);
    } else {
        weft_error(volume->log, "not enough memory to read %zu bricks", missed);
    }
    for (size_t i = 0; res == WEFT_OK && i < missed; i++) {
        float *out = values + missing[i] * WEFT_BRICK_VOXELS;
        if (read != values)
            memcpy(out, read + i * WEFT_BRICK_VOXELS, BRICK_BYTES);
        keep(c, own[i], out);
    }
    c->info.bricks_read += res == WEFT_OK ? missed : 0;
    if (read != values)
        free(read);
    free(own);
    return res;
}

static enum weft_result read(weft_volume *volume, size_t count, const int32_t (*brick_origin)[3],
                             float *values)
{
    enum weft_result res = WEFT_OK;
    size_t *missing = malloc(count * sizeof *missing + 1);
    if (!missing) {
        weft_error(volume->log, "not enough memory to read %zu bricks", count);
        return WEFT_ERR_MEMORY;
    }
    const size_t missed = copy_kept(volume->data, count, brick_origin, values, missing);
    if (missed)
        res = read_missing(volume, count, brick_origin, values, missing, missed);
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
    for (size_t i = 0; i < c->capacity; i++)
        free(c->values[i]);
    free(c->values);
    weft_cell_cache_clear(&c->places);
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
    const uint64_t places = memory_bytes / BRICK_BYTES;
    while (c->places.count > places) {
        const int64_t place = weft_cell_cache_remove_oldest(&c->places);
        free(c->values[place]);
        c->values[place] = NULL;
        c->info.kept_bytes -= BRICK_BYTES;
    }
    c->places.limit = places < UINT32_MAX / 4 ? (size_t)places : UINT32_MAX / 4;
}

const struct weft_volume_cache_info *weft_volume_cache_get_info(const weft_volume *cache)
{
    return &((const struct cache *)cache->data)->info;
}
