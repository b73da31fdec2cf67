// SPDX-License-Identifier: BSD-3-Clause
// passes/slice/multipass.h - slices by plans of several passes (passes/plan/plan.h): what a target
// of limited precision makes of a cut through a volume. Pixels lie where weft_slice_run has them,
// at the same fixed-point positions (off by at most 2.4e-10 voxels). The slice is cut into
// rectangles, of which each has the voxels in reach in a dense box; the range of the voxels is
// fixed before the first, and positions are exact in every box, so that the result is the same in
// every bit however the slice is cut.
#ifndef WEFT_PASSES_SLICE_MULTIPASS_H
#define WEFT_PASSES_SLICE_MULTIPASS_H

#include <math.h>

#include "../multipass/multipass.h"
#include "slice.h"

WEFT_BEGIN_DECLS

struct weft_slice_multipass_params {
    const weft_slice_plan *slice; // required: kernel, geometry, and what is in reach
    const weft_pass_plan *plan;   // required: in 3D, of one channel and the slice's kernel
    weft_volume *volume;          // required: the one that the slice was planned for
    // The range mapped to [0, 1]; voxels outside are clamped to it. Both 0 or NAN: the finite
    // minimum and maximum of the voxels in reach, which are read once more for it. With a
    // prefiltered kernel voxels are coefficients, whose range is wider.
    double low, high;
    uint64_t memory_bytes; // bricks, boxes, textures, targets and tiles while running (default
                           // 1 GiB); the caller's pixels are not counted
    float *pixels;         // required: [y * width + x]
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;
};
#define weft_slice_multipass_params(...) (&(struct weft_slice_multipass_params){__VA_ARGS__})

struct weft_slice_multipass_report {
    double low, high; // the range that was mapped: the plan's bounds are in units of its width
    // Voxels in reach that are outside it or not finite, counted in every rectangle that has them.
    uint64_t clamped;
    uint64_t not_finite;    // pixels, NAN all of them
    float minimum, maximum; // of the finite pixels; NAN if there are none
    int rectangles;
    int passes;           // over all rectangles
    uint64_t bricks_read; // in this run: those that were not kept already
    uint64_t uploaded_bytes;
    uint64_t peak_bytes; // of bricks, boxes, textures, targets and tiles
    double measure_seconds, read_seconds, layout_seconds;
    double prepare_seconds, upload_seconds, pass_seconds, readback_seconds; // weft_multipass_run's
    // On the CPU only: stores that clamped over all passes, and by how many codes at most.
    uint64_t clamps;
    double largest_clamp;
};

// Without a context (NULL) the passes run on the CPU, in the same integers. The values of a plan
// with a derivative are per voxel. report may be NULL. Returns WEFT_ERR_ARGUMENT (the plan is not
// one for this slice; a range without width), WEFT_ERR_LIMIT (what the smallest rectangle needs and
// the limit are in the log), WEFT_ERR_CANCELLED, and what weft_volume_read and weft_multipass_run
// return.
WEFT_API enum weft_result weft_slice_multipass_run(weft_context *context,
                                                   const struct weft_slice_multipass_params *params,
                                                   struct weft_slice_multipass_report *report);

// The terms of |pixel - exact| for weft_bound_compute: those of the plan of passes, what the grid's
// numbers lose as floats, and positions, which are off by their rounding to fixed point.
WEFT_API struct weft_bound_terms weft_slice_multipass_bound_terms(const weft_slice_plan *slice,
                                                                  const weft_pass_plan *plan);

// What both kinds of slices report.
WEFT_API struct weft_slice_report
weft_slice_multipass_summary(const struct weft_slice_multipass_report *report);

WEFT_END_DECLS
#endif
