// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "passes/multipass/multipass.h"
#include "passes/slice/multipass.h"
#include "passes/slice/slice_impl.h"

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
enum {
    MIN_SIDE = 4, // a rectangle is cut no smaller
    // Along a side of a box. Positions of up to 13 whole and 40 fraction bits are exact in double.
    MAX_BOX_SIDE = 2048,
    // The box of an oblique rectangle grows with the cube of its side, and most of it is out of
    // reach: larger ones cost more than setting up the passes once more (measured, 2^17 to 2^23).
    COMFORTABLE_VOXELS = 1 << 21,
    BRICK_BYTES = WEFT_BRICK_VOXELS * 4,
};

// What a rectangle's pixels reach: cells, the box of all their taps, and the bricks that hold them.
struct reach {
    const struct weft_slice_cells *cells; // the footprint's; NULL: not found
    struct weft_cell_map bricks;
    int32_t min[3];
    int size[3];
};

// What a slice is cut into: run at once, with the box of what it reaches.
struct piece {
    struct weft_rectangle at;
    struct reach reach;
};

struct weft_slice_multipass {
    struct weft_slice_passes p;
    const struct weft_pass_plan_info *plan;
    weft_footprint *footprint;
    weft_multipass *compiled;
    uint64_t memory_bytes;
    struct piece *pieces;
    size_t piece_count, piece_capacity;
    float *box; // grows to the largest piece's
    size_t box_voxels;
    // Of a run.
    const struct weft_slice_run_params *run;
    uint64_t pixels_done;
    int current_pixels; // of the rectangle that runs
    struct weft_slice_report report;
};

static bool go_on(const struct weft_slice_multipass *r, double fraction)
{
    const struct weft_progress *progress = r->run->progress;
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

static bool report_rectangle(void *priv, double fraction)
{
    const struct weft_slice_multipass *r = priv;
    const struct weft_slice_geometry *g = &r->footprint->grid.index;
    return go_on(r, ((double)r->pixels_done + fraction * r->current_pixels) /
                        ((double)g->width * g->height));
}

// While the voxels are measured nothing is done yet.
static bool report_begun(void *priv, double fraction)
{
    (void)fraction;
    return go_on(priv, 0.0);
}

static enum weft_result out_of_memory(const struct weft_slice_multipass *r, size_t bytes,
                                      const char *what)
{
    weft_error(r->p.log, "not enough memory: %zu bytes for %s", bytes, what);
    return WEFT_ERR_MEMORY;
}

// ---- what is in reach ---------------------------------------------------------------------------

static void reach_destroy(const struct weft_slice_multipass *r, struct reach *reach)
{
    weft_footprint_release(r->footprint, &reach->cells);
    weft_cell_map_destroy(&reach->bricks);
    *reach = (struct reach){.cells = NULL};
}

static void set_box(const weft_footprint *footprint, const struct weft_rectangle *at,
                    struct reach *reach)
{
    int32_t max[3];
    weft_footprint_box(footprint, at, reach->min, max);
    for (int a = 0; a < 3; a++)
        reach->size[a] = max[a] - reach->min[a] + 1;
}

static enum weft_result find_bricks(const struct weft_slice_multipass *r,
                                    const struct weft_rectangle *at, struct reach *reach)
{
    enum weft_result res = weft_footprint_cells(r->footprint, at, NULL, 0.0, &reach->cells);
    for (size_t i = 0; res == WEFT_OK && i < reach->cells->map.count; i++) {
        int32_t min[3], max[3];
        weft_footprint_cell_box(r->footprint, reach->cells, i, min, max);
        if (!weft_brick_reader_note(&r->footprint->bricks, min, max, &reach->bricks))
            res = out_of_memory(r, (reach->bricks.count + 1) * sizeof *reach->bricks.keys,
                                "a list of bricks");
    }
    return res;
}

static size_t count_voxels(const struct reach *reach)
{
    return (size_t)reach->size[0] * (size_t)reach->size[1] * (size_t)reach->size[2];
}

// ---- how rectangles are cut ---------------------------------------------------------------------

static struct weft_rectangle block_at(const struct weft_slice_geometry *g, int x, int y)
{
    return (struct weft_rectangle){
        .x = x,
        .y = y,
        .width = g->width - x < WEFT_GRID_BLOCK ? g->width - x : WEFT_GRID_BLOCK,
        .height = g->height - y < WEFT_GRID_BLOCK ? g->height - y : WEFT_GRID_BLOCK,
    };
}

static bool can_be_cut(const struct weft_rectangle *whole)
{
    const int longer = whole->width > whole->height ? whole->width : whole->height;
    return longer / 2 >= MIN_SIDE;
}

static void cut_in_half(const struct weft_rectangle *whole, struct weft_rectangle half[2])
{
    half[0] = half[1] = *whole;
    if (whole->width >= whole->height) {
        half[0].width /= 2;
        half[1].x += half[0].width;
        half[1].width -= half[0].width;
    } else {
        half[0].height /= 2;
        half[1].y += half[0].height;
        half[1].height -= half[0].height;
    }
}

// Whether a rectangle's box is one to lay out, whatever its bytes.
static bool is_fit(const struct weft_rectangle *at, const struct reach *reach)
{
    for (int a = 0; a < 3; a++)
        if (reach->size[a] > MAX_BOX_SIDE)
            return false;
    return !can_be_cut(at) || count_voxels(reach) <= COMFORTABLE_VOXELS;
}

static double count_samples(const weft_footprint *footprint, const struct weft_rectangle *whole)
{
    struct reach reach = {.cells = NULL};
    struct weft_rectangle half[2];
    set_box(footprint, whole, &reach);
    if (is_fit(whole, &reach) || !can_be_cut(whole))
        return (double)count_voxels(&reach);
    cut_in_half(whole, half);
    return count_samples(footprint, &half[0]) + count_samples(footprint, &half[1]);
}

double weft_slice_multipass_samples(const weft_footprint *footprint)
{
    const struct weft_slice_geometry *g = &footprint->grid.index;
    double samples = 0.0;
    for (int y = 0; y < g->height; y += WEFT_GRID_BLOCK) {
        for (int x = 0; x < g->width; x += WEFT_GRID_BLOCK) {
            const struct weft_rectangle block = block_at(g, x, y);
            samples += count_samples(footprint, &block);
        }
    }
    return samples;
}

// ---- rectangles ---------------------------------------------------------------------------------

// What is held while a rectangle runs, staging copies included.
static uint64_t rectangle_bytes(const struct weft_slice_multipass *r,
                                const struct weft_rectangle *at, const struct reach *reach)
{
    const uint64_t sample = r->plan->passes->dot4 ? 16 : 4;
    const uint64_t pixel = 2 * sizeof(float) + 3 * sizeof(uint32_t); // value and position
    return reach->bricks.count * BRICK_BYTES + count_voxels(reach) * (sizeof(float) + 2 * sample) +
           (uint64_t)at->width * (uint64_t)at->height *
               (2 * pixel + r->plan->target_bytes_per_pixel) +
           2 * r->plan->tile_bytes;
}

static enum weft_result refuse(const struct weft_slice_multipass *r,
                               const struct weft_rectangle *at, const struct reach *reach,
                               uint64_t bytes)
{
    weft_error(r->p.log,
               "%d x %d pixels of the slice reach a box of %d x %d x %d voxels, which needs "
               "%" PRIu64 " bytes; the limits are %d voxels along a side and %" PRIu64 " bytes",
               at->width, at->height, reach->size[0], reach->size[1], reach->size[2], bytes,
               MAX_BOX_SIDE, r->memory_bytes);
    return WEFT_ERR_LIMIT;
}

// The piece has the reach from then on.
static enum weft_result append_piece(struct weft_slice_multipass *r,
                                     const struct weft_rectangle *at, const struct reach *reach)
{
    if (r->piece_count == r->piece_capacity) {
        const size_t capacity = r->piece_capacity ? 2 * r->piece_capacity : 16;
        void *pieces = realloc(r->pieces, capacity * sizeof *r->pieces);
        if (!pieces)
            return out_of_memory(r, capacity * sizeof *r->pieces, "the rectangles of a slice");
        r->pieces = pieces;
        r->piece_capacity = capacity;
    }
    r->pieces[r->piece_count++] = (struct piece){*at, *reach};
    return WEFT_OK;
}

static enum weft_result cut_rectangle(struct weft_slice_multipass *r,
                                      const struct weft_rectangle *whole);

static enum weft_result cut_halves(struct weft_slice_multipass *r,
                                   const struct weft_rectangle *whole)
{
    struct weft_rectangle half[2];
    cut_in_half(whole, half);
    enum weft_result res = cut_rectangle(r, &half[0]);
    return res == WEFT_OK ? cut_rectangle(r, &half[1]) : res;
}

// Cuts a rectangle into as many pieces as the size of its box asks for.
static enum weft_result cut_rectangle(struct weft_slice_multipass *r,
                                      const struct weft_rectangle *whole)
{
    struct reach reach = {.cells = NULL};
    enum weft_result res = WEFT_OK;
    set_box(r->footprint, whole, &reach);
    const bool fits = is_fit(whole, &reach);
    if (fits)
        res = find_bricks(r, whole, &reach);
    const uint64_t bytes = rectangle_bytes(r, whole, &reach);
    const bool whole_runs = fits && bytes <= r->memory_bytes;
    if (res == WEFT_OK && whole_runs)
        res = append_piece(r, whole, &reach);
    else if (res == WEFT_OK && !can_be_cut(whole))
        res = refuse(r, whole, &reach, bytes);
    if (res != WEFT_OK || !whole_runs)
        reach_destroy(r, &reach);
    return res == WEFT_OK && !whole_runs ? cut_halves(r, whole) : res;
}

// No voxel is read and nothing made.
static enum weft_result cut_slice(struct weft_slice_multipass *r)
{
    const struct weft_slice_geometry *g = &r->footprint->grid.index;
    enum weft_result res = WEFT_OK;
    for (int y = 0; res == WEFT_OK && y < g->height; y += WEFT_GRID_BLOCK) {
        for (int x = 0; res == WEFT_OK && x < g->width; x += WEFT_GRID_BLOCK) {
            const struct weft_rectangle block = block_at(g, x, y);
            res = cut_rectangle(r, &block);
        }
    }
    return res;
}

// ---- one piece ----------------------------------------------------------------------------------

// Whether the range is known to hold all voxels in reach: then what it does not is not in reach.
static bool range_holds(const struct weft_slice_multipass *r)
{
    const weft_footprint *f = r->footprint;
    return f->measured && f->statistics.not_finite == 0 && r->report.low <= f->statistics.low &&
           r->report.high >= f->statistics.high;
}

// The voxels in reach, in a box; what is not in reach there is some value in range.
static enum weft_result fill_box(struct weft_slice_multipass *r, const weft_brick_store *store,
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
    for (size_t i = 0; i < reach->cells->map.count; i++) {
        int32_t min[3], max[3];
        int size[3];
        size_t at[3];
        weft_footprint_cell_box(r->footprint, reach->cells, i, min, max);
        for (int a = 0; a < 3; a++) {
            size[a] = max[a] - min[a] + 1;
            at[a] = (size_t)(min[a] - reach->min[a]);
        }
        weft_brick_store_copy_box(
            store, min, size, reach->size,
            r->box + (at[2] * (size_t)reach->size[1] + at[1]) * (size_t)reach->size[0] + at[0]);
    }
    const bool holds = range_holds(r);
    for (size_t i = 0; holds && i < count; i++)
        if (!(r->box[i] >= r->report.low && r->box[i] <= r->report.high))
            r->box[i] = unused;
    return WEFT_OK;
}

// The block's fixed-point positions in the box's coordinates, before they are rounded: in double
// they are exact, and so are their sums with multiples of the steps that stay in the box.
static void set_grid(const struct weft_slice_multipass *r, const struct weft_rectangle *at,
                     const struct reach *reach, struct weft_pixel_grid *out)
{
    const struct weft_slice_grid *grid = &r->footprint->grid;
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

static void add_report(struct weft_slice_multipass *r, const struct weft_multipass_report *one,
                       uint64_t other_bytes)
{
    struct weft_slice_report *sum = &r->report;
    const uint64_t bytes =
        other_bytes + one->source_bytes + one->tile_bytes + one->target_bytes + one->position_bytes;
    sum->clamped += one->clamped;
    sum->rectangles++;
    sum->passes += r->plan->passes->pass_count;
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->peak_bytes = bytes > sum->peak_bytes ? bytes : sum->peak_bytes;
    sum->layout_seconds += one->prepare_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->clamps += one->clamps;
    sum->largest_clamp = fmax(sum->largest_clamp, one->largest_clamp);
}

static enum weft_result convolve(struct weft_slice_multipass *r, const struct weft_rectangle *at,
                                 const struct reach *reach)
{
    const int64_t stride = r->run->stride;
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
        .pixels = {r->run->pixels + at->y * stride + at->x},
        .stride = stride,
        .progress = &progress,
        .log = r->p.log,
    };
    struct weft_multipass_report report = {0};
    r->current_pixels = at->width * at->height;
    const enum weft_result res = weft_multipass_run(r->compiled, &params, &report);
    if (res == WEFT_OK)
        add_report(r, &report,
                   r->footprint->info.kept_bytes + count_voxels(reach) * sizeof *r->box);
    return res;
}

static enum weft_result run_piece(struct weft_slice_multipass *r, const struct piece *piece)
{
    const struct weft_rectangle *at = &piece->at;
    const struct reach *reach = &piece->reach;
    const uint64_t other_bytes = rectangle_bytes(r, at, reach) - reach->bricks.count * BRICK_BYTES;
    const weft_brick_store *store;
    const double start = weft_now_seconds();
    enum weft_result res = weft_footprint_load(r->footprint, &reach->bricks, other_bytes, &store);
    const double read = weft_now_seconds();
    if (res == WEFT_OK)
        res = fill_box(r, store, reach);
    r->report.read_seconds += read - start;
    r->report.layout_seconds += weft_now_seconds() - read;
    if (res == WEFT_OK)
        res = convolve(r, at, reach);
    if (res == WEFT_OK)
        r->pixels_done += (uint64_t)at->width * (uint64_t)at->height;
    return res;
}

// ---- runs ---------------------------------------------------------------------------------------

// The voxels' own range is what the footprint knows, or finds now.
static enum weft_result find_range(struct weft_slice_multipass *r)
{
    struct weft_slice_statistics statistics;
    r->report.low = r->p.low;
    r->report.high = r->p.high;
    if (!weft_range_is_open(r->p.low, r->p.low, r->p.high))
        return WEFT_OK;
    const struct weft_progress begun = {report_begun, r};
    const double start = weft_now_seconds();
    const enum weft_result res = weft_footprint_statistics(r->footprint, &begun, &statistics);
    r->report.low = statistics.low;
    r->report.high = statistics.high;
    r->report.read_seconds = weft_now_seconds() - start;
    return res;
}

static enum weft_result check_passes(const struct weft_slice_plan *slice,
                                     const struct weft_slice_passes *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->plan != NULL);
    const struct weft_pass_plan_info *plan = weft_pass_plan_get_info(p->plan);
    weft_require(p->log, plan->dims == 3 && plan->channels == 1);
    weft_require(p->log, weft_kernel_same(&plan->kernel, &slice->info.kernel));
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

enum weft_result weft_slice_multipass_compile(weft_context *context,
                                              const struct weft_slice_plan *plan,
                                              const struct weft_slice_passes *passes,
                                              weft_slice_multipass **out)
{
    *out = NULL;
    enum weft_result res = check_passes(plan, passes);
    if (res != WEFT_OK)
        return res;
    weft_slice_multipass *r = calloc(1, sizeof *r);
    if (!r) {
        weft_error(passes->log, "not enough memory to compile a slice in passes");
        return WEFT_ERR_MEMORY;
    }
    r->p = *passes;
    r->plan = weft_pass_plan_get_info(passes->plan);
    r->footprint = plan->footprint;
    r->memory_bytes = passes->memory_bytes ? passes->memory_bytes : DEFAULT_MEMORY;
    res = cut_slice(r);
    if (res == WEFT_OK)
        res = weft_multipass_compile(
            context, weft_multipass_params(.plan = passes->plan, .log = passes->log), &r->compiled);
    if (res == WEFT_OK)
        *out = r;
    else
        weft_slice_multipass_destroy(&r);
    return res;
}

void weft_slice_multipass_destroy(weft_slice_multipass **multipass)
{
    if (!multipass || !*multipass)
        return;
    weft_multipass_destroy(&(*multipass)->compiled);
    for (size_t i = 0; i < (*multipass)->piece_count; i++)
        reach_destroy(*multipass, &(*multipass)->pieces[i].reach);
    free((*multipass)->pieces);
    free((*multipass)->box);
    free(*multipass);
    *multipass = NULL;
}

enum weft_result weft_slice_multipass_run(weft_slice_multipass *r,
                                          const struct weft_slice_run_params *params,
                                          struct weft_slice_report *report)
{
    r->run = params;
    r->pixels_done = 0;
    r->report = (struct weft_slice_report){0};
    enum weft_result res = find_range(r);
    if (res == WEFT_OK)
        for (size_t i = 0; res == WEFT_OK && i < r->piece_count; i++)
            res = run_piece(r, &r->pieces[i]);
    if (res == WEFT_OK && !weft_range_is_open(r->p.low, r->p.low, r->p.high) && r->report.clamped)
        weft_warn(r->p.log,
                  "%" PRIu64 " voxels in reach are outside the source range from %g to %g, or not "
                  "finite: the error is bounded only where they are not",
                  r->report.clamped, r->p.low, r->p.high);
    *report = r->report;
    r->run = NULL;
    return res;
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
