// SPDX-License-Identifier: BSD-3-Clause
// passes/hardware/run.h - plans of hardware filtering on GL: compiled once and run often (not
// installed).
#ifndef WEFT_PASSES_HARDWARE_RUN_H
#define WEFT_PASSES_HARDWARE_RUN_H

#include "passes/fused/run.h"
#include "passes/gl/context.h"
#include "passes/hardware/plan.h"

// Program, texture, table and target for the plan's largest tile. What is in the texture stays: a
// plan of one tile lays voxels out in its first run alone.
typedef struct weft_hardware weft_hardware;

// Plan and context are borrowed. Returns WEFT_ERR_LIMIT (the context's, or a sampler that is worse
// than the plan's, with the numbers in the log), WEFT_ERR_MEMORY, WEFT_ERR_GL and what
// weft_sampler_measure returns.
enum weft_result weft_hardware_compile(weft_context *context, const weft_hardware_plan *plan,
                                       weft_hardware **out);
void weft_hardware_destroy(weft_hardware **hardware); // accepts &NULL

// As weft_fused_run, with the same report.
enum weft_result weft_hardware_run(weft_hardware *hardware, const struct weft_slice_pixels *pixels,
                                   const struct weft_progress *progress,
                                   struct weft_fused_report *report);

#endif
