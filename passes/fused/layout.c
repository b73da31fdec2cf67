// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/fused/exact.h"

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

static size_t product(const int size[3])
{
    return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

// Voxels that a cell's block is made of, by axis of the volume.
static void box_span(const struct weft_slice_axes *axes, const struct weft_block_layout *layout,
                     int span[3])
{
    for (int i = 0; i < 3; i++)
        span[axes->order[i]] = i == 2 && axes->summed ? axes->kept : layout->span[i];
}

enum weft_result weft_slice_layout_create(const struct weft_slice_plan *plan,
                                          struct weft_slice_layout *out)
{
    size_t box = 0, block = 0, cells = 0;
    *out = (struct weft_slice_layout){.plan = plan};
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_tile_plan *tile = &plan->tile_plans[i];
        int span[3];
        box_span(&plan->axes, &tile->layout, span);
        box = larger(box, product(span));
        block = larger(block, product(tile->layout.span));
        cells = larger(cells, tile->cells ? tile->cells->map.count : 0);
    }
    // malloc(0) may be NULL: one more than needed.
    out->box = malloc((box + 1) * sizeof *out->box);
    out->block = malloc((block + 1) * sizeof *out->block);
    out->constants = malloc((cells + 1) * sizeof *out->constants);
    out->entries = malloc((cells + 1) * sizeof *out->entries);
    out->classes = malloc(cells + 1);
    if (out->box && out->block && out->constants && out->entries && out->classes)
        return WEFT_OK;
    weft_error(plan->log, "not enough memory to lay out %zu cells", cells);
    weft_slice_layout_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_slice_layout_destroy(struct weft_slice_layout *layout)
{
    free(layout->box);
    free(layout->block);
    free(layout->constants);
    free(layout->entries);
    free(layout->classes);
    *layout = (struct weft_slice_layout){0};
}

// ---- one cell -----------------------------------------------------------------------------------

// A box of samples in memory: [z][y][x], x fastest.
struct samples {
    const float *at;
    int size[3], pitch[3]; // samples along each axis, and floats between them
};

static struct samples samples_of(const float *at, const int size[3], const int span[3])
{
    return (struct samples){at, {size[0], size[1], size[2]}, {1, span[0], span[0] * span[1]}};
}

struct bounds {
    float low, high;
    bool finite;
};

static struct bounds range_of(const struct samples *s)
{
    struct bounds b = {s->at[0], s->at[0], true};
    float sum = 0.0f; // finite numbers times zero are zero; anything else is NaN
    for (int z = 0; z < s->size[2]; z++) {
        for (int y = 0; y < s->size[1]; y++) {
            const float *row = s->at + z * s->pitch[2] + y * s->pitch[1];
            for (int x = 0; x < s->size[0]; x++) {
                b.low = row[x] < b.low ? row[x] : b.low;
                b.high = row[x] > b.high ? row[x] : b.high;
                sum += row[x] * 0.0f;
            }
        }
    }
    b.finite = sum == 0.0f;
    return b;
}

// Largest |f_k-1 - 2 f_k + f_k+1| along an axis; +INFINITY where a sample is not finite.
static double second_difference(const struct samples *s, int axis)
{
    float largest = 0.0f, sum = 0.0f;
    const int step = s->pitch[axis];
    int from[3] = {0}, to[3] = {s->size[0], s->size[1], s->size[2]};
    from[axis]++;
    to[axis]--;
    for (int z = from[2]; z < to[2]; z++) {
        for (int y = from[1]; y < to[1]; y++) {
            const float *row = s->at + z * s->pitch[2] + y * s->pitch[1];
            for (int x = from[0]; x < to[0]; x++) {
                float d = (row[x - step] - row[x]) + (row[x + step] - row[x]);
                largest = fabsf(d) > largest ? fabsf(d) : largest;
                sum += d * 0.0f;
            }
        }
    }
    return sum == 0.0f ? largest : INFINITY;
}

static bool is_smooth(const struct weft_slice_plan *plan, const struct samples *block,
                      const struct bounds *range)
{
    const struct weft_slice_smooth *smooth = &plan->smooth;
    const int axes = plan->axes.summed ? 2 : 3;
    double error = 0.0, weight = smooth->curvature;
    if (!(smooth->curvature > 0.0) || !range->finite)
        return false;
    for (int axis = axes - 1; axis >= 0; axis--, weight *= smooth->gain)
        error += weight * second_difference(block, axis);
    // What forming the differences in single precision rounds: 4 units of the samples each.
    double magnitude = fmax(fabs(range->low), fabs(range->high));
    return error + axes * weight * 4.0 * 0x1p-24 * magnitude <= smooth->error;
}

static void replace_unfit(struct weft_slice_layout *l, float *box, const int size[3],
                          const int span[3])
{
    for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++)
            weft_slice_replace_unfit(l->plan, box + (z * span[1] + y) * span[0], (size_t)size[0]);
    l->any_unfit = true;
}

static void set_constant(struct weft_slice_layout *l, size_t cell, float value)
{
    l->constants[l->constant_count] = value;
    l->entries[cell] = ~(int32_t)l->constant_count++;
    l->classes[cell] = WEFT_CELL_CONSTANT;
}

// The cell's voxels as they are laid out in l->block, zeros past its own; or its class alone if one
// value does for all.
static enum weft_cell_class make_block(struct weft_slice_layout *l, const weft_brick_store *store,
                                       size_t number, float *value)
{
    const struct weft_slice_plan *plan = l->plan;
    const struct weft_slice_axes *axes = &plan->axes;
    const int *order = axes->order, *block_span = l->block_layout.span;
    int32_t min[3], max[3];
    int size[3], span[3], block_size[3] = {1, 1, 1};
    weft_slice_cell_box(plan, number, min, max);
    for (int a = 0; a < 3; a++)
        size[a] = max[a] - min[a] + 1;
    box_span(axes, &l->block_layout, span);
    for (int i = 0; i < (axes->summed ? 2 : 3); i++)
        block_size[i] = size[order[i]];
    // Aligned rows begin where the cell does: zeros before what is in reach.
    const int lead =
        l->block_layout.kind == WEFT_LAYOUT_ALIGNED ? plan->cells->at[number].low[order[0]] : 0;
    float *block = l->block + lead, *box = axes->summed ? l->box : block;
    if (product(block_size) < product(block_span))
        memset(l->block, 0, sizeof *l->block * product(block_span));
    weft_brick_store_copy_box(store, min, size, span, box);

    struct samples samples = samples_of(box, size, span);
    struct bounds range = range_of(&samples);
    const bool fit =
        range.finite && !weft_slice_unfit(plan, range.low) && !weft_slice_unfit(plan, range.high);
    *value = range.low;
    if (plan->info.savings & WEFT_SAVING_CONSTANT && range.finite && range.low == range.high)
        return WEFT_CELL_CONSTANT;
    if (!fit)
        replace_unfit(l, box, size, span);
    if (axes->summed)
        weft_slice_sum_planes(axes, box, size, span, block, block_span[0]);
    if (fit && plan->smooth.error > 0.0) {
        samples = samples_of(block, block_size, block_span);
        range = range_of(&samples);
        *value = (float)(0.5 * ((double)range.low + range.high));
        double half = 0.5 * ((double)range.high - range.low) + 0x1p-24 * fabs(*value);
        if (range.finite &&
            half * pow(plan->smooth.gain, axes->summed ? 2 : 3) <= plan->smooth.error)
            return WEFT_CELL_CONSTANT;
        if (is_smooth(plan, &samples, &range))
            return WEFT_CELL_SMOOTH;
    }
    return WEFT_CELL_FULL;
}

// ---- tiles --------------------------------------------------------------------------------------

void weft_slice_layout_write(struct weft_slice_layout *l, const struct weft_slice_tile_plan *tile,
                             const weft_brick_store *store, char *source)
{
    const struct weft_slice_axes *axes = &l->plan->axes;
    l->block_layout = tile->layout;
    const int last[3] = {7, 7, axes->summed ? 0 : 7};
    size_t at = weft_block_layout_offset(&l->block_layout, last) + 1;
    memset(source, 0, at * l->block_layout.texel_bytes);
    l->constant_count = 0;
    l->any_unfit = false;
    for (size_t i = 0; i < tile->cells->map.count; i++) {
        const struct weft_slice_content *content = &tile->content[i];
        const struct weft_slice_cell *cell = &l->plan->cells->at[content->number];
        float value = content->value;
        enum weft_cell_class class = WEFT_CELL_CONSTANT;
        if (!content->constant) {
            class = make_block(l, store, content->number, &value);
            l->cells_constant += class == WEFT_CELL_CONSTANT;
            l->cells_smooth += class == WEFT_CELL_SMOOTH;
        }
        if (class == WEFT_CELL_CONSTANT) {
            set_constant(l, i, value);
            continue;
        }
        int low[3];
        for (int a = 0; a < 3; a++)
            low[a] = a == 2 && axes->summed ? 0 : cell->low[axes->order[a]];
        if (tile->layout.kind == WEFT_LAYOUT_ALIGNED)
            low[0] = 0;
        weft_block_layout_write(&l->block_layout, &l->plan->range, l->block,
                                source + at * l->block_layout.texel_bytes);
        l->entries[i] = (int32_t)(at - weft_block_layout_offset(&l->block_layout, low));
        l->classes[i] = (uint8_t) class;
        at += l->block_layout.block_texels;
    }
}
