// SPDX-License-Identifier: BSD-3-Clause
// passes/simple/simple.h - one call for the simplest things: a slice, or values at points, of a
// file or of a volume that is at hand. Each call makes the plans and objects of
// passes/slice/slice.h and passes/points/points.h, runs them once and gives them up; the numbers
// are theirs, bit for bit. Whoever makes many slices of a file, or wants bounds, budgets, reports
// or derivatives beyond the first, goes that way, where each of these things is done once.
// Thread-safety: pure but for the volume and the context, which one thread at a time may use.
#ifndef WEFT_PASSES_SIMPLE_SIMPLE_H
#define WEFT_PASSES_SIMPLE_SIMPLE_H

#include "../../tiles/volume/volume.h"
#include "../cpu/cpu.h"
#include "../gl/context.h"
#include "../positions/geometry.h"

WEFT_BEGIN_DECLS

// Which slice, and by what. All zero is a slice across z through the middle of the first grid, by
// the Catmull-Rom kernel, in 512 x 512 square pixels. Borrowed until the call returns.
struct weft_slice_file_params {
    const char *grid;   // of a file: its name, as weft_volume_open takes it (default: the first of
                        // a scalar type, or of vectors, of which x is sliced, where there is none)
    const char *kernel; // as weft_kernel_parse reads it: "mitchell", "bspline3i", "lanczos:3+unit"
                        // (default "catmull-rom"); not radial
    // Where it lies: across an axis at a coordinate, over the active voxels and half a voxel around
    // them as weft_slice_axis_geometry has it, but that the shorter side is widened alike on both
    // ends until pixels are square in world space.
    char axis;        // 'x', 'y' or 'z' (default 'z')
    const double *at; // on that axis, in `space`: a pointer, as 0 is a place (default NULL: the
                      // middle of the active box)
    bool fill;        // not widened: the box fills the picture, and pixels need not be square
    // Or a plane of any orientation, by the corner where pixel (0, 0) lies and its edges along rows
    // and down columns (default: u and v all 0, by the axis). Not with axis, at or fill.
    double origin[3], u[3], v[3];
    enum weft_space space; // of at, or of origin, u and v (default world)
    int width, height;     // pixels (default both 0: 512 x 512); of one 0 as many as the other
    int64_t stride;        // of the result: floats from row to row (default width)
    // OpenGL that may be used: it is where it is hardware, or where weft_cost_default predicts it
    // to be faster than the CPU engine (default NULL: the CPU engine).
    weft_context *context;
    struct weft_cpu cpu;                  // how the CPU engine runs (default: as fast as it can)
    uint64_t memory_bytes;                // as in struct weft_slice_params (default 1 GiB)
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;           // may be NULL
};
#define WEFT_SLICE_FILE_DEFAULTS
#define weft_slice_file_params(...)                                                                \
    (&(struct weft_slice_file_params){WEFT_SLICE_FILE_DEFAULTS __VA_ARGS__})

// Slices a grid of a file (VDB, NRRD, NIfTI), which its reader process opens. Pixel (x, y), row 0
// on top, is pixels[y * stride + x]. params NULL: all defaults. Returns WEFT_ERR_ARGUMENT (no path
// or pixels; a grid or kernel of no such name, with those there are in the log; an axis that is
// none; axis and plane together; edges without a length; sizes, stride, enums),
// WEFT_ERR_UNSUPPORTED (a radial kernel, a grid of a type that weft does not read), WEFT_ERR_LIMIT,
// WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED, WEFT_ERR_OPEN (no such file), WEFT_ERR_FORMAT (a damaged
// file, a transform that leaves no slice), WEFT_ERR_READER and WEFT_ERR_GL; pixels may then be
// written in part.
WEFT_API enum weft_result
weft_slice_file(const char *path, const struct weft_slice_file_params *params, float *pixels);
// Slices a volume that is open, or in memory (weft_volume_create), likewise. Its grid has been
// chosen: params->grid is NULL, else WEFT_ERR_ARGUMENT.
WEFT_API enum weft_result
weft_slice_volume(weft_volume *volume, const struct weft_slice_file_params *params, float *pixels);

// How points are sampled. All zero: of the first grid, by the Catmull-Rom kernel, at positions in
// world space. Borrowed until the call returns.
struct weft_sample_params {
    const char *grid;                     // as above
    const char *kernel;                   // likewise
    enum weft_space space;                // of positions, and of gradients (default world)
    struct weft_cpu cpu;                  // how the CPU engine runs (default: as fast as it can)
    uint64_t memory_bytes;                // as in struct weft_points_params (default 1 GiB)
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;           // may be NULL
};
#define WEFT_SAMPLE_DEFAULTS
#define weft_sample_params(...) (&(struct weft_sample_params){WEFT_SAMPLE_DEFAULTS __VA_ARGS__})

// Samples a volume at `count` points: value[i], and where gradient is not NULL, gradient[i] along
// x, y and z, per unit of the space, each rounded to float once from what the engine has. The value
// is NAN at a position that is not finite, or beyond index range; outside the voxels there are it
// is the background, or the edge of a volume that is clamped to it. params NULL: all defaults;
// count 0: nothing is done. Returns WEFT_ERR_ARGUMENT (no volume, positions or value; a kernel of
// no such name; params->grid; enums, threads; a transform that is singular, with a gradient),
// WEFT_ERR_UNSUPPORTED (a radial kernel; a gradient of a kernel that has no derivative),
// WEFT_ERR_FORMAT (a transform without an inverse), WEFT_ERR_LIMIT (memory_bytes below 1 MiB),
// WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED, WEFT_ERR_READER; results may then be written in part.
WEFT_API enum weft_result weft_sample(weft_volume *volume, const struct weft_sample_params *params,
                                      size_t count, const double (*position)[3], float *value,
                                      float (*gradient)[3]);
// Samples a grid of a file likewise, and returns what weft_volume_open returns, too.
WEFT_API enum weft_result weft_sample_file(const char *path,
                                           const struct weft_sample_params *params, size_t count,
                                           const double (*position)[3], float *value,
                                           float (*gradient)[3]);

WEFT_END_DECLS
#endif
