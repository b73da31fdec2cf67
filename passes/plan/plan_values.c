// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "passes/plan/plan_impl.h"

size_t weft_planner_positions(const struct weft_planner *planner)
{
    return weft_kernel_tiles_get_info(planner->plan->tiles)->tile_values;
}

size_t weft_planner_chunk(const struct weft_planner *planner, size_t first,
                          uint32_t positions[WEFT_PLANNER_CHUNK])
{
    const size_t left = weft_planner_positions(planner) - first;
    const size_t count = left < WEFT_PLANNER_CHUNK ? left : WEFT_PLANNER_CHUNK;
    for (size_t i = 0; i < count; i++)
        positions[i] = (uint32_t)(first + i);
    return count;
}

// Sample positions are mostly looked at in their order: how many follow each other in a row.
static size_t row_length(const struct weft_kernel_tiles_info *info, const uint32_t *positions,
                         size_t count)
{
    const size_t left = (size_t)info->samples - positions[0] % (size_t)info->samples;
    const size_t most = count < left ? count : left;
    size_t length = 1;
    while (length < most && positions[length] == positions[0] + length)
        length++;
    return length;
}

// Index of a sample in a tile's memory: base + step at.
struct tile_place {
    int64_t base, step[3];
};

static struct tile_place place_of(const struct weft_kernel_tiles_info *info,
                                  const struct weft_kernel_tile *tile)
{
    struct tile_place place = {0, {0, 0, 0}};
    int64_t stride = 1;
    for (int a = 0; a < info->dims; a++, stride *= info->samples) {
        place.step[a] = tile->mirrored[a] ? -stride : stride;
        place.base += tile->mirrored[a] ? (info->samples - 1) * stride : 0;
    }
    return place;
}

// The code of a weight's logarithm, passes/plan/pass.h.
static int log_code(const struct weft_pass_list *list, double weight)
{
    const int full = weft_target_one(list->target);
    if (weight < exp2(-list->log_octaves))
        return full;
    return (int)fmax(0.0, round(-log2(weight) * (full - 1) / list->log_octaves));
}

static int32_t log_value(const struct weft_planner *planner, const struct weft_kernel_tile *tile,
                         int64_t index)
{
    const double weight = fabs((double)((const float *)tile->data)[index]) / tile->scale;
    const int code = log_code(&planner->plan->list, weight);
    return code < planner->full ? (int32_t)planner->plan->log_table[code] : 0;
}

static int64_t index_of(const struct weft_kernel_tiles_info *info, const struct tile_place *place,
                        uint32_t position)
{
    const uint32_t m = (uint32_t)info->samples;
    return place->base + position % m * place->step[0] + position / m % m * place->step[1] +
           position / m / m * place->step[2];
}

static void add_tile(const struct weft_planner *planner, int tile, int32_t factor, size_t count,
                     const uint32_t *positions, int32_t *out)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(planner->plan->tiles);
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(planner->plan->tiles, tile);
    const struct tile_place place = place_of(info, t);
    const int64_t step = place.step[0];
    for (size_t i = 0, length; i < count; i += length) {
        const int64_t index = index_of(info, &place, positions[i]);
        length = row_length(info, positions + i, count - i);
        if (planner->logarithms) {
            for (size_t k = 0; k < length; k++)
                out[i + k] += factor * log_value(planner, t, index + (int64_t)k * step);
            continue;
        }
        const uint16_t *stored = (const uint16_t *)t->data + index;
        for (size_t k = 0; k < length; k++)
            out[i + k] += factor * stored[(int64_t)k * step];
    }
}

void weft_planner_add_values(const struct weft_planner *planner,
                             const struct weft_pass_plan_item *item, size_t count,
                             const uint32_t *positions, int32_t *out)
{
    const struct weft_tap_group *group = &item->group;
    for (int c = 0; c < 4; c++)
        if (group->tile[c] >= 0)
            add_tile(planner, group->tile[c], group->sign[c] * (1 << group->shift[c]), count,
                     positions, out);
}

enum { CHUNK = WEFT_PLANNER_CHUNK };

static void sum_chunk(const struct weft_planner *planner, size_t count, const uint32_t *positions,
                      struct weft_pass_plan_sums *out)
{
    int32_t whole[CHUNK] = {0}, positive[CHUNK] = {0};
    for (int i = 0; i < planner->item_count; i++) {
        struct weft_pass_plan_item item = planner->items[i], adds = item;
        weft_planner_add_values(planner, &item, count, positions, whole);
        for (int c = 0; c < 4; c++)
            if (adds.group.sign[c] < 0)
                adds.group.tile[c] = -1;
        weft_planner_add_values(planner, &adds, count, positions, positive);
    }
    for (size_t i = 0; i < count; i++) {
        const int32_t negative = positive[i] - whole[i];
        out->least = whole[i] < out->least ? whole[i] : out->least;
        out->most = whole[i] > out->most ? whole[i] : out->most;
        out->positive = positive[i] > out->positive ? positive[i] : out->positive;
        out->negative = negative > out->negative ? negative : out->negative;
    }
}

enum weft_result weft_planner_sums(const struct weft_planner *planner,
                                   struct weft_pass_plan_sums *out)
{
    uint32_t positions[CHUNK];
    size_t count;
    *out = (struct weft_pass_plan_sums){.least = INT32_MAX, .most = INT32_MIN};
    for (size_t first = 0; (count = weft_planner_chunk(planner, first, positions));
         first += count) {
        sum_chunk(planner, count, positions, out);
        if (weft_planner_cancelled(planner))
            return WEFT_ERR_CANCELLED;
    }
    return WEFT_OK;
}
