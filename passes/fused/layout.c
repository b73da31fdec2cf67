// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/layout.h"

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
    size_t box = 0, block = 0;
    *out = (struct weft_slice_layout){.plan = plan};
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_tile_plan *tile = &plan->tile_plans[i];
        int span[3];
        box_span(&plan->axes, &tile->layout, span);
        box = larger(box, product(span));
        block = larger(block, product(tile->layout.span));
    }
    // malloc(0) may be NULL: one more than needed.
    out->box = malloc((box + 1) * sizeof *out->box);
    out->block = malloc((block + 1) * sizeof *out->block);
    if (out->box && out->block)
        return WEFT_OK;
    weft_error(plan->log, "not enough memory to lay out a cell of %zu voxels", box);
    weft_slice_layout_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_slice_layout_destroy(struct weft_slice_layout *layout)
{
    free(layout->box);
    free(layout->block);
    *layout = (struct weft_slice_layout){.plan = NULL};
}

// ---- one cell -----------------------------------------------------------------------------------

static void replace_unfit(const struct weft_slice_layout *l, float *box, const int size[3],
                          const int span[3])
{
    for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++)
            weft_slice_replace_unfit(l->plan, box + (z * span[1] + y) * span[0], (size_t)size[0]);
}

// The class of the samples of a block, all of which are fit; the value of a constant one.
static enum weft_cell_class classify(const struct weft_slice_plan *plan,
                                     const struct weft_sample_box *block, float *value)
{
    const struct weft_sample_range range = weft_sample_box_range(block);
    float second[3];
    if (weft_sample_range_constant(plan, &range, value))
        return WEFT_CELL_CONSTANT;
    for (int a = 0; a < (plan->axes.summed ? 2 : 3); a++)
        second[a] = weft_sample_box_second_difference(block, a);
    return weft_sample_range_smooth(plan, &range, second) ? WEFT_CELL_SMOOTH : WEFT_CELL_FULL;
}

// The cell's voxels as they are laid out in l->block, zeros past its own; or its class alone if one
// value does for all.
static enum weft_cell_class make_block(const struct weft_slice_layout *l,
                                       const weft_brick_store *store, size_t number,
                                       struct weft_slice_blocks *out, float *value)
{
    const struct weft_slice_plan *plan = l->plan;
    const struct weft_slice_axes *axes = &plan->axes;
    const int *order = axes->order, *block_span = out->layout.span;
    int32_t min[3], max[3];
    int size[3], span[3], block_size[3] = {1, 1, 1};
    weft_slice_cell_box(plan, number, min, max);
    for (int a = 0; a < 3; a++)
        size[a] = max[a] - min[a] + 1;
    box_span(axes, &out->layout, span);
    for (int i = 0; i < (axes->summed ? 2 : 3); i++)
        block_size[i] = size[order[i]];
    // Aligned rows begin where the cell does: zeros before what is in reach.
    const int lead =
        out->layout.kind == WEFT_LAYOUT_ALIGNED ? plan->cells->at[number].low[order[0]] : 0;
    float *block = l->block + lead, *box = axes->summed ? l->box : block;
    if (product(block_size) < product(block_span))
        memset(l->block, 0, sizeof *l->block * product(block_span));
    weft_brick_store_copy_box(store, min, size, span, NULL, box);

    const struct weft_sample_box samples = weft_sample_box_of(box, size, span);
    const struct weft_sample_range range = weft_sample_box_range(&samples);
    const bool fit = weft_sample_range_fit(plan, &range);
    *value = range.low;
    if (plan->info.savings & WEFT_SAVING_CONSTANT && range.finite && range.low == range.high)
        return WEFT_CELL_CONSTANT;
    if (!fit)
        replace_unfit(l, box, size, span);
    out->any_unfit |= !fit;
    if (axes->summed)
        weft_slice_sum_planes(axes, box, size, span, block, block_span[0]);
    if (!fit || !(plan->smooth.error > 0.0))
        return WEFT_CELL_FULL;
    const struct weft_sample_box own = weft_sample_box_of(block, block_size, block_span);
    return classify(plan, &own, value);
}

// ---- tiles --------------------------------------------------------------------------------------

void weft_slice_layout_write(const struct weft_slice_layout *l,
                             const struct weft_slice_tile_plan *tile, const weft_brick_store *store,
                             char *source, struct weft_slice_blocks *out)
{
    const struct weft_slice_axes *axes = &l->plan->axes;
    out->layout = tile->layout;
    out->lead = 0;
    const int last[3] = {7, 7, axes->summed ? 0 : 7};
    size_t at = weft_block_layout_offset(&out->layout, last) + 1;
    memset(source, 0, at * out->layout.texel_bytes);
    out->constant_count = out->smooth_count = 0;
    out->any_unfit = false;
    for (size_t i = 0; i < tile->cells->map.count; i++) {
        const struct weft_slice_content *content = &tile->content[i];
        const struct weft_slice_cell *cell = &l->plan->cells->at[content->number];
        float value = content->value;
        enum weft_cell_class class = WEFT_CELL_CONSTANT;
        if (!content->constant) {
            class = make_block(l, store, content->number, out, &value);
            out->cells_constant += class == WEFT_CELL_CONSTANT;
            out->cells_smooth += class == WEFT_CELL_SMOOTH;
        }
        if (class == WEFT_CELL_CONSTANT) {
            weft_slice_blocks_set_constant(out, i, value);
            continue;
        }
        int low[3];
        for (int a = 0; a < 3; a++)
            low[a] = a == 2 && axes->summed ? 0 : cell->low[axes->order[a]];
        if (tile->layout.kind == WEFT_LAYOUT_ALIGNED)
            low[0] = 0;
        weft_block_layout_write(&out->layout, &l->plan->range, l->block,
                                source + at * out->layout.texel_bytes);
        weft_slice_blocks_set(out, i, at - weft_block_layout_offset(&out->layout, low), class);
        at += out->layout.block_texels;
    }
}
