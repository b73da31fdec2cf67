// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "tiles/kernel/kernel_tiles_impl.h"

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
