// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "passes/fused/plan.h"
#include "tiles/volume/region.h"

// ---- one brick ----------------------------------------------------------------------------------

static void measure_differences(const float *brick, struct weft_statistics *out)
{
    enum { ROW = WEFT_BRICK_SIZE, PLANE = ROW * ROW };
    for (int i = 0; i < PLANE; i++) {
        weft_statistics_add_differences(out, brick + i * ROW, ROW, 1);
        weft_statistics_add_differences(out, brick + i / ROW * PLANE + i % ROW, ROW, ROW);
        weft_statistics_add_differences(out, brick + i, ROW, PLANE);
    }
}

// Constant tiles and the background count too, though not among the voxels read.
static void measure_constants(const struct weft_slice_plan *plan,
                              const struct weft_volume_info *info, struct weft_statistics *out)
{
    const uint64_t read = out->count;
    if (!info->clamp_to_edge)
        weft_statistics_add(out, &info->background, 1);
    for (size_t i = 0; i < plan->topology.tile_count; i++)
        weft_statistics_add(out, &plan->topology.tiles[i].value, 1);
    out->count = read;
}

// ---- what coefficients stand for ----------------------------------------------------------------

// Regions of rising size: what is in reach, then what lies beyond within each cut.
struct reach {
    struct weft_region taps;
    struct weft_region region[1 + WEFT_SLICE_SHELLS];
    struct weft_slice_statistics *out;
    struct weft_slice_shells *shells;
    struct weft_statistics voxels; // what is read
};

static void set_reach(const struct weft_slice_plan *plan, const struct weft_volume_info *info,
                      struct reach *reach)
{
    struct weft_region taps;
    weft_slice_grid_region(&plan->grid, plan->info.kernel.width, &taps);
    for (int i = 0; i <= WEFT_SLICE_SHELLS; i++) {
        reach->region[i] = weft_region_widen(&taps, reach->shells->overlap[i]);
        if (info->clamp_to_edge)
            weft_slice_clamp_region(info, &reach->region[i]);
    }
    if (info->clamp_to_edge)
        weft_slice_clamp_region(info, &taps);
    reach->taps = taps;
}

// 0: in reach; else in shell n - 1, the nearest one that the cube meets. At least `from`.
static int find_reach(const struct reach *reach, const int32_t origin[3], int32_t size, int from)
{
    while (from < WEFT_SLICE_SHELLS && !weft_region_meets(&reach->region[from], origin, size))
        from++;
    return from;
}

static bool is_known(const struct reach *reach, int at, double value)
{
    return !isfinite(value) ||
           fabs(value) <= (at ? reach->shells->largest[at - 1] : reach->shells->at_taps);
}

static void add_value(const struct reach *reach, const int32_t origin[3], int32_t size, int from,
                      double value)
{
    struct weft_slice_statistics *out = reach->out;
    const int at = find_reach(reach, origin, size, from);
    if (at) {
        reach->shells->largest[at - 1] = fmax(reach->shells->largest[at - 1], fabs(value));
        return;
    }
    out->voxel_low = fmin(out->voxel_low, value);
    out->voxel_high = fmax(out->voxel_high, value);
    if (fabs(value) > reach->shells->at_taps && weft_region_meets(&reach->taps, origin, size))
        reach->shells->at_taps = fabs(value);
}

// Each voxel where it is itself, if that may change anything.
static bool measure_brick(const struct reach *reach, const int32_t origin[3], const float *values)
{
    const int at = find_reach(reach, origin, WEFT_BRICK_SIZE, 0);
    for (int i = 0; i < WEFT_BRICK_VOXELS; i++) {
        const double value = (double)values[i];
        const int32_t voxel[3] = {origin[0] + (i & 7), origin[1] + (i >> 3 & 7),
                                  origin[2] + (i >> 6)};
        const bool widens =
            at == 0 && (value < reach->out->voxel_low || value > reach->out->voxel_high);
        if (isfinite(value) && (widens || !is_known(reach, at, value)))
            add_value(reach, voxel, 1, at, value);
    }
    return at == 0;
}

// It may be anywhere.
static void measure_background(const struct reach *reach, double value)
{
    if (!isfinite(value))
        return;
    reach->out->voxel_low = fmin(reach->out->voxel_low, value);
    reach->out->voxel_high = fmax(reach->out->voxel_high, value);
    reach->shells->at_taps = fmax(reach->shells->at_taps, fabs(value));
}

static double sum_shells(const struct weft_slice_shells *shells)
{
    double sum = 0.0;
    for (int i = WEFT_SLICE_SHELLS - 1; i >= 0; i--)
        sum = shells->largest[i] + WEFT_SLICE_SHELL_FALL * sum;
    return sum;
}

// A few bricks at a time.
static enum weft_result measure_base(const struct weft_slice_plan *plan, weft_volume *volume,
                                     const struct weft_progress *progress, struct reach *reach)
{
    enum { CHUNK = 1024 };
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_brick_list list = {0};
    float *values = malloc(CHUNK * WEFT_BRICK_VOXELS * sizeof *values);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (!values) {
        weft_error(plan->log, "not enough memory to measure %d bricks", CHUNK);
        return res;
    }
    set_reach(plan, info, reach);
    res = weft_volume_find(volume, &reach->region[WEFT_SLICE_SHELLS], &list);
    for (size_t from = 0; res == WEFT_OK && from < list.brick_count; from += CHUNK) {
        const size_t left = list.brick_count - from, count = left < CHUNK ? left : CHUNK;
        if (progress && progress->report &&
            !progress->report(progress->priv, (double)from / (double)list.brick_count))
            res = WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = weft_volume_read(volume, count, (const int32_t(*)[3])list.brick_origin + from,
                                   values);
        for (size_t b = 0; res == WEFT_OK && b < count; b++) {
            const float *brick = values + b * WEFT_BRICK_VOXELS;
            if (measure_brick(reach, list.brick_origin[from + b], brick))
                measure_differences(brick, &reach->voxels);
        }
    }
    measure_background(reach, (double)info->background);
    for (size_t i = 0; i < list.tile_count; i++)
        if (isfinite(list.tiles[i].value))
            add_value(reach, list.tiles[i].origin, list.tiles[i].size, 0,
                      (double)list.tiles[i].value);
    reach->out->beyond = sum_shells(reach->shells);
    weft_brick_list_clear(&list);
    free(values);
    return res;
}

static void set_shells(const struct weft_kernel *kernel, struct weft_slice_shells *out)
{
    struct weft_prefilter prefilter;
    double cut = WEFT_VOLUME_PREFILTER_ERROR;
    *out = (struct weft_slice_shells){.overlap = {0}};
    if (weft_prefilter_compute(NULL, kernel, &prefilter) != WEFT_OK)
        return;
    for (int i = 0; i <= WEFT_SLICE_SHELLS; i++, cut *= WEFT_SLICE_SHELL_FALL)
        out->overlap[i] = weft_prefilter_overlap(&prefilter, cut);
}

static void set_voxels(const struct weft_statistics *voxels, struct weft_slice_statistics *out)
{
    const bool none = isnan(voxels->minimum);
    out->low = none ? 0.0 : voxels->minimum;
    out->high = none ? 0.0 : voxels->maximum;
    out->voxels = voxels->count;
    out->not_finite = voxels->not_finite;
    memcpy(out->difference, voxels->difference, sizeof out->difference);
}

// ---- all ----------------------------------------------------------------------------------------

enum weft_result weft_slice_statistics_shells(const struct weft_slice_plan *plan,
                                              weft_volume *volume,
                                              const struct weft_progress *progress,
                                              struct weft_slice_statistics *out,
                                              struct weft_slice_shells *shells)
{
    enum weft_result res = WEFT_OK;
    struct reach reach = {.out = out, .shells = shells, .voxels = WEFT_STATISTICS_NONE};
    size_t most = 0;
    const bool coefficients = plan->info.kernel.prefiltered;
    *out = (struct weft_slice_statistics){.voxel_low = INFINITY, .voxel_high = -INFINITY};
    set_shells(&plan->info.kernel, shells);
    if (coefficients)
        res = measure_base(plan, volume, progress, &reach);
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
            weft_statistics_add(&reach.voxels, values, bricks->count * WEFT_BRICK_VOXELS);
        for (size_t b = 0; res == WEFT_OK && !coefficients && b < bricks->count; b++)
            measure_differences(values + b * WEFT_BRICK_VOXELS, &reach.voxels);
    }
    free(values);
    measure_constants(plan, weft_volume_get_info(volume), &reach.voxels);
    set_voxels(&reach.voxels, out);
    if (!coefficients) {
        out->voxel_low = out->low;
        out->voxel_high = out->high;
    }
    if (out->voxel_low > out->voxel_high)
        out->voxel_low = out->voxel_high = 0.0;
    return res;
}

enum weft_result weft_slice_statistics_compute(const weft_slice_plan *plan, weft_volume *volume,
                                               const struct weft_progress *progress,
                                               struct weft_slice_statistics *out)
{
    struct weft_slice_shells shells;
    return weft_slice_statistics_shells(plan, volume, progress, out, &shells);
}
