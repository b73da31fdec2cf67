// SPDX-License-Identifier: BSD-3-Clause
#include "passes/hardware/plan.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
enum {
    MIN_TILE = 16, // a tile is cut no smaller
    BRICK_BYTES = WEFT_BRICK_VOXELS * 4,
    PIXEL_BYTES = 8, // of the table and the target
};

// ---- tiles --------------------------------------------------------------------------------------

static void tile_destroy(const struct weft_hardware_plan *plan, struct weft_hardware_tile *tile)
{
    weft_footprint_release(plan->slice->footprint, &tile->cells);
    weft_cell_map_destroy(&tile->bricks);
}

static enum weft_result out_of_memory(const struct weft_hardware_plan *plan,
                                      const struct weft_rectangle *at)
{
    weft_error(plan->log, "not enough memory to plan %d x %d pixels", at->width, at->height);
    return WEFT_ERR_MEMORY;
}

static enum weft_result fill_tile(const struct weft_hardware_plan *plan,
                                  struct weft_hardware_tile *tile)
{
    weft_footprint *footprint = plan->slice->footprint;
    const enum weft_result res =
        weft_footprint_cells(footprint, &tile->at, NULL, 0.0, &tile->cells);
    for (size_t i = 0; res == WEFT_OK && i < tile->cells->map.count; i++) {
        int32_t min[3], max[3];
        weft_footprint_cell_box(footprint, tile->cells, i, min, max);
        if (!weft_brick_reader_note(&footprint->bricks, min, max, &tile->bricks))
            return out_of_memory(plan, &tile->at);
    }
    return res;
}

// What a tile takes while it runs, with a plane of blocks on its way to the texture; 0: more than a
// texture holds.
static uint64_t tile_bytes(const struct weft_hardware_plan *plan,
                           const struct weft_hardware_tile *tile, struct weft_hardware_atlas *atlas)
{
    const int side = weft_hardware_side(&plan->slice->info.kernel);
    if (!weft_hardware_atlas_fit(tile->cells->map.count, side, plan->info.sampler.max_size, atlas))
        return 0;
    const uint64_t texture = weft_hardware_atlas_bytes(atlas, plan->slice->info.source);
    return (uint64_t)BRICK_BYTES * tile->bricks.count + texture +
           texture / (uint64_t)atlas->size[2] * (uint64_t)side +
           (uint64_t)PIXEL_BYTES * (uint64_t)tile->at.width * (uint64_t)tile->at.height;
}

static bool append_tile(struct weft_hardware_plan *plan, const struct weft_hardware_tile *tile)
{
    const size_t count = (size_t)plan->info.tile_count;
    if (count == plan->tile_capacity) {
        const size_t capacity = count ? 2 * count : 16;
        void *tiles = realloc(plan->tiles, capacity * sizeof *plan->tiles);
        if (!tiles)
            return false;
        plan->tiles = tiles;
        plan->tile_capacity = capacity;
    }
    plan->tiles[count] = *tile;
    plan->info.tile_count++;
    return true;
}

// Of a tile that the plan takes: sizes that hold all of them.
static void note_tile(struct weft_hardware_plan *plan, const struct weft_hardware_tile *tile,
                      const struct weft_hardware_atlas *atlas, uint64_t bytes)
{
    if (weft_hardware_atlas_blocks(atlas) > weft_hardware_atlas_blocks(&plan->atlas))
        plan->atlas = *atlas;
    if (bytes > plan->info.memory_bytes)
        plan->info.memory_bytes = bytes;
    plan->info.work.texels += (double)tile->cells->map.count * pow((double)atlas->side, 3);
}

static enum weft_result plan_rectangle(struct weft_hardware_plan *plan,
                                       const struct weft_rectangle *at);

static enum weft_result plan_halves(struct weft_hardware_plan *plan,
                                    const struct weft_rectangle *at)
{
    struct weft_rectangle first = *at, second = *at;
    if (at->width >= at->height) {
        first.width /= 2;
        second.x += first.width;
        second.width -= first.width;
    } else {
        first.height /= 2;
        second.y += first.height;
        second.height -= first.height;
    }
    const enum weft_result res = plan_rectangle(plan, &first);
    return res == WEFT_OK ? plan_rectangle(plan, &second) : res;
}

static enum weft_result refuse(const struct weft_hardware_plan *plan,
                               const struct weft_hardware_tile *tile, uint64_t bytes)
{
    weft_error(plan->log,
               "%d x %d pixels of the slice reach %zu cells, which need %" PRIu64
               " bytes (0: more than a texture holds); the limits are %d texels along a side and "
               "%" PRIu64 " bytes",
               tile->at.width, tile->at.height, tile->cells->map.count, bytes,
               plan->info.sampler.max_size, plan->memory_bytes);
    return WEFT_ERR_LIMIT;
}

static enum weft_result plan_rectangle(struct weft_hardware_plan *plan,
                                       const struct weft_rectangle *at)
{
    struct weft_hardware_tile tile = {.at = *at};
    struct weft_hardware_atlas atlas;
    enum weft_result res = fill_tile(plan, &tile);
    const uint64_t bytes = res == WEFT_OK ? tile_bytes(plan, &tile, &atlas) : 0;
    const bool fits = bytes > 0 && bytes <= plan->memory_bytes;
    const int longer = at->width > at->height ? at->width : at->height;
    if (fits && append_tile(plan, &tile)) {
        note_tile(plan, &tile, &atlas, bytes);
        return WEFT_OK;
    }
    if (res == WEFT_OK && fits)
        res = out_of_memory(plan, at);
    else if (res == WEFT_OK && longer / 2 < MIN_TILE)
        res = refuse(plan, &tile, bytes);
    tile_destroy(plan, &tile);
    return res == WEFT_OK ? plan_halves(plan, at) : res;
}

// The slice's own tiles, which fit targets and tables, cut further where voxels ask for it.
static enum weft_result plan_tiles(struct weft_hardware_plan *plan)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < plan->slice->info.tile_count; i++) {
        const struct weft_rectangle at = weft_slice_tile_part(plan->slice, &plan->slice->tiles[i]);
        res = plan_rectangle(plan, &at);
    }
    for (int a = 0; a < 3; a++)
        plan->info.texture_size[a] = plan->atlas.size[a];
    return res;
}

// ---- the plan -----------------------------------------------------------------------------------

static enum weft_result check(const struct weft_hardware_params *p)
{
    const struct weft_sampler *sampler = &p->sampler;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->slice != NULL);
    weft_require(p->log,
                 sampler->max_size == 0 ||
                     (sampler->max_size >= 64 && sampler->max_size <= WEFT_SAMPLER_MAX_SIZE &&
                      sampler->fraction >= 0.0 && sampler->fraction <= 0.5 &&
                      sampler->rounding >= 0.0 && sampler->rounding <= 0.5));
    res = WEFT_OK;
fail:
    return res;
}

static void set_info(struct weft_hardware_plan *plan, const struct weft_hardware_figures *figures)
{
    struct weft_hardware_plan_info *info = &plan->info;
    plan->pairs = figures->pairs;
    info->fetches_per_axis = figures->pairs.fetches;
    info->pairs_per_axis = figures->pairs.pairs;
    info->fetches_per_pixel = (int)figures->work.fetches;
    info->bound = figures->bound;
    info->work = figures->work;
    info->work.texels = 0.0; // tiles may share cells
}

enum weft_result weft_hardware_plan_create(const struct weft_hardware_params *params,
                                           weft_hardware_plan **out)
{
    *out = NULL;
    enum weft_result res = check(params);
    if (res != WEFT_OK)
        return res;
    struct weft_hardware_plan *plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(params->log, "not enough memory to plan hardware filtering");
        return WEFT_ERR_MEMORY;
    }
    struct weft_hardware_figures figures;
    plan->slice = params->slice;
    plan->log = params->log;
    plan->memory_bytes = params->memory_bytes ? params->memory_bytes : DEFAULT_MEMORY;
    plan->info.sampler = params->sampler.max_size ? params->sampler
                                                  : weft_sampler_assume(params->slice->info.source);
    res = weft_hardware_figures_find(params->log, plan->slice, plan->slice, &plan->info.sampler,
                                     &figures);
    if (res == WEFT_OK) {
        set_info(plan, &figures);
        res = plan_tiles(plan);
    }
    if (res == WEFT_OK)
        res = weft_hardware_text_print(plan);
    if (res == WEFT_OK)
        *out = plan;
    else
        weft_hardware_plan_destroy(&plan);
    return res;
}

void weft_hardware_plan_destroy(weft_hardware_plan **plan)
{
    if (!plan || !*plan)
        return;
    for (int i = 0; i < (*plan)->info.tile_count; i++)
        tile_destroy(*plan, &(*plan)->tiles[i]);
    free((*plan)->tiles);
    free((*plan)->text);
    free(*plan);
    *plan = NULL;
}

const struct weft_hardware_plan_info *weft_hardware_plan_get_info(const weft_hardware_plan *plan)
{
    return &plan->info;
}
