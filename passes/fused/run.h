// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/run.h - plans in one pass on GL: compiled once and run often (not installed).
#ifndef WEFT_PASSES_FUSED_RUN_H
#define WEFT_PASSES_FUSED_RUN_H

#include "filter/statistics.h"
#include "passes/fused/plan.h"
#include "passes/gl/context.h"

// Buffers, target and kernel tiles, sized for the plan's largest tile, and programs. Those that
// only some voxels need (smooth and constant cells) are made when the first of them are met.
typedef struct weft_fused weft_fused;

// For a plan that is not separable, which is borrowed, as is the context. Returns WEFT_ERR_LIMIT
// (the context's, with the numbers in the log), WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_fused_compile(weft_context *context, const weft_slice_plan *plan,
                                    weft_fused **out);
void weft_fused_destroy(weft_fused **fused); // accepts &NULL

struct weft_fused_report {
    double read_seconds, layout_seconds, upload_seconds, pass_seconds, readback_seconds;
    uint64_t uploaded_bytes, peak_bytes, cells_constant, cells_smooth, fetches, exact_pixels;
    int passes;
    struct weft_statistics pixels; // range and counts; count 0: they were not measured
};

// The report tells of the first output's pixels. Returns WEFT_ERR_CANCELLED, WEFT_ERR_UNSUPPORTED,
// WEFT_ERR_GL, WEFT_ERR_MEMORY and what weft_volume_read returns.
enum weft_result weft_fused_run(weft_fused *fused, const struct weft_slice_pixels *pixels,
                                const struct weft_progress *progress,
                                struct weft_fused_report *report);

#endif
