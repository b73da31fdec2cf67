// SPDX-License-Identifier: BSD-3-Clause
// What passes read of tiles, and how far their sums may go.
#include <math.h>

#include "passes/plan/range_impl.h"

double weft_range_limit(const struct weft_pass_list *list)
{
    if (list->exact_inside || !weft_target_bits(list->target))
        return INFINITY;
    return floor(ldexp(list->range * weft_target_one(list->target), list->extra_bits));
}

static void load_row(const struct weft_kernel_tiles_info *tiles,
                     const struct weft_kernel_tile *tile, size_t from, ptrdiff_t step, int count,
                     double *out)
{
    switch (tiles->format) {
    case WEFT_TILE_UNORM: {
        const uint16_t *q = (const uint16_t *)tile->data + from;
        for (int i = 0; i < count; i++)
            out[i] = q[i * step];
        return;
    }
    case WEFT_TILE_SNORM: {
        const int16_t *q = (const int16_t *)tile->data + from;
        for (int i = 0; i < count; i++)
            out[i] = q[i * step];
        return;
    }
    case WEFT_TILE_HALF:
    case WEFT_TILE_FLOAT:
        break;
    }
    const float *q = (const float *)tile->data + from;
    for (int i = 0; i < count; i++)
        out[i] = (double)q[i * step];
}

// Along axes past dims, index and mirrored are 0.
void weft_range_load(const struct weft_pass_list *list, int tile, size_t first, int count,
                     double *out)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(list->tiles);
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(list->tiles, tile);
    const size_t m = (size_t)info->samples;
    int row;
    for (int done = 0; done < count; done += row) {
        const size_t at = first + (size_t)done;
        size_t index[3] = {at % m, at / m % m, at / m / m};
        const size_t left = m - index[0];
        row = left < (size_t)(count - done) ? (int)left : count - done;
        for (int a = 0; a < 3; a++)
            index[a] = t->mirrored[a] ? m - 1 - index[a] : index[a];
        load_row(info, t, (index[2] * m + index[1]) * m + index[0], t->mirrored[0] ? -1 : 1, row,
                 &out[done]);
    }
}

void weft_range_load_codes(const struct weft_pass_list *list, int tile, size_t first, int count,
                           double *out)
{
    const double octaves = list->log_octaves, one = weft_target_one(list->target);
    const double scale = weft_kernel_tiles_get(list->tiles, tile)->scale;
    weft_range_load(list, tile, first, count, out);
    for (int i = 0; i < count; i++) {
        const double weight = fabs(out[i]) / scale;
        out[i] =
            weight < exp2(-octaves) ? one : fmax(0.0, round(-log2(weight) * (one - 1.0) / octaves));
    }
}
