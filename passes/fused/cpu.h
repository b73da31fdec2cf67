// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/cpu.h - plans in one pass on the CPU: compiled once and run often (not installed).
// A tile's voxels are laid out in blocks of floats as for OpenGL, in the plain layout, so that all
// taps of a pixel lie in one block, rows of them one after the other. Threads then take rectangles
// of pixels; along each row of one, pixels that are made alike make a line
// (passes/fused/lines/lines.h). Rectangles lie on a fixed grid, and a pixel's sum does not depend
// on where in a line it is: pixels are the same bytes for any number of threads, and any tiles.
#ifndef WEFT_PASSES_FUSED_CPU_H
#define WEFT_PASSES_FUSED_CPU_H

#include "passes/fused/plan.h"
#include "passes/fused/run.h"

// Weights and memory for the plan's largest tile.
typedef struct weft_fused_cpu weft_fused_cpu;

// For a plan of the CPU engine that is not separable, which is borrowed; `cpu` as weft_cpu_resolve
// makes it. Returns WEFT_ERR_MEMORY.
enum weft_result weft_fused_cpu_compile(const struct weft_cpu *cpu, const weft_slice_plan *plan,
                                        weft_fused_cpu **out);
void weft_fused_cpu_destroy(weft_fused_cpu **fused); // accepts &NULL

// As weft_fused_run. Progress is asked by the calling thread alone. Returns
// WEFT_ERR_CANCELLED, WEFT_ERR_MEMORY and what weft_volume_read returns.
enum weft_result weft_fused_cpu_run(weft_fused_cpu *fused, const struct weft_slice_pixels *pixels,
                                    const struct weft_progress *progress,
                                    struct weft_fused_report *report);

#endif
