// SPDX-License-Identifier: BSD-3-Clause
// passes/slice/slice.h - planar cuts through volumes: planned (passes/fused/fused.h), compiled for
// a context or the CPU, and run, in one pass, one axis after the other, by the texture sampler
// (passes/hardware/hardware.h), or in the passes of a plan of its own. What a plan of passes makes
// of a cut lies where the others have it, at the same fixed-point positions (off by at most 2.4e-10
// voxels): the cut is run in rectangles, of which each has the voxels in reach in a dense box; the
// range of the voxels is fixed before the first, and positions are exact in every box, so that
// pixels are the same in every bit however the cut is cut.
#ifndef WEFT_PASSES_SLICE_SLICE_H
#define WEFT_PASSES_SLICE_SLICE_H

#include "../cpu/cpu.h"
#include "../fused/fused.h"
#include "../gl/context.h"
#include "../gl/textures/texture.h"
#include "../hardware/hardware.h"
#include "../plan/plan.h"

WEFT_BEGIN_DECLS

// A plan made ready to run. Thread-safety: as of its plan's footprint, and one at a time with
// whatever else uses its context.
typedef struct weft_slice weft_slice;

// What is run in the place of one pass: a plan of several.
struct weft_slice_passes {
    const weft_pass_plan *plan; // required: in 3D, of one channel and the slice's kernel; borrowed
                                // while the compiled slice lives
    // The range mapped to [0, 1]; voxels outside are clamped to it. Both 0 or NAN: the finite
    // minimum and maximum of the voxels in reach (weft_footprint_statistics). With a prefiltered
    // kernel voxels are coefficients, whose range is wider.
    double low, high;
    uint64_t memory_bytes;      // bricks, boxes, textures, targets and tiles while running (default
                                // 1 GiB); the caller's pixels are not counted
    const struct weft_log *log; // of compiling and running, in the plan's place; may be NULL
};
#define weft_slice_passes(...) (&(struct weft_slice_passes){__VA_ARGS__})

// Where a plan runs, and what in the place of its one pass. Borrowed until the call returns, but
// for the context, the plan of passes and that of hardware filtering.
struct weft_slice_compile_params {
    weft_context *context; // of plans for OpenGL (required), which must outlive the result; of
                           // plans of passes default the CPU, which runs them in the same integers
    struct weft_cpu cpu;   // how plans for the CPU engine run (default: as fast as it can)
    const struct weft_slice_passes *passes; // default NULL: as the slice is planned
    const weft_hardware_plan *hardware;     // made of the same slice's plan (default NULL: as the
                                            // slice is planned); not with passes
};
#define WEFT_SLICE_COMPILE_DEFAULTS
#define weft_slice_compile_params(...)                                                             \
    (&(struct weft_slice_compile_params){WEFT_SLICE_COMPILE_DEFAULTS __VA_ARGS__})

// Makes programs, buffers, targets and kernel tiles for a plan, which is borrowed while the result
// lives. Passes are cut into rectangles here, before anything is made or read.
// Returns WEFT_ERR_ARGUMENT (no plan, or one of passes or hardware filtering that is not for this
// slice; a context for a plan of the CPU engine, or none for one of OpenGL; a range without width;
// threads, instructions),
// WEFT_ERR_UNSUPPORTED (instructions that do not run here), WEFT_ERR_LIMIT (tiles beyond what the
// context holds: plan with its limits; a sampler that is worse than the plan's: plan with what
// weft_sampler_measure gives; or what the smallest rectangle of passes needs and the limit are in
// the log), WEFT_ERR_MEMORY, WEFT_ERR_GL, and what weft_multipass_compile and weft_sampler_measure
// return.
WEFT_API enum weft_result weft_slice_compile(const weft_slice_plan *plan,
                                             const struct weft_slice_compile_params *params,
                                             weft_slice **out);
WEFT_API void weft_slice_destroy(weft_slice **slice); // accepts &NULL, leaves NULL behind

// Where the pixels of a run go.
struct weft_slice_run_params {
    // Required without a texture: output o of pixel (x, y) is pixels[o * plane_stride + y * stride +
    // x]; x and y are from the plan's part's corner on.
    float *pixels;
    int64_t stride;       // floats from row to row (default the part's width)
    int64_t plane_stride; // from an output's plane to the next (default the part's height * stride)
    // Of compiled slices that have a context: where pixels are drawn to, in the place of memory or
    // as well, output o to channel `channel` + o, which are four at most (default NULL: none).
    // Nothing is read back for it but tiles with a pixel that is computed exactly (exact_pixels of
    // the report); plans of passes make pixels in memory, from where they are uploaded. Borrowed
    // until the call returns.
    const struct weft_texture *texture;
    const struct weft_progress *progress; // may be NULL
};
#define WEFT_SLICE_RUN_DEFAULTS
#define weft_slice_run_params(...)                                                                 \
    (&(struct weft_slice_run_params){WEFT_SLICE_RUN_DEFAULTS __VA_ARGS__})

// What a run took. Seconds of this run, one after the other; counts over all of the plan's part.
struct weft_slice_report {
    double read_seconds;   // of voxels, and of measuring them
    double layout_seconds; // of voxels as shaders read them
    double upload_seconds, pass_seconds, readback_seconds;
    uint64_t bricks_read;    // in this run: those that were not kept
    uint64_t uploaded_bytes; // in this run
    uint64_t peak_bytes;     // of voxels, layouts, boxes and GL memory
    int passes;              // draws; of plans of passes, their passes over all rectangles
    uint64_t cells_constant,
        cells_smooth;       // found so in the voxels, beside the plan's constant ones
    uint64_t fetches;       // of the source, over all pixels: of texels, or of voxels on the CPU
                            // engine; 0 of plans of passes
    float minimum, maximum; // of the finite pixels; NAN if there are none, or no pixels in memory
    uint64_t not_finite;    // pixels that are NaN or infinite; without pixels in memory 0
    uint64_t exact_pixels;  // computed in double on the CPU: near values that floats do not stand
    struct weft_cpu cpu; // of the CPU engine: the threads and instructions that made them; else 0
    // Of plans of passes only: the range that was mapped, in units of whose width bounds are;
    // voxels outside it or not finite, counted in every rectangle that has them; the rectangles;
    // and on the CPU stores that clamped over all passes, by how many codes at most.
    double low, high;
    uint64_t clamped;
    int rectangles;
    uint64_t clamps;
    double largest_clamp;
};

// Adds what another run took, of the same slice or of one beside it: times and counts are summed
// up, peaks, errors and the pixels' range are those of both together. What is said of the engine
// and of the range that passes map stays.
WEFT_API void weft_slice_report_add(struct weft_slice_report *sum,
                                    const struct weft_slice_report *one);

// Runs a compiled slice into the caller's memory. The same plan and volume give the same bytes,
// in every run and whatever the number of threads; a second run reads what the footprint has not
// kept, and makes nothing anew. The values of a plan of passes with a derivative are per voxel.
// report may be NULL. Returns WEFT_ERR_ARGUMENT (pixels, stride, a texture that does not do, or one
// without a context), WEFT_ERR_CANCELLED,
// WEFT_ERR_UNSUPPORTED (a unorm source and a voxel that is not finite), WEFT_ERR_GL,
// WEFT_ERR_MEMORY, and what weft_volume_read and weft_multipass_run return; pixels may then be
// written in part.
WEFT_API enum weft_result weft_slice_run(weft_slice *slice,
                                         const struct weft_slice_run_params *params,
                                         struct weft_slice_report *report);

// Compiles, runs once and destroys. Returns as these do.
WEFT_API enum weft_result weft_slice_run_once(const weft_slice_plan *plan,
                                              const struct weft_slice_compile_params *where,
                                              const struct weft_slice_run_params *params,
                                              struct weft_slice_report *report);

WEFT_END_DECLS
#endif
