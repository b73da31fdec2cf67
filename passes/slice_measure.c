// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "passes/slice_plan.h"
#include "tiles/region.h"

// What coefficients stand for.
static void measure_voxel_range(const float *values, size_t count, struct weft_slice_measure *out)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i]))
            continue;
        out->voxel_low = fmin(out->voxel_low, values[i]);
        out->voxel_high = fmax(out->voxel_high, values[i]);
    }
}

static void measure_voxels(const float *values, size_t count, struct weft_slice_measure *out)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            out->not_finite++;
            continue;
        }
        out->low = fmin(out->low, values[i]);
        out->high = fmax(out->high, values[i]);
    }
    out->voxels += count;
}

// Differences of rising order along one line of a brick.
static void measure_line(const float *values, int step, struct weft_slice_measure *out)
{
    double line[WEFT_BRICK_SIZE];
    for (int i = 0; i < WEFT_BRICK_SIZE; i++)
        line[i] = values[i * step];
    for (int n = 0; n < WEFT_MEASURE_DIFFERENCES; n++) {
        for (int i = 0; i + n + 1 < WEFT_BRICK_SIZE; i++) {
            line[i] = line[i + 1] - line[i];
            if (fabs(line[i]) > out->difference[n] && isfinite(line[i]))
                out->difference[n] = fabs(line[i]);
        }
    }
}

static void measure_differences(const float *brick, struct weft_slice_measure *out)
{
    enum { ROW = WEFT_BRICK_SIZE, PLANE = ROW * ROW };
    for (int i = 0; i < PLANE; i++) {
        measure_line(brick + i * ROW, 1, out);
        measure_line(brick + i / ROW * PLANE + i % ROW, ROW, out);
        measure_line(brick + i, PLANE, out);
    }
}

// Constant tiles and the background count too, though not among the voxels read.
static void measure_constants(const struct weft_slice_plan *plan,
                              const struct weft_volume_info *info, struct weft_slice_measure *out)
{
    const uint64_t read = out->voxels;
    if (!info->clamp_to_edge)
        measure_voxels(&info->background, 1, out);
    for (size_t i = 0; i < plan->topology.tile_count; i++)
        measure_voxels(&plan->topology.tiles[i].value, 1, out);
    out->voxels = read;
}

// The voxels in reach of a prefiltered kernel, a few bricks at a time.
static enum weft_result measure_base(const struct weft_slice_plan *plan, weft_volume *volume,
                                     const struct weft_progress *progress,
                                     struct weft_slice_measure *out)
{
    enum { CHUNK = 1024 };
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_region region;
    struct weft_brick_list list = {0};
    float *values = malloc(CHUNK * WEFT_BRICK_VOXELS * sizeof *values);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (!values) {
        weft_error(plan->log, "not enough memory to measure %d bricks", CHUNK);
        return res;
    }
    weft_slice_grid_region(&plan->grid, plan->info.kernel.width, &region);
    region = weft_region_widen(&region, plan->info.prefilter_overlap);
    if (info->clamp_to_edge)
        weft_slice_clamp_region(info, &region);
    res = weft_volume_find(volume, &region, &list);
    for (size_t from = 0; res == WEFT_OK && from < list.brick_count; from += CHUNK) {
        const size_t left = list.brick_count - from, count = left < CHUNK ? left : CHUNK;
        if (progress && progress->report &&
            !progress->report(progress->priv, (double)from / (double)list.brick_count))
            res = WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = weft_volume_read(volume, count, (const int32_t(*)[3])list.brick_origin + from,
                                   values);
        if (res == WEFT_OK)
            measure_voxel_range(values, count * WEFT_BRICK_VOXELS, out);
        for (size_t b = 0; res == WEFT_OK && b < count; b++)
            measure_differences(values + b * WEFT_BRICK_VOXELS, out);
    }
    measure_voxel_range(&info->background, 1, out);
    for (size_t i = 0; i < list.tile_count; i++)
        measure_voxel_range(&list.tiles[i].value, 1, out);
    weft_brick_list_clear(&list);
    free(values);
    return res;
}

enum weft_result weft_slice_measure(const weft_slice_plan *plan, weft_volume *volume,
                                    const struct weft_progress *progress,
                                    struct weft_slice_measure *out)
{
    enum weft_result res = WEFT_OK;
    size_t most = 0;
    const bool coefficients = plan->info.kernel.prefiltered;
    *out = (struct weft_slice_measure){
        .low = INFINITY, .high = -INFINITY, .voxel_low = INFINITY, .voxel_high = -INFINITY};
    if (coefficients)
        res = measure_base(plan, volume, progress, out);
    volume = weft_slice_voxels(plan, volume);
    for (int i = 0; i < plan->info.tile_count; i++)
        most = plan->tile_plans[i].bricks.count > most ? plan->tile_plans[i].bricks.count : most;
    float *values = malloc((most + 1) * WEFT_BRICK_VOXELS * sizeof *values);
    if (!values) {
        weft_error(plan->log, "not enough memory to measure %zu bricks", most);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; res == WEFT_OK && i < plan->info.tile_count; i++) {
        const struct weft_cell_map *bricks = &plan->tile_plans[i].bricks;
        if (progress && progress->report &&
            !progress->report(progress->priv, (double)i / plan->info.tile_count))
            res = WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = weft_slice_read_bricks(plan, volume, bricks, values);
        if (res == WEFT_OK)
            measure_voxels(values, bricks->count * WEFT_BRICK_VOXELS, out);
        for (size_t b = 0; res == WEFT_OK && !coefficients && b < bricks->count; b++)
            measure_differences(values + b * WEFT_BRICK_VOXELS, out);
    }
    free(values);
    measure_constants(plan, weft_volume_get_info(volume), out);
    if (out->low > out->high)
        out->low = out->high = 0.0;
    if (!coefficients) {
        out->voxel_low = out->low;
        out->voxel_high = out->high;
    }
    if (out->voxel_low > out->voxel_high)
        out->voxel_low = out->voxel_high = 0.0;
    return res;
}
