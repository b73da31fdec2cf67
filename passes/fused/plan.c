// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/plan.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/fused/resident_impl.h"

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
// Of the CPU engine: what over a hundred threads filter separable tiles in.
static const uint64_t CPU_BYTES = UINT64_C(64) << 20;
enum {
    MAX_TILE = 4096,        // pixels along a side
    MIN_TILE = 16,          // a tile is cut no smaller
    COMFORTABLE_TILE = 256, // below this the automatic layout gives up interleaving
    BRICK_BYTES = WEFT_BRICK_VOXELS * 4,
    CELL_BYTES = sizeof(struct weft_slice_cell) + sizeof(struct weft_slice_content) +
                 sizeof(struct weft_cell_key) + 16,
};
static const int64_t MAX_TEXELS = INT64_C(1) << 26;

// ---- cells of a rectangle -----------------------------------------------------------------------

struct planner {
    struct weft_slice_plan *plan;
    uint64_t memory_bytes;
    int max_tile;
    int64_t max_texels;
    const struct weft_progress *progress;
    int64_t all_pixels;     // of what is planned
    int64_t planned_pixels; // in finished tiles
    double fraction;        // last reported; another layout's attempt begins anew
    size_t needed_blocks;   // of the tile that was sized last
};

static enum weft_result out_of_memory(const struct weft_slice_plan *plan,
                                      const struct weft_slice_tile *tile)
{
    weft_error(plan->log, "not enough memory to plan %d x %d pixels", tile->width, tile->height);
    return WEFT_ERR_MEMORY;
}

void weft_slice_cell_box(const struct weft_slice_plan *plan, size_t number, int32_t min[3],
                         int32_t max[3])
{
    weft_footprint_cell_box(plan->footprint, plan->cells, number, min, max);
    weft_slice_axes_narrow(&plan->axes, min, max);
}

// What cells hold, and which bricks are to be read for those that are not constant.
static bool sort_cells(const struct weft_slice_plan *plan, struct weft_slice_tile_plan *tile,
                       struct weft_slice_tile *out, int starts[3])
{
    const struct weft_slice_cells *cells = tile->cells;
    const int *order = plan->axes.order;
    for (size_t i = 0; i < cells->map.count; i++) {
        struct weft_slice_content *content = &tile->content[i];
        int32_t min[3], max[3];
        content->number = (size_t)weft_cell_map_find(&plan->cells->map, cells->map.keys[i]);
        const struct weft_slice_cell *cell = &plan->cells->at[content->number];
        weft_slice_cell_box(plan, content->number, min, max);
        // A constant convolved is that constant only where the weights sum to one.
        content->constant = plan->info.savings & WEFT_SAVING_CONSTANT &&
                            weft_brick_store_box_constant(plan->footprint->bricks.places, min, max,
                                                          &content->value);
        if (content->constant)
            continue;
        out->cells_laid_out++;
        for (int a = 0; a < 3; a++)
            if (cell->high[order[a]] - cell->low[order[a]] + 1 > starts[a])
                starts[a] = cell->high[order[a]] - cell->low[order[a]] + 1;
        if (!weft_brick_reader_note(&plan->footprint->bricks, min, max, &tile->bricks))
            return false;
    }
    return true;
}

// Of the table and the targets.
static uint64_t pixel_bytes(const struct weft_slice_plan *plan)
{
    const bool several = plan->info.engine == WEFT_ENGINE_GL && weft_slice_derives(plan);
    return 4 + (several ? 16 * (uint64_t)weft_fused_target_count(plan->info.output_count) : 4);
}

// Finds a tile's cells and sizes everything.
static enum weft_result size_cells(const struct planner *planner, enum weft_layout layout,
                                   struct weft_slice_tile_plan *tile, struct weft_slice_tile *out)
{
    const struct weft_slice_plan *plan = planner->plan;
    const struct weft_rectangle at = {out->x, out->y, out->width, out->height};
    int starts[3] = {1, 1, 1};
    const enum weft_result res = weft_footprint_cells(plan->footprint, &at, planner->progress,
                                                      planner->fraction, &tile->cells);
    if (res != WEFT_OK)
        return res;
    const size_t count = tile->cells->map.count;
    tile->content = malloc(count * sizeof *tile->content);
    if (!tile->content || !sort_cells(plan, tile, out, starts))
        return out_of_memory(plan, out);
    weft_block_layout_init(&tile->layout, layout, plan->info.source, plan->axes.taps, starts);
    int last = plan->axes.summed ? 0 : 7;
    tile->head_texels = weft_block_layout_offset(&tile->layout, (const int[]){7, 7, last}) + 1;
    tile->source_texels = tile->head_texels + out->cells_laid_out * tile->layout.block_texels;
    out->cells = count;
    out->bricks_read = tile->bricks.count;
    out->memory_bytes =
        tile->bricks.count * BRICK_BYTES + tile->source_texels * tile->layout.texel_bytes +
        (uint64_t)out->width * (uint64_t)out->height * pixel_bytes(plan) + count * CELL_BYTES;
    return WEFT_OK;
}

// The same for tiles that read resident blocks.
static enum weft_result size_blocks(struct planner *planner, struct weft_slice_tile_plan *tile,
                                    struct weft_slice_tile *out)
{
    const struct weft_slice_plan *plan = planner->plan;
    const struct weft_rectangle at = {out->x, out->y, out->width, out->height};
    struct weft_resident_survey survey;
    enum weft_result res = weft_footprint_cells(plan->footprint, &at, planner->progress,
                                                planner->fraction, &tile->cells);
    if (res != WEFT_OK)
        return res;
    const struct weft_resident_request request = weft_resident_request_of(plan, tile->cells);
    res = weft_resident_survey(plan->resident, &request, &survey);
    tile->layout = plan->resident->layout;
    tile->background = survey.background;
    tile->source_texels = survey.blocks * tile->layout.block_texels;
    planner->needed_blocks = survey.blocks;
    out->cells = tile->cells->map.count;
    out->cells_laid_out = survey.blocks;
    out->bricks_read = survey.bricks;
    out->memory_bytes =
        (uint64_t)out->width * (uint64_t)out->height * pixel_bytes(plan) + out->cells * CELL_BYTES;
    return res;
}

// The same for tiles without cells.
static enum weft_result size_plane(const struct planner *planner, struct weft_slice_tile_plan *tile,
                                   struct weft_slice_tile *out)
{
    const struct weft_slice_plan *plan = planner->plan;
    const int *order = plan->axes.order;
    const struct weft_rectangle at = {out->x, out->y, out->width, out->height};
    int32_t min[3], max[3];
    weft_slice_axes_box(&plan->axes, &plan->info.kernel, &plan->footprint->grid, &at, min, max);
    const uint64_t columns = (uint64_t)(max[order[0]] - min[order[0]] + 1);
    const uint64_t rows = (uint64_t)(max[order[1]] - min[order[1]] + 1);
    if (!weft_brick_reader_note(&plan->footprint->bricks, min, max, &tile->bricks))
        return out_of_memory(plan, out);
    // Samples, what is between the passes, and the result as a target and as it is read back.
    const uint64_t width = (uint64_t)out->width, height = (uint64_t)out->height;
    const uint64_t between = width * rows > height * columns ? width * rows : height * columns;
    const bool gl = plan->info.engine == WEFT_ENGINE_GL;
    const uint64_t passes =
        gl ? 4 * (columns * rows + 2 * between + 2 * width * height) : plan->separable_bytes;
    const uint64_t sample = plan->info.sums == WEFT_SUMS_DOUBLE ? sizeof(double) : sizeof(float);
    tile->source_texels = columns * rows;
    out->bricks_read = tile->bricks.count;
    out->memory_bytes = tile->bricks.count * BRICK_BYTES + columns * rows * sample +
                        (width + height) * sizeof(double) +
                        (passes < plan->separable_bytes ? passes : plan->separable_bytes);
    return WEFT_OK;
}

static void tile_plan_destroy(const struct weft_slice_plan *plan, struct weft_slice_tile_plan *tile)
{
    weft_footprint_release(plan->footprint, &tile->cells);
    weft_cell_map_destroy(&tile->bricks);
    free(tile->content);
    *tile = (struct weft_slice_tile_plan){0};
}

uint64_t weft_slice_bricks_read(const struct weft_slice_plan *plan)
{
    if (!plan->resident || !plan->resident->kept)
        return plan->footprint->info.bricks_read;
    weft_resident_count(plan->resident);
    return plan->resident->info.bricks_read;
}

enum weft_result weft_slice_tile_bricks(const struct weft_slice_plan *plan, int tile,
                                        const struct weft_cell_map **out)
{
    struct weft_slice_tile_plan *t = &plan->tile_plans[tile];
    *out = &t->bricks;
    if (!weft_slice_reads_blocks(plan) || t->bricks.count)
        return WEFT_OK;
    const enum weft_result res = weft_footprint_open(plan->footprint);
    for (size_t i = 0; res == WEFT_OK && i < t->cells->map.count; i++) {
        int32_t min[3], max[3];
        weft_footprint_cell_box(plan->footprint, t->cells, i, min, max);
        if (!weft_brick_reader_note(&plan->footprint->bricks, min, max, &t->bricks))
            return out_of_memory(plan, &plan->tiles[tile]);
    }
    return res;
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

// Whether which shader draws a pixel depends on those around it.
static bool draws_squares(const struct weft_slice_plan *plan)
{
    return plan->info.engine == WEFT_ENGINE_GL && plan->smooth.error > 0.0;
}

// Where to cut a side that begins at `from`: at a block boundary, or in the middle of what is
// smaller than two blocks, which where squares are drawn lies between two of them.
static int cut(const struct weft_slice_plan *plan, int from, int length)
{
    const int half = length / 2, end = from + half;
    if (half >= WEFT_GRID_BLOCK)
        return half / WEFT_GRID_BLOCK * WEFT_GRID_BLOCK;
    return draws_squares(plan) && end / WEFT_SLICE_SQUARE * WEFT_SLICE_SQUARE > from
               ? end / WEFT_SLICE_SQUARE * WEFT_SLICE_SQUARE - from
               : half;
}

// What is done of all pixels; another layout's attempt begins anew, and tells no less.
static void note_progress(struct planner *planner, const struct weft_slice_tile *done)
{
    planner->planned_pixels += (int64_t)done->width * done->height;
    planner->fraction = fmin(1.0, fmax(planner->fraction, (double)planner->planned_pixels /
                                                              (double)planner->all_pixels));
}

static enum weft_result plan_rectangle(struct planner *planner, enum weft_layout layout,
                                       int min_tile, struct weft_slice_tile rectangle);

static enum weft_result plan_halves(struct planner *planner, enum weft_layout layout, int min_tile,
                                    const struct weft_slice_tile *whole)
{
    struct weft_slice_tile first = {whole->x, whole->y, whole->width, whole->height, 0, 0, 0, 0};
    struct weft_slice_tile second = first;
    if (whole->width >= whole->height) {
        first.width = cut(planner->plan, whole->x, whole->width);
        second.x += first.width;
        second.width -= first.width;
    } else {
        first.height = cut(planner->plan, whole->y, whole->height);
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
    struct weft_slice_plan *plan = planner->plan;
    const bool separable = plan->axes.separable;
    if (!separable && (rectangle.width > planner->max_tile || rectangle.height > planner->max_tile))
        return plan_halves(planner, layout, min_tile, &rectangle);
    struct weft_slice_tile_plan tile = {.cells = NULL};
    const bool blocks = weft_slice_reads_blocks(plan);
    enum weft_result res = separable ? size_plane(planner, &tile, &rectangle)
                           : blocks  ? size_blocks(planner, &tile, &rectangle)
                                     : size_cells(planner, layout, &tile, &rectangle);
    const bool fits =
        rectangle.memory_bytes <= planner->memory_bytes &&
        (!blocks || planner->needed_blocks <= plan->resident->info.capacity) &&
        (separable || ((blocks || (int64_t)tile.source_texels <= planner->max_texels) &&
                       (int64_t)rectangle.width * rectangle.height <= planner->max_texels));
    if (res == WEFT_OK && fits && append_tile(plan, &rectangle, &tile)) {
        note_progress(planner, &rectangle);
        return WEFT_OK;
    }
    tile_plan_destroy(plan, &tile);
    if (res != WEFT_OK)
        return res;
    if (fits)
        return out_of_memory(plan, &rectangle);
    int longer = rectangle.width > rectangle.height ? rectangle.width : rectangle.height;
    if (longer / 2 >= min_tile)
        return plan_halves(planner, layout, min_tile, &rectangle);
    weft_debug(plan->log,
               "layout %s: a tile of %d x %d pixels needs %" PRIu64 " bytes, over the limit of "
               "%" PRIu64,
               weft_layout_name(layout), rectangle.width, rectangle.height, rectangle.memory_bytes,
               planner->memory_bytes);
    plan->info.memory_bytes = rectangle.memory_bytes;
    return WEFT_ERR_LIMIT;
}

static void forget_tiles(struct weft_slice_plan *plan)
{
    for (int i = 0; i < plan->info.tile_count; i++)
        tile_plan_destroy(plan, &plan->tile_plans[i]);
    plan->info.tile_count = 0;
}

static struct weft_rectangle whole_of(const struct weft_slice_plan *plan)
{
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    return (struct weft_rectangle){0, 0, g->width, g->height};
}

// How many columns (or rows) apart two pixels of one cell may be: along each two axes their
// distance is less than a cell.
static double cell_pixels(const double along[3], const double across[3])
{
    double most = INFINITY;
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3;
        const double area = fabs(along[a] * across[b] - along[b] * across[a]);
        most = fmin(most, WEFT_BRICK_SIZE * (fabs(across[a]) + fabs(across[b])) / area);
    }
    return most;
}

static void widen(double by, int32_t limit, int32_t *from, int32_t *length)
{
    const double first = fmax(0.0, *from - by);
    const double end = fmin((double)limit, (double)*from + *length + by);
    *from = (int32_t)first;
    *length = (int32_t)end - *from;
}

// What a part is drawn with: whole squares where those are drawn.
static struct weft_rectangle planned_rectangle(const struct weft_slice_plan *plan)
{
    const struct weft_rectangle whole = whole_of(plan);
    struct weft_rectangle at = plan->info.part;
    if (!draws_squares(plan) || plan->axes.separable)
        return at;
    const int32_t x = at.x & -WEFT_SLICE_SQUARE, y = at.y & -WEFT_SLICE_SQUARE;
    at.width = (at.x + at.width - x + WEFT_SLICE_SQUARE - 1) & -WEFT_SLICE_SQUARE;
    at.height = (at.y + at.height - y + WEFT_SLICE_SQUARE - 1) & -WEFT_SLICE_SQUARE;
    at.x = x;
    at.y = y;
    return weft_rectangle_common(&at, &whole);
}

// What is planned, with all pixels of its cells around it.
static struct weft_rectangle window_of(const struct weft_slice_plan *plan)
{
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    struct weft_rectangle window = planned_rectangle(plan);
    double du[3], dv[3];
    for (int a = 0; a < 3; a++) {
        du[a] = g->u[a] / g->width;
        dv[a] = g->v[a] / g->height;
    }
    // Positions are rounded, by far less than a pixel's share of a cell.
    enum { SLACK = 2 };
    widen(1.01 * cell_pixels(du, dv) + SLACK, g->width, &window.x, &window.width);
    widen(1.01 * cell_pixels(dv, du) + SLACK, g->height, &window.y, &window.height);
    return window;
}

// The cells that say what is needed of each; blocks that stay resident are whole ones.
static enum weft_result find_cells(const struct planner *planner, bool all)
{
    struct weft_slice_plan *plan = planner->plan;
    const struct weft_rectangle whole = whole_of(plan);
    const bool known =
        all || weft_slice_is_whole(plan) || weft_footprint_has_cells(plan->footprint, &whole);
    const struct weft_rectangle window = known ? whole : window_of(plan);
    if (plan->cells || plan->axes.separable ||
        (weft_slice_reads_blocks(plan) && !weft_slice_is_whole(plan)))
        return WEFT_OK;
    return weft_footprint_cells(plan->footprint, &window, planner->progress, 0.0, &plan->cells);
}

// Layouts to try in turn, each down to a smallest tile.
struct tries {
    int count;
    enum weft_layout layout[2];
    int min_tile[2];
};

static void add_try(struct tries *tries, enum weft_layout layout, int min_tile)
{
    tries->layout[tries->count] = layout;
    tries->min_tile[tries->count++] = min_tile;
}

static struct tries find_tries(const struct weft_slice_plan *plan, enum weft_layout asked)
{
    const int width = plan->info.kernel.width;
    struct tries tries = {0};
    if (plan->axes.separable || plan->info.engine == WEFT_ENGINE_CPU) {
        add_try(&tries, WEFT_LAYOUT_PLAIN, MIN_TILE);
    } else if (weft_slice_reads_blocks(plan)) {
        add_try(&tries, plan->resident->info.layout, MIN_TILE);
    } else if (asked != WEFT_LAYOUT_AUTO) {
        add_try(&tries, asked, MIN_TILE);
    } else if (width < 3) { // one or two taps a row use too little of a texel of four
        add_try(&tries, WEFT_LAYOUT_PLAIN, MIN_TILE);
    } else {
        add_try(&tries, WEFT_LAYOUT_INTERLEAVED, COMFORTABLE_TILE);
        add_try(&tries, WEFT_LAYOUT_ALIGNED, MIN_TILE);
    }
    return tries;
}

static enum weft_result try_layouts(struct planner *planner, const struct tries *tries,
                                    const struct weft_rectangle *at)
{
    struct weft_slice_plan *plan = planner->plan;
    const struct weft_slice_tile tile = {at->x, at->y, at->width, at->height, 0, 0, 0, 0};
    enum weft_result res = WEFT_ERR_LIMIT;
    planner->all_pixels = (int64_t)at->width * at->height;
    for (int i = 0; i < tries->count && res == WEFT_ERR_LIMIT; i++) {
        forget_tiles(plan);
        planner->planned_pixels = 0;
        plan->info.layout = tries->layout[i];
        res = plan_rectangle(planner, tries->layout[i], tries->min_tile[i], tile);
    }
    return res;
}

// Of a part the layout is the one that the whole slice has.
static enum weft_result try_whole(struct planner *planner, struct tries *tries)
{
    struct weft_slice_plan *plan = planner->plan;
    const struct weft_rectangle whole = whole_of(plan);
    enum weft_result res = find_cells(planner, true);
    if (res == WEFT_OK)
        res = try_layouts(planner, tries, &whole);
    if (res != WEFT_OK)
        return res;
    forget_tiles(plan);
    *tries = (struct tries){0};
    add_try(tries, plan->info.layout, MIN_TILE);
    return WEFT_OK;
}

static enum weft_result plan_tiles(struct planner *planner, enum weft_layout asked)
{
    struct weft_slice_plan *plan = planner->plan;
    struct tries tries = find_tries(plan, asked);
    enum weft_result res = WEFT_OK;
    if (tries.count > 1 && !weft_slice_is_whole(plan))
        res = try_whole(planner, &tries);
    if (res == WEFT_OK)
        res = find_cells(planner, false);
    const struct weft_rectangle at = planned_rectangle(plan);
    if (res == WEFT_OK)
        res = try_layouts(planner, &tries, &at);
    if (res == WEFT_ERR_LIMIT && weft_slice_reads_blocks(plan) &&
        planner->needed_blocks > plan->resident->info.capacity)
        weft_error(plan->log,
                   "the smallest tile of the slice needs %zu blocks; the resident volume has "
                   "places for %" PRIu64,
                   planner->needed_blocks, plan->resident->info.capacity);
    else if (res == WEFT_ERR_LIMIT)
        weft_error(plan->log,
                   "the smallest tile of the slice needs %" PRIu64
                   " bytes; the memory limit is %" PRIu64,
                   plan->info.memory_bytes, planner->memory_bytes);
    return res;
}

// ---- the request --------------------------------------------------------------------------------

static enum weft_result check_derivatives(const struct weft_slice_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->derivative_count >= 0 && p->derivative_count <= WEFT_DERIVATIVES);
    weft_require(p->log, p->derivative || !p->derivative_count);
    for (int i = 0; i < p->derivative_count; i++) {
        const int *along = p->derivative[i].along;
        for (int a = 0; a < 3; a++)
            weft_require(p->log, along[a] >= 0 && along[a] <= 2);
        weft_require(p->log, along[0] + along[1] + along[2] <= 2);
    }
    return WEFT_OK;
fail:
    return res;
}

static enum weft_result check_values(const struct weft_slice_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(p->log, p->engine, WEFT_ENGINE_CPU);
    weft_require_enum(p->log, p->sums, WEFT_SUMS_DOUBLE);
    weft_require_enum(p->log, p->layout, WEFT_LAYOUT_PLAIN);
    weft_require_enum(p->log, p->source, WEFT_SOURCE_UNORM8);
    weft_require_enum(p->log, p->lookup, WEFT_LOOKUP_NEAREST);
    weft_require(p->log, p->without <= WEFT_SAVING_ALL);
    weft_require(p->log, p->max_target_size >= 0);
    weft_require(p->log, p->max_buffer_texels >= 0);
    res = check_derivatives(p);
fail:
    return res;
}

// Layout and source of a resident volume are what they are; so is what it was made for.
static enum weft_result check_resident(const struct weft_slice_params *p)
{
    const struct weft_resident_info *r = &p->resident->info;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, (p->engine == WEFT_ENGINE_CPU) == !p->resident->context);
    if ((p->layout != WEFT_LAYOUT_AUTO && p->layout != r->layout) ||
        (p->source != WEFT_SOURCE_FLOAT && p->source != r->source)) {
        weft_error(p->log, "the resident volume is laid out %s, as %s, and not %s, as %s",
                   weft_layout_name(r->layout), weft_source_format_name(r->source),
                   weft_layout_name(p->layout), weft_source_format_name(p->source));
        return res;
    }
    if (p->source != WEFT_SOURCE_FLOAT && (p->low != r->low || p->high != r->high)) {
        weft_error(p->log, "the resident volume holds %g to %g, and not %g to %g", r->low, r->high,
                   p->low, p->high);
        return res;
    }
    return WEFT_OK;
fail:
    return res;
}

static enum weft_result check_request(const struct weft_slice_params *p)
{
    if (p->sums == WEFT_SUMS_DOUBLE && p->engine != WEFT_ENGINE_CPU) {
        weft_error(p->log, "OpenGL sums in single precision: sums in double need the CPU engine");
        return WEFT_ERR_UNSUPPORTED;
    }
    if (p->engine == WEFT_ENGINE_CPU &&
        (p->source != WEFT_SOURCE_FLOAT ||
         (p->layout != WEFT_LAYOUT_AUTO && p->layout != WEFT_LAYOUT_PLAIN))) {
        weft_error(p->log, "the CPU engine reads floats in the plain layout, not %s in the %s one",
                   weft_source_format_name(p->source), weft_layout_name(p->layout));
        return WEFT_ERR_UNSUPPORTED;
    }
    const struct weft_source_range range = {p->low, p->high};
    if (!weft_source_format_holds(p->source, &range)) {
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

static enum weft_result find_weights(struct weft_slice_plan *plan,
                                     const struct weft_slice_params *p)
{
    enum { DEFAULT_SAMPLES = 64 };
    const int samples = p->lookup == WEFT_LOOKUP_POLYNOMIAL ? 0
                        : p->samples                        ? p->samples
                                                            : DEFAULT_SAMPLES;
    bool needed[WEFT_LINE_ORDERS] = {true};
    enum weft_result res = WEFT_OK;
    for (int o = 0; o < plan->info.output_count; o++)
        for (int a = 0; a < 3; a++)
            needed[plan->info.output[o].derivative.along[a]] = true;
    for (int n = 0; res == WEFT_OK && n < WEFT_LINE_ORDERS; n++) {
        if (!needed[n])
            continue;
        res = weft_footprint_derive(p->log, plan->footprint, n, &plan->kernels[n]);
        if (res == WEFT_OK)
            res = weft_kernel_facts_weights(p->log, plan->kernels[n], samples,
                                            p->lookup == WEFT_LOOKUP_LINEAR, p->sums,
                                            &plan->weights[n]);
    }
    return res;
}

static void set_axes(struct weft_slice_plan *plan, const struct weft_slice_params *p)
{
    const struct weft_kernel *kernel = &plan->info.kernel;
    const struct weft_slice_grid *grid = &plan->footprint->grid;
    const bool may_sum = !p->clamp_to_samples && !weft_slice_derives(plan);
    weft_slice_axes_set(kernel, grid, !(p->without & WEFT_SAVING_AXIS) && may_sum, &plan->axes);
    // It has a layout, a source and weights of its own.
    if (p->layout == WEFT_LAYOUT_AUTO && plan->info.source == WEFT_SOURCE_FLOAT &&
        p->lookup == WEFT_LOOKUP_POLYNOMIAL && !(p->without & WEFT_SAVING_SEPARABLE))
        weft_slice_axes_separate(kernel, grid, &plan->axes);
    // Blocks hold floats: what is summed before would be rounded twice.
    if (p->sums == WEFT_SUMS_DOUBLE && !plan->axes.separable)
        weft_slice_axes_set(kernel, grid, false, &plan->axes);
}

// Everything but what lies where.
static enum weft_result set_request(struct weft_slice_plan *plan, const struct weft_slice_params *p)
{
    struct weft_slice_plan_info *info = &plan->info;
    enum weft_result res = check_request(p);
    info->source = plan->resident ? plan->resident->info.source : p->source;
    info->lookup = p->lookup;
    plan->range =
        plan->resident ? plan->resident->range : (struct weft_source_range){p->low, p->high};
    plan->clamp_to_samples = p->clamp_to_samples;
    if (res == WEFT_OK)
        res = find_weights(plan, p);
    if (res != WEFT_OK)
        return res;
    info->samples = plan->weights[0]->tiles.segments;
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        if (plan->weights[n])
            info->weight_vectors +=
                (plan->weights[n]->tiles.degree + 1) * plan->weights[n]->tiles.groups;
    set_axes(plan, p);
    info->summed_axis = plan->axes.summed ? plan->axes.order[2] : -1;
    info->summed_taps = plan->axes.kept;
    const bool smooth = !(p->without & WEFT_SAVING_SMOOTH) && !weft_slice_derives(plan);
    res = weft_slice_bound_set(plan, smooth ? p->smooth_error : 0.0);
    if (res != WEFT_OK)
        return res;
    if (plan->axes.separable)
        info->savings |= WEFT_SAVING_SEPARABLE;
    // A constant convolved is that constant only where the weights sum to one.
    else if (info->kernel.unit_sum && !(p->without & WEFT_SAVING_CONSTANT))
        info->savings |= WEFT_SAVING_CONSTANT;
    if (plan->axes.summed)
        info->savings |= WEFT_SAVING_AXIS;
    if (plan->smooth.error > 0.0)
        info->savings |= WEFT_SAVING_SMOOTH;
    info->smooth_error = plan->smooth.error;
    return WEFT_OK;
}

// ---- plans --------------------------------------------------------------------------------------

// Whether every pixel sees the background and nothing else.
static bool sees_background_only(const struct weft_slice_plan *plan, float background)
{
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_tile_plan *tile = &plan->tile_plans[i];
        if (weft_slice_reads_blocks(plan) && !tile->background)
            return false;
        if (plan->axes.separable && (tile->bricks.count || plan->footprint->bricks.has_tiles))
            return false;
        for (size_t c = 0; tile->content && c < tile->cells->map.count; c++)
            if (!tile->content[c].constant ||
                memcmp(&tile->content[c].value, &background, sizeof background) != 0)
                return false;
    }
    return true;
}

static void fill_info(struct weft_slice_plan *plan, const struct weft_volume_info *volume)
{
    struct weft_slice_plan_info *info = &plan->info;
    int width = info->kernel.width;
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

// The footprint is the caller's, if it is of this slice, or made here.
static enum weft_result set_footprint(struct weft_slice_plan *plan, weft_volume *volume,
                                      const struct weft_slice_params *p)
{
    const struct weft_footprint_params *own =
        weft_footprint_params(.volume = p->resident ? weft_resident_volume(p->resident) : volume,
                              .kernel = p->kernel, .space = p->space, .geometry = p->geometry,
                              .memory_bytes = p->memory_bytes, .log = p->log);
    if (!p->footprint && p->resident) {
        const struct weft_footprint_shared shared = weft_resident_shared(p->resident);
        return weft_footprint_create_over(own, &shared, &plan->footprint);
    }
    if (!p->footprint)
        return weft_footprint_create(own, &plan->footprint);
    const struct weft_footprint_info *given = &p->footprint->info;
    weft_require(p->log, p->footprint->volume == volume ||
                             (p->resident && p->footprint->volume == own->volume));
    weft_require(p->log, !p->kernel.info || weft_kernel_same(&p->kernel, &given->kernel));
    weft_require(p->log, memcmp(&p->geometry, &given->geometry, sizeof p->geometry) == 0);
    weft_require(p->log, p->space == given->space);
    plan->footprint = weft_footprint_hold(p->footprint);
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result start_info(struct weft_slice_plan *plan, const struct weft_slice_params *p)
{
    struct weft_slice_plan_info *info = &plan->info;
    const struct weft_footprint_info *reach = &plan->footprint->info;
    info->kernel = reach->kernel;
    info->geometry = reach->geometry;
    info->space = reach->space;
    info->engine = p->engine;
    info->sums = p->sums;
    info->index_geometry = reach->index_geometry;
    info->prefilter_overlap = reach->prefilter_overlap;
    info->output_count = p->derivative_count ? p->derivative_count : 1;
    for (int i = 0; i < p->derivative_count; i++)
        info->output[i].derivative = p->derivative[i];
    const enum weft_result res = weft_rectangle_within(p->log, &p->part, info->geometry.width,
                                                       info->geometry.height, &info->part);
    if (res != WEFT_OK)
        return res;
    if (p->clamp_to_samples && weft_slice_derives(plan)) {
        weft_error(p->log, "values alone are clamped to samples, not slices with derivatives");
        return WEFT_ERR_UNSUPPORTED;
    }
    if (!reach->kernel.prefiltered || !p->clamp_to_samples)
        return WEFT_OK;
    weft_error(p->log, "kernel %si: coefficients are no samples that pixels could be clamped to",
               reach->kernel.info->name);
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_slice_request_create(weft_volume *volume,
                                           const struct weft_slice_params *params,
                                           struct weft_slice_plan **out)
{
    *out = NULL;
    struct weft_slice_plan *plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(params->log, "not enough memory to plan the slice");
        return WEFT_ERR_MEMORY;
    }
    plan->log = params->log;
    plan->resident = params->resident;
    enum weft_result res = check_values(params);
    if (res == WEFT_OK && plan->resident)
        res = check_resident(params);
    if (res == WEFT_OK)
        res = set_footprint(plan, volume, params);
    if (res == WEFT_OK && plan->resident)
        res =
            weft_resident_check(plan->resident, params->log, volume, &plan->footprint->info.kernel);
    if (res == WEFT_OK)
        res = start_info(plan, params);
    if (res == WEFT_OK)
        res = set_request(plan, params);
    if (res == WEFT_OK)
        *out = plan;
    else
        weft_slice_plan_destroy(&plan);
    return res;
}

static int64_t limit_of(int64_t asked, int64_t most)
{
    return asked > 0 && asked < most ? asked : most;
}

enum weft_result weft_slice_plan_create(weft_volume *volume, const struct weft_slice_params *params,
                                        weft_slice_plan **out)
{
    *out = NULL;
    const struct weft_slice_params *p = params;
    struct weft_slice_plan *plan = NULL;
    enum weft_result res = weft_slice_request_create(volume, params, &plan);
    if (res != WEFT_OK)
        return res;
    const struct weft_volume_info *info =
        weft_volume_get_info(weft_footprint_voxels(plan->footprint));
    struct planner planner = {
        .plan = plan,
        .progress = p->progress,
        .memory_bytes = p->memory_bytes ? p->memory_bytes : DEFAULT_MEMORY,
        .max_tile = (int)limit_of(p->max_target_size, MAX_TILE),
        .max_texels = limit_of(p->max_buffer_texels, MAX_TEXELS),
    };
    plan->separable_bytes = planner.memory_bytes / 2;
    if (p->engine == WEFT_ENGINE_CPU && plan->separable_bytes > CPU_BYTES)
        plan->separable_bytes = CPU_BYTES;
    if (!weft_slice_reads_blocks(plan))
        res = weft_footprint_open(plan->footprint);
    if (res == WEFT_OK)
        res = plan_tiles(&planner, p->layout);
    if (res != WEFT_OK)
        goto fail;
    fill_info(plan, info);
    res = weft_slice_text_print(plan, info);
    if (res != WEFT_OK)
        goto fail;
    if (plan->info.misses_volume && weft_slice_is_whole(plan) && !p->may_miss)
        weft_slice_miss_report(p->log, &plan->footprint->grid, &plan->info.geometry,
                               plan->info.space, plan->info.kernel.width, info);
    *out = plan;
    return WEFT_OK;
fail:
    weft_slice_plan_destroy(&plan);
    return res;
}

void weft_slice_plan_destroy(weft_slice_plan **plan)
{
    if (!plan || !*plan)
        return;
    forget_tiles(*plan);
    weft_footprint_release((*plan)->footprint, &(*plan)->cells);
    free((*plan)->tiles);
    free((*plan)->tile_plans);
    weft_footprint_destroy(&(*plan)->footprint);
    free((*plan)->text);
    free(*plan);
    *plan = NULL;
}

const struct weft_slice_plan_info *weft_slice_plan_get_info(const weft_slice_plan *plan)
{
    return &plan->info;
}

weft_footprint *weft_slice_plan_get_footprint(const weft_slice_plan *plan)
{
    return plan->footprint;
}
