// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "passes/plan_impl.h"

size_t weft_planner_positions(const struct weft_planner *planner)
{
    return weft_kernel_tiles_get_info(planner->plan->tiles)->tile_values;
}

static void unpack(const struct weft_kernel_tiles_info *info, uint32_t position, int at[3])
{
    const uint32_t m = (uint32_t)info->samples;
    at[0] = (int)(position % m);
    at[1] = (int)(position / m % m);
    at[2] = (int)(position / m / m);
}

static size_t stored_index(const struct weft_kernel_tiles_info *info,
                           const struct weft_kernel_tile *tile, const int at[3])
{
    size_t index = 0;
    for (int a = info->dims - 1; a >= 0; a--)
        index = index * (size_t)info->samples +
                (size_t)(tile->mirrored[a] ? info->samples - 1 - at[a] : at[a]);
    return index;
}

// The code of a weight's logarithm, passes/pass.h.
static int log_code(const struct weft_pass_list *list, double weight)
{
    const int full = weft_target_one(list->target);
    const double code = weight > 0.0 ? -log2(weight) * (full - 1) / list->log_octaves : full;
    return code < full - 0.5 ? (int)fmax(0.0, round(code)) : full;
}

int32_t weft_planner_tile_value(const struct weft_planner *planner, int tile, const int at[3])
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(planner->plan->tiles);
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(planner->plan->tiles, tile);
    const size_t index = stored_index(info, t, at);
    if (!planner->logarithms)
        return ((const uint16_t *)t->data)[index];
    const int code =
        log_code(&planner->plan->list, fabs((double)((const float *)t->data)[index]) / t->scale);
    return code < planner->full ? (int32_t)planner->plan->log_table[code] : 0;
}

void weft_planner_add_values(const struct weft_planner *planner, const struct weft_plan_atom *atom,
                             size_t count, const uint32_t *positions, int32_t *out)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(planner->plan->tiles);
    for (int c = 0; c < 4; c++) {
        if (atom->group.tile[c] < 0)
            continue;
        const int32_t factor = atom->group.sign[c] * (1 << atom->group.shift[c]);
        for (size_t i = 0; i < count; i++) {
            int at[3];
            unpack(info, positions[i], at);
            out[i] += factor * weft_planner_tile_value(planner, atom->group.tile[c], at);
        }
    }
}

enum { CHUNK = 2048 };

static void sum_chunk(const struct weft_planner *planner, size_t count, const uint32_t *positions,
                      struct weft_plan_sums *out)
{
    int32_t whole[CHUNK] = {0}, positive[CHUNK] = {0};
    for (int i = 0; i < planner->atom_count; i++) {
        struct weft_plan_atom atom = planner->atoms[i], adds = atom;
        weft_planner_add_values(planner, &atom, count, positions, whole);
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

enum weft_result weft_planner_sums(const struct weft_planner *planner, struct weft_plan_sums *out)
{
    const size_t all = weft_planner_positions(planner);
    uint32_t positions[CHUNK];
    *out = (struct weft_plan_sums){.least = INT32_MAX, .most = INT32_MIN};
    for (size_t first = 0; first < all; first += CHUNK) {
        const size_t count = all - first < CHUNK ? all - first : CHUNK;
        for (size_t i = 0; i < count; i++)
            positions[i] = (uint32_t)(first + i);
        sum_chunk(planner, count, positions, out);
        const struct weft_progress *progress = planner->p.progress;
        if (progress && progress->report && !progress->report(progress->priv, 0.0))
            return WEFT_ERR_CANCELLED;
    }
    return WEFT_OK;
}
