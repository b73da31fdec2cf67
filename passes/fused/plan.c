// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/plan.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"

const char *const weft_lookup_names[] = {"polynomial", "linear", "nearest", NULL};
const char *const weft_saving_names[] = {"constant", "axis", "separable", "smooth", NULL};

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
enum {
    MAX_TILE = 4096,        // pixels along a side
    MIN_TILE = 16,          // a tile is cut no smaller
    COMFORTABLE_TILE = 256, // below this the automatic layout gives up interleaving
    BRICK_BYTES = WEFT_BRICK_VOXELS * 4,
};
static const int64_t MAX_TEXELS = INT64_C(1) << 26;

// Polynomial tiles are to be as good as single precision.
static const double TILE_TOLERANCE = 1e-9;

// ---- stores -------------------------------------------------------------------------------------

enum weft_result weft_slice_store_create(const struct weft_log *log,
                                         const struct weft_volume_info *info,
                                         const struct weft_brick_list *topology,
                                         const struct weft_cell_map *bricks, const float *values,
                                         weft_brick_store **out)
{
    // Planning asks only whether a brick is there.
    static const float unread[WEFT_BRICK_VOXELS];
    size_t count = bricks ? bricks->count : topology->brick_count;
    enum weft_result res =
        weft_brick_store_create(log, count + topology->tile_count, info->background, out);
    for (size_t i = 0; res == WEFT_OK && i < count; i++) {
        int32_t origin[3];
        for (int a = 0; a < 3; a++)
            origin[a] =
                bricks ? bricks->keys[i].at[a] * WEFT_BRICK_SIZE : topology->brick_origin[i][a];
        res = weft_brick_store_add_brick(*out, origin,
                                         bricks ? values + i * WEFT_BRICK_VOXELS : unread);
    }
    for (size_t i = 0; res == WEFT_OK && i < topology->tile_count; i++)
        res = weft_brick_store_add_tile(*out, &topology->tiles[i]);
    if (res != WEFT_OK)
        weft_brick_store_destroy(out);
    else if (info->clamp_to_edge)
        weft_brick_store_clamp(*out, info->active_min, info->active_max);
    return res;
}

enum weft_result weft_slice_read_bricks(const struct weft_slice_plan *plan, weft_volume *volume,
                                        const struct weft_cell_map *bricks, float *values)
{
    if (bricks->count == 0)
        return WEFT_OK;
    int32_t(*origin)[3] = malloc(bricks->count * sizeof *origin);
    if (!origin) {
        weft_error(plan->log, "not enough memory for the origins of %zu bricks", bricks->count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < bricks->count; i++)
        for (int a = 0; a < 3; a++)
            origin[i][a] = bricks->keys[i].at[a] * WEFT_BRICK_SIZE;
    enum weft_result res =
        weft_volume_read(volume, bricks->count, (const int32_t(*)[3])origin, values);
    free(origin);
    return res;
}

weft_volume *weft_slice_voxels(const struct weft_slice_plan *plan, weft_volume *volume)
{
    return plan->coefficients ? plan->coefficients : volume;
}

// ---- cells of a rectangle -----------------------------------------------------------------------

struct planner {
    struct weft_slice_plan *plan;
    const struct weft_volume_info *volume;
    const weft_brick_store *store; // of the topology
    uint64_t memory_bytes;
    int max_tile;
    int64_t max_texels;
    const struct weft_progress *progress;
    int64_t planned_pixels; // in finished tiles
    double fraction;        // last reported; another layout's attempt begins anew
};

struct collector {
    struct planner *planner;
    struct weft_slice_tile_plan *tile;
    size_t capacity;
    struct weft_cell_key last;
    int64_t last_number;
    int row;
    bool cancelled;
};

static bool go_on(struct planner *planner)
{
    const struct weft_progress *progress = planner->progress;
    const struct weft_slice_geometry *g = &planner->plan->grid.index;
    double pixels = (double)g->width * g->height;
    planner->fraction = fmax(planner->fraction, (double)planner->planned_pixels / pixels);
    return !progress || !progress->report || progress->report(progress->priv, planner->fraction);
}

static bool collect_span(void *priv, const struct weft_span *run)
{
    struct collector *c = priv;
    int64_t number = c->last_number;
    if (run->y != c->row) {
        c->row = run->y;
        c->cancelled = !go_on(c->planner);
        if (c->cancelled)
            return false;
    }
    if (number == WEFT_CELL_NONE || memcmp(&run->cell, &c->last, sizeof c->last) != 0) {
        size_t known = c->tile->map.count;
        number = weft_cell_map_add(&c->tile->map, run->cell);
        if (number == WEFT_CELL_NONE)
            return false;
        if ((size_t)number >= c->capacity) {
            size_t capacity = c->capacity ? 2 * c->capacity : 256;
            void *cells = realloc(c->tile->cells, capacity * sizeof *c->tile->cells);
            if (!cells)
                return false;
            c->tile->cells = cells;
            c->capacity = capacity;
        }
        if ((size_t)number == known)
            c->tile->cells[number] = (struct weft_slice_cell){.low = {7, 7, 7}};
        c->last = run->cell;
        c->last_number = number;
    }
    struct weft_slice_cell *cell = &c->tile->cells[number];
    for (int a = 0; a < 3; a++) {
        cell->low[a] = run->low[a] < cell->low[a] ? run->low[a] : cell->low[a];
        cell->high[a] = run->high[a] > cell->high[a] ? run->high[a] : cell->high[a];
    }
    return true;
}

void weft_slice_cell_reach(const struct weft_slice_plan *plan, struct weft_cell_key key,
                           const struct weft_slice_cell *cell, int32_t min[3], int32_t max[3])
{
    for (int a = 0; a < 3; a++) {
        int32_t start = key.at[a] * WEFT_BRICK_SIZE - plan->grid.tap_offset;
        min[a] = start + cell->low[a];
        max[a] = start + cell->high[a] + plan->info.kernel.width - 1;
    }
}

void weft_slice_cell_box(const struct weft_slice_plan *plan, struct weft_cell_key key,
                         const struct weft_slice_cell *cell, int32_t min[3], int32_t max[3])
{
    weft_slice_cell_reach(plan, key, cell, min, max);
    if (plan->axes.summed) {
        int a = plan->axes.order[2];
        min[a] += plan->axes.first;
        max[a] = min[a] + plan->axes.kept - 1;
    }
}

// Notes the bricks that hold a box of voxels, those of the clamp box where the volume has one.
static bool need_bricks(const struct planner *planner, struct weft_cell_map *bricks, int32_t min[3],
                        int32_t max[3])
{
    const struct weft_volume_info *v = planner->volume;
    struct weft_cell_key from, to, at;
    for (int a = 0; a < 3; a++) {
        if (v->clamp_to_edge) {
            min[a] = min[a] < v->active_min[a]   ? v->active_min[a]
                     : min[a] > v->active_max[a] ? v->active_max[a]
                                                 : min[a];
            max[a] = max[a] > v->active_max[a]   ? v->active_max[a]
                     : max[a] < v->active_min[a] ? v->active_min[a]
                                                 : max[a];
        }
        from.at[a] = min[a] >> 3;
        to.at[a] = max[a] >> 3;
    }
    for (at.at[2] = from.at[2]; at.at[2] <= to.at[2]; at.at[2]++) {
        for (at.at[1] = from.at[1]; at.at[1] <= to.at[1]; at.at[1]++) {
            for (at.at[0] = from.at[0]; at.at[0] <= to.at[0]; at.at[0]++) {
                int32_t origin[3] = {at.at[0] * 8, at.at[1] * 8, at.at[2] * 8};
                const float *values;
                float constant;
                if (weft_brick_store_find(planner->store, origin, &values, &constant) ==
                        WEFT_BRICK_VALUES &&
                    weft_cell_map_add(bricks, at) == WEFT_CELL_NONE)
                    return false;
            }
        }
    }
    return true;
}

// Sorts a tile's cells into constant ones and those with blocks, and sizes everything.
static bool classify_cells(const struct planner *planner, enum weft_layout layout,
                           struct weft_slice_tile_plan *tile, struct weft_slice_tile *out)
{
    const struct weft_slice_plan *plan = planner->plan;
    const int *order = plan->axes.order;
    int starts[3] = {1, 1, 1};
    for (size_t i = 0; i < tile->map.count; i++) {
        struct weft_slice_cell *cell = &tile->cells[i];
        int32_t min[3], max[3];
        weft_slice_cell_box(plan, tile->map.keys[i], cell, min, max);
        // A constant convolved is that constant only where the weights sum to one.
        cell->constant = plan->info.savings & WEFT_SAVING_CONSTANT &&
                         weft_brick_store_box_constant(planner->store, min, max, &cell->value);
        if (cell->constant)
            continue;
        out->cells_laid_out++;
        for (int i = 0; i < 3; i++)
            if (cell->high[order[i]] - cell->low[order[i]] + 1 > starts[i])
                starts[i] = cell->high[order[i]] - cell->low[order[i]] + 1;
        if (!need_bricks(planner, &tile->bricks, min, max))
            return false;
    }
    weft_block_layout_init(&tile->layout, layout, plan->info.source, plan->axes.taps, starts);
    int last = plan->axes.summed ? 0 : 7;
    tile->head_texels = weft_block_layout_offset(&tile->layout, (const int[]){7, 7, last}) + 1;
    tile->source_texels = tile->head_texels + out->cells_laid_out * tile->layout.block_texels;
    out->cells = tile->map.count;
    out->bricks_read = tile->bricks.count;
    out->memory_bytes = tile->bricks.count * BRICK_BYTES +
                        tile->source_texels * tile->layout.texel_bytes +
                        (uint64_t)out->width * (uint64_t)out->height * 8 + // table and target
                        tile->map.count * (sizeof *tile->cells + sizeof *tile->map.keys + 16);
    return true;
}

// The same for tiles without cells.
static bool size_plane(const struct planner *planner, struct weft_slice_tile_plan *tile,
                       struct weft_slice_tile *out)
{
    const struct weft_slice_plan *plan = planner->plan;
    const int *order = plan->axes.order;
    int32_t min[3], max[3];
    weft_slice_separable_box(plan, out, min, max);
    const uint64_t columns = (uint64_t)(max[order[0]] - min[order[0]] + 1);
    const uint64_t rows = (uint64_t)(max[order[1]] - min[order[1]] + 1);
    if (!need_bricks(planner, &tile->bricks, min, max))
        return false;
    // Samples, what is between the passes, and the result as a target and as it is read back.
    const uint64_t width = (uint64_t)out->width, height = (uint64_t)out->height;
    const uint64_t between = width * rows > height * columns ? width * rows : height * columns;
    const uint64_t passes = 4 * (columns * rows + 2 * between + 2 * width * height);
    tile->source_texels = columns * rows;
    out->bricks_read = tile->bricks.count;
    out->memory_bytes = tile->bricks.count * BRICK_BYTES +
                        columns * (rows + WEFT_BRICK_SIZE * (uint64_t)plan->axes.kept) * 4 +
                        (width + height) * sizeof(double) +
                        (passes < plan->separable_bytes ? passes : plan->separable_bytes);
    return true;
}

static void tile_plan_destroy(struct weft_slice_tile_plan *tile)
{
    weft_cell_map_destroy(&tile->map);
    weft_cell_map_destroy(&tile->bricks);
    free(tile->cells);
    *tile = (struct weft_slice_tile_plan){0};
}

// ---- tiles --------------------------------------------------------------------------------------

static bool append_tile(struct weft_slice_plan *plan, const struct weft_slice_tile *tile,
                        const struct weft_slice_tile_plan *tile_plan)
{
    size_t count = (size_t)plan->info.tile_count;
    if (count == plan->tile_capacity) {
        size_t capacity = plan->tile_capacity ? 2 * plan->tile_capacity : 16;
        void *tiles = realloc(plan->tiles, capacity * sizeof *plan->tiles);
        if (tiles)
            plan->tiles = tiles;
        void *plans = realloc(plan->tile_plans, capacity * sizeof *plan->tile_plans);
        if (plans)
            plan->tile_plans = plans;
        if (!tiles || !plans)
            return false;
        plan->tile_capacity = capacity;
    }
    plan->tiles[count] = *tile;
    plan->tile_plans[count] = *tile_plan;
    plan->info.tile_count++;
    return true;
}

// Where to cut a side: at a block boundary, or in the middle of what is smaller than two blocks.
static int cut(int length)
{
    int half = length / 2;
    return half >= WEFT_GRID_BLOCK ? half / WEFT_GRID_BLOCK * WEFT_GRID_BLOCK : half;
}

static enum weft_result plan_rectangle(struct planner *planner, enum weft_layout layout,
                                       int min_tile, struct weft_slice_tile rectangle);

static enum weft_result plan_halves(struct planner *planner, enum weft_layout layout, int min_tile,
                                    const struct weft_slice_tile *whole)
{
    struct weft_slice_tile first = {whole->x, whole->y, whole->width, whole->height, 0, 0, 0, 0};
    struct weft_slice_tile second = first;
    if (whole->width >= whole->height) {
        first.width = cut(whole->width);
        second.x += first.width;
        second.width -= first.width;
    } else {
        first.height = cut(whole->height);
        second.y += first.height;
        second.height -= first.height;
    }
    enum weft_result res = plan_rectangle(planner, layout, min_tile, first);
    return res == WEFT_OK ? plan_rectangle(planner, layout, min_tile, second) : res;
}

// Plans a rectangle in as few tiles as fit. WEFT_ERR_LIMIT when tiles of min_tile do not.
static enum weft_result plan_rectangle(struct planner *planner, enum weft_layout layout,
                                       int min_tile, struct weft_slice_tile rectangle)
{
    const bool separable = planner->plan->axes.separable;
    if (!separable && (rectangle.width > planner->max_tile || rectangle.height > planner->max_tile))
        return plan_halves(planner, layout, min_tile, &rectangle);
    struct weft_slice_tile_plan tile = {0};
    struct collector collector = {
        .planner = planner, .tile = &tile, .last_number = WEFT_CELL_NONE, .row = -1};
    if (separable && !size_plane(planner, &tile, &rectangle))
        goto fail;
    if (!separable &&
        (!weft_slice_grid_walk(&planner->plan->grid, rectangle.x, rectangle.y, rectangle.width,
                               rectangle.height, collect_span, &collector) ||
         !classify_cells(planner, layout, &tile, &rectangle)))
        goto fail;
    if (rectangle.memory_bytes <= planner->memory_bytes &&
        (int64_t)tile.source_texels <= planner->max_texels) {
        if (!append_tile(planner->plan, &rectangle, &tile))
            goto fail;
        planner->planned_pixels += (int64_t)rectangle.width * rectangle.height;
        return WEFT_OK;
    }
    tile_plan_destroy(&tile);
    int longer = rectangle.width > rectangle.height ? rectangle.width : rectangle.height;
    if (longer / 2 < min_tile) {
        weft_debug(planner->plan->log,
                   "layout %s: a tile of %d x %d pixels needs %" PRIu64 " bytes, over the limit of "
                   "%" PRIu64,
                   weft_layout_name(layout), rectangle.width, rectangle.height,
                   rectangle.memory_bytes, planner->memory_bytes);
        planner->plan->info.memory_bytes = rectangle.memory_bytes;
        return WEFT_ERR_LIMIT;
    }
    return plan_halves(planner, layout, min_tile, &rectangle);
fail:
    tile_plan_destroy(&tile);
    if (collector.cancelled)
        return WEFT_ERR_CANCELLED;
    weft_error(planner->plan->log, "not enough memory to plan %d x %d pixels", rectangle.width,
               rectangle.height);
    return WEFT_ERR_MEMORY;
}

static void forget_tiles(struct weft_slice_plan *plan)
{
    for (int i = 0; i < plan->info.tile_count; i++)
        tile_plan_destroy(&plan->tile_plans[i]);
    plan->info.tile_count = 0;
}

// The layouts to try in turn, each down to a smallest tile.
static enum weft_result plan_tiles(struct planner *planner, enum weft_layout asked)
{
    struct weft_slice_plan *plan = planner->plan;
    int width = plan->info.kernel.width;
    struct {
        enum weft_layout layout;
        int min_tile;
    } tries[3] = {{asked, MIN_TILE}};
    int count = 1;
    if (plan->axes.separable) {
        tries[0].layout = WEFT_LAYOUT_PLAIN;
    } else if (asked == WEFT_LAYOUT_AUTO) {
        // One or two taps a row use too little of a texel of four.
        tries[0].layout = width < 3 ? WEFT_LAYOUT_PLAIN : WEFT_LAYOUT_INTERLEAVED;
        tries[0].min_tile = width < 3 ? MIN_TILE : COMFORTABLE_TILE;
        if (width >= 3) {
            tries[count].layout = WEFT_LAYOUT_ALIGNED;
            tries[count++].min_tile = MIN_TILE;
        }
    }
    enum weft_result res = WEFT_ERR_LIMIT;
    for (int i = 0; i < count && res == WEFT_ERR_LIMIT; i++) {
        forget_tiles(plan);
        planner->planned_pixels = 0;
        plan->info.layout = tries[i].layout;
        res = plan_rectangle(planner, tries[i].layout, tries[i].min_tile,
                             (struct weft_slice_tile){0, 0, plan->grid.index.width,
                                                      plan->grid.index.height, 0, 0, 0, 0});
    }
    if (res == WEFT_ERR_LIMIT)
        weft_error(plan->log,
                   "the smallest tile of the slice needs %" PRIu64
                   " bytes; the memory limit is %" PRIu64,
                   plan->info.memory_bytes, planner->memory_bytes);
    return res;
}

// ---- the request --------------------------------------------------------------------------------

static enum weft_result check_values(const struct weft_slice_params *p)
{
    enum weft_result res = weft_kernel_check(p->log, &p->kernel);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require_enum(p->log, p->space, WEFT_SPACE_INDEX);
    weft_require_enum(p->log, p->layout, WEFT_LAYOUT_PLAIN);
    weft_require_enum(p->log, p->source, WEFT_SOURCE_UNORM8);
    weft_require_enum(p->log, p->lookup, WEFT_LOOKUP_NEAREST);
    weft_require(p->log, p->without <= WEFT_SAVING_ALL);
    weft_require(p->log, p->max_target_size >= 0);
    weft_require(p->log, p->max_buffer_texels >= 0);
    return WEFT_OK;
fail:
    return res;
}

bool weft_slice_source_holds(enum weft_source_format source, double low, double high)
{
    const double most = 1e37; // so that widths and sums of a range are single precision too
    return source == WEFT_SOURCE_FLOAT ||
           (high - low >= FLT_MIN && fabs(low) <= most && fabs(high) <= most);
}

static enum weft_result check_request(const struct weft_slice_params *p)
{
    if (!weft_slice_source_holds(p->source, p->low, p->high)) {
        weft_error(p->log,
                   "a source of format %s needs a range within +-1e37, 1.2e-38 wide or more: %g to "
                   "%g is none",
                   weft_source_format_name(p->source), p->low, p->high);
        return WEFT_ERR_ARGUMENT;
    }
    if (!(p->smooth_error >= 0.0) || isinf(p->smooth_error)) {
        weft_error(p->log, "the error of cheaper pieces must be 0 or more: %g", p->smooth_error);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result create_kernel_tiles(struct weft_slice_plan *plan,
                                            const struct weft_slice_params *p)
{
    enum { DEFAULT_SAMPLES = 64 };
    if (p->lookup == WEFT_LOOKUP_POLYNOMIAL)
        return weft_polynomial_tiles_create(p->log, &p->kernel, TILE_TOLERANCE,
                                            &plan->kernel_tiles);
    return weft_polynomial_tiles_sample(p->log, &p->kernel,
                                        p->samples ? p->samples : DEFAULT_SAMPLES,
                                        p->lookup == WEFT_LOOKUP_LINEAR, &plan->kernel_tiles);
}

// Everything but what lies where.
static enum weft_result set_request(struct weft_slice_plan *plan, const struct weft_slice_params *p,
                                    const struct weft_volume_info *volume)
{
    struct weft_slice_plan_info *info = &plan->info;
    enum weft_result res = check_request(p);
    info->kernel = p->kernel;
    info->source = p->source;
    info->lookup = p->lookup;
    plan->range = (struct weft_source_range){p->low, p->high};
    plan->clamp_to_samples = p->clamp_to_samples;
    if (res == WEFT_OK)
        res = create_kernel_tiles(plan, p);
    if (res != WEFT_OK)
        return res;
    info->samples = plan->kernel_tiles.segments;
    info->weight_vectors = (plan->kernel_tiles.degree + 1) * plan->kernel_tiles.groups;
    weft_slice_axes_set(plan, !(p->without & WEFT_SAVING_AXIS) && !p->clamp_to_samples);
    // It has a layout, a source and weights of its own.
    if (p->layout == WEFT_LAYOUT_AUTO && p->source == WEFT_SOURCE_FLOAT &&
        p->lookup == WEFT_LOOKUP_POLYNOMIAL && !(p->without & WEFT_SAVING_SEPARABLE))
        weft_slice_separable_set(plan);
    weft_slice_bound_set(plan, p->without & WEFT_SAVING_SMOOTH ? 0.0 : p->smooth_error, volume);
    if (plan->axes.separable)
        info->savings |= WEFT_SAVING_SEPARABLE;
    // A constant convolved is that constant only where the weights sum to one.
    else if (p->kernel.unit_sum && !(p->without & WEFT_SAVING_CONSTANT))
        info->savings |= WEFT_SAVING_CONSTANT;
    if (plan->axes.summed)
        info->savings |= WEFT_SAVING_AXIS;
    if (plan->smooth.error > 0.0)
        info->savings |= WEFT_SAVING_SMOOTH;
    return WEFT_OK;
}

// ---- plans --------------------------------------------------------------------------------------

// Whether every pixel sees the background and nothing else.
static bool sees_background_only(const struct weft_slice_plan *plan, float background)
{
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_tile_plan *tile = &plan->tile_plans[i];
        if (plan->axes.separable && (tile->bricks.count || plan->topology.tile_count))
            return false;
        for (size_t c = 0; c < tile->map.count; c++)
            if (!tile->cells[c].constant ||
                memcmp(&tile->cells[c].value, &background, sizeof background) != 0)
                return false;
    }
    return true;
}

static void fill_info(struct weft_slice_plan *plan, const struct weft_slice_params *params,
                      const struct weft_volume_info *volume)
{
    struct weft_slice_plan_info *info = &plan->info;
    int width = info->kernel.width;
    info->geometry = params->geometry;
    info->space = params->space;
    info->index_geometry = plan->grid.index;
    info->fetches_per_pixel =
        plan->axes.separable
            ? 2 * width
            : plan->axes.taps[2] * width * weft_layout_row_fetches(info->layout, width);
    info->tiles = plan->tiles;
    info->memory_bytes = 0;
    for (int i = 0; i < info->tile_count; i++) {
        info->source_texels += plan->tile_plans[i].source_texels;
        info->bricks_read += plan->tiles[i].bricks_read;
        if (plan->tiles[i].memory_bytes > info->memory_bytes)
            info->memory_bytes = plan->tiles[i].memory_bytes;
    }
    info->misses_volume = sees_background_only(plan, volume->background);
}

void weft_slice_clamp_region(const struct weft_volume_info *volume, struct weft_region *region)
{
    region->slab_count = 0;
    for (int a = 0; a < 3; a++) {
        int32_t low = volume->active_min[a], high = volume->active_max[a];
        region->min[a] = region->min[a] < low ? low : region->min[a] > high ? high : region->min[a];
        region->max[a] = region->max[a] > high ? high : region->max[a] < low ? low : region->max[a];
    }
}

static enum weft_result find_topology(struct weft_slice_plan *plan, weft_volume *volume)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_region region;
    weft_slice_grid_region(&plan->grid, plan->info.kernel.width, &region);
    if (info->clamp_to_edge)
        weft_slice_clamp_region(info, &region);
    return weft_volume_find(volume, &region, &plan->topology);
}

static enum weft_result create_coefficients(struct weft_slice_plan *plan, weft_volume *volume,
                                            const struct weft_slice_params *p)
{
    struct weft_prefilter prefilter;
    if (p->clamp_to_samples) {
        weft_error(p->log,
                   "kernel %si: coefficients are no samples that pixels could be clamped to",
                   p->kernel.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    enum weft_result res = weft_prefilter_compute(p->log, &p->kernel, &prefilter);
    if (res != WEFT_OK)
        return res;
    plan->info.prefilter_overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    return weft_volume_prefilter(volume, &p->kernel, p->log, &plan->coefficients);
}

enum weft_result weft_slice_request_create(weft_volume *volume,
                                           const struct weft_slice_params *params,
                                           struct weft_slice_plan **out)
{
    *out = NULL;
    enum weft_result res = WEFT_ERR_MEMORY;
    struct weft_slice_params p = *params;
    struct weft_slice_plan *plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(p.log, "not enough memory to plan the slice");
        goto fail;
    }
    plan->log = p.log;
    if (!p.kernel.info) {
        res = weft_kernel_parse(p.log, "catmull-rom", &p.kernel);
        if (res != WEFT_OK)
            goto fail;
    }
    res = check_values(&p);
    if (res != WEFT_OK)
        goto fail;
    if (p.kernel.radial) {
        weft_error(p.log, "kernel %s is radial: a slice multiplies the weights of three axes",
                   p.kernel.info->name);
        res = WEFT_ERR_UNSUPPORTED;
        goto fail;
    }
    res = p.kernel.prefiltered ? create_coefficients(plan, volume, &p) : WEFT_OK;
    if (res == WEFT_OK)
        res = weft_slice_grid_create(p.log, &p, weft_volume_get_info(volume), &plan->grid);
    if (res == WEFT_OK)
        res = set_request(plan, &p, weft_volume_get_info(volume));
    if (res != WEFT_OK)
        goto fail;
    *out = plan;
    return WEFT_OK;
fail:
    weft_slice_plan_destroy(&plan);
    return res;
}

enum weft_result weft_slice_plan_create(weft_volume *volume, const struct weft_slice_params *params,
                                        weft_slice_plan **out)
{
    *out = NULL;
    const struct weft_slice_params *p = params;
    weft_brick_store *store = NULL;
    struct weft_slice_plan *plan = NULL;
    enum weft_result res = weft_slice_request_create(volume, params, &plan);
    if (res != WEFT_OK)
        return res;
    volume = weft_slice_voxels(plan, volume);
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    res = find_topology(plan, volume);
    if (res == WEFT_OK)
        res = weft_slice_store_create(p->log, info, &plan->topology, NULL, NULL, &store);
    if (res != WEFT_OK)
        goto fail;
    struct planner planner = {
        .plan = plan,
        .volume = info,
        .store = store,
        .progress = p->progress,
        .memory_bytes = p->memory_bytes ? p->memory_bytes : DEFAULT_MEMORY,
        .max_tile =
            p->max_target_size > 0 && p->max_target_size < MAX_TILE ? p->max_target_size : MAX_TILE,
        .max_texels = p->max_buffer_texels > 0 && p->max_buffer_texels < MAX_TEXELS
                          ? p->max_buffer_texels
                          : MAX_TEXELS,
    };
    plan->separable_bytes = planner.memory_bytes / 2;
    res = plan_tiles(&planner, p->layout);
    if (res != WEFT_OK)
        goto fail;
    fill_info(plan, p, info);
    res = weft_slice_text_print(plan, info);
    if (res != WEFT_OK)
        goto fail;
    if (plan->info.misses_volume)
        weft_slice_miss_report(p->log, plan, p, info);
    weft_brick_store_destroy(&store);
    *out = plan;
    return WEFT_OK;
fail:
    weft_brick_store_destroy(&store);
    weft_slice_plan_destroy(&plan);
    return res;
}

void weft_slice_plan_destroy(weft_slice_plan **plan)
{
    if (!plan || !*plan)
        return;
    forget_tiles(*plan);
    free((*plan)->tiles);
    free((*plan)->tile_plans);
    weft_polynomial_tiles_destroy(&(*plan)->kernel_tiles);
    weft_brick_list_clear(&(*plan)->topology);
    weft_volume_destroy(&(*plan)->coefficients);
    free((*plan)->text);
    free(*plan);
    *plan = NULL;
}

const struct weft_slice_plan_info *weft_slice_plan_get_info(const weft_slice_plan *plan)
{
    return &plan->info;
}
