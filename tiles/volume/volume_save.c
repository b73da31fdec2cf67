// SPDX-License-Identifier: BSD-3-Clause
// Volumes in memory, as VDB files.
#include <string.h>

#include "tiles/volume/volume_impl.h"
#include "tiles/volume/volume_writer.h"

enum weft_result weft_volume_save(const weft_volume *volume,
                                  const struct weft_volume_save_params *params)
{
    const struct weft_log *log = params->log;
    const struct weft_volume_info *info = &volume->info;
    const struct weft_volume_memory *m = weft_volume_in_memory(volume);
    weft_volume_writer *writer = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, params->path != NULL);
    weft_require(log, m != NULL);
    struct weft_volume_grid grid = {.name = info->name,
                                    .grid_class = info->grid_class,
                                    .background = info->clamp_to_edge ? 0 : info->background,
                                    .boxed = info->clamp_to_edge};
    memcpy(grid.index_to_world, info->index_to_world, sizeof grid.index_to_world);
    memcpy(grid.box_min, info->active_min, sizeof grid.box_min);
    memcpy(grid.box_max, info->active_max, sizeof grid.box_max);
    res = weft_volume_writer_create(weft_volume_writer_params(.path = params->path,
                                                              .no_clobber = params->no_clobber,
                                                              .grid_count = 1, .grid = &grid,
                                                              .limits = params->limits, .log = log),
                                    &writer);
    const struct weft_volume_lot lot = {.brick_count = m->brick_count,
                                        .brick_origin = (const int32_t(*)[3])m->brick_origin,
                                        .values = m->values,
                                        .tile_count = m->tile_count,
                                        .tiles = m->tiles};
    if (res == WEFT_OK)
        res = weft_volume_writer_add(writer, &lot);
    if (res == WEFT_OK)
        res = weft_volume_writer_finish(&writer, NULL);
fail:
    weft_volume_writer_discard(&writer);
    return res;
}
