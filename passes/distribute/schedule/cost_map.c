// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/schedule/cost_map.h"

#include <math.h>
#include <stdlib.h>

#include "passes/distribute/schedule/cost_map_impl.h"

// An estimate is never less: what costs nothing is still an item.
static const double least_seconds = 1e-12;

static int32_t cells_of(int32_t length)
{
    return length < WEFT_COST_MAP_CELLS ? length : WEFT_COST_MAP_CELLS;
}

enum weft_result weft_cost_map_create(int32_t width, int32_t height, weft_cost_map **out)
{
    *out = NULL;
    if (width < 1 || height < 1)
        return WEFT_ERR_ARGUMENT;
    weft_cost_map *map = malloc(sizeof *map);
    if (!map)
        return WEFT_ERR_MEMORY;
    *map = (weft_cost_map){width, height, cells_of(width), cells_of(height), NULL, NULL};
    const size_t count = (size_t)map->columns * (size_t)map->rows;
    map->seconds = calloc(count, sizeof *map->seconds);
    map->times = calloc(count, sizeof *map->times);
    if (!map->seconds || !map->times) {
        weft_cost_map_destroy(&map);
        return WEFT_ERR_MEMORY;
    }
    *out = map;
    return WEFT_OK;
}

void weft_cost_map_destroy(weft_cost_map **map)
{
    if (*map) {
        free((*map)->seconds), free((*map)->times);
        free(*map);
    }
    *map = NULL;
}

// ---- cells that a part overlaps -----------------------------------------------------------------

struct range {
    int32_t first, last; // cells
    double low, high;    // in cells
};

static struct range range_of(const double at[2], int32_t length, int32_t count)
{
    struct range r = {.low = at[0] * count / length, .high = at[1] * count / length};
    r.first = (int32_t)r.low < count ? (int32_t)r.low : count - 1;
    r.last = (int32_t)ceil(r.high) - 1 < count ? (int32_t)ceil(r.high) - 1 : count - 1;
    return r;
}

// How much of a cell is in the range, 0 to 1.
static double share(const struct range *r, int32_t cell)
{
    return fmax(0.0, fmin(r->high, cell + 1.0) - fmax(r->low, cell));
}

void weft_cost_map_spread(weft_cost_map *map, const double x[2], const double y[2], double seconds)
{
    const struct range across = range_of(x, map->width, map->columns);
    const struct range down = range_of(y, map->height, map->rows);
    const double area = (across.high - across.low) * (down.high - down.low);
    for (int32_t r = down.first; r <= down.last; r++)
        for (int32_t c = across.first; c <= across.last; c++) {
            const double part = share(&across, c) * share(&down, r);
            map->seconds[r * map->columns + c] += seconds * (part / area);
            map->times[r * map->columns + c] += part;
        }
}

// What a cell costs that nothing is known of: the mean of what is known.
static double mean_seconds(const weft_cost_map *map)
{
    double seconds = 0.0, times = 0.0;
    for (int32_t i = 0; i < map->rows * map->columns; i++)
        seconds += map->seconds[i], times += map->times[i];
    return times > 0.0 ? seconds / times : 1.0;
}

double weft_cost_map_sum(const weft_cost_map *map, const double x[2], const double y[2])
{
    const struct range across = range_of(x, map->width, map->columns);
    const struct range down = range_of(y, map->height, map->rows);
    double sum = 0.0, unknown = 0.0;
    for (int32_t r = down.first; r <= down.last; r++)
        for (int32_t c = across.first; c <= across.last; c++) {
            const int32_t i = r * map->columns + c;
            const double part = share(&across, c) * share(&down, r);
            if (map->times[i] > 0.0)
                sum += map->seconds[i] / map->times[i] * part;
            else
                unknown += part;
        }
    return unknown > 0.0 ? sum + unknown * mean_seconds(map) : sum;
}

// ---- regions ------------------------------------------------------------------------------------

static bool place(const weft_cost_map *map, const struct weft_rectangle *region, double x[2],
                  double y[2])
{
    x[0] = region->x, x[1] = (double)region->x + region->width;
    y[0] = region->y, y[1] = (double)region->y + region->height;
    return x[0] >= 0.0 && y[0] >= 0.0 && region->width > 0 && region->height > 0 &&
           x[1] <= map->width && y[1] <= map->height;
}

void weft_cost_map_add(weft_cost_map *map, const struct weft_rectangle *region, double seconds)
{
    double x[2], y[2];
    if (seconds >= 0.0 && isfinite(seconds) && place(map, region, x, y))
        weft_cost_map_spread(map, x, y, seconds);
}

double weft_cost_map_estimate(const weft_cost_map *map, const struct weft_rectangle *region)
{
    double x[2], y[2];
    return place(map, region, x, y) ? fmax(weft_cost_map_sum(map, x, y), least_seconds) : 0.0;
}
