// SPDX-License-Identifier: BSD-3-Clause
// passes/verify/cardinal.h - what a prefiltered kernel makes of the voxels themselves, without
// coefficients: the truth for slices (not installed).
#ifndef WEFT_PASSES_VERIFY_CARDINAL_H
#define WEFT_PASSES_VERIFY_CARDINAL_H

#include "filter/analysis/reference.h"
#include "passes/fused/plan.h"

typedef struct weft_slice_samples weft_slice_samples;

// Finds which of the volume's bricks the plan's slice depends on; they are read through the plan's
// footprint when needed, up to 64 MiB at a time. statistics and shells are the footprint's: voxels
// count out to where what is left out is below some 2^-30 of the largest one at the taps. The plan
// is borrowed. Returns WEFT_ERR_ARGUMENT for kernels that are not prefiltered, WEFT_ERR_MEMORY, and
// what weft_volume_find returns.
enum weft_result weft_slice_samples_create(const struct weft_slice_plan *plan,
                                           const struct weft_slice_statistics *statistics,
                                           const struct weft_slice_shells *shells,
                                           weft_slice_samples **out);
void weft_slice_samples_destroy(weft_slice_samples **samples); // accepts &NULL

// The sum over voxels at a position in index coordinates, those that are not finite counting as 0;
// NAN where it is missing (weft_prefilter_is_missing; `finite`: whether what it is compared with is
// there). `derivative`: of the sum, in index space. magnitude is over the finite ones of the bricks
// that coefficients depend on by over 2^-32. Returns WEFT_ERR_MEMORY and what weft_volume_read
// returns.
enum weft_result weft_slice_samples_compute(weft_slice_samples *samples,
                                            const struct weft_derivative *derivative,
                                            const double position[3], bool finite,
                                            struct weft_reference_value *out);

// About how long one takes.
double weft_slice_samples_seconds(const weft_slice_samples *samples);

#endif
