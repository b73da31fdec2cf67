// SPDX-License-Identifier: BSD-3-Clause
// Grids as a VDB file.
#include "tools/volumes/convert.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

// Bricks that are read and handed over at once.
enum { LOT = 4096 };

struct target {
    weft_volume_writer *writer;
    int grid; // its place in the file
    const struct convert_grid *source;
    const struct weft_volume_grid *to;
    int components;
    bool sparse; // bricks of nothing but background are left out
    double tolerance;
    float *values, *joined; // LOT bricks of a component, and of all
    int32_t (*origin)[3];
};

// The place of all components, which a staggered grid's faces are moved from.
static void set_transform(const struct convert_grid *grid, double out[3][4])
{
    memcpy(out, grid->info->index_to_world, sizeof grid->info->index_to_world);
}

static struct weft_volume_grid describe(const struct convert_job *job,
                                        const struct convert_grid *grid)
{
    const struct weft_volume_info *info = weft_volume_get_info(grid->volume[0]);
    const struct option_value *background = &job->option[CONVERT_BACKGROUND];
    struct weft_volume_grid to = {.name = info->name,
                                  .grid_class = info->grid_class,
                                  .components = info->components,
                                  .background = info->clamp_to_edge ? 0.0f : info->background,
                                  .boxed = info->clamp_to_edge && !background->given,
                                  .metadata_count = info->metadata_count,
                                  .metadata = info->metadata};
    if (background->given)
        to.background = (float)background->number[0];
    set_transform(grid, to.index_to_world);
    memcpy(to.box_min, info->active_min, sizeof to.box_min);
    memcpy(to.box_max, info->active_max, sizeof to.box_max);
    return to;
}

// Beyond the box of a dense file nothing is known: that is background, too.
static bool in_box(const struct weft_volume_info *info, const int32_t origin[3], int v)
{
    const int32_t at[3] = {origin[0] + (v & 7), origin[1] + (v >> 3 & 7), origin[2] + (v >> 6)};
    for (int i = 0; i < 3; i++)
        if (at[i] < info->active_min[i] || at[i] > info->active_max[i])
            return false;
    return true;
}

// Values near the background become it. Returns whether any is another.
static bool thin(const struct target *t, const int32_t origin[3], float *values)
{
    const struct weft_volume_info *info = weft_volume_get_info(t->source->volume[0]);
    bool any = false;
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        const bool outside = info->clamp_to_edge && !in_box(info, origin, v);
        if (outside || fabs((double)values[v] - (double)t->to->background) <= t->tolerance)
            values[v] = t->to->background;
        any = any || values[v] != t->to->background;
    }
    return any;
}

// Keeps the bricks that hold anything; returns how many.
static size_t thin_all(const struct target *t, size_t count)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        float *from = t->joined + i * WEFT_BRICK_VOXELS;
        if (!thin(t, t->origin[i], from))
            continue;
        memmove(t->joined + kept * WEFT_BRICK_VOXELS, from, WEFT_BRICK_VOXELS * sizeof *from);
        memmove(t->origin[kept++], t->origin[i], sizeof t->origin[i]);
    }
    return kept;
}

static enum weft_result add_bricks(const struct target *t, const int32_t (*origin)[3], size_t count)
{
    const size_t block = WEFT_BRICK_VOXELS, stride = block * (size_t)t->components;
    enum weft_result res = WEFT_OK;
    memcpy(t->origin, origin, count * sizeof *origin);
    for (int c = 0; c < t->components && res == WEFT_OK; c++) {
        res = weft_volume_read(t->source->volume[c], count, origin, t->values);
        for (size_t i = 0; i < count && res == WEFT_OK; i++)
            memcpy(t->joined + i * stride + (size_t)c * block, t->values + i * block,
                   block * sizeof *t->values);
    }
    if (res != WEFT_OK)
        return res;
    const size_t kept = t->sparse && t->components == 1 ? thin_all(t, count) : count;
    const struct weft_volume_lot lot = {.grid = t->grid,
                                        .brick_count = kept,
                                        .brick_origin = (const int32_t(*)[3])t->origin,
                                        .values = t->joined};
    return kept ? weft_volume_writer_add(t->writer, &lot) : WEFT_OK;
}

// Vectors have no tiles in the writer.
static enum weft_result add_tiles(const struct target *t, const struct weft_brick_list *list)
{
    if (!list->tile_count)
        return WEFT_OK;
    if (t->components > 1) {
        report_error("grid '%s': %zu constant cubes of vectors, which cannot be written",
                     t->to->name, list->tile_count);
        return WEFT_ERR_UNSUPPORTED;
    }
    const struct weft_volume_lot lot = {
        .grid = t->grid, .tile_count = list->tile_count, .tiles = list->tiles};
    return weft_volume_writer_add(t->writer, &lot);
}

static enum weft_result add_grid(struct target *t)
{
    static const struct weft_region everywhere = {
        .min = {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
        .max = {WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT}};
    struct weft_brick_list list = {0};
    enum weft_result res = weft_volume_find(t->source->volume[0], &everywhere, &list);
    for (size_t done = 0; done < list.brick_count && res == WEFT_OK; done += LOT) {
        const size_t left = list.brick_count - done;
        res = add_bricks(t, (const int32_t(*)[3])list.brick_origin + done, left < LOT ? left : LOT);
    }
    if (res == WEFT_OK)
        res = add_tiles(t, &list);
    weft_brick_list_clear(&list);
    return res;
}

static enum weft_result add_all(struct convert_job *job, weft_volume_writer *writer,
                                const struct weft_volume_grid *grids)
{
    const size_t bytes = (size_t)LOT * WEFT_BRICK_VOXELS * sizeof(float);
    struct target t = {.writer = writer,
                       .sparse = job->option[CONVERT_BACKGROUND].given,
                       .tolerance = job->option[CONVERT_PRUNE].number[0],
                       .values = malloc(bytes),
                       .joined = malloc(3 * bytes),
                       .origin = malloc(LOT * sizeof *t.origin)};
    enum weft_result res = t.values && t.joined && t.origin ? WEFT_OK : WEFT_ERR_MEMORY;
    for (size_t i = 0; i < job->grid_count && res == WEFT_OK; i++) {
        t.grid = (int)i;
        t.source = &job->grid[i];
        t.to = &grids[i];
        t.components = grids[i].components;
        res = add_grid(&t);
    }
    free(t.values);
    free(t.joined);
    free(t.origin);
    return res;
}

static enum weft_result check(const struct convert_job *job)
{
    const bool background = job->option[CONVERT_BACKGROUND].given;
    if (job->option[CONVERT_TYPE].given) {
        report_error("--type is for NRRD files; grids of VDB files are of floats");
        return WEFT_ERR_ARGUMENT;
    }
    for (size_t i = 0; i < job->grid_count && background; i++) {
        const struct weft_volume_info *info = weft_volume_get_info(job->grid[i].volume[0]);
        if (info->clamp_to_edge && info->components == 1)
            continue;
        report_error("--background is for dense grids of one component; '%s' is %s", info->name,
                     info->components > 1 ? "one of vectors" : "sparse");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result convert_write_vdb(struct convert_job *job)
{
    weft_volume_writer *writer = NULL;
    uint64_t bytes = 0;
    enum weft_result res = check(job);
    if (res != WEFT_OK)
        return res;
    struct weft_volume_grid *grids = calloc(job->grid_count, sizeof *grids);
    if (!grids)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < job->grid_count; i++)
        grids[i] = describe(job, &job->grid[i]);
    report_stage("writing", job->output);
    res = weft_volume_writer_create(
        weft_volume_writer_params(.path = job->output,
                                  .no_clobber = job->option[CONVERT_NO_CLOBBER].given,
                                  .grid_count = (int)job->grid_count, .grid = grids,
                                  .log = report_log()),
        &writer);
    if (res == WEFT_OK)
        res = add_all(job, writer, grids);
    if (res == WEFT_OK)
        res = weft_volume_writer_finish(&writer, &bytes);
    weft_volume_writer_discard(&writer);
    free(grids);
    if (res == WEFT_OK)
        report_note("%s: %zu grids, %llu bytes", job->output, job->grid_count,
                    (unsigned long long)bytes);
    return res;
}
