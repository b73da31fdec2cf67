// SPDX-License-Identifier: BSD-3-Clause
// Volumes in memory.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tiles/volume/region.h"
#include "tiles/volume/volume_impl.h"

// ---- looking ------------------------------------------------------------------------------------

static enum weft_result find(weft_volume *volume, const struct weft_region *region,
                             struct weft_brick_list *out)
{
    const struct weft_volume_memory *m = volume->data;
    struct weft_brick_list list = {0};
    list.brick_origin = malloc(m->brick_count * sizeof *list.brick_origin + 1);
    list.tiles = malloc(m->tile_count * sizeof *list.tiles + 1);
    if (!list.brick_origin || !list.tiles) {
        weft_error(volume->log, "not enough memory for a list of %zu bricks", m->brick_count);
        weft_brick_list_clear(&list);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < m->brick_count; i++)
        if (weft_volume_brick_meets(&volume->info, region, m->brick_origin[i]))
            memcpy(list.brick_origin[list.brick_count++], m->brick_origin[i],
                   sizeof *list.brick_origin);
    for (size_t i = 0; i < m->tile_count; i++)
        if (weft_region_meets(region, m->tiles[i].origin, m->tiles[i].size))
            list.tiles[list.tile_count++] = m->tiles[i];
    *out = list;
    return WEFT_OK;
}

static enum weft_result read(weft_volume *volume, size_t count, const int32_t (*brick_origin)[3],
                             float *values)
{
    const struct weft_volume_memory *m = volume->data;
    for (size_t i = 0; i < count; i++) {
        const int32_t *at = brick_origin[i];
        const float *found = NULL;
        float constant;
        if (at[0] % 8 == 0 && at[1] % 8 == 0 && at[2] % 8 == 0)
            weft_brick_store_find(m->store, at, &found, &constant);
        if (!found) {
            weft_error(volume->log, "no brick at (%d, %d, %d)", at[0], at[1], at[2]);
            return WEFT_ERR_ARGUMENT;
        }
        memcpy(values + i * WEFT_BRICK_VOXELS, found, WEFT_BRICK_VOXELS * sizeof *values);
    }
    return WEFT_OK;
}

static void clear(void *data)
{
    struct weft_volume_memory *m = data;
    weft_brick_store_destroy(&m->store);
    free(m->brick_origin);
    free(m->values);
    free(m->tiles);
}

static const struct weft_volume_backend memory = {
    .data_bytes = sizeof(struct weft_volume_memory), .find = find, .read = read, .clear = clear};

const struct weft_volume_memory *weft_volume_in_memory(const weft_volume *volume)
{
    return volume->backend == &memory ? volume->data : NULL;
}

// ---- making -------------------------------------------------------------------------------------

static enum weft_result make(const struct weft_log *log, float background, weft_volume **out)
{
    enum weft_result res = weft_volume_make(log, &memory, out);
    if (res != WEFT_OK)
        return res;
    (*out)->info.background = background;
    (*out)->info.supported = true;
    (*out)->info.counted = true;
    (*out)->info.empty = true;
    (*out)->info.format = WEFT_VOLUME_MEMORY;
    (*out)->info.components = 1;
    strcpy((*out)->info.type, "float");
    return WEFT_OK;
}

static bool all_zero(const double m[3][4])
{
    for (int i = 0; i < 12; i++)
        if (m[i / 4][i % 4] != 0)
            return false;
    return true;
}

static void set_text(char *out, size_t size, const char *text, const char *otherwise)
{
    snprintf(out, size, "%s", text ? text : otherwise);
}

static enum weft_result set_transform(weft_volume *volume, const double m[3][4])
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            volume->info.index_to_world[r][c] = all_zero(m) ? r == c : m[r][c];
    if (weft_transform_valid(volume->info.index_to_world))
        return WEFT_OK;
    weft_error(volume->log,
               "the transform is singular or not finite: (%g %g %g %g) (%g %g %g %g) (%g %g %g %g)",
               m[0][0], m[0][1], m[0][2], m[0][3], m[1][0], m[1][1], m[1][2], m[1][3], m[2][0],
               m[2][1], m[2][2], m[2][3]);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check_range(const struct weft_log *log, int64_t first, int64_t last)
{
    if (first >= -WEFT_INDEX_LIMIT && last <= WEFT_INDEX_LIMIT)
        return WEFT_OK;
    weft_error(log, "voxels from %lld to %lld; index coordinates are limited to +-%d",
               (long long)first, (long long)last, WEFT_INDEX_LIMIT);
    return WEFT_ERR_LIMIT;
}

static enum weft_result allocate(weft_volume *volume, size_t bricks, size_t tiles)
{
    struct weft_volume_memory *m = volume->data;
    size_t bytes;
    if (weft_size_mul(bricks, WEFT_BRICK_VOXELS * sizeof(float), &bytes) &&
        tiles <= SIZE_MAX / sizeof(struct weft_volume_tile)) {
        m->values = malloc(bytes + 1);
        m->brick_origin = malloc(bricks * sizeof *m->brick_origin + 1);
        m->tiles = malloc(tiles * sizeof *m->tiles + 1);
    }
    if (m->values && m->brick_origin && m->tiles)
        return WEFT_OK;
    weft_error(volume->log, "not enough memory for %zu bricks of 2048 bytes", bricks);
    return WEFT_ERR_MEMORY;
}

static bool is_active(const struct weft_volume_info *info, float value)
{
    if (info->clamp_to_edge)
        return true;
    return strcmp(info->grid_class, "level set") ? value != info->background
                                                 : fabsf(value) < fabsf(info->background);
}

static void add_active(struct weft_volume_info *info, const int32_t first[3], const int32_t last[3],
                       uint64_t voxels)
{
    for (int i = 0; i < 3; i++) {
        if (info->empty || first[i] < info->active_min[i])
            info->active_min[i] = first[i];
        if (info->empty || last[i] > info->active_max[i])
            info->active_max[i] = last[i];
    }
    info->empty = false;
    info->active_voxels += voxels;
}

static void survey_brick(struct weft_volume_info *info, const int32_t origin[3],
                         const float *values)
{
    int first[3] = {8, 8, 8}, last[3] = {-1, -1, -1};
    uint64_t voxels = 0;
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        if (!is_active(info, values[v]))
            continue;
        const int at[3] = {v & 7, v >> 3 & 7, v >> 6};
        for (int i = 0; i < 3; i++) {
            first[i] = at[i] < first[i] ? at[i] : first[i];
            last[i] = at[i] > last[i] ? at[i] : last[i];
        }
        voxels++;
    }
    int32_t low[3], high[3];
    for (int i = 0; i < 3; i++) {
        low[i] = origin[i] + first[i];
        high[i] = origin[i] + last[i];
    }
    if (voxels)
        add_active(info, low, high, voxels);
}

static void survey(weft_volume *volume)
{
    struct weft_volume_memory *m = volume->data;
    for (size_t i = 0; i < m->brick_count; i++)
        survey_brick(&volume->info, m->brick_origin[i], m->values + i * WEFT_BRICK_VOXELS);
    for (size_t i = 0; i < m->tile_count; i++) {
        const struct weft_volume_tile *tile = &m->tiles[i];
        int32_t last[3];
        for (int c = 0; c < 3; c++)
            last[c] = tile->origin[c] + tile->size - 1;
        if (is_active(&volume->info, tile->value))
            add_active(&volume->info, tile->origin, last,
                       (uint64_t)tile->size * (uint64_t)tile->size * (uint64_t)tile->size);
    }
}

static enum weft_result fill_store(weft_volume *volume)
{
    struct weft_volume_memory *m = volume->data;
    struct weft_brick_list list = {m->brick_count, m->brick_origin, m->tile_count, m->tiles};
    enum weft_result res = weft_brick_store_create(volume->log, m->brick_count + m->tile_count,
                                                   volume->info.background, &m->store);
    if (!res)
        res = weft_brick_store_add_list(m->store, &list, m->values);
    if (!res)
        res = weft_brick_store_check_disjoint(m->store);
    volume->info.bricks = m->brick_count;
    volume->info.memory_bytes = (uint64_t)m->brick_count * WEFT_BRICK_VOXELS * sizeof(float);
    return res;
}

// One row of a brick's voxels at a time; outside the data the background or the nearest voxel.
static void fill_brick(const struct weft_volume_params *params, bool clamped,
                       const int32_t brick[3], float *out)
{
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        const int in_brick[3] = {v & 7, v >> 3 & 7, v >> 6};
        int64_t at[3];
        bool inside = true;
        for (int i = 0; i < 3; i++) {
            at[i] = (int64_t)brick[i] + in_brick[i] - params->origin[i];
            inside = inside && at[i] >= 0 && at[i] < params->size[i];
            at[i] = at[i] < 0 ? 0 : at[i] >= params->size[i] ? params->size[i] - 1 : at[i];
        }
        size_t n =
            ((size_t)at[2] * (size_t)params->size[1] + (size_t)at[1]) * (size_t)params->size[0] +
            (size_t)at[0];
        out[v] = inside || clamped ? params->data[n] : params->background;
    }
}

static bool is_constant(const float *values, float value)
{
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++)
        if (values[v] != value)
            return false;
    return true;
}

// Bricks that hold nothing but background are left out.
static void fill_dense(weft_volume *volume, const struct weft_volume_params *params,
                       const int32_t first[3], const int32_t last[3])
{
    struct weft_volume_memory *m = volume->data;
    int32_t at[3];
    for (at[2] = first[2]; at[2] <= last[2]; at[2] += 8)
        for (at[1] = first[1]; at[1] <= last[1]; at[1] += 8)
            for (at[0] = first[0]; at[0] <= last[0]; at[0] += 8) {
                float *values = m->values + m->brick_count * WEFT_BRICK_VOXELS;
                fill_brick(params, volume->info.clamp_to_edge, at, values);
                if (!volume->info.clamp_to_edge && is_constant(values, params->background))
                    continue;
                memcpy(m->brick_origin[m->brick_count++], at, sizeof at);
            }
}

enum weft_result weft_volume_create(const struct weft_volume_params *params, weft_volume **out)
{
    *out = NULL;
    weft_volume *volume = NULL;
    const struct weft_log *log = params->log;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    size_t bricks = 1, voxels = sizeof(float);
    int32_t first[3], last[3], end[3];
    weft_require(log, params->data != NULL);
    for (int i = 0; i < 3; i++) {
        res = WEFT_ERR_ARGUMENT;
        weft_require(log, params->size[i] > 0);
        int64_t most = (int64_t)params->origin[i] + params->size[i] - 1;
        res = check_range(log, params->origin[i], most);
        if (res)
            goto fail;
        end[i] = (int32_t)most;
        first[i] = params->origin[i] & ~7;
        last[i] = end[i] & ~7;
        res = WEFT_ERR_MEMORY;
        if (!weft_size_mul(bricks, (size_t)((last[i] - first[i]) / 8 + 1), &bricks) ||
            !weft_size_mul(voxels, (size_t)params->size[i], &voxels))
            goto fail;
    }
    res = make(log, params->background, &volume);
    if (res)
        goto fail;
    set_text(volume->info.name, sizeof volume->info.name, params->name, "density");
    strcpy(volume->info.grid_class, "fog volume");
    volume->info.clamp_to_edge = isnan(params->background);
    res = set_transform(volume, params->index_to_world);
    if (!res)
        res = allocate(volume, bricks, 0);
    if (res)
        goto fail;
    fill_dense(volume, params, first, last);
    res = fill_store(volume);
    if (res)
        goto fail;
    if (volume->info.clamp_to_edge) {
        weft_brick_store_clamp(weft_volume_in_memory(volume)->store, params->origin, end);
        add_active(&volume->info, params->origin, end, voxels / sizeof(float));
    } else {
        survey(volume);
    }
    *out = volume;
    return WEFT_OK;
fail:
    weft_volume_destroy(&volume);
    return res;
}

struct order {
    int32_t origin[3];
    size_t index;
};

static int compare_order(const void *a, const void *b)
{
    return weft_compare_origins(((const struct order *)a)->origin,
                                ((const struct order *)b)->origin);
}

static int compare_tiles(const void *a, const void *b)
{
    return weft_compare_origins(((const struct weft_volume_tile *)a)->origin,
                                ((const struct weft_volume_tile *)b)->origin);
}

static enum weft_result copy_bricks(weft_volume *volume,
                                    const struct weft_volume_bricks_params *params)
{
    struct weft_volume_memory *m = volume->data;
    size_t count = params->brick_count;
    struct order *order = malloc(count * sizeof *order + 1);
    if (!order) {
        weft_error(volume->log, "not enough memory to sort %zu bricks", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        memcpy(order[i].origin, params->brick_origin[i], sizeof order[i].origin);
        order[i].index = i;
    }
    qsort(order, count, sizeof *order, compare_order);
    for (size_t i = 0; i < count; i++) {
        memcpy(m->brick_origin[i], order[i].origin, sizeof order[i].origin);
        memcpy(m->values + i * WEFT_BRICK_VOXELS,
               params->brick_values + order[i].index * WEFT_BRICK_VOXELS,
               WEFT_BRICK_VOXELS * sizeof(float));
    }
    m->brick_count = count;
    free(order);
    return WEFT_OK;
}

static void copy_tiles(weft_volume *volume, const struct weft_volume_bricks_params *params)
{
    struct weft_volume_memory *m = volume->data;
    for (size_t i = 0; i < params->tile_count; i++)
        if (params->tiles[i].value != params->background)
            m->tiles[m->tile_count++] = params->tiles[i];
    qsort(m->tiles, m->tile_count, sizeof *m->tiles, compare_tiles);
}

enum weft_result weft_volume_create_bricks(const struct weft_volume_bricks_params *params,
                                           weft_volume **out)
{
    *out = NULL;
    weft_volume *volume = NULL;
    const struct weft_log *log = params->log;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, !params->brick_count || (params->brick_origin && params->brick_values));
    weft_require(log, !params->tile_count || params->tiles);
    for (size_t i = 0; i < params->brick_count; i++)
        for (int c = 0; c < 3; c++) {
            int32_t first = params->brick_origin[i][c];
            res = check_range(log, first, (int64_t)first + WEFT_BRICK_SIZE - 1);
            if (res)
                goto fail;
        }
    for (size_t i = 0; i < params->tile_count; i++)
        for (int c = 0; c < 3; c++) {
            int32_t first = params->tiles[i].origin[c];
            res = check_range(log, first, (int64_t)first + params->tiles[i].size - 1);
            if (res)
                goto fail;
        }
    res = make(log, params->background, &volume);
    if (res)
        goto fail;
    set_text(volume->info.name, sizeof volume->info.name, params->name, "density");
    set_text(volume->info.grid_class, sizeof volume->info.grid_class, params->grid_class,
             "fog volume");
    res = set_transform(volume, params->index_to_world);
    if (!res)
        res = allocate(volume, params->brick_count, params->tile_count);
    if (!res)
        res = copy_bricks(volume, params);
    if (res)
        goto fail;
    copy_tiles(volume, params);
    res = fill_store(volume);
    if (res)
        goto fail;
    survey(volume);
    *out = volume;
    return WEFT_OK;
fail:
    weft_volume_destroy(&volume);
    return res;
}
