// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/blocks.h"

#include <math.h>
#include <stdlib.h>

#include "passes/fused/exact.h"

enum weft_result weft_slice_blocks_create(const struct weft_slice_plan *plan,
                                          struct weft_slice_blocks *out)
{
    size_t cells = 0;
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_cells *own = plan->tile_plans[i].cells;
        cells = own && own->map.count > cells ? own->map.count : cells;
    }
    // malloc(0) may be NULL: one more than needed.
    *out = (struct weft_slice_blocks){
        .entries = malloc((cells + 1) * sizeof *out->entries),
        .classes = malloc(cells + 1),
        .constants = malloc((cells + 1) * sizeof *out->constants),
    };
    if (out->entries && out->classes && out->constants)
        return WEFT_OK;
    weft_error(plan->log, "not enough memory to lay out %zu cells", cells);
    weft_slice_blocks_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_slice_blocks_destroy(struct weft_slice_blocks *blocks)
{
    free(blocks->entries);
    free(blocks->classes);
    free(blocks->constants);
    *blocks = (struct weft_slice_blocks){.texels = NULL};
}

void weft_slice_blocks_set_constant(struct weft_slice_blocks *b, size_t cell, float value)
{
    b->constants[b->constant_count] = value;
    b->entries[cell] = ~(int32_t)b->constant_count++;
    b->classes[cell] = WEFT_CELL_CONSTANT;
}

void weft_slice_blocks_set(struct weft_slice_blocks *b, size_t cell, size_t texel,
                           enum weft_cell_class class)
{
    b->smooth_count += class == WEFT_CELL_SMOOTH;
    b->entries[cell] = (int32_t)texel;
    b->classes[cell] = (uint8_t) class;
}

// ---- what samples are ---------------------------------------------------------------------------

struct weft_sample_box weft_sample_box_of(const float *at, const int size[3], const int span[3])
{
    return (struct weft_sample_box){
        at, {size[0], size[1], size[2]}, {1, span[0], span[0] * span[1]}};
}

// What a compiler makes vectors of: as many at a time, of rows that are longer.
enum { LANES = 16 };

static void widen(struct weft_sample_range *b, float low, float high, float zero)
{
    b->low = low < b->low ? low : b->low;
    b->high = high > b->high ? high : b->high;
    b->finite &= zero == 0.0f; // finite numbers times zero are zero; anything else is NaN
}

static void widen_by_row(struct weft_sample_range *b, const float *row, size_t count)
{
    float low[LANES], high[LANES], zero[LANES] = {0};
    size_t i = 0;
    if (count >= LANES) {
        for (int l = 0; l < LANES; l++)
            low[l] = high[l] = row[l];
        for (; i + LANES <= count; i += LANES) {
            for (int l = 0; l < LANES; l++) {
                const float x = row[i + (size_t)l];
                low[l] = x < low[l] ? x : low[l];
                high[l] = x > high[l] ? x : high[l];
                zero[l] += x * 0.0f;
            }
        }
        for (int l = 0; l < LANES; l++)
            widen(b, low[l], high[l], zero[l]);
    }
    for (; i < count; i++)
        widen(b, row[i], row[i], row[i] * 0.0f);
}

struct weft_sample_range weft_sample_box_range(const struct weft_sample_box *s)
{
    const bool packed = s->pitch[1] == s->size[0] && s->pitch[2] == s->size[0] * s->size[1];
    struct weft_sample_range b = {s->at[0], s->at[0], true};
    const int rows = packed ? 1 : s->size[1], slices = packed ? 1 : s->size[2];
    const size_t row = (size_t)s->size[0] * (packed ? (size_t)s->size[1] * (size_t)s->size[2] : 1);
    for (int z = 0; z < slices; z++)
        for (int y = 0; y < rows; y++)
            widen_by_row(&b, s->at + z * s->pitch[2] + y * s->pitch[1], row);
    if (b.low == b.high) // of zeros of either sign the first
        b.low = b.high = s->at[0];
    return b;
}

float weft_sample_box_second_difference(const struct weft_sample_box *s, int axis)
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

bool weft_sample_range_fit(const struct weft_slice_plan *plan,
                           const struct weft_sample_range *range)
{
    return range->finite && !weft_slice_unfit(plan, range->low) &&
           !weft_slice_unfit(plan, range->high);
}

bool weft_sample_range_constant(const struct weft_slice_plan *plan,
                                const struct weft_sample_range *range, float *value)
{
    const int axes = plan->axes.summed ? 2 : 3;
    *value = (float)(0.5 * ((double)range->low + range->high));
    const double half = 0.5 * ((double)range->high - range->low) + 0x1p-24 * fabs(*value);
    return range->finite && half * pow(plan->smooth.gain, axes) <= plan->smooth.error;
}

bool weft_sample_range_smooth(const struct weft_slice_plan *plan,
                              const struct weft_sample_range *range, const float second[3])
{
    const struct weft_slice_smooth *smooth = &plan->smooth;
    const int axes = plan->axes.summed ? 2 : 3;
    double error = 0.0, weight = smooth->curvature;
    if (!(smooth->curvature > 0.0) || !range->finite)
        return false;
    for (int axis = axes - 1; axis >= 0; axis--, weight *= smooth->gain)
        error += weight * (double)second[axis];
    // What forming the differences in single precision rounds: 4 units of the samples each.
    double magnitude = fmax(fabs(range->low), fabs(range->high));
    return error + axes * weight * 4.0 * 0x1p-24 * magnitude <= smooth->error;
}
