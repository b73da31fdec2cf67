// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/multipass/boxes.h"
#include "passes/slice/multipass.h"
#include "passes/slice/slice_impl.h"

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
enum {
    MIN_SIDE = 4, // a rectangle is cut no smaller
    // Along a side of what it reaches. Positions of up to 13 whole and 40 fraction bits are exact
    // in double.
    MAX_BOX_SIDE = 2048,
    BRICK_BYTES = WEFT_BRICK_VOXELS * 4,
    PART_CELLS = 256,    // that a thread fills at once
    PART_ROWS = 16,      // of pixels whose cells it finds
    SAMPLED_BLOCKS = 16, // by which the samples of a large slice are estimated
    KEPT_PART = 16,      // of the memory, which what is kept of pixels may take
};

// What a rectangle's pixels reach: cells, each with the box of its taps, and the bricks that hold
// these.
struct reach {
    const struct weft_slice_cells *cells; // the footprint's; NULL: not found
    struct weft_cell_map bricks;
    int32_t min[3]; // of the box of all
    int size[3];
    size_t samples; // of the cells' boxes
    size_t texels;  // of the source, about: boxes lie in rows and slices of the largest one's
};

// What a slice is cut into: run at once, with the box of what it reaches.
struct piece {
    struct weft_rectangle at;
    struct reach reach;
    // Kept between runs: which cell each pixel reads, and where its first tap is; NULL before.
    uint32_t *of_pixel;
    struct weft_box_entries entries;
};

struct weft_slice_multipass {
    struct weft_slice_passes p;
    const struct weft_pass_plan_info *plan;
    const struct weft_slice_plan *slice;
    weft_footprint *footprint;
    weft_multipass *compiled;
    uint64_t memory_bytes;
    struct piece *pieces;
    size_t piece_count, piece_capacity;
    bool keeps_pixels; // what pieces keep of them
    int threads;
    uint64_t max_texels; // of a source
    // Of the piece that runs; they grow to the largest piece's.
    float *samples;
    struct weft_sample_box *boxes;
    uint32_t *of_pixel;
    size_t sample_capacity, box_capacity, pixel_capacity;
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
    const struct weft_rectangle *part = &r->slice->info.part;
    return go_on(r, ((double)r->pixels_done + fraction * r->current_pixels) /
                        ((double)part->width * part->height));
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

static void cell_box(const weft_footprint *f, const struct weft_slice_cells *cells, size_t i,
                     int32_t min[3], int size[3])
{
    int32_t max[3];
    weft_footprint_cell_box(f, cells, i, min, max);
    for (int a = 0; a < 3; a++)
        size[a] = max[a] - min[a] + 1;
}

static size_t count_voxels(const int size[3])
{
    return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

static void count_samples(const weft_footprint *f, struct reach *reach)
{
    const size_t count = reach->cells->map.count;
    size_t pitch[2] = {0};
    int32_t min[3];
    int size[3];
    for (size_t i = 0; i < count; i++) {
        cell_box(f, reach->cells, i, min, size);
        reach->samples += count_voxels(size);
        for (int a = 0; a < 2; a++)
            pitch[a] = (size_t)size[a] > pitch[a] ? (size_t)size[a] : pitch[a];
    }
    for (size_t i = 0; i < count; i++) {
        cell_box(f, reach->cells, i, min, size);
        reach->texels += ((size_t)(size[2] - 1) * pitch[1] + (size_t)size[1]) * pitch[0];
    }
}

static enum weft_result find_cells(const struct weft_slice_multipass *r,
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
    if (res == WEFT_OK)
        count_samples(r->footprint, reach);
    return res;
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

static bool is_fit(const struct reach *reach)
{
    for (int a = 0; a < 3; a++)
        if (reach->size[a] > MAX_BOX_SIDE)
            return false;
    return true;
}

// Of large slices some blocks, evenly spread, stand for all.
double weft_slice_multipass_samples(weft_footprint *footprint)
{
    const struct weft_slice_geometry *g = &footprint->grid.index;
    const int columns = (g->width + WEFT_GRID_BLOCK - 1) / WEFT_GRID_BLOCK;
    const int rows = (g->height + WEFT_GRID_BLOCK - 1) / WEFT_GRID_BLOCK;
    const int64_t blocks = (int64_t)columns * rows;
    const int64_t count = blocks < SAMPLED_BLOCKS ? blocks : SAMPLED_BLOCKS;
    double samples = 0.0, pixels = 0.0;
    for (int64_t i = 0; i < count; i++) {
        const int64_t block = i * blocks / count;
        const struct weft_rectangle at = block_at(g, (int)(block % columns) * WEFT_GRID_BLOCK,
                                                  (int)(block / columns) * WEFT_GRID_BLOCK);
        struct reach reach = {.cells = NULL};
        if (weft_footprint_cells(footprint, &at, NULL, 0.0, &reach.cells) != WEFT_OK)
            return INFINITY;
        count_samples(footprint, &reach);
        weft_footprint_release(footprint, &reach.cells);
        samples += (double)reach.samples;
        pixels += (double)at.width * at.height;
    }
    return samples / pixels * ((double)g->width * g->height);
}

// ---- rectangles ---------------------------------------------------------------------------------

// Of all pixels: which cell each reads, and where its first tap is.
static uint64_t kept_bytes(const struct weft_slice_multipass *r)
{
    const struct weft_rectangle *part = &r->slice->info.part;
    return (uint64_t)part->width * (uint64_t)part->height * 3 * sizeof(uint32_t);
}

// What is held while a rectangle runs, staging copies included.
static uint64_t rectangle_bytes(const struct weft_slice_multipass *r,
                                const struct weft_rectangle *at, const struct reach *reach)
{
    const uint64_t sample = r->plan->passes->dot4 ? 16 : 4;
    // Value, position, and which box.
    const uint64_t pixel = 2 * sizeof(float) + 3 * sizeof(uint32_t);
    return (r->keeps_pixels ? kept_bytes(r) : 0) + reach->bricks.count * BRICK_BYTES +
           reach->samples * sizeof(float) + 2 * reach->texels * sample +
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
    r->pieces[r->piece_count++] = (struct piece){.at = *at, .reach = *reach};
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

// Cuts a rectangle into as many pieces as the size of what it reaches asks for.
static enum weft_result cut_rectangle(struct weft_slice_multipass *r,
                                      const struct weft_rectangle *whole)
{
    struct reach reach = {.cells = NULL};
    enum weft_result res = WEFT_OK;
    set_box(r->footprint, whole, &reach);
    const bool fits = is_fit(&reach);
    if (fits)
        res = find_cells(r, whole, &reach);
    const uint64_t bytes = rectangle_bytes(r, whole, &reach);
    const bool whole_runs = fits && bytes <= r->memory_bytes && reach.texels <= r->max_texels;
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
    const struct weft_rectangle *part = &r->slice->info.part;
    const int from[2] = {part->x & -WEFT_GRID_BLOCK, part->y & -WEFT_GRID_BLOCK};
    const int end[2] = {part->x + part->width, part->y + part->height};
    enum weft_result res = WEFT_OK;
    for (int y = from[1]; res == WEFT_OK && y < end[1]; y += WEFT_GRID_BLOCK) {
        for (int x = from[0]; res == WEFT_OK && x < end[0]; x += WEFT_GRID_BLOCK) {
            const struct weft_rectangle block = block_at(g, x, y);
            const struct weft_rectangle own = weft_rectangle_common(&block, part);
            res = cut_rectangle(r, &own);
        }
    }
    return res;
}

// ---- one piece ----------------------------------------------------------------------------------

// Whether the range is known to hold all voxels in reach: then what it does not is not in reach.
static bool range_holds(const struct weft_slice_multipass *r)
{
    const weft_footprint *f = r->footprint;
    return f->ranged && f->statistics.not_finite == 0 && r->report.low <= f->statistics.low &&
           r->report.high >= f->statistics.high;
}

// Makes sure of an array's size; what was in it is gone then.
static bool grow(void **array, size_t *capacity, size_t count, size_t bytes)
{
    if (count <= *capacity)
        return true;
    free(*array);
    *array = malloc(count * bytes);
    *capacity = *array ? count : 0;
    return *array != NULL;
}

static enum weft_result make_room(struct weft_slice_multipass *r, const struct piece *piece)
{
    const size_t pixels = (size_t)piece->at.width * (size_t)piece->at.height;
    const size_t cells = piece->reach.cells->map.count;
    if (grow((void **)&r->samples, &r->sample_capacity, piece->reach.samples, sizeof *r->samples) &&
        grow((void **)&r->boxes, &r->box_capacity, cells, sizeof *r->boxes) &&
        (r->keeps_pixels ||
         grow((void **)&r->of_pixel, &r->pixel_capacity, pixels, sizeof *r->of_pixel)))
        return WEFT_OK;
    return out_of_memory(r, piece->reach.samples * sizeof *r->samples, "the voxels of a rectangle");
}

// A piece that is filled, by threads.
struct filler {
    struct weft_slice_multipass *r;
    const struct piece *piece;
    const weft_brick_store *store;
    uint32_t *of_pixel;
    bool holds;
};

// The voxels of a cell's taps. Those that are not in reach may be out of range where none in reach
// is: they become some value in range.
static void fill_cell(const struct filler *f, struct weft_brick_memo *memo, size_t number)
{
    const struct reach *reach = &f->piece->reach;
    const struct weft_sample_box *box = &f->r->boxes[number];
    const double low = f->r->report.low, high = f->r->report.high;
    const float unused = (float)(0.5 * low + 0.5 * high);
    float *out = (float *)(uintptr_t)box->plane[0];
    int32_t min[3];
    for (int a = 0; a < 3; a++)
        min[a] = box->min[a] + reach->min[a];
    weft_brick_store_copy_box(f->store, min, box->size, box->size, memo, out);
    const struct weft_float_range range = weft_float_range(low, high);
    const size_t count = f->holds ? count_voxels(box->size) : 0;
    for (size_t i = 0; i < count; i++)
        out[i] = ((out[i] >= range.least) & (out[i] <= range.most)) ? out[i] : unused;
}

static bool fill_cells(void *priv, int thread, size_t part)
{
    const struct filler *f = priv;
    const size_t end = (part + 1) * PART_CELLS, count = f->piece->reach.cells->map.count;
    struct weft_brick_memo memo = {0};
    (void)thread;
    for (size_t i = part * PART_CELLS; i < end && i < count; i++)
        fill_cell(f, &memo, i);
    return true;
}

// Which cell the pixels of a span read.
static bool note_span(void *priv, const struct weft_span *span)
{
    const struct filler *f = priv;
    const struct weft_rectangle *at = &f->piece->at;
    const int64_t number = weft_cell_map_find(&f->piece->reach.cells->map, span->cell);
    uint32_t *out =
        f->of_pixel + (size_t)(span->y - at->y) * (size_t)at->width + (size_t)(span->x - at->x);
    for (int i = 0; i < span->count; i++)
        out[i] = (uint32_t)number;
    return true;
}

static bool note_rows(void *priv, int thread, size_t part)
{
    const struct filler *f = priv;
    const struct weft_rectangle *at = &f->piece->at;
    const int first = (int)part * PART_ROWS, left = at->height - first;
    (void)thread;
    return weft_slice_grid_walk(&f->r->footprint->grid, at->x, at->y + first, at->width,
                                left < PART_ROWS ? left : PART_ROWS, note_span, priv);
}

// Where each cell's samples lie.
static void place_boxes(struct weft_slice_multipass *r, const struct reach *reach)
{
    float *next = r->samples;
    for (size_t i = 0; i < reach->cells->map.count; i++) {
        struct weft_sample_box *box = &r->boxes[i];
        *box = (struct weft_sample_box){.plane = {next}};
        cell_box(r->footprint, reach->cells, i, box->min, box->size);
        for (int a = 0; a < 3; a++)
            box->min[a] -= reach->min[a];
        next += count_voxels(box->size);
    }
}

// Finds which cell each pixel reads, or takes it where it is kept.
static enum weft_result note_pixels(struct weft_slice_multipass *r, struct piece *piece)
{
    const size_t pixels = (size_t)piece->at.width * (size_t)piece->at.height;
    const size_t parts = (size_t)((piece->at.height + PART_ROWS - 1) / PART_ROWS);
    if (piece->of_pixel)
        return WEFT_OK;
    if (r->keeps_pixels)
        piece->of_pixel = malloc(pixels * sizeof *piece->of_pixel);
    struct filler f = {
        .r = r, .piece = piece, .of_pixel = r->keeps_pixels ? piece->of_pixel : r->of_pixel};
    if (!f.of_pixel)
        return out_of_memory(r, pixels * sizeof *piece->of_pixel, "which cells pixels read");
    weft_threads_run(r->threads, parts, note_rows, &f);
    return WEFT_OK;
}

static enum weft_result fill_boxes(struct weft_slice_multipass *r, const weft_brick_store *store,
                                   struct piece *piece)
{
    struct filler f = {.r = r, .piece = piece, .store = store, .holds = range_holds(r)};
    const size_t cells = piece->reach.cells->map.count;
    const enum weft_result res = make_room(r, piece);
    if (res != WEFT_OK)
        return res;
    place_boxes(r, &piece->reach);
    weft_threads_run(r->threads, (cells + PART_CELLS - 1) / PART_CELLS, fill_cells, &f);
    return note_pixels(r, piece);
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

static int compare_places(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

// Where voxels are out of range, or not finite: as numbers in the box of all, which has up to 2^33
// of them. Returns how many there are.
static size_t find_clamped(const struct weft_slice_multipass *r, const struct reach *reach,
                           uint64_t *places)
{
    size_t count = 0;
    for (size_t b = 0; b < reach->cells->map.count; b++) {
        const struct weft_sample_box *box = &r->boxes[b];
        for (size_t i = 0; i < count_voxels(box->size); i++) {
            const double v = (double)box->plane[0][i];
            if (v >= r->report.low && v <= r->report.high)
                continue;
            const size_t x = i % (size_t)box->size[0], rows = i / (size_t)box->size[0];
            const size_t y = rows % (size_t)box->size[1], z = rows / (size_t)box->size[1];
            places[count++] = (((size_t)box->min[2] + z) * MAX_BOX_SIDE + (size_t)box->min[1] + y) *
                                  MAX_BOX_SIDE +
                              (size_t)box->min[0] + x;
        }
    }
    return count;
}

// Voxels of several boxes count once.
static enum weft_result count_clamped(struct weft_slice_multipass *r, const struct reach *reach,
                                      uint64_t clamped)
{
    if (!clamped)
        return WEFT_OK;
    uint64_t *places = malloc(clamped * sizeof *places);
    if (!places)
        return out_of_memory(r, clamped * sizeof *places, "places of voxels out of range");
    const size_t count = find_clamped(r, reach, places);
    qsort(places, count, sizeof *places, compare_places);
    for (size_t i = 0; i < count; i++)
        r->report.clamped += i == 0 || places[i] != places[i - 1];
    free(places);
    return WEFT_OK;
}

static enum weft_result convolve(struct weft_slice_multipass *r, struct piece *piece)
{
    const struct weft_rectangle *at = &piece->at;
    const struct reach *reach = &piece->reach;
    const int64_t stride = r->run->stride;
    const struct weft_sample_boxes boxes = {
        .count = reach->cells->map.count,
        .box = r->boxes,
        .of_pixel = r->keeps_pixels ? piece->of_pixel : r->of_pixel,
        .kept = r->keeps_pixels ? &piece->entries : NULL,
        .low = r->report.low,
        .high = r->report.high,
    };
    const struct weft_progress progress = {report_rectangle, r};
    struct weft_pixel_grid grid;
    set_grid(r, at, reach, &grid);
    const struct weft_multipass_run_params params = {
        .grid = &grid,
        .pixels = {weft_slice_pixel(r->slice, r->run->pixels, stride, at->x, at->y)},
        .stride = stride,
        .progress = &progress,
        .log = r->p.log,
    };
    struct weft_multipass_report report = {0};
    r->current_pixels = at->width * at->height;
    enum weft_result res = weft_multipass_run_boxes(r->compiled, &params, &boxes, &report);
    if (res == WEFT_OK)
        res = count_clamped(r, reach, report.clamped);
    if (res == WEFT_OK)
        add_report(r, &report,
                   r->footprint->info.kept_bytes + reach->samples * sizeof *r->samples +
                       (r->keeps_pixels ? kept_bytes(r) : 0));
    return res;
}

static enum weft_result run_piece(struct weft_slice_multipass *r, struct piece *piece)
{
    const struct weft_rectangle *at = &piece->at;
    const struct reach *reach = &piece->reach;
    const uint64_t other_bytes = rectangle_bytes(r, at, reach) - reach->bricks.count * BRICK_BYTES;
    const weft_brick_store *store;
    const double start = weft_now_seconds();
    enum weft_result res = weft_footprint_load(r->footprint, &reach->bricks, other_bytes, &store);
    const double read = weft_now_seconds();
    if (res == WEFT_OK)
        res = fill_boxes(r, store, piece);
    r->report.read_seconds += read - start;
    r->report.layout_seconds += weft_now_seconds() - read;
    if (res == WEFT_OK)
        res = convolve(r, piece);
    if (res == WEFT_OK)
        r->pixels_done += (uint64_t)at->width * (uint64_t)at->height;
    return res;
}

// ---- runs ---------------------------------------------------------------------------------------

// The voxels' own range is what the footprint knows, or finds now.
static enum weft_result find_range(struct weft_slice_multipass *r)
{
    const struct weft_slice_statistics *statistics = &r->footprint->statistics;
    r->report.low = r->p.low;
    r->report.high = r->p.high;
    if (!weft_range_is_open(r->p.low, r->p.low, r->p.high))
        return WEFT_OK;
    const struct weft_progress begun = {report_begun, r};
    const double start = weft_now_seconds();
    const enum weft_result res = weft_footprint_measure_range(r->footprint, r->threads, &begun);
    r->report.low = statistics->low;
    r->report.high = statistics->high;
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

enum weft_result weft_slice_multipass_compile(weft_context *context, const struct weft_cpu *cpu,
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
    r->slice = plan;
    r->footprint = plan->footprint;
    r->threads = cpu->threads;
    r->max_texels =
        context ? (uint64_t)weft_context_get_info(context)->max_buffer_texels : INT32_MAX;
    r->memory_bytes = passes->memory_bytes ? passes->memory_bytes : DEFAULT_MEMORY;
    r->keeps_pixels = kept_bytes(r) <= r->memory_bytes / KEPT_PART;
    res = cut_slice(r);
    if (res == WEFT_OK)
        res = weft_multipass_compile(
            context,
            weft_multipass_params(.plan = passes->plan, .threads = r->threads, .log = passes->log),
            &r->compiled);
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
    for (size_t i = 0; i < (*multipass)->piece_count; i++) {
        struct piece *piece = &(*multipass)->pieces[i];
        reach_destroy(*multipass, &piece->reach);
        free(piece->of_pixel);
        weft_box_entries_destroy(&piece->entries);
    }
    free((*multipass)->pieces);
    free((*multipass)->samples);
    free((*multipass)->boxes);
    free((*multipass)->of_pixel);
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
    const struct weft_bound_terms *grid = &slice->info.output[0].bound;
    struct weft_bound_terms terms = weft_pass_plan_get_info(plan)->bound;
    terms.relative = weft_slice_position_bound(slice);
    terms.sample_rounding = grid->sample_rounding;
    terms.absolute_rounding = grid->absolute_rounding;
    return terms;
}
