// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/brick_reader.h"

#include <stdlib.h>

#include "tiles/volume/volume_impl.h"

enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float) };

// ---- what lies where ----------------------------------------------------------------------------

void weft_region_clamp(const struct weft_volume_info *volume, struct weft_region *region)
{
    region->slab_count = 0;
    for (int a = 0; a < 3; a++) {
        int32_t low = volume->active_min[a], high = volume->active_max[a];
        region->min[a] = region->min[a] < low ? low : region->min[a] > high ? high : region->min[a];
        region->max[a] = region->max[a] > high ? high : region->max[a] < low ? low : region->max[a];
    }
}

static enum weft_result add_tiles(const struct weft_volume_info *info,
                                  const struct weft_brick_list *topology, weft_brick_store *store)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; res == WEFT_OK && i < topology->tile_count; i++)
        res = weft_brick_store_add_tile(store, &topology->tiles[i]);
    if (res == WEFT_OK && info->clamp_to_edge)
        weft_brick_store_clamp(store, info->active_min, info->active_max);
    return res;
}

enum weft_result weft_brick_places_create(const struct weft_log *log,
                                          const struct weft_volume_info *info,
                                          const struct weft_brick_list *topology,
                                          weft_brick_store **out)
{
    static const float unread[WEFT_BRICK_VOXELS];
    enum weft_result res = weft_brick_store_create(
        log, topology->brick_count + topology->tile_count, info->background, out);
    for (size_t i = 0; res == WEFT_OK && i < topology->brick_count; i++)
        res = weft_brick_store_add_brick(*out, topology->brick_origin[i], unread);
    if (res == WEFT_OK)
        res = add_tiles(info, topology, *out);
    if (res != WEFT_OK)
        weft_brick_store_destroy(out);
    return res;
}

enum weft_result weft_brick_reader_open(const struct weft_log *log, weft_volume *volume,
                                        const struct weft_region *region,
                                        struct weft_brick_reader *out)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_region reached = *region;
    *out = (struct weft_brick_reader){.volume = volume, .log = log};
    if (info->clamp_to_edge)
        weft_region_clamp(info, &reached);
    enum weft_result res = weft_volume_find(volume, &reached, &out->topology);
    if (res == WEFT_OK)
        res = weft_brick_places_create(log, info, &out->topology, &out->places);
    out->has_tiles = out->topology.tile_count > 0;
    if (res != WEFT_OK)
        weft_brick_reader_close(out);
    return res;
}

bool weft_brick_reader_borrow(const struct weft_log *log, weft_volume *volume,
                              struct weft_brick_reader *out)
{
    const struct weft_volume_memory *memory = weft_volume_in_memory(volume);
    if (!memory)
        return false;
    *out = (struct weft_brick_reader){.volume = volume,
                                      .log = log,
                                      .borrowed = true,
                                      .has_tiles = memory->tile_count > 0,
                                      .places = memory->store,
                                      .store = memory->store};
    return true;
}

void weft_brick_reader_close(struct weft_brick_reader *r)
{
    weft_brick_reader_drop(r);
    free(r->lots);
    if (!r->borrowed)
        weft_brick_store_destroy(&r->places);
    weft_brick_list_clear(&r->topology);
    *r = (struct weft_brick_reader){.volume = NULL};
}

// The bricks, from the first to the last along each axis, that hold a box of voxels, which is
// clamped where the volume is; in units of 8 voxels.
static void find_bricks(const struct weft_volume_info *v, const int32_t min[3],
                        const int32_t max[3], struct weft_cell_key *from, struct weft_cell_key *to)
{
    for (int a = 0; a < 3; a++) {
        const int32_t low = v->clamp_to_edge ? v->active_min[a] : min[a];
        const int32_t high = v->clamp_to_edge ? v->active_max[a] : max[a];
        from->at[a] = (min[a] < low ? low : min[a] > high ? high : min[a]) >> 3;
        to->at[a] = (max[a] < low ? low : max[a] > high ? high : max[a]) >> 3;
    }
}

bool weft_brick_reader_note(const struct weft_brick_reader *r, const int32_t min[3],
                            const int32_t max[3], struct weft_cell_map *bricks)
{
    struct weft_cell_key from, to, at;
    find_bricks(weft_volume_get_info(r->volume), min, max, &from, &to);
    for (at.at[2] = from.at[2]; at.at[2] <= to.at[2]; at.at[2]++) {
        for (at.at[1] = from.at[1]; at.at[1] <= to.at[1]; at.at[1]++) {
            for (at.at[0] = from.at[0]; at.at[0] <= to.at[0]; at.at[0]++) {
                const int32_t origin[3] = {at.at[0] * 8, at.at[1] * 8, at.at[2] * 8};
                const float *values;
                float constant;
                if (weft_brick_store_find(r->places, origin, &values, &constant) ==
                        WEFT_BRICK_VALUES &&
                    weft_cell_map_add(bricks, at) == WEFT_CELL_NONE)
                    return false;
            }
        }
    }
    return true;
}

// ---- voxels -------------------------------------------------------------------------------------

static enum weft_result create_store(struct weft_brick_reader *r)
{
    const struct weft_volume_info *info = weft_volume_get_info(r->volume);
    enum weft_result res =
        weft_brick_store_create(r->log, r->topology.tile_count, info->background, &r->store);
    if (res == WEFT_OK)
        res = add_tiles(info, &r->topology, r->store);
    if (res != WEFT_OK)
        weft_brick_store_destroy(&r->store);
    return res;
}

static bool is_kept(const struct weft_brick_reader *r, const struct weft_cell_key *key)
{
    const int32_t origin[3] = {key->at[0] * 8, key->at[1] * 8, key->at[2] * 8};
    const float *values;
    float constant;
    return r->store &&
           weft_brick_store_find(r->store, origin, &values, &constant) == WEFT_BRICK_VALUES;
}

size_t weft_brick_reader_missing(const struct weft_brick_reader *r,
                                 const struct weft_cell_map *bricks)
{
    size_t count = 0;
    for (size_t i = 0; i < bricks->count; i++)
        count += !is_kept(r, &bricks->keys[i]);
    return count;
}

void weft_brick_reader_drop(struct weft_brick_reader *r)
{
    if (r->borrowed)
        return;
    weft_brick_store_destroy(&r->store);
    for (size_t i = 0; i < r->lot_count; i++)
        free(r->lots[i]);
    r->lot_count = 0;
    r->kept_bytes = 0;
}

// Room for the voxels of so many bricks; NULL: out of memory.
static float *add_lot(struct weft_brick_reader *r, size_t bricks)
{
    if (r->lot_count == r->lot_capacity) {
        const size_t capacity = r->lot_capacity ? 2 * r->lot_capacity : 16;
        void *lots = realloc(r->lots, capacity * sizeof *r->lots);
        if (!lots)
            return NULL;
        r->lots = lots;
        r->lot_capacity = capacity;
    }
    float *values = malloc(bricks * BRICK_BYTES);
    if (values)
        r->lots[r->lot_count++] = values;
    return values;
}

static enum weft_result read_missing(struct weft_brick_reader *r,
                                     const struct weft_cell_map *bricks, size_t count)
{
    enum weft_result res = WEFT_ERR_MEMORY;
    int32_t(*origin)[3] = malloc(count * sizeof *origin);
    float *values = origin ? add_lot(r, count) : NULL;
    if (!values) {
        weft_error(r->log, "not enough memory for the voxels of %zu bricks", count);
        goto fail;
    }
    size_t n = 0;
    for (size_t i = 0; i < bricks->count; i++) {
        if (is_kept(r, &bricks->keys[i]))
            continue;
        for (int a = 0; a < 3; a++)
            origin[n][a] = bricks->keys[i].at[a] * WEFT_BRICK_SIZE;
        n++;
    }
    const double start = weft_now_seconds();
    res = weft_volume_read(r->volume, count, (const int32_t(*)[3])origin, values);
    r->read_seconds += weft_now_seconds() - start;
    if (res != WEFT_OK)
        goto fail;
    r->kept_bytes += count * BRICK_BYTES;
    r->bricks_read += count;
    for (size_t i = 0; res == WEFT_OK && i < count; i++)
        res = weft_brick_store_add_brick(r->store, origin[i], values + i * WEFT_BRICK_VOXELS);
fail:
    free(origin);
    return res;
}

enum weft_result weft_brick_reader_load(struct weft_brick_reader *r,
                                        const struct weft_cell_map *bricks)
{
    enum weft_result res = r->store ? WEFT_OK : create_store(r);
    const size_t missing = res == WEFT_OK ? weft_brick_reader_missing(r, bricks) : 0;
    if (missing)
        res = read_missing(r, bricks, missing);
    if (res != WEFT_OK)
        weft_brick_reader_drop(r);
    return res;
}
