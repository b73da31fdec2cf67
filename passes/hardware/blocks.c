// SPDX-License-Identifier: BSD-3-Clause
#include "passes/hardware/blocks.h"

#include <stdlib.h>
#include <string.h>

#include "passes/fused/exact.h"

// Voxels along a side of a block: those that taps reach, without the texel behind.
static int span_of(const struct weft_hardware_plan *plan)
{
    return plan->atlas.side - 1;
}

static size_t largest_tile(const struct weft_hardware_plan *plan)
{
    size_t cells = 0;
    for (int i = 0; i < plan->info.tile_count; i++)
        if (plan->tiles[i].cells->map.count > cells)
            cells = plan->tiles[i].cells->map.count;
    return cells;
}

enum weft_result weft_hardware_blocks_create(const struct weft_hardware_plan *plan,
                                             struct weft_hardware_blocks *out)
{
    const size_t side = (size_t)plan->atlas.side, cells = largest_tile(plan);
    const size_t voxels = side * side * side;
    *out = (struct weft_hardware_blocks){.plan = plan};
    out->plane_bytes = (size_t)weft_source_format_bytes(plan->slice->info.source) * side *
                       (size_t)plan->atlas.size[0] * (size_t)plan->atlas.size[1];
    out->entries = malloc(cells * sizeof *out->entries);
    out->plane = malloc(out->plane_bytes);
    out->box = malloc(voxels * sizeof *out->box);
    out->block = malloc(voxels * sizeof(float));
    if (out->entries && out->plane && out->box && out->block)
        return WEFT_OK;
    weft_error(plan->log, "not enough memory to lay out %zu cells", cells);
    weft_hardware_blocks_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_hardware_blocks_destroy(struct weft_hardware_blocks *blocks)
{
    free(blocks->entries);
    free(blocks->plane);
    free(blocks->box);
    free(blocks->block);
    *blocks = (struct weft_hardware_blocks){0};
}

void weft_hardware_blocks_begin(struct weft_hardware_blocks *b)
{
    b->count = 0;
    b->any_constant = b->any_unfit = false;
}

// ---- one block ----------------------------------------------------------------------------------

// The voxels that the cell's taps reach, with zeros around; false where they are one constant.
static bool load_box(struct weft_hardware_blocks *b, const struct weft_hardware_tile *tile,
                     const weft_brick_store *store, size_t cell, float *constant)
{
    const struct weft_slice_plan *slice = b->plan->slice;
    const int span = span_of(b->plan), pitch[3] = {span, span, span};
    int32_t min[3], max[3];
    int size[3];
    size_t at[3];
    weft_footprint_cell_box(slice->footprint, tile->cells, cell, min, max);
    if (slice->info.savings & WEFT_SAVING_CONSTANT &&
        weft_brick_store_box_constant(store, min, max, constant))
        return false;
    for (int a = 0; a < 3; a++) {
        const int32_t origin =
            tile->cells->map.keys[cell].at[a] * WEFT_BRICK_SIZE - slice->footprint->grid.tap_offset;
        at[a] = (size_t)(min[a] - origin);
        size[a] = max[a] - min[a] + 1;
    }
    const size_t row = (size_t)span;
    memset(b->box, 0, row * row * row * sizeof *b->box);
    float *first = b->box + (at[2] * row + at[1]) * row + at[0];
    weft_brick_store_copy_box(store, min, size, pitch, NULL, first);
    for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++)
            b->any_unfit |= weft_slice_replace_unfit(
                slice, first + ((size_t)z * row + (size_t)y) * row, (size_t)size[0]);
    return true;
}

static void fill_constant(struct weft_hardware_blocks *b, float value)
{
    const size_t span = (size_t)span_of(b->plan);
    for (size_t i = 0; i < span * span * span; i++)
        b->box[i] = value;
    b->any_unfit |= weft_slice_replace_unfit(b->plan->slice, b->box, span * span * span);
}

// Puts the box, as texels, where the next block lies. Returns its entry.
static int32_t write_block(struct weft_hardware_blocks *b)
{
    const struct weft_hardware_atlas *atlas = &b->plan->atlas;
    const int span = span_of(b->plan);
    const size_t texel = (size_t)weft_source_format_bytes(b->plan->slice->info.source);
    const struct weft_block_layout layout = {
        .kind = WEFT_LAYOUT_PLAIN,
        .format = b->plan->slice->info.source,
        .span = {span, span, span},
        .row_texels = span,
        .texel_bytes = texel,
    };
    const size_t row = (size_t)atlas->blocks[0], plane = row * (size_t)atlas->blocks[1];
    const size_t x = b->count % row, y = b->count % plane / row, z = b->count / plane;
    const size_t side = (size_t)atlas->side, length = (size_t)span * texel;
    const size_t pitch = (size_t)atlas->size[0] * texel;
    const char *in = b->block;
    weft_block_layout_write(&layout, &b->plan->slice->range, b->box, b->block);
    for (int k = 0; k < span; k++) {
        char *out =
            b->plane + ((size_t)k * (size_t)atlas->size[1] + y * side) * pitch + x * side * texel;
        for (int j = 0; j < span; j++, in += length, out += pitch)
            memcpy(out, in, length);
    }
    b->count++;
    return (int32_t)(x | y << 10 | z << 20);
}

// ---- planes -------------------------------------------------------------------------------------

static bool same_bits(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

void weft_hardware_blocks_fill(struct weft_hardware_blocks *b,
                               const struct weft_hardware_tile *tile, const weft_brick_store *store,
                               size_t *cell)
{
    const struct weft_hardware_atlas *atlas = &b->plan->atlas;
    const size_t plane = (size_t)atlas->blocks[0] * (size_t)atlas->blocks[1];
    const size_t last = (b->count / plane + 1) * plane;
    memset(b->plane, 0, b->plane_bytes);
    for (; *cell < tile->cells->map.count && b->count < last; ++*cell) {
        float constant;
        const bool boxed = load_box(b, tile, store, *cell, &constant);
        b->cells_constant += !boxed;
        if (!boxed && b->any_constant && same_bits(constant, b->constant)) {
            b->entries[*cell] = b->at;
            continue;
        }
        if (!boxed)
            fill_constant(b, constant);
        b->entries[*cell] = write_block(b);
        if (!boxed) {
            b->any_constant = true;
            b->constant = constant;
            b->at = b->entries[*cell];
        }
    }
}
