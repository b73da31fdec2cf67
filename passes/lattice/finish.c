// SPDX-License-Identifier: BSD-3-Clause
// From derivatives to a grid's bricks: channels, what is active, what is a tile.
#include <string.h>

#include "passes/lattice/lattice_impl.h"

static bool same(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

void weft_lattice_channels(const struct weft_lattice_work *work, const double *derivative,
                           const size_t pitch[3], const int32_t origin[3], float *const *channel)
{
    const struct weft_lattice_plan *plan = work->plan;
    const struct weft_lattice_box *box = &work->block->box;
    const int count = plan->info.derivative_count;
    const size_t output = (size_t)(box->max[0] - box->min[0] + 1) *
                          (size_t)(box->max[1] - box->min[1] + 1) *
                          (size_t)(box->max[2] - box->min[2] + 1);
    float rounded[WEFT_DERIVATIVES][WEFT_BRICK_VOXELS];
    const float *planes[WEFT_DERIVATIVES];
    for (int d = 0; d < count; d++) {
        const double *start = derivative + (size_t)d * output;
        float *out = plan->plain ? channel[d] : rounded[d];
        for (int a = 0; a < 3; a++)
            start += (size_t)(origin[a] - box->min[a]) * pitch[a];
        for (size_t z = 0; z < 8; z++)
            for (size_t y = 0; y < 8; y++)
                for (size_t x = 0; x < 8; x++)
                    out[z << 6 | y << 3 | x] =
                        (float)start[z * pitch[2] + y * pitch[1] + x * pitch[0]];
        planes[d] = rounded[d];
    }
    if (!plan->plain)
        weft_quantities_compute_planes(&plan->quantities, &plan->transform, WEFT_BRICK_VOXELS,
                                       planes, channel);
}

bool weft_lattice_is_made(const struct weft_lattice_plan *plan, const int64_t r[3])
{
    const struct weft_lattice_info *info = &plan->info;
    const struct weft_volume_info *source = weft_volume_get_info(plan->volume);
    for (int a = 0; plan->boxed && a < 3; a++)
        if (r[a] < info->box_min[a] || r[a] > info->box_max[a])
            return false;
    for (int a = 0; plan->clamped && a < 3; a++) {
        const double at = weft_lattice_at(info->to_source[a], r);
        if (at < source->active_min[a] - 0.5 || at > source->active_max[a] + 0.5)
            return false;
    }
    return true;
}

// Whether all voxels of a brick's row are made, or of all of it (rows = 8), by its corners:
// positions are affine, and rounded monotonically.
static bool all_made(const struct weft_lattice_plan *plan, const int64_t first[3], int rows)
{
    for (int corner = 0; corner < (rows == 1 ? 2 : 8); corner++) {
        const int64_t r[3] = {first[0] + (corner & 1 ? WEFT_BRICK_SIZE - 1 : 0),
                              first[1] + (corner & 2 ? rows - 1 : 0),
                              first[2] + (corner & 4 ? rows - 1 : 0)};
        if (!weft_lattice_is_made(plan, r))
            return false;
    }
    return true;
}

static void leave_out(const struct weft_lattice_plan *plan, const int32_t origin[3], int components,
                      float background, float *values)
{
    const int64_t first[3] = {origin[0], origin[1], origin[2]};
    if ((!plan->boxed && !plan->clamped) || all_made(plan, first, WEFT_BRICK_SIZE))
        return;
    for (int row = 0; row < WEFT_BRICK_VOXELS; row += WEFT_BRICK_SIZE) {
        int64_t r[3] = {first[0], first[1] + (row >> 3 & 7), first[2] + (row >> 6)};
        if (all_made(plan, r, 1))
            continue;
        for (int x = 0; x < WEFT_BRICK_SIZE; x++, r[0]++) {
            if (weft_lattice_is_made(plan, r))
                continue;
            for (int c = 0; c < components; c++)
                values[c * WEFT_BRICK_VOXELS + row + x] = background;
        }
    }
}

// A level set's: within the background, and the background where it is not active.
static void finish_level_set(const struct weft_lattice_plan *plan, float *values,
                             struct weft_lattice_made *made)
{
    const float most = fabsf(plan->background);
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        const float distance = fabsf(values[v]);
        made->clamped += distance > most;
        if ((double)distance < (double)most - plan->prune)
            made->active++;
        else if (distance == distance)
            values[v] = copysignf(most, values[v]);
    }
}

// NaN differs from everything.
static void finish_fog(const struct weft_lattice_plan *plan, int components, float background,
                       float *values, struct weft_lattice_made *made)
{
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        bool active = false;
        for (int c = 0; c < components; c++)
            active |= !(fabs((double)values[c * WEFT_BRICK_VOXELS + v] - (double)background) <=
                        plan->prune) &&
                      !same(values[c * WEFT_BRICK_VOXELS + v], background);
        made->active += active;
        for (int c = 0; !active && c < components; c++)
            values[c * WEFT_BRICK_VOXELS + v] = background;
    }
}

static bool is_constant(const float *values, size_t count)
{
    for (size_t i = 1; i < count; i++)
        if (!same(values[i], values[0]))
            return false;
    return true;
}

struct weft_lattice_made weft_lattice_finish(const struct weft_lattice_plan *plan, int grid,
                                             const int32_t origin[3], float *values)
{
    const struct weft_lattice_grid *out = &plan->info.grid[grid];
    const float background = out->grid.background;
    struct weft_lattice_made made = {.kind = WEFT_LATTICE_VALUES};
    leave_out(plan, origin, out->components, background, values);
    if (out->quantity == WEFT_QUANTITY_VALUE && plan->info.clamps)
        finish_level_set(plan, values, &made);
    else
        finish_fog(plan, out->components, background, values, &made);
    for (int v = 0; v < out->components * WEFT_BRICK_VOXELS; v++)
        made.not_finite += !isfinite(values[v]);
    const bool constant = out->components == 1 && is_constant(values, WEFT_BRICK_VOXELS);
    if (!made.active && (out->components > 1 || (constant && same(values[0], background))))
        made.kind = WEFT_LATTICE_NONE;
    else if (constant) {
        made.kind = WEFT_LATTICE_TILE;
        made.constant = values[0];
    }
    return made;
}
