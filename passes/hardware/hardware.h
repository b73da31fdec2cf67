// SPDX-License-Identifier: BSD-3-Clause
// passes/hardware/hardware.h - plans of cuts through volumes that the texture sampler filters:
// fast on GPUs, and as inexact as their samplers.
// Voxels lie in a 3D texture that is filtered linearly. Where the weights a and b of neighbouring
// taps have one sign, one fetch at b / (a + b) between the two, times a + b, takes both (Sigg and
// Hadwiger, "Fast third-order texture filtering", GPU Gems 2, chapter 20, eqs. 3 to 6): of a cubic
// B-spline's 64 taps in 3D so come 8 fetches. Kernels with negative lobes keep the taps alone whose
// neighbours differ in sign: Catmull-Rom's 64 come to 27. Which pairs there are is found by the
// signs of the kernel's polynomial tiles over all positions, and weights and places of fetches are
// computed from the tiles in the shader.
//
// A sampler keeps few bits of the place between two texels: 8 on most GPUs, and of 8-bit textures
// on llvmpipe. The bound has what passes/gl/sampler.h measured, times the range of the voxels:
// about 9 bits of a result are right then, whatever the kernel. On the lattice interpolating
// kernels give the voxels, bit by bit, as they do elsewhere. Pixels are the same in every bit for
// every tiling of the output, where a sampler does not depend on where in a texture it filters.
//
// Images are not filtered so: one axis after the other (passes/separable/separable.h) takes fewer
// fetches a pixel, and single precision is kept.
#ifndef WEFT_PASSES_HARDWARE_HARDWARE_H
#define WEFT_PASSES_HARDWARE_HARDWARE_H

#include "../fused/fused.h"
#include "../gl/sampler.h"
#include "work.h"

WEFT_BEGIN_DECLS

// How a slice is filtered. Borrowed until the call returns, but for the slice's plan and the log.
struct weft_hardware_params {
    // Required: for OpenGL, planned without savings along axes (WEFT_SAVING_AXIS) and without
    // clamp_to_samples. Its kernel, positions, source format and range are taken, and not its
    // layout and smooth_error. Held by the caller while the plan of hardware filtering lives.
    const weft_slice_plan *slice;
    // What is to run it has a sampler at least as good (default, max_size 0: weft_sampler_assume;
    // weft_sampler_measure tells what a context has).
    struct weft_sampler sampler;
    uint64_t memory_bytes;      // voxels, texture, table and target while running (default 1 GiB)
    const struct weft_log *log; // borrowed for the plan's life; may be NULL
};
#define WEFT_HARDWARE_DEFAULTS
#define weft_hardware_params(...)                                                                  \
    (&(struct weft_hardware_params){WEFT_HARDWARE_DEFAULTS __VA_ARGS__})

// A plan. Thread-safety: as of the slice's plan.
typedef struct weft_hardware_plan weft_hardware_plan;

// What a plan is. It belongs to the plan and lives as long.
struct weft_hardware_plan_info {
    struct weft_sampler sampler; // that the bound holds for
    int fetches_per_axis;        // at least half the kernel's taps
    int pairs_per_axis;          // of taps that share a fetch; at least 1
    int fetches_per_pixel;       // cube of those per axis
    int texture_size[3];         // texels; powers of two
    int tile_count;              // rectangles of the output, whose voxels the texture holds in turn
    uint64_t memory_bytes;       // of the largest one: voxels, texture, table and target
    // The terms of |result - exact|: what the sampler is off by is in e3, times the range of the
    // values read (of a source that is not float, with its own range, in absolute).
    struct weft_bound_terms bound;
    struct weft_hardware_work work; // of a run
    const char *text;               // the plan as --explain prints it
};

// Finds the pairs, cuts the slice into tiles whose voxels fit the texture, and bounds the error.
// Reads no voxel. On failure *out is NULL. Returns WEFT_ERR_ARGUMENT (no slice; one with savings
// along axes, for the CPU engine, or clamped; a sampler's numbers), WEFT_ERR_UNSUPPORTED (a kernel
// without a pair, such as nearest: the sampler would save nothing), WEFT_ERR_LIMIT (what the
// smallest tile needs and the limits are in the log) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_hardware_plan_create(const struct weft_hardware_params *params,
                                                    weft_hardware_plan **out);
WEFT_API void weft_hardware_plan_destroy(weft_hardware_plan **plan); // accepts &NULL
WEFT_API const struct weft_hardware_plan_info *
weft_hardware_plan_get_info(const weft_hardware_plan *plan);

WEFT_END_DECLS
#endif
