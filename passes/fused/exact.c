// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/exact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_SPAN = WEFT_BRICK_SIZE + WEFT_KERNEL_MAX_WIDTH - 1 };

// Of all voxels that a cell's pixels may reach.
enum state { STATE_FIT, STATE_MIXED, STATE_NAN };

struct painter {
    const struct weft_slice_plan *plan;
    const weft_brick_store *store;
    struct weft_slice_pixels pixels;
    const struct weft_progress *progress;
    double fraction;
    struct weft_cell_map map; // of cells that were looked at
    uint8_t *states;          // by number
    size_t capacity;
    int64_t boxed; // number of the cell whose voxels are in `box`; WEFT_CELL_NONE: none
    int32_t min[3];
    int size[3];
    float box[MAX_SPAN * MAX_SPAN * MAX_SPAN];
    struct weft_slice_block block;
    int block_x, block_y;
    int row;
    uint64_t count;
    enum weft_result result;
};

bool weft_slice_replace_unfit(const struct weft_slice_plan *plan, float *voxels, size_t count)
{
    bool any = false;
    for (size_t i = 0; i < count; i++) {
        if (weft_slice_unfit(plan, voxels[i])) {
            voxels[i] = 0.0f;
            any = true;
        }
    }
    return any;
}

enum weft_result weft_slice_exact_check(const struct weft_slice_plan *plan,
                                        const struct weft_progress *progress)
{
    const enum weft_source_format source = plan->info.source;
    struct weft_slice_statistics statistics;
    if (source == WEFT_SOURCE_FLOAT || source == WEFT_SOURCE_HALF)
        return WEFT_OK;
    const enum weft_result res = weft_footprint_statistics(plan->footprint, progress, &statistics);
    if (res != WEFT_OK || statistics.not_finite == 0)
        return res;
    weft_error(plan->log, "the volume holds NaN or infinity, which a source of format %s does not",
               weft_source_format_name(source));
    return WEFT_ERR_UNSUPPORTED;
}

// ---- cells --------------------------------------------------------------------------------------

static void load_box(struct painter *p, int64_t number)
{
    const struct weft_slice_axes *axes = &p->plan->axes;
    if (p->boxed == number)
        return;
    for (int a = 0; a < 3; a++) {
        const bool summed = axes->summed && a == axes->order[2];
        p->min[a] = summed ? (int32_t)axes->plane
                           : p->map.keys[number].at[a] * WEFT_BRICK_SIZE -
                                 p->plan->footprint->grid.tap_offset;
        p->size[a] = summed ? axes->kept : WEFT_BRICK_SIZE + p->plan->info.kernel.width - 1;
    }
    weft_brick_store_copy_box(p->store, p->min, p->size, p->size, NULL, p->box);
    p->boxed = number;
}

static enum state find_state(const struct painter *p)
{
    const size_t count = (size_t)p->size[0] * (size_t)p->size[1] * (size_t)p->size[2];
    size_t unfit = 0, nans = 0;
    for (size_t i = 0; i < count; i++) {
        unfit += weft_slice_unfit(p->plan, p->box[i]);
        nans += isnan(p->box[i]);
    }
    return !unfit ? STATE_FIT : nans == count ? STATE_NAN : STATE_MIXED;
}

// The cell's number, its state being known then; WEFT_CELL_NONE when memory ran out.
static int64_t find_cell(struct painter *p, struct weft_cell_key key)
{
    const size_t known = p->map.count;
    const int64_t number = weft_cell_map_add(&p->map, key);
    if (number == WEFT_CELL_NONE || (size_t)number < known)
        return number;
    if (known == p->capacity) {
        const size_t capacity = known ? 2 * known : 256;
        void *states = realloc(p->states, capacity);
        if (!states)
            return WEFT_CELL_NONE;
        p->states = states;
        p->capacity = capacity;
    }
    load_box(p, number);
    p->states[number] = (uint8_t)find_state(p);
    return number;
}

// ---- one pixel ----------------------------------------------------------------------------------

// A pixel's taps along an axis: the first one's place in the box, and those that count.
struct taps {
    int first, width, count;
    int at[WEFT_KERNEL_MAX_WIDTH]; // from the first
    double weight[WEFT_KERNEL_MAX_WIDTH];
};

static void set_taps(const struct painter *p, int a, int order, int32_t whole, double fraction,
                     struct taps *out)
{
    const struct weft_slice_axes *axes = &p->plan->axes;
    const struct weft_slice_grid *grid = &p->plan->footprint->grid;
    const bool summed = axes->summed && a == axes->order[2];
    double own[WEFT_KERNEL_MAX_WIDTH];
    if (!summed)
        weft_kernel_weights(&p->plan->kernels[order]->kernel, fraction - grid->tap_shift, own);
    const double *weight = summed ? axes->weight : own;
    out->first = summed ? 0 : whole - grid->tap_offset - p->min[a];
    out->width = summed ? axes->kept : p->plan->info.kernel.width;
    out->count = 0;
    for (int i = 0; i < out->width; i++) {
        if (weight[i] == 0.0)
            continue;
        out->at[out->count] = i;
        out->weight[out->count++] = weight[i];
    }
}

// Along the three axes.
typedef const struct taps *const axes_taps[3];

static const float *row_at(const struct painter *p, axes_taps t, int y, int z)
{
    return p->box + ((t[2]->first + z) * p->size[1] + t[1]->first + y) * p->size[0] + t[0]->first;
}

static bool reaches_unfit(const struct painter *p, axes_taps t)
{
    for (int z = 0; z < t[2]->width; z++) {
        for (int y = 0; y < t[1]->width; y++) {
            const float *row = row_at(p, t, y, z);
            for (int x = 0; x < t[0]->width; x++)
                if (weft_slice_unfit(p->plan, row[x]))
                    return true;
        }
    }
    return false;
}

static double convolve(const struct painter *p, axes_taps t)
{
    double sum = 0.0;
    for (int z = 0; z < t[2]->count; z++) {
        for (int y = 0; y < t[1]->count; y++) {
            const float *row = row_at(p, t, t[1]->at[y], t[2]->at[z]);
            double line = 0.0;
            for (int x = 0; x < t[0]->count; x++)
                line += t[0]->weight[x] * (double)row[t[0]->at[x]];
            sum += t[2]->weight[z] * t[1]->weight[y] * line;
        }
    }
    return sum;
}

// To the range of the samples next to the pixel, as the shader does it.
static double clamp_to_samples(const struct painter *p, axes_taps t, double value)
{
    const int width = p->plan->info.kernel.width, middle = (width - 1) / 2;
    const int from = middle - width % 2, to = middle + 1;
    double least = INFINITY, most = -INFINITY;
    if (!p->plan->clamp_to_samples || width == 1 || !isfinite(value))
        return value;
    for (int z = from; z <= to; z++) {
        for (int y = from; y <= to; y++) {
            const float *row = row_at(p, t, y, z);
            for (int x = from; x <= to; x++) {
                least = fmin(least, (double)row[x]);
                most = fmax(most, (double)row[x]);
            }
        }
    }
    return value < least ? least : value > most ? most : value;
}

// All outputs.
static void paint_pixel(struct painter *p, int x, int y)
{
    const struct weft_slice_plan *plan = p->plan;
    int32_t whole[3];
    double fraction[3];
    struct taps taps[WEFT_LINE_ORDERS][3];
    weft_slice_grid_pixel(&plan->footprint->grid, &p->block, x, y, whole, fraction);
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        for (int a = 0; a < 3 && plan->kernels[n]; a++)
            set_taps(p, a, n, whole[a], fraction[a], &taps[n][a]);
    if (!reaches_unfit(p, (axes_taps){&taps[0][0], &taps[0][1], &taps[0][2]}))
        return;
    float *out = weft_slice_pixel(plan, p->pixels.at, p->pixels.stride, x, y);
    for (int o = 0; o < plan->info.output_count; o++, out += p->pixels.plane) {
        const int *n = plan->info.output[o].derivative.along;
        axes_taps own = {&taps[n[0]][0], &taps[n[1]][1], &taps[n[2]][2]};
        *out = (float)clamp_to_samples(p, own, convolve(p, own));
    }
    p->count++;
}

// Pixels none of whose voxels is there.
static void paint_missing(const struct painter *p, const struct weft_span *run)
{
    float *out = weft_slice_pixel(p->plan, p->pixels.at, p->pixels.stride, run->x, run->y);
    for (int o = 0; o < p->plan->info.output_count; o++, out += p->pixels.plane)
        for (int i = 0; i < run->count; i++)
            out[i] = NAN;
}

// ---- tiles --------------------------------------------------------------------------------------

static bool go_on(struct painter *p, int row)
{
    if (row == p->row)
        return true;
    p->row = row;
    if (!p->progress || !p->progress->report || p->progress->report(p->progress->priv, p->fraction))
        return true;
    p->result = WEFT_ERR_CANCELLED;
    return false;
}

static void set_block(struct painter *p, int x, int y)
{
    const int bx = x / WEFT_GRID_BLOCK, by = y / WEFT_GRID_BLOCK;
    if (bx == p->block_x && by == p->block_y)
        return;
    weft_slice_grid_block(&p->plan->footprint->grid, bx, by, &p->block);
    p->block_x = bx;
    p->block_y = by;
}

static bool paint_run(void *priv, const struct weft_span *run)
{
    struct painter *p = priv;
    if (!go_on(p, run->y))
        return false;
    const int64_t number = find_cell(p, run->cell);
    if (number == WEFT_CELL_NONE) {
        p->result = WEFT_ERR_MEMORY;
        return false;
    }
    if (p->states[number] == STATE_FIT)
        return true;
    if (p->states[number] == STATE_NAN) {
        paint_missing(p, run);
        p->count += (uint64_t)run->count;
        return true;
    }
    load_box(p, number);
    set_block(p, run->x, run->y);
    for (int i = 0; i < run->count; i++)
        paint_pixel(p, run->x + i, run->y);
    return true;
}

enum weft_result
weft_slice_exact_paint_from(const struct weft_slice_plan *plan, const struct weft_slice_tile *tile,
                            const weft_brick_store *store, const struct weft_slice_pixels *pixels,
                            const struct weft_progress *progress, double fraction, uint64_t *count)
{
    struct painter *p = malloc(sizeof *p);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (!p)
        goto fail;
    *p = (struct painter){.plan = plan,
                          .store = store,
                          .pixels = *pixels,
                          .progress = progress,
                          .fraction = fraction,
                          .boxed = WEFT_CELL_NONE,
                          .block_x = -1,
                          .row = -1};
    const struct weft_rectangle at = weft_slice_tile_part(plan, tile);
    weft_slice_grid_walk(&plan->footprint->grid, at.x, at.y, at.width, at.height, paint_run, p);
    res = p->result;
    *count += p->count;
    weft_cell_map_destroy(&p->map);
    free(p->states);
    free(p);
fail:
    if (res == WEFT_ERR_MEMORY)
        weft_error(plan->log, "not enough memory for the pixels near voxels that are not finite");
    return res;
}

enum weft_result weft_slice_exact_paint(const struct weft_slice_plan *plan, int tile,
                                        uint64_t other_bytes,
                                        const struct weft_slice_pixels *pixels,
                                        const struct weft_progress *progress, double fraction,
                                        uint64_t *count)
{
    const struct weft_cell_map *bricks;
    const weft_brick_store *store = NULL;
    enum weft_result res = weft_slice_tile_bricks(plan, tile, &bricks);
    if (res == WEFT_OK)
        res = weft_footprint_load(plan->footprint, bricks, other_bytes, &store);
    return res == WEFT_OK ? weft_slice_exact_paint_from(plan, &plan->tiles[tile], store, pixels,
                                                        progress, fraction, count)
                          : res;
}
