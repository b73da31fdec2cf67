// SPDX-License-Identifier: BSD-3-Clause
// Weights along the result's axes, where they run along the source's.
#include <stdlib.h>

#include "passes/lattice/lattice_impl.h"

void weft_lattice_memo_clear(struct weft_lattice_memo *memo)
{
    for (size_t i = 0; i < memo->known.count; i++)
        free(memo->weights[i]);
    free(memo->weights);
    weft_cell_map_destroy(&memo->known);
    *memo = (struct weft_lattice_memo){.capacity = 0};
}

static struct weft_lattice_weights *make(const struct weft_lattice_plan *plan, int axis,
                                         int32_t origin)
{
    const struct weft_lattice_info *info = &plan->info;
    const int a = info->axis[axis];
    const size_t width = (size_t)info->width[a], block = WEFT_BRICK_SIZE * width;
    bool needed[WEFT_LATTICE_ORDERS] = {false};
    struct weft_lattice_weights *out = NULL;
    for (int d = 0; d < info->derivative_count; d++)
        needed[info->derivative[d].along[a]] = true;
    const size_t orders = (size_t)needed[0] + needed[1] + needed[2];
    out = calloc(1, sizeof *out + orders * block * sizeof(double));
    if (!out)
        return NULL;
    double *next = (double *)(out + 1);
    for (int order = 0; order < WEFT_LATTICE_ORDERS; order++) {
        if (!needed[order])
            continue;
        out->weight[order] = next;
        next += block;
        for (int i = 0; i < WEFT_BRICK_SIZE; i++) {
            int64_t r[3] = {0};
            r[axis] = (int64_t)origin + i;
            out->first[i] = weft_stretch_weights(&plan->kernel[order], info->stretch[a],
                                                 weft_lattice_at(info->to_source[a], r),
                                                 out->weight[order] + (size_t)i * width);
        }
    }
    return out;
}

const struct weft_lattice_weights *weft_lattice_memo_find(const struct weft_lattice_memo *memo,
                                                          int axis, int32_t origin)
{
    const struct weft_cell_key key = {{axis, origin, 0}};
    const int64_t at = weft_cell_map_find(&memo->known, key);
    return at == WEFT_CELL_NONE ? NULL : memo->weights[at];
}

const struct weft_lattice_weights *weft_lattice_memo_get(const struct weft_lattice_plan *plan,
                                                         struct weft_lattice_memo *memo, int axis,
                                                         int32_t origin)
{
    const struct weft_cell_key key = {{axis, origin, 0}};
    const struct weft_lattice_weights *found = weft_lattice_memo_find(memo, axis, origin);
    if (found)
        return found;
    if (memo->known.count == memo->capacity) {
        const size_t capacity = memo->capacity ? 2 * memo->capacity : 64;
        void *weights = realloc(memo->weights, capacity * sizeof *memo->weights);
        if (!weights)
            return NULL;
        memo->weights = weights;
        memo->capacity = capacity;
    }
    struct weft_lattice_weights *made = make(plan, axis, origin);
    if (!made)
        return NULL;
    const int64_t at = weft_cell_map_add(&memo->known, key);
    if (at == WEFT_CELL_NONE) {
        free(made);
        return NULL;
    }
    return memo->weights[at] = made;
}
