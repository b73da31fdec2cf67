// SPDX-License-Identifier: BSD-3-Clause
// The range of the previews of a sweep, which flickered if each frame had its own.
#include "tools/slice/stages.h"

#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"

enum { BRICKS = 4096 }; // that are read at once: 8 MiB

static void add_values(const struct weft_volume_info *info, const struct weft_brick_list *list,
                       struct weft_statistics *statistics)
{
    for (size_t i = 0; i < list->tile_count; i++)
        weft_statistics_add(statistics, &list->tiles[i].value, 1);
    if (!info->clamp_to_edge)
        weft_statistics_add(statistics, &info->background, 1);
}

static enum weft_result add_voxels(weft_volume *volume, const struct weft_brick_list *list,
                                   struct weft_statistics *statistics)
{
    const struct weft_progress *progress = report_progress("measuring");
    float *values = malloc((size_t)BRICKS * WEFT_BRICK_VOXELS * sizeof *values);
    enum weft_result res = values ? WEFT_OK : WEFT_ERR_MEMORY;
    for (size_t at = 0; at < list->brick_count && res == WEFT_OK; at += BRICKS) {
        const size_t left = list->brick_count - at, count = left < BRICKS ? left : BRICKS;
        res = weft_volume_read(volume, count, list->brick_origin + at, values);
        if (res == WEFT_OK)
            weft_statistics_add(statistics, values, count * WEFT_BRICK_VOXELS);
        progress->report(progress->priv, (double)(at + count) / (double)list->brick_count);
    }
    free(values);
    return res;
}

enum weft_result slice_find_range(struct slice_job *job)
{
    struct option_value *range = &job->setup->range;
    if (range->given || !job->preview || !job->setup->sweep.given)
        return WEFT_OK;
    const struct weft_volume_info *info = weft_volume_get_info(job->volume);
    const int32_t end = WEFT_INDEX_LIMIT;
    const struct weft_region all = {.min = {-end, -end, -end}, .max = {end, end, end}};
    struct weft_statistics statistics = WEFT_STATISTICS_NONE;
    struct weft_brick_list list = {0};
    enum weft_result res = weft_volume_find(job->volume, &all, &list);
    if (res == WEFT_OK)
        res = add_voxels(job->volume, &list, &statistics);
    if (res == WEFT_OK)
        add_values(info, &list, &statistics);
    weft_brick_list_clear(&list);
    if (res != WEFT_OK)
        return res;
    const bool any = statistics.minimum <= statistics.maximum;
    range->given = true;
    range->number[0] = any ? statistics.minimum : 0.0;
    range->number[1] = any ? statistics.maximum : 1.0;
    if (!job->setup->option[SLICE_JSON].given)
        run_report_print_preview(job->setup->option[SLICE_PREVIEW].text,
                                 (float[]){(float)range->number[0], (float)range->number[1]});
    return WEFT_OK;
}
