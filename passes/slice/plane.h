// SPDX-License-Identifier: BSD-3-Clause
// passes/slice/plane.h - the voxels in reach of a tile of a separable slice, summed along the axis
// that all its pixels share a coordinate of (not installed).
#ifndef WEFT_PASSES_SLICE_PLANE_H
#define WEFT_PASSES_SLICE_PLANE_H

#include "passes/fused/plan.h"

struct weft_slice_plane {
    int32_t min[3], max[3]; // of the voxels, inclusive
    int size[2];            // samples along the slice's rows and columns
    // [y][x]: floats; and NULL, or where the plan sums in double these, and no floats.
    float *samples;
    double *wide;
    double *x, *y; // the sample coordinate of every column and every row of the tile
};

// Bytes of so many samples.
static inline uint64_t weft_slice_plane_bytes(const struct weft_slice_plan *plan, const int size[2])
{
    return (plan->info.sums == WEFT_SUMS_DOUBLE ? sizeof(double) : sizeof(float)) *
           (uint64_t)size[0] * (uint64_t)size[1];
}

// Where a tile's samples and pixels lie, without room for samples; to be destroyed. On failure the
// plane is {0}. Returns WEFT_ERR_MEMORY.
enum weft_result weft_slice_plane_place(const struct weft_slice_plan *plan,
                                        const struct weft_slice_tile *tile,
                                        struct weft_slice_plane *out);
// The same, with room.
enum weft_result weft_slice_plane_create(const struct weft_slice_plan *plan,
                                         const struct weft_slice_tile *tile,
                                         struct weft_slice_plane *out);
void weft_slice_plane_destroy(struct weft_slice_plane *plane); // {0} is fine

// Sums the voxels of a store that holds the tile's bricks, in double, each sum rounded once where
// samples are floats. Voxels that are unfit (passes/fused/exact.h) count as 0. Returns whether all
// were fit. The same samples for any number of threads.
bool weft_slice_plane_fill(const struct weft_slice_plan *plan, const weft_brick_store *store,
                           int threads, struct weft_slice_plane *plane);

#endif
