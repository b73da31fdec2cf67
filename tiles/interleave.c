// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/interleave.h"

#include <string.h>

static const char *const layout_names[] = {"auto", "interleaved", "aligned", "plain"};

const char *weft_layout_name(enum weft_layout layout)
{
    return (size_t)layout < WEFT_COUNT(layout_names) ? layout_names[layout] : "unknown";
}

enum weft_result weft_layout_parse(const struct weft_log *log, const char *text,
                                   enum weft_layout *out)
{
    for (size_t i = 0; i < WEFT_COUNT(layout_names); i++) {
        if (strcmp(text, layout_names[i]) == 0) {
            *out = (enum weft_layout)i;
            return WEFT_OK;
        }
    }
    weft_error(log, "unknown layout '%.64s'; there are: auto, interleaved, aligned, plain", text);
    return WEFT_ERR_ARGUMENT;
}

int weft_layout_row_fetches(enum weft_layout kind, int width)
{
    switch (kind) {
    case WEFT_LAYOUT_INTERLEAVED:
        return (width + 3) / 4;
    case WEFT_LAYOUT_ALIGNED:
        return (width + 3 + 3) / 4; // the row may begin at any of a texel's four samples
    default:
        return width;
    }
}

void weft_block_layout_init(struct weft_block_layout *layout, enum weft_layout kind, int width,
                            const int starts[3])
{
    // Aligned rows begin at the cell's own start, whose samples are multiples of four apart.
    int starts_x = kind == WEFT_LAYOUT_ALIGNED ? WEFT_BRICK_SIZE : starts[0];
    *layout = (struct weft_block_layout){
        .kind = kind,
        .width = width,
        .span = {starts_x + width - 1, starts[1] + width - 1, starts[2] + width - 1},
        .texel_bytes = kind == WEFT_LAYOUT_PLAIN ? 4 : 16,
    };
    int fetches = weft_layout_row_fetches(kind, width);
    switch (kind) {
    case WEFT_LAYOUT_INTERLEAVED:
        layout->row_texels = starts_x + 4 * (fetches - 1);
        break;
    case WEFT_LAYOUT_ALIGNED:
        layout->row_texels = (WEFT_BRICK_SIZE - 1) / 4 + fetches;
        break;
    default:
        layout->row_texels = layout->span[0];
    }
    layout->block_texels =
        (size_t)layout->row_texels * (size_t)layout->span[1] * (size_t)layout->span[2];
}

size_t weft_block_layout_offset(const struct weft_block_layout *layout, const int start[3])
{
    int x = layout->kind == WEFT_LAYOUT_ALIGNED ? start[0] / 4 : start[0];
    return ((size_t)start[2] * (size_t)layout->span[1] + (size_t)start[1]) *
               (size_t)layout->row_texels +
           (size_t)x;
}

void weft_block_layout_write(const struct weft_block_layout *layout, const float *voxels,
                             void *texels)
{
    enum { MAX_ROW = 64 };
    float row[MAX_ROW] = {0}; // zeros past the span
    float *out = texels;
    size_t rows = (size_t)layout->span[1] * (size_t)layout->span[2];
    size_t span = (size_t)layout->span[0], row_texels = (size_t)layout->row_texels;
    for (size_t r = 0; r < rows; r++, voxels += span) {
        memcpy(row, voxels, span * sizeof *row);
        if (layout->kind == WEFT_LAYOUT_INTERLEAVED) {
            for (size_t i = 0; i < row_texels; i++, out += 4)
                memcpy(out, row + i, 4 * sizeof *row);
        } else {
            size_t count = row_texels * layout->texel_bytes / sizeof *row;
            memcpy(out, row, count * sizeof *row);
            out += count;
        }
    }
}

static int32_t brick_start(int32_t voxel)
{
    return voxel & ~(WEFT_BRICK_SIZE - 1);
}

// The part of a box that lies in the brick at `origin`: from[a] to to[a], exclusive, box-relative.
static void clip_to_brick(const int32_t min[3], const int size[3], const int32_t origin[3],
                          int from[3], int to[3])
{
    for (int a = 0; a < 3; a++) {
        from[a] = origin[a] < min[a] ? 0 : origin[a] - min[a];
        to[a] = origin[a] + WEFT_BRICK_SIZE - min[a];
        if (to[a] > size[a])
            to[a] = size[a];
    }
}

static void copy_brick(const weft_brick_store *store, const int32_t origin[3], const int32_t min[3],
                       const int size[3], const int pitch[3], float *out)
{
    float scratch[WEFT_BRICK_VOXELS];
    const float *values;
    float constant;
    int from[3], to[3];
    clip_to_brick(min, size, origin, from, to);
    enum weft_brick_kind kind = weft_brick_store_find(store, origin, &values, &constant);
    if (kind == WEFT_BRICK_EDGE) {
        weft_brick_store_copy(store, origin, scratch);
        values = scratch;
    }
    for (int z = from[2]; z < to[2]; z++) {
        for (int y = from[1]; y < to[1]; y++) {
            float *row = out + (z * pitch[1] + y) * pitch[0];
            if (kind == WEFT_BRICK_CONSTANT) {
                for (int x = from[0]; x < to[0]; x++)
                    row[x] = constant;
                continue;
            }
            int32_t line = ((min[2] + z - origin[2]) * WEFT_BRICK_SIZE + min[1] + y - origin[1]) *
                               WEFT_BRICK_SIZE +
                           min[0] + from[0] - origin[0];
            memcpy(row + from[0], values + line, (size_t)(to[0] - from[0]) * sizeof *row);
        }
    }
}

void weft_brick_store_copy_box(const weft_brick_store *store, const int32_t min[3],
                               const int size[3], const int pitch[3], float *out)
{
    int32_t at[3];
    for (at[2] = brick_start(min[2]); at[2] < min[2] + size[2]; at[2] += WEFT_BRICK_SIZE)
        for (at[1] = brick_start(min[1]); at[1] < min[1] + size[1]; at[1] += WEFT_BRICK_SIZE)
            for (at[0] = brick_start(min[0]); at[0] < min[0] + size[0]; at[0] += WEFT_BRICK_SIZE)
                copy_brick(store, at, min, size, pitch, out);
}

bool weft_brick_store_box_constant(const weft_brick_store *store, const int32_t min[3],
                                   const int32_t max[3], float *constant)
{
    bool first = true;
    int32_t at[3];
    for (at[2] = brick_start(min[2]); at[2] <= max[2]; at[2] += WEFT_BRICK_SIZE) {
        for (at[1] = brick_start(min[1]); at[1] <= max[1]; at[1] += WEFT_BRICK_SIZE) {
            for (at[0] = brick_start(min[0]); at[0] <= max[0]; at[0] += WEFT_BRICK_SIZE) {
                const float *values;
                float value;
                if (weft_brick_store_find(store, at, &values, &value) != WEFT_BRICK_CONSTANT)
                    return false;
                // Bits, so that NaN equals itself and -0 stays apart from 0.
                if (!first && memcmp(&value, constant, sizeof value) != 0)
                    return false;
                *constant = value;
                first = false;
            }
        }
    }
    return true;
}
