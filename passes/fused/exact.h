// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/exact.h - pixels that single precision on GL does not do, in double on the CPU (not
// installed).
// A voxel is unfit that is NaN or infinite, or so large that sums of it by weights may overflow
// where the result does not. Engines read 0 in its place, and every pixel with an unfit voxel in
// its reach, whatever the weight, is then computed here: taps whose weight is exactly 0 do not
// count, and the sum is rounded to a float once. Which pixels those are does not depend on tiles or
// layouts, and where all voxels are fit engines do what they do without.
#ifndef WEFT_PASSES_FUSED_EXACT_H
#define WEFT_PASSES_FUSED_EXACT_H

#include "passes/fused/plan.h"

static inline bool weft_slice_unfit(const struct weft_slice_plan *plan, float voxel)
{
    return !(voxel >= -plan->largest_fit && voxel <= plan->largest_fit);
}

// Puts 0 in the place of unfit voxels; false where there were none.
bool weft_slice_replace_unfit(const struct weft_slice_plan *plan, float *voxels, size_t count);

// Where there were some: sources of fixed point, which hold a range, have nothing for what is not
// finite, unless no tap reaches it. Returns WEFT_ERR_UNSUPPORTED, and what
// weft_footprint_statistics does.
enum weft_result weft_slice_exact_check(const struct weft_slice_plan *plan,
                                        const struct weft_progress *progress);

// Repaints those pixels of a plan's tile that have an unfit voxel in reach and adds their number to
// *count. Voxels are read anew where the footprint has not kept them, in what other_bytes leave
// (weft_footprint_load). `fraction` is
// told to progress, which may be NULL. Returns WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED and what
// weft_volume_read returns.
enum weft_result weft_slice_exact_paint(const struct weft_slice_plan *plan, int tile,
                                        uint64_t other_bytes,
                                        const struct weft_slice_pixels *pixels,
                                        const struct weft_progress *progress, double fraction,
                                        uint64_t *count);

// The same for a rectangle of pixels, those of it that are the part's, whose voxels `store` has as
// they are. Returns WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED.
enum weft_result
weft_slice_exact_paint_from(const struct weft_slice_plan *plan, const struct weft_slice_tile *tile,
                            const weft_brick_store *store, const struct weft_slice_pixels *pixels,
                            const struct weft_progress *progress, double fraction, uint64_t *count);

#endif
