// SPDX-License-Identifier: BSD-3-Clause
#include "passes/slice/multipass.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "filter/statistics.h"
#include "passes/fused/plan.h"

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
enum {
    MIN_SIDE = 4, // a rectangle is cut no smaller
    // Along a side of a box. Positions of up to 13 whole and 40 fraction bits are exact in double.
    MAX_BOX_SIDE = 2048,
    // The box of an oblique rectangle grows with the cube of its side, and most of it is out of
    // reach: larger ones cost more than setting up the passes once more (measured, 2^17 to 2^23).
    COMFORTABLE_VOXELS = 1 << 21,
    MEASURED_CELLS = 1024, // whose bricks are read together
    BRICK_BYTES = WEFT_BRICK_VOXELS * 4,
    MAX_SPAN = WEFT_BRICK_SIZE + WEFT_KERNEL_MAX_WIDTH - 1,
};

struct rectangle {
    int x, y, width, height; // within one block of the grid
};

// What a rectangle's pixels reach: cells, the box of all their taps, and the bricks that hold them.
struct reach {
    struct weft_cell_map map;
    struct weft_slice_cell *cells; // by number
    size_t capacity;
    struct weft_cell_map bricks;
    int32_t min[3];
    int size[3];
};

struct runner {
    const struct weft_slice_multipass_params *p;
    const struct weft_slice_plan *slice;
    const struct weft_pass_plan_info *plan;
    weft_multipass *compiled;
    weft_brick_store *topology;
    uint64_t memory_bytes;
    float *values; // of bricks
    size_t value_bricks;
    float *box;
    size_t box_voxels;
    uint64_t pixels_done;
    int current_pixels; // of the rectangle that runs
    struct weft_statistics voxels;
    struct weft_slice_multipass_report report;
};

static bool go_on(const struct runner *r, double fraction)
{
    const struct weft_progress *progress = r->p->progress;
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

static bool report_rectangle(void *priv, double fraction)
{
    const struct runner *r = priv;
    const struct weft_slice_geometry *g = &r->slice->grid.index;
    return go_on(r, ((double)r->pixels_done + fraction * r->current_pixels) /
                        ((double)g->width * g->height));
}

static enum weft_result out_of_memory(const struct runner *r, size_t bytes, const char *what)
{
    weft_error(r->p->log, "not enough memory: %zu bytes for %s", bytes, what);
    return WEFT_ERR_MEMORY;
}

// ---- what is in reach ---------------------------------------------------------------------------

static void reach_destroy(struct reach *reach)
{
    weft_cell_map_destroy(&reach->map);
    weft_cell_map_destroy(&reach->bricks);
    free(reach->cells);
    *reach = (struct reach){0};
}

static bool collect_span(void *priv, const struct weft_span *run)
{
    struct reach *reach = priv;
    size_t known = reach->map.count;
    int64_t number = weft_cell_map_add(&reach->map, run->cell);
    if (number == WEFT_CELL_NONE)
        return false;
    if ((size_t)number >= reach->capacity) {
        size_t capacity = reach->capacity ? 2 * reach->capacity : 256;
        void *cells = realloc(reach->cells, capacity * sizeof *reach->cells);
        if (!cells)
            return false;
        reach->cells = cells;
        reach->capacity = capacity;
    }
    struct weft_slice_cell *cell = &reach->cells[number];
    if ((size_t)number == known)
        *cell = (struct weft_slice_cell){.low = {7, 7, 7}};
    for (int a = 0; a < 3; a++) {
        cell->low[a] = run->low[a] < cell->low[a] ? run->low[a] : cell->low[a];
        cell->high[a] = run->high[a] > cell->high[a] ? run->high[a] : cell->high[a];
    }
    return true;
}

// Notes the bricks that hold a box of voxels, those of the clamp box where the volume has one.
static bool note_bricks(const struct runner *r, const int32_t min[3], const int32_t max[3],
                        struct weft_cell_map *bricks)
{
    const struct weft_volume_info *v = weft_volume_get_info(r->p->volume);
    struct weft_cell_key from, to, at;
    for (int a = 0; a < 3; a++) {
        int32_t low = v->clamp_to_edge ? v->active_min[a] : min[a];
        int32_t high = v->clamp_to_edge ? v->active_max[a] : max[a];
        from.at[a] = (min[a] < low ? low : min[a] > high ? high : min[a]) >> 3;
        to.at[a] = (max[a] < low ? low : max[a] > high ? high : max[a]) >> 3;
    }
    for (at.at[2] = from.at[2]; at.at[2] <= to.at[2]; at.at[2]++) {
        for (at.at[1] = from.at[1]; at.at[1] <= to.at[1]; at.at[1]++) {
            for (at.at[0] = from.at[0]; at.at[0] <= to.at[0]; at.at[0]++) {
                const int32_t origin[3] = {at.at[0] * 8, at.at[1] * 8, at.at[2] * 8};
                const float *values;
                float constant;
                if (weft_brick_store_find(r->topology, origin, &values, &constant) ==
                        WEFT_BRICK_VALUES &&
                    weft_cell_map_add(bricks, at) == WEFT_CELL_NONE)
                    return false;
            }
        }
    }
    return true;
}

static bool note_cells(const struct runner *r, const struct reach *reach, size_t from, size_t to,
                       struct weft_cell_map *bricks)
{
    for (size_t i = from; i < to; i++) {
        int32_t min[3], max[3];
        weft_slice_cell_reach(r->slice, reach->map.keys[i], &reach->cells[i], min, max);
        if (!note_bricks(r, min, max, bricks))
            return false;
    }
    return true;
}

static void set_box(const struct runner *r, struct reach *reach)
{
    int32_t last[3];
    for (size_t i = 0; i < reach->map.count; i++) {
        int32_t min[3], max[3];
        weft_slice_cell_reach(r->slice, reach->map.keys[i], &reach->cells[i], min, max);
        for (int a = 0; a < 3; a++) {
            reach->min[a] = i && reach->min[a] < min[a] ? reach->min[a] : min[a];
            last[a] = i && last[a] > max[a] ? last[a] : max[a];
            reach->size[a] = last[a] - reach->min[a] + 1;
        }
    }
}

static enum weft_result find_cells(const struct runner *r, const struct rectangle *at,
                                   struct reach *out)
{
    *out = (struct reach){0};
    if (weft_slice_grid_walk(&r->slice->grid, at->x, at->y, at->width, at->height, collect_span,
                             out))
        return WEFT_OK;
    const size_t bytes = 2 * (out->capacity + 1) * (sizeof *out->cells + sizeof *out->map.keys);
    reach_destroy(out);
    return out_of_memory(r, bytes, "the cells of a rectangle");
}

// A store of these bricks, whose values stay in r->values.
static enum weft_result load_bricks(struct runner *r, const struct weft_cell_map *bricks,
                                    weft_brick_store **out)
{
    *out = NULL;
    if (bricks->count > r->value_bricks || !r->values) {
        const size_t bytes = (bricks->count + 1) * BRICK_BYTES; // malloc(0) may be NULL
        free(r->values);
        r->value_bricks = bricks->count;
        r->values = malloc(bytes);
        if (!r->values)
            return out_of_memory(r, bytes, "the voxels of bricks");
    }
    double start = weft_now_seconds();
    enum weft_result res = weft_slice_read_bricks(r->slice, r->p->volume, bricks, r->values);
    r->report.read_seconds += weft_now_seconds() - start;
    r->report.bricks_read += bricks->count;
    if (res != WEFT_OK)
        return res;
    return weft_slice_store_create(r->p->log, weft_volume_get_info(r->p->volume),
                                   &r->slice->topology, bricks, r->values, out);
}

// ---- the range of the voxels --------------------------------------------------------------------

static void measure_cell(struct runner *r, const weft_brick_store *store, const int32_t min[3],
                         const int32_t max[3])
{
    float voxels[MAX_SPAN * MAX_SPAN * MAX_SPAN];
    if (weft_brick_store_box_constant(store, min, max, voxels)) {
        weft_statistics_add(&r->voxels, voxels, 1);
        return;
    }
    const int size[3] = {max[0] - min[0] + 1, max[1] - min[1] + 1, max[2] - min[2] + 1};
    weft_brick_store_copy_box(store, min, size, size, voxels);
    weft_statistics_add(&r->voxels, voxels, (size_t)size[0] * (size_t)size[1] * (size_t)size[2]);
}

static enum weft_result measure_cells(struct runner *r, const struct reach *reach, size_t from,
                                      size_t to)
{
    struct weft_cell_map bricks = {0};
    weft_brick_store *store = NULL;
    enum weft_result res =
        note_cells(r, reach, from, to, &bricks)
            ? load_bricks(r, &bricks, &store)
            : out_of_memory(r, (bricks.count + 1) * sizeof *bricks.keys, "a list of bricks");
    for (size_t i = from; res == WEFT_OK && i < to; i++) {
        int32_t min[3], max[3];
        weft_slice_cell_reach(r->slice, reach->map.keys[i], &reach->cells[i], min, max);
        measure_cell(r, store, min, max);
    }
    weft_brick_store_destroy(&store);
    weft_cell_map_destroy(&bricks);
    return res;
}

// Of whole blocks: what their cells reach does not depend on how the slice is cut.
static enum weft_result measure_block(struct runner *r, const struct rectangle *block)
{
    struct reach reach;
    enum weft_result res = find_cells(r, block, &reach);
    if (res != WEFT_OK)
        return res;
    for (size_t i = 0; res == WEFT_OK && i < reach.map.count; i += MEASURED_CELLS) {
        const size_t left = reach.map.count - i;
        const size_t end = i + (left < MEASURED_CELLS ? left : MEASURED_CELLS);
        res = go_on(r, 0.0) ? measure_cells(r, &reach, i, end) : WEFT_ERR_CANCELLED;
    }
    reach_destroy(&reach);
    return res;
}

// ---- rectangles ---------------------------------------------------------------------------------

static size_t count_voxels(const struct reach *reach)
{
    return (size_t)reach->size[0] * (size_t)reach->size[1] * (size_t)reach->size[2];
}

// What is held while a rectangle runs, staging copies included.
static uint64_t rectangle_bytes(const struct runner *r, const struct rectangle *at,
                                const struct reach *reach)
{
    const uint64_t sample = r->plan->passes->dot4 ? 16 : 4;
    const uint64_t pixel = 2 * sizeof(float) + 3 * sizeof(uint32_t); // value and position
    return reach->bricks.count * BRICK_BYTES + count_voxels(reach) * (sizeof(float) + 2 * sample) +
           (uint64_t)at->width * (uint64_t)at->height *
               (2 * pixel + r->plan->target_bytes_per_pixel) +
           2 * r->plan->tile_bytes;
}

// The voxels in reach, in a box; what is not in reach there is some value in range.
static enum weft_result fill_box(struct runner *r, const weft_brick_store *store,
                                 const struct reach *reach)
{
    const size_t count = count_voxels(reach);
    if (count > r->box_voxels) {
        free(r->box);
        r->box_voxels = count;
        r->box = malloc(count * sizeof *r->box);
        if (!r->box)
            return out_of_memory(r, count * sizeof *r->box, "the voxels of a rectangle");
    }
    const float unused = (float)(0.5 * r->report.low + 0.5 * r->report.high);
    for (size_t i = 0; i < count; i++)
        r->box[i] = unused;
    for (size_t i = 0; i < reach->map.count; i++) {
        int32_t min[3], max[3];
        int size[3];
        size_t at[3];
        weft_slice_cell_reach(r->slice, reach->map.keys[i], &reach->cells[i], min, max);
        for (int a = 0; a < 3; a++) {
            size[a] = max[a] - min[a] + 1;
            at[a] = (size_t)(min[a] - reach->min[a]);
        }
        weft_brick_store_copy_box(
            store, min, size, reach->size,
            r->box + (at[2] * (size_t)reach->size[1] + at[1]) * (size_t)reach->size[0] + at[0]);
    }
    return WEFT_OK;
}

// The block's fixed-point positions in the box's coordinates, before they are rounded: in double
// they are exact, and so are their sums with multiples of the steps that stay in the box.
static void set_grid(const struct runner *r, const struct rectangle *at, const struct reach *reach,
                     struct weft_pixel_grid *out)
{
    const struct weft_slice_grid *grid = &r->slice->grid;
    const int bx = at->x / WEFT_GRID_BLOCK, by = at->y / WEFT_GRID_BLOCK;
    const int low_bits = grid->fraction_bits - WEFT_GRID_WORD_FRACTION_BITS;
    struct weft_slice_block block;
    weft_slice_grid_block(grid, bx, by, &block);
    *out = (struct weft_pixel_grid){
        .width = at->width, .height = at->height, .fraction_bits = WEFT_GRID_WORD_FRACTION_BITS};
    for (int a = 0; a < 3; a++) {
        const int64_t position = block.position[a] - (INT64_C(1) << low_bits) / 2 +
                                 (at->x - bx * WEFT_GRID_BLOCK) * grid->du[a] +
                                 (at->y - by * WEFT_GRID_BLOCK) * grid->dv[a];
        const int64_t whole = position >> grid->fraction_bits;
        const int64_t fraction = position - whole * (INT64_C(1) << grid->fraction_bits);
        out->origin[a] = (double)(block.base[a] + whole - reach->min[a]) +
                         (ldexp((double)fraction, -grid->fraction_bits) - grid->tap_shift);
        out->du[a] = ldexp((double)grid->du[a], -grid->fraction_bits);
        out->dv[a] = ldexp((double)grid->dv[a], -grid->fraction_bits);
    }
}

static void add_report(struct runner *r, const struct weft_multipass_report *one,
                       uint64_t other_bytes)
{
    struct weft_slice_multipass_report *sum = &r->report;
    const uint64_t bytes =
        other_bytes + one->source_bytes + one->tile_bytes + one->target_bytes + one->position_bytes;
    sum->clamped += one->clamped;
    sum->rectangles++;
    sum->passes += r->plan->passes->pass_count;
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->peak_bytes = bytes > sum->peak_bytes ? bytes : sum->peak_bytes;
    sum->prepare_seconds += one->prepare_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->clamps += one->clamps;
    sum->largest_clamp = fmax(sum->largest_clamp, one->largest_clamp);
}

static enum weft_result convolve(struct runner *r, const struct rectangle *at,
                                 const struct reach *reach)
{
    const size_t width = (size_t)r->slice->grid.index.width;
    const struct weft_samples samples = {
        .size = {reach->size[0], reach->size[1], reach->size[2]},
        .plane = {r->box},
        .low = r->report.low,
        .high = r->report.high,
    };
    const struct weft_progress progress = {report_rectangle, r};
    struct weft_pixel_grid grid;
    set_grid(r, at, reach, &grid);
    const struct weft_multipass_run_params params = {
        .samples = &samples,
        .grid = &grid,
        .pixels = {r->p->pixels + (size_t)at->y * width + at->x},
        .stride = (int64_t)width,
        .progress = &progress,
        .log = r->p->log,
    };
    struct weft_multipass_report report = {0};
    r->current_pixels = at->width * at->height;
    const enum weft_result res = weft_multipass_run(r->compiled, &params, &report);
    if (res == WEFT_OK)
        add_report(r, &report,
                   reach->bricks.count * BRICK_BYTES + count_voxels(reach) * sizeof *r->box);
    return res;
}

static enum weft_result run_rectangle(struct runner *r, const struct rectangle *at,
                                      const struct reach *reach)
{
    weft_brick_store *store = NULL;
    enum weft_result res = load_bricks(r, &reach->bricks, &store);
    double start = weft_now_seconds();
    if (res == WEFT_OK)
        res = fill_box(r, store, reach);
    r->report.layout_seconds += weft_now_seconds() - start;
    weft_brick_store_destroy(&store);
    if (res == WEFT_OK)
        res = convolve(r, at, reach);
    if (res == WEFT_OK)
        r->pixels_done += (uint64_t)at->width * (uint64_t)at->height;
    return res;
}

static enum weft_result refuse(const struct runner *r, const struct rectangle *at,
                               const struct reach *reach, uint64_t bytes)
{
    weft_error(r->p->log,
               "%d x %d pixels of the slice reach a box of %d x %d x %d voxels, which needs "
               "%" PRIu64 " bytes; the limits are %d voxels along a side and %" PRIu64 " bytes",
               at->width, at->height, reach->size[0], reach->size[1], reach->size[2], bytes,
               MAX_BOX_SIDE, r->memory_bytes);
    return WEFT_ERR_LIMIT;
}

static enum weft_result cut_rectangle(struct runner *r, const struct rectangle *whole);

static enum weft_result run_halves(struct runner *r, const struct rectangle *whole)
{
    struct rectangle first = *whole, second = *whole;
    if (whole->width >= whole->height) {
        first.width /= 2;
        second.x += first.width;
        second.width -= first.width;
    } else {
        first.height /= 2;
        second.y += first.height;
        second.height -= first.height;
    }
    enum weft_result res = cut_rectangle(r, &first);
    return res == WEFT_OK ? cut_rectangle(r, &second) : res;
}

// Runs a rectangle, in as many pieces as the size of its box asks for.
static enum weft_result cut_rectangle(struct runner *r, const struct rectangle *whole)
{
    struct reach reach;
    enum weft_result res = find_cells(r, whole, &reach);
    if (res != WEFT_OK)
        return res;
    set_box(r, &reach);
    const int longer = whole->width > whole->height ? whole->width : whole->height;
    const bool can_be_cut = longer / 2 >= MIN_SIDE;
    bool fits = reach.size[0] <= MAX_BOX_SIDE && reach.size[1] <= MAX_BOX_SIDE &&
                reach.size[2] <= MAX_BOX_SIDE;
    if (fits && can_be_cut)
        fits = count_voxels(&reach) <= COMFORTABLE_VOXELS;
    if (fits && !note_cells(r, &reach, 0, reach.map.count, &reach.bricks))
        res = out_of_memory(r, (reach.bricks.count + 1) * sizeof *reach.bricks.keys,
                            "a list of bricks");
    const uint64_t bytes = rectangle_bytes(r, whole, &reach);
    const bool runs = fits && bytes <= r->memory_bytes;
    if (res == WEFT_OK && runs)
        res = run_rectangle(r, whole, &reach);
    else if (res == WEFT_OK && !can_be_cut)
        res = refuse(r, whole, &reach, bytes);
    reach_destroy(&reach);
    return res == WEFT_OK && !runs ? run_halves(r, whole) : res;
}

// ---- runs ---------------------------------------------------------------------------------------

static enum weft_result each_block(struct runner *r,
                                   enum weft_result (*run)(struct runner *r,
                                                           const struct rectangle *block))
{
    const struct weft_slice_geometry *g = &r->slice->grid.index;
    enum weft_result res = WEFT_OK;
    for (int y = 0; res == WEFT_OK && y < g->height; y += WEFT_GRID_BLOCK) {
        for (int x = 0; res == WEFT_OK && x < g->width; x += WEFT_GRID_BLOCK) {
            const struct rectangle block = {
                .x = x,
                .y = y,
                .width = g->width - x < WEFT_GRID_BLOCK ? g->width - x : WEFT_GRID_BLOCK,
                .height = g->height - y < WEFT_GRID_BLOCK ? g->height - y : WEFT_GRID_BLOCK,
            };
            res = run(r, &block);
        }
    }
    return res;
}

static enum weft_result find_range(struct runner *r)
{
    r->report.low = r->p->low;
    r->report.high = r->p->high;
    if (!weft_range_is_open(r->p->low, r->p->low, r->p->high))
        return WEFT_OK;
    double start = weft_now_seconds();
    r->voxels = (struct weft_statistics)WEFT_STATISTICS_NONE;
    enum weft_result res = each_block(r, measure_block);
    const bool none = isnan(r->voxels.minimum);
    r->report.low = none ? 0.0 : r->voxels.minimum;
    r->report.high = none ? 0.0 : r->voxels.maximum;
    r->report.measure_seconds = weft_now_seconds() - start;
    r->report.read_seconds = 0.0;
    return res;
}

static enum weft_result compile(struct runner *r, weft_context *context)
{
    const struct weft_multipass_params params = {.plan = r->p->plan, .log = r->p->log};
    const enum weft_result res = weft_multipass_compile(context, &params, &r->compiled);
    if (res != WEFT_OK)
        return res;
    const struct weft_multipass_info *info = weft_multipass_get_info(r->compiled);
    r->report.prepare_seconds = info->seconds;
    r->report.uploaded_bytes = context ? info->tile_bytes : 0;
    return WEFT_OK;
}

static bool same_kernel(const struct weft_kernel *a, const struct weft_kernel *b)
{
    bool same = a->info == b->info && a->normalised == b->normalised && a->radial == b->radial &&
                a->prefiltered == b->prefiltered;
    for (int i = 0; i < WEFT_KERNEL_PARAMS; i++)
        same = same && (!a->info->params[i].name || a->param[i] == b->param[i]);
    return same;
}

static enum weft_result check_params(const struct weft_slice_multipass_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->slice && p->plan && p->volume && p->pixels);
    const struct weft_pass_plan_info *plan = weft_pass_plan_get_info(p->plan);
    weft_require(p->log, plan->dims == 3 && plan->channels == 1);
    weft_require(p->log, same_kernel(&plan->kernel, &p->slice->info.kernel));
    if (!(isnan(p->low) && isnan(p->high)) && !(p->low == 0.0 && p->high == 0.0) &&
        !(isfinite(p->low) && isfinite(p->high) && p->low < p->high)) {
        weft_error(p->log, "a source range from %g to %g: it must be finite, and the first less",
                   p->low, p->high);
        goto fail;
    }
    res = WEFT_OK;
fail:
    return res;
}

static void measure_pixels(struct runner *r)
{
    const struct weft_slice_geometry *g = &r->slice->grid.index;
    const size_t count = (size_t)g->width * (size_t)g->height;
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    weft_statistics_add(&s, r->p->pixels, count);
    r->report.minimum = (float)s.minimum;
    r->report.maximum = (float)s.maximum;
    r->report.not_finite = s.not_finite;
}

enum weft_result weft_slice_multipass_run(weft_context *context,
                                          const struct weft_slice_multipass_params *params,
                                          struct weft_slice_multipass_report *report)
{
    enum weft_result res = check_params(params);
    if (res != WEFT_OK)
        return res;
    struct weft_slice_multipass_params p = *params;
    p.volume = weft_slice_voxels(p.slice, p.volume);
    struct runner r = {
        .p = &p,
        .slice = params->slice,
        .plan = weft_pass_plan_get_info(params->plan),
        .memory_bytes = params->memory_bytes ? params->memory_bytes : DEFAULT_MEMORY,
    };
    res = weft_slice_store_create(params->log, weft_volume_get_info(p.volume), &r.slice->topology,
                                  NULL, NULL, &r.topology);
    if (res == WEFT_OK)
        res = compile(&r, context);
    if (res == WEFT_OK)
        res = find_range(&r);
    if (res == WEFT_OK)
        res = each_block(&r, cut_rectangle);
    weft_brick_store_destroy(&r.topology);
    weft_multipass_destroy(&r.compiled);
    free(r.values);
    free(r.box);
    if (res != WEFT_OK)
        return res;
    go_on(&r, 1.0);
    if (!weft_range_is_open(params->low, params->low, params->high) && r.report.clamped)
        weft_warn(params->log,
                  "%" PRIu64 " voxels in reach are outside the source range from %g to %g, or not "
                  "finite: the error is bounded only where they are not",
                  r.report.clamped, params->low, params->high);
    measure_pixels(&r);
    if (report)
        *report = r.report;
    return WEFT_OK;
}

struct weft_bound_terms weft_slice_multipass_bound_terms(const weft_slice_plan *slice,
                                                         const weft_pass_plan *plan)
{
    const struct weft_bound_terms *grid = &slice->info.bound;
    struct weft_bound_terms terms = weft_pass_plan_get_info(plan)->bound;
    terms.relative = weft_slice_position_bound(slice);
    terms.sample_rounding = grid->sample_rounding;
    terms.absolute_rounding = grid->absolute_rounding;
    return terms;
}

struct weft_slice_report
weft_slice_multipass_summary(const struct weft_slice_multipass_report *report)
{
    return (struct weft_slice_report){
        .read_seconds = report->read_seconds + report->measure_seconds,
        .layout_seconds = report->layout_seconds + report->prepare_seconds,
        .upload_seconds = report->upload_seconds,
        .pass_seconds = report->pass_seconds,
        .readback_seconds = report->readback_seconds,
        .uploaded_bytes = report->uploaded_bytes,
        .peak_bytes = report->peak_bytes,
        .passes = report->passes,
        .minimum = report->minimum,
        .maximum = report->maximum,
        .not_finite = report->not_finite,
    };
}
