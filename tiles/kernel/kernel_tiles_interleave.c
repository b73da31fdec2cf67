// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tiles/kernel/kernel_tiles_impl.h"

// ---- splitting ----------------------------------------------------------------------------------

static bool more_fits(const weft_kernel_tiles *set, size_t bytes, const char *what)
{
    if (bytes <= set->params.memory_bytes &&
        set->info.memory_bytes <= set->params.memory_bytes - bytes)
        return true;
    weft_error(set->params.log, "tiles: %s takes %zu bytes besides %zu, over the limit of %.0f",
               what, bytes, set->info.memory_bytes, (double)set->params.memory_bytes);
    return false;
}

// Both sides of the threshold, as the tile's weights see it.
static void divide(const weft_kernel_tiles *set, const struct weft_kernel_tile *tile,
                   double threshold, const void *source, void *high, void *low)
{
    const double unit = (tile->negated ? -1.0 : 1.0) / (set->info.one * tile->scale);
    for (size_t i = 0; i < set->info.tile_values; i++) {
        const double q = weft_tiles_load(set, source, i);
        const bool above = q * unit >= threshold;
        weft_tiles_store(set, low, i, above ? 0.0 : q); // high may be the source
        weft_tiles_store(set, high, i, above ? q : 0.0);
    }
}

// Room for one more tile and up to two more stored ones.
static bool make_room(weft_kernel_tiles *set)
{
    const size_t tiles = (size_t)set->info.tile_count, stored = (size_t)set->info.stored_count;
    struct weft_kernel_tile *t = realloc(set->tiles, (tiles + 1) * sizeof *t);
    set->tiles = t ? t : set->tiles;
    struct weft_stored_tile *s = realloc(set->stored, (stored + 2) * sizeof *s);
    set->stored = s ? s : set->stored;
    return t && s;
}

static int add_stored(weft_kernel_tiles *set, void *data, double scale)
{
    const int number = set->info.stored_count++;
    set->stored[number] = (struct weft_stored_tile){.data = data, .scale = scale, .users = 1};
    set->info.memory_bytes += set->info.tile_values * set->info.value_bytes;
    return number;
}

enum weft_result weft_kernel_tiles_split(weft_kernel_tiles *tiles, int tile, double threshold)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const size_t bytes = tiles->info.tile_values * tiles->info.value_bytes;
    void *low = NULL, *high = NULL;
    weft_require(tiles->params.log, tile >= 0 && tile < tiles->info.tile_count);
    const bool shared = tiles->stored[tiles->tiles[tile].stored].users > 1;
    res = WEFT_ERR_LIMIT;
    if (!more_fits(tiles, shared ? 2 * bytes : bytes, "splitting a tile"))
        goto fail;
    res = WEFT_ERR_MEMORY;
    low = malloc(bytes);
    high = shared ? malloc(bytes) : NULL;
    if (!low || (shared && !high) || !make_room(tiles)) {
        weft_error(tiles->params.log, "tiles: not enough memory for %zu bytes of a split tile",
                   bytes);
        goto fail;
    }
    struct weft_kernel_tile *upper = &tiles->tiles[tile];
    struct weft_kernel_tile *lower = &tiles->tiles[tiles->info.tile_count++];
    const double at = isnan(threshold) ? 0.5 * (upper->minimum + upper->maximum) : threshold;
    void *source = tiles->stored[upper->stored].data;
    divide(tiles, upper, at, source, shared ? high : source, low);
    *lower = *upper;
    if (shared) {
        tiles->stored[upper->stored].users--;
        upper->stored = add_stored(tiles, high, upper->scale);
    }
    lower->stored = add_stored(tiles, low, lower->scale);
    weft_tiles_measure(tiles, &tiles->stored[upper->stored]);
    weft_tiles_measure(tiles, &tiles->stored[lower->stored]);
    weft_tiles_refresh(tiles, upper);
    weft_tiles_refresh(tiles, lower);
    return WEFT_OK;
fail:
    free(low);
    free(high);
    return res;
}

// ---- interleaving by four -----------------------------------------------------------------------

// The tile unmirrored, to every fourth value from `component` on.
static void spread(const weft_kernel_tiles *set, int tile, int component, void *out)
{
    const struct weft_kernel_tile *t = &set->tiles[tile];
    const int last = set->info.samples - 1;
    int at[3] = {0};
    size_t i = 0;
    do {
        int from[3] = {0};
        for (int a = 0; a < set->info.dims; a++)
            from[a] = t->mirrored[a] ? last - at[a] : at[a];
        const double q = weft_tiles_load(set, t->data, weft_tiles_sample_index(set, from));
        weft_tiles_store(set, out, 4 * i++ + (size_t)component, q);
    } while (weft_tiles_next(set->info.dims, set->info.samples, at));
}

enum weft_result weft_tile_group_create(const weft_kernel_tiles *tiles, const int tile[4],
                                        struct weft_tile_group *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = (struct weft_tile_group){.tile = {-1, -1, -1, -1}};
    const size_t values = 4 * tiles->info.tile_values; // at most 2^38
    for (int c = 0; c < 4; c++)
        weft_require(tiles->params.log, tile[c] >= -1 && tile[c] < tiles->info.tile_count);
    if (values > tiles->params.memory_bytes / tiles->info.value_bytes) {
        weft_error(tiles->params.log,
                   "tiles: interleaving four takes %zu bytes, over the limit of %.0f",
                   values * tiles->info.value_bytes, (double)tiles->params.memory_bytes);
        res = WEFT_ERR_LIMIT;
        goto fail;
    }
    out->data = calloc(values, tiles->info.value_bytes);
    if (!out->data) {
        weft_error(tiles->params.log, "tiles: not enough memory for %zu bytes of interleaved tiles",
                   values * tiles->info.value_bytes);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    for (int c = 0; c < 4; c++) {
        out->tile[c] = tile[c];
        if (tile[c] < 0)
            continue;
        out->factor[c] = (tiles->tiles[tile[c]].negated ? -1.0 : 1.0) / tiles->tiles[tile[c]].scale;
        spread(tiles, tile[c], c, out->data);
    }
    return WEFT_OK;
fail:
    return res;
}

static int count_tiles(const weft_kernel_tiles *set, const int tap[3], enum weft_tile_part part)
{
    int count = 0;
    for (int i = 0; i < set->info.tile_count; i++)
        count += set->tiles[i].part == part &&
                 memcmp(set->tiles[i].tap, tap, sizeof set->tiles[i].tap) == 0;
    return count;
}

enum weft_result weft_tile_group_create_taps(const weft_kernel_tiles *tiles, const int tap[4][3],
                                             enum weft_tile_part part, struct weft_tile_group *out)
{
    int tile[4];
    *out = (struct weft_tile_group){.tile = {-1, -1, -1, -1}};
    for (int c = 0; c < 4; c++) {
        if (count_tiles(tiles, tap[c], part) > 1) {
            weft_error(tiles->params.log, "tiles: the tile of tap (%d, %d, %d) is split", tap[c][0],
                       tap[c][1], tap[c][2]);
            return WEFT_ERR_ARGUMENT;
        }
        tile[c] = weft_kernel_tiles_find(tiles, tap[c], part);
    }
    return weft_tile_group_create(tiles, tile, out);
}

void weft_tile_group_destroy(struct weft_tile_group *group)
{
    if (!group)
        return;
    free(group->data);
    *group = (struct weft_tile_group){0};
}

double weft_tile_group_value(const weft_kernel_tiles *tiles, const struct weft_tile_group *group,
                             int component, const int position[3])
{
    for (int a = 0; a < tiles->info.dims; a++)
        if (position[a] < 0 || position[a] >= tiles->info.samples)
            return NAN;
    if (!group->data || component < 0 || component > 3)
        return NAN;
    const size_t i = 4 * weft_tiles_sample_index(tiles, position) + (size_t)component;
    return weft_tiles_load(tiles, group->data, i) / tiles->info.one * group->factor[component];
}
