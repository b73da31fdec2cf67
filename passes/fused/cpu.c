// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/cpu.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/fused/exact.h"
#include "passes/fused/layout.h"
#include "passes/fused/lines/lines.h"
#include "passes/fused/resident_impl.h"

// What a thread does at once: parts of the grid's blocks of 256 x 256 pixels.
enum { PART_HEIGHT = 16, PARTS_PER_BLOCK = WEFT_GRID_BLOCK / PART_HEIGHT };

// Cells that a thread met last, by a hash.
enum { KNOWN = 64 };

struct weft_fused_cpu {
    const struct weft_slice_plan *plan;
    const struct weft_log *log;
    struct weft_cpu cpu;
    // Of full and of smooth cells; those of constant ones are not used.
    struct weft_line_kernel kernel[WEFT_CELL_CLASSES];
    weft_line_fn line[WEFT_CELL_CLASSES];
    struct weft_slice_layout layout;
    struct weft_slice_blocks cells; // of the tile
    float *source;                  // its blocks and samples past the last one, if it has its own
    size_t source_samples;
    double per_step[3]; // 1 / |grid->du|
    // Of a run.
    struct weft_slice_pixels pixels;
    const struct weft_progress *progress;
    struct weft_fused_report report;
    int tile;
    size_t parts;
    atomic_uint_fast64_t taps;          // that were read
    struct weft_statistics *statistics; // of pixels, by thread
};

static bool go_on(const struct weft_fused_cpu *r, double fraction)
{
    return !r->progress || !r->progress->report || r->progress->report(r->progress->priv, fraction);
}

// ---- compiling ----------------------------------------------------------------------------------

// Linear interpolation of two taps.
static float linear_coefficients[] = {1.0f, 0.0f, 0.0f, 0.0f, -1.0f, 1.0f, 0.0f, 0.0f};
static double linear_precise[] = {1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0};
static const struct weft_polynomial_tiles linear = {
    .width = 2,
    .groups = 1,
    .degree = 1,
    .segments = 1,
    .coefficients = linear_coefficients,
    .precise = linear_precise,
};

// Outputs other than the value alone, along the axes of blocks, which are the volume's then.
static void set_outputs(const struct weft_slice_plan *plan, struct weft_line_kernel *full)
{
    if (!weft_slice_derives(plan))
        return;
    full->output_count = plan->info.output_count;
    for (int o = 0; o < full->output_count; o++)
        full->output[o] = plan->info.output[o].derivative;
}

static enum weft_result create_kernels(struct weft_fused_cpu *r)
{
    const struct weft_slice_plan *plan = r->plan;
    const enum weft_sums sums = plan->info.sums;
    const int width = plan->info.kernel.width, middle = (width - 1) / 2;
    const struct weft_polynomial_tiles *own[WEFT_LINE_ORDERS];
    const struct weft_polynomial_tiles *const smooth[WEFT_LINE_ORDERS] = {&linear};
    struct weft_line_kernel *full = &r->kernel[WEFT_CELL_FULL];
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        own[n] = plan->weights[n] ? &plan->weights[n]->tiles : NULL;
    set_outputs(plan, full);
    enum weft_result res = weft_line_kernel_create(r->log, sums, own, full);
    if (res == WEFT_OK)
        res = weft_line_kernel_create(r->log, sums, smooth, &r->kernel[WEFT_CELL_SMOOTH]);
    if (plan->clamp_to_samples && width > 1) {
        full->clamp_from = middle - width % 2;
        full->clamp_to = middle + 1;
    }
    return res;
}

static enum weft_result create_source(struct weft_fused_cpu *r)
{
    const enum weft_result res = weft_slice_blocks_create(r->plan, &r->cells);
    if (res != WEFT_OK || weft_slice_reads_blocks(r->plan))
        return res;
    for (int i = 0; i < r->plan->info.tile_count; i++)
        if (r->plan->tile_plans[i].source_texels > r->source_samples)
            r->source_samples = r->plan->tile_plans[i].source_texels;
    // Vectors read past the last row; what they find there does not count.
    r->source = calloc(r->source_samples + WEFT_LINE_SAMPLES, sizeof *r->source);
    if (r->source)
        return weft_slice_layout_create(r->plan, &r->layout);
    weft_error(r->log, "not enough memory for %zu voxels of a slice", r->source_samples);
    return WEFT_ERR_MEMORY;
}

static enum weft_result create_statistics(struct weft_fused_cpu *r)
{
    r->statistics = malloc((size_t)r->cpu.threads * sizeof *r->statistics);
    if (r->statistics)
        return WEFT_OK;
    weft_error(r->log, "not enough memory for %d threads of a slice", r->cpu.threads);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_fused_cpu_compile(const struct weft_cpu *cpu, const weft_slice_plan *plan,
                                        weft_fused_cpu **out)
{
    *out = NULL;
    weft_fused_cpu *r = calloc(1, sizeof *r);
    if (!r) {
        weft_error(plan->log, "not enough memory to compile the slice");
        return WEFT_ERR_MEMORY;
    }
    r->plan = plan;
    r->log = plan->log;
    r->cpu = *cpu;
    for (int a = 0; a < 3; a++) {
        const int64_t step = plan->footprint->grid.du[a];
        r->per_step[a] = step ? 1.0 / (double)(step < 0 ? -step : step) : 0.0;
    }
    enum weft_result res = create_kernels(r);
    if (res == WEFT_OK)
        res = create_source(r);
    if (res == WEFT_OK)
        res = create_statistics(r);
    if (res == WEFT_OK)
        *out = r;
    else
        weft_fused_cpu_destroy(&r);
    return res;
}

void weft_fused_cpu_destroy(weft_fused_cpu **fused)
{
    weft_fused_cpu *r = fused ? *fused : NULL;
    if (!r)
        return;
    for (int i = 0; i < WEFT_CELL_CLASSES; i++)
        weft_line_kernel_destroy(&r->kernel[i]);
    weft_slice_layout_destroy(&r->layout);
    weft_slice_blocks_destroy(&r->cells);
    free(r->source);
    free(r->statistics);
    free(r);
    *fused = NULL;
}

// ---- lines of a rectangle -----------------------------------------------------------------------

// What one cell's pixels are made from.
struct cell {
    struct weft_cell_key key;
    bool known;
    enum weft_cell_class class;
    float value;        // of a constant one
    const float *start; // of others: the first tap's sample at the cell's start
};

// A thread's rectangle, row by row.
struct part {
    struct weft_fused_cpu *r;
    struct weft_rectangle at; // within one block of the grid
    struct cell known[KNOWN];
    // Pixels of the row from the line's first on, all of one class that has blocks.
    enum weft_cell_class class;
    int first, count;
    const float *start[WEFT_LINE_PIXELS + WEFT_LINE_PAD];
    uint64_t taps;
};

static void set_cell(const struct weft_fused_cpu *r, struct weft_cell_key key, struct cell *out)
{
    const struct weft_slice_tile_plan *tile = &r->plan->tile_plans[r->tile];
    const int64_t number = weft_cell_map_find(&tile->cells->map, key);
    const int32_t entry = r->cells.entries[number];
    const struct weft_line_kernel *full = &r->kernel[WEFT_CELL_FULL];
    out->key = key;
    out->known = true;
    out->class = (enum weft_cell_class)r->cells.classes[number];
    if (out->class == WEFT_CELL_CONSTANT) {
        out->value = r->cells.constants[~entry];
        return;
    }
    // Linear interpolation has the full kernel's middle taps.
    const int middle = out->class == WEFT_CELL_SMOOTH ? (r->plan->info.kernel.width - 1) / 2 : 0;
    out->start =
        (const float *)r->cells.texels + entry +
        (size_t)(r->cells.lead + middle) * (1 + full->pitch_y + (full->summed ? 0 : full->pitch_z));
}

static const struct cell *find_cell(struct part *p, struct weft_cell_key key)
{
    struct cell *known = &p->known[(key.at[0] + 5 * key.at[1] + 23 * key.at[2]) & (KNOWN - 1)];
    if (!known->known || memcmp(&known->key, &key, sizeof key) != 0)
        set_cell(p->r, key, known);
    return known;
}

// Makes the pixels that were gathered. `block`: of the grid; its position is that of the part's
// first pixel in this row.
static void end_line(struct part *p, const struct weft_slice_block *block, int y)
{
    const struct weft_fused_cpu *r = p->r;
    const struct weft_slice_grid *grid = &r->plan->footprint->grid;
    const struct weft_line_kernel *kernel = &r->kernel[p->class];
    const int low_bits = grid->fraction_bits - WEFT_GRID_WORD_FRACTION_BITS;
    const int64_t low_mask = (INT64_C(1) << low_bits) - 1;
    if (!p->count)
        return;
    struct weft_line line = {
        .kernel = kernel,
        .start = p->start,
        .low_bits = low_bits,
        .count = p->count,
        .out = weft_slice_pixel(r->plan, r->pixels.at, r->pixels.stride, p->first, y),
        .plane = (size_t)r->pixels.plane,
    };
    for (int i = 0; i < 3; i++) {
        const int a = r->plan->axes.order[i];
        const int64_t at = block->position[a] + (p->first - p->at.x) * grid->du[a];
        line.position[i] = (uint32_t)(at >> low_bits);
        line.low[i] = (uint32_t)(at & low_mask);
        line.step[i] = (uint32_t)(grid->du[a] >> low_bits);
        line.low_step[i] = (uint32_t)(grid->du[a] & low_mask);
    }
    for (int i = 0; i < WEFT_LINE_PAD; i++)
        p->start[p->count + i] = p->start[p->count - 1];
    r->line[p->class](&line);
    const int width = kernel->width;
    p->taps += (uint64_t)p->count * (uint64_t)(width * width * (kernel->summed ? 1 : width));
    p->count = 0;
}

// How many pixels from one at this position on are in its cell, at most `limit`: as
// weft_slice_grid_walk finds it, by a product in place of a division. The quotient of two such
// numbers is at most one off, since their product is less than 2^53 times as large.
static int pixels_in_cell(const struct weft_fused_cpu *r, const int64_t at[3], int limit)
{
    const struct weft_slice_grid *grid = &r->plan->footprint->grid;
    const int64_t last = (INT64_C(8) << grid->fraction_bits) - 1;
    for (int a = 0; a < 3; a++) {
        const int64_t step = grid->du[a] < 0 ? -grid->du[a] : grid->du[a];
        const int64_t in = at[a] & last, left = grid->du[a] < 0 ? in : last - in;
        if (step == 0 || left >= step * limit)
            continue;
        int64_t steps = (int64_t)((double)left * r->per_step[a]);
        steps -= steps * step > left;
        steps += (steps + 1) * step <= left;
        limit = (int)steps + 1;
    }
    return limit;
}

static void fill(float *out, float value, int count)
{
    for (int i = 0; i < count; i++)
        out[i] = value;
}

// Pixels of a constant cell.
static void fill_outputs(const struct weft_fused_cpu *r, int x, int y, float value, int count)
{
    const struct weft_slice_plan_info *info = &r->plan->info;
    float *out = weft_slice_pixel(r->plan, r->pixels.at, r->pixels.stride, x, y);
    for (int o = 0; o < info->output_count; o++, out += r->pixels.plane)
        fill(out, weft_slice_constant(&info->output[o].derivative, value), count);
}

// `block` as in end_line.
static void make_row(struct part *p, const struct weft_slice_block *block, int y)
{
    const struct weft_fused_cpu *r = p->r;
    const struct weft_slice_grid *grid = &r->plan->footprint->grid;
    int64_t at[3];
    memcpy(at, block->position, sizeof at);
    for (int x = 0, count; x < p->at.width; x += count) {
        struct weft_cell_key key;
        count = pixels_in_cell(r, at, p->at.width - x);
        for (int a = 0; a < 3; a++) {
            key.at[a] = (block->base[a] >> 3) + (int32_t)(at[a] >> (grid->fraction_bits + 3));
            at[a] += count * grid->du[a];
        }
        const struct cell *cell = find_cell(p, key);
        if (p->count && cell->class != p->class)
            end_line(p, block, y);
        if (cell->class == WEFT_CELL_CONSTANT) {
            fill_outputs(r, p->at.x + x, y, cell->value, count);
            continue;
        }
        if (!p->count)
            p->first = p->at.x + x;
        p->class = cell->class;
        const float **start = p->start + p->count, *own = cell->start;
        for (int i = 0; i < count; i++)
            start[i] = own;
        p->count += count;
    }
    end_line(p, block, y);
}

// ---- tiles --------------------------------------------------------------------------------------

// Blocks of the grid that a tile meets along an axis.
static int count_blocks(int start, int length)
{
    return (start + length - 1) / WEFT_GRID_BLOCK - start / WEFT_GRID_BLOCK + 1;
}

// Part number i of the tile, which may have no pixels there.
static struct weft_rectangle part_at(const struct weft_slice_tile *tile, size_t i)
{
    const int columns = count_blocks(tile->x, tile->width);
    const int column = (int)(i % (size_t)columns), row = (int)(i / (size_t)columns);
    int from[2] = {(tile->x / WEFT_GRID_BLOCK + column) * WEFT_GRID_BLOCK,
                   tile->y / WEFT_GRID_BLOCK * WEFT_GRID_BLOCK + row * PART_HEIGHT};
    int to[2] = {from[0] + WEFT_GRID_BLOCK, from[1] + PART_HEIGHT};
    const int first[2] = {tile->x, tile->y};
    const int end[2] = {tile->x + tile->width, tile->y + tile->height};
    for (int a = 0; a < 2; a++) {
        from[a] = from[a] < first[a] ? first[a] : from[a];
        to[a] = to[a] > end[a] ? end[a] : to[a];
    }
    return (struct weft_rectangle){from[0], from[1], to[0] - from[0], to[1] - from[1]};
}

static bool make_part(void *priv, int thread, size_t i)
{
    struct weft_fused_cpu *r = priv;
    const struct weft_slice_grid *grid = &r->plan->footprint->grid;
    struct part p;
    p.r = r;
    p.at = part_at(&r->plan->tiles[r->tile], i);
    p.class = WEFT_CELL_FULL;
    p.count = 0;
    p.taps = 0;
    for (int k = 0; k < KNOWN; k++)
        p.known[k].known = false;
    const int bx = p.at.x / WEFT_GRID_BLOCK, by = p.at.y / WEFT_GRID_BLOCK;
    const double tiles = r->plan->info.tile_count;
    if (thread == 0 && !go_on(r, (r->tile + (double)i / (double)r->parts) / tiles))
        return false;
    struct weft_slice_block block;
    weft_slice_grid_block(grid, bx, by, &block);
    for (int a = 0; a < 3; a++)
        block.position[a] += (p.at.x - bx * WEFT_GRID_BLOCK) * grid->du[a] +
                             (p.at.y - by * WEFT_GRID_BLOCK) * grid->dv[a];
    for (int y = p.at.y; y < p.at.y + p.at.height; y++) {
        make_row(&p, &block, y);
        weft_statistics_add(&r->statistics[thread],
                            weft_slice_pixel(r->plan, r->pixels.at, r->pixels.stride, p.at.x, y),
                            (size_t)p.at.width);
        for (int a = 0; a < 3; a++)
            block.position[a] += grid->dv[a];
    }
    atomic_fetch_add(&r->taps, p.taps);
    return true;
}

// How the tile's blocks lie, and what reads them so.
static void set_lines(struct weft_fused_cpu *r)
{
    const struct weft_block_layout *layout = &r->cells.layout;
    for (int i = 0; i < WEFT_CELL_CONSTANT; i++) {
        struct weft_line_kernel *kernel = &r->kernel[i];
        kernel->summed = r->plan->axes.summed;
        kernel->pitch_y = (uint32_t)layout->row_texels;
        kernel->pitch_z = (uint32_t)(layout->row_texels * layout->span[1]);
        r->line[i] = weft_line_find(r->cpu.instructions, kernel);
    }
}

// What the tile needs of the resident volume is there, or added.
static enum weft_result load_blocks(struct weft_fused_cpu *r)
{
    const struct weft_resident_info *info = &r->plan->resident->info, before = *info;
    const enum weft_result res =
        weft_resident_load(r->plan->resident, r->plan, r->tile, r->progress, &r->cells);
    r->report.read_seconds += info->read_seconds - before.read_seconds;
    r->report.layout_seconds += info->layout_seconds - before.layout_seconds;
    return res;
}

// Bricks are read, and the tile's own blocks made of them.
static enum weft_result load_source(struct weft_fused_cpu *r)
{
    const weft_brick_store *store;
    const struct weft_slice_tile_plan *tile = &r->plan->tile_plans[r->tile];
    const uint64_t own = r->source_samples * sizeof *r->source;
    const double start = weft_now_seconds();
    const enum weft_result res =
        weft_footprint_load(r->plan->footprint, &tile->bricks, own, &store);
    const double read = weft_now_seconds();
    if (res != WEFT_OK)
        return res;
    const uint64_t bytes = own + r->plan->footprint->info.kept_bytes;
    r->report.peak_bytes = bytes > r->report.peak_bytes ? bytes : r->report.peak_bytes;
    weft_slice_layout_write(&r->layout, tile, store, (char *)r->source, &r->cells);
    r->cells.texels = r->source;
    r->report.read_seconds += read - start;
    r->report.layout_seconds += weft_now_seconds() - read;
    return WEFT_OK;
}

static enum weft_result run_tile(struct weft_fused_cpu *r)
{
    const struct weft_slice_plan *plan = r->plan;
    const struct weft_slice_tile *tile = &plan->tiles[r->tile];
    enum weft_result res = weft_slice_reads_blocks(plan) ? load_blocks(r) : load_source(r);
    if (res != WEFT_OK)
        return res;
    set_lines(r);
    const double start = weft_now_seconds();
    r->parts = (size_t)count_blocks(tile->x, tile->width) *
               (size_t)(count_blocks(tile->y, tile->height) * PARTS_PER_BLOCK);
    if (!weft_threads_run(r->cpu.threads, r->parts, make_part, r))
        res = WEFT_ERR_CANCELLED;
    r->report.pass_seconds += weft_now_seconds() - start;
    r->report.passes++;
    if (res == WEFT_OK && r->cells.any_unfit)
        res = weft_slice_exact_paint(
            plan, r->tile, r->source_samples * sizeof *r->source, &r->pixels, r->progress,
            (r->tile + 1.0) / plan->info.tile_count, &r->report.exact_pixels);
    return res;
}

enum weft_result weft_fused_cpu_run(weft_fused_cpu *r, const struct weft_slice_pixels *pixels,
                                    const struct weft_progress *progress,
                                    struct weft_fused_report *report)
{
    const int count = r->plan->info.tile_count;
    enum weft_result res = WEFT_OK;
    r->pixels = *pixels;
    r->progress = progress;
    r->report = (struct weft_fused_report){0};
    r->cells.cells_constant = r->cells.cells_smooth = 0;
    atomic_store(&r->taps, 0);
    for (int i = 0; i < r->cpu.threads; i++)
        r->statistics[i] = (struct weft_statistics)WEFT_STATISTICS_NONE;
    for (r->tile = 0; res == WEFT_OK && r->tile < count; r->tile++) {
        if (go_on(r, (double)r->tile / count))
            res = run_tile(r);
        else
            res = WEFT_ERR_CANCELLED;
    }
    if (res == WEFT_ERR_CANCELLED)
        weft_note(r->log, "the slice was cancelled at tile %d of %d", r->tile - 1, count);
    r->report.cells_constant = r->cells.cells_constant;
    r->report.cells_smooth = r->cells.cells_smooth;
    r->report.fetches = atomic_load(&r->taps);
    r->report.pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
    // Pixels that were repainted were not measured.
    for (int i = 0; i < r->cpu.threads && !r->report.exact_pixels; i++)
        weft_statistics_join(&r->report.pixels, &r->statistics[i]);
    *report = r->report;
    return res;
}
