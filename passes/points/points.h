// SPDX-License-Identifier: BSD-3-Clause
// passes/points/points.h - a volume at any points: values and derivatives, by the CPU engine.
// Points come in any order and any number, as lists, from images of positions (curved slices) or
// along polylines. They are sorted by the cells that they lie in, bricks are read once per call as
// long as memory holds them, and all derivatives of a point are sums over the same voxels: products
// along x are added up once for every order along x, those along y once for every pair of orders.
#ifndef WEFT_PASSES_POINTS_POINTS_H
#define WEFT_PASSES_POINTS_POINTS_H

#include "../../filter/analysis/bound.h"
#include "../../filter/quantity.h"
#include "../../tiles/volume/volume.h"
#include "../cpu/cpu.h"
#include "../positions/geometry.h"

WEFT_BEGIN_DECLS

// What is sampled, and of what. Borrowed until the call returns, but for the volume and the log.
struct weft_points_params {
    weft_volume *volume;       // required; must outlive the result
    struct weft_kernel kernel; // default (info NULL): catmull-rom; not radial
    enum weft_space space;     // of positions (default world)
    // Partial derivatives, in index space whatever space positions are in (default count 0: the
    // value alone). The kernel must have them: weft_kernel_derive, once or twice along an axis.
    const struct weft_derivative *derivative;
    int derivative_count;       // to WEFT_DERIVATIVES
    enum weft_sums sums;        // of products (default float)
    struct weft_cpu cpu;        // default: as fast as it can
    uint64_t memory_bytes;      // of voxels, and what points are sorted by (default 1 GiB, at least
                                // 1 MiB). Prefiltered kernels take up to 64 MiB more
    const struct weft_log *log; // borrowed for the result's life; may be NULL
};
#define WEFT_POINTS_DEFAULTS
#define weft_points_params(...) (&(struct weft_points_params){WEFT_POINTS_DEFAULTS __VA_ARGS__})

// A volume ready to be sampled. Thread-safety: one thread at a time, for it and its volume.
typedef struct weft_points weft_points;

// What a volume is sampled with: the parameters with their defaults filled in, and what they came
// to. It belongs to the weft_points and lives as long.
struct weft_points_info {
    struct weft_kernel kernel;
    enum weft_space space;
    enum weft_sums sums;
    int output_count; // derivatives, or 1
    struct weft_derivative output[WEFT_DERIVATIVES];
    // Of each output: the terms of |result - exact| that weft_bound_compute adds up for values that
    // were measured. Exact is the result at the position in index space, as double has it, of the
    // numbers that the grid stores.
    struct weft_bound_terms bound[WEFT_DERIVATIVES];
    // Prefiltered kernels: voxels on either side of the taps that coefficients depend on; else 0.
    int prefilter_overlap;
    struct weft_cpu cpu; // the threads and instructions that make sums
};

// Makes weights; reads nothing. Returns WEFT_ERR_ARGUMENT (kernel, derivatives, enums),
// WEFT_ERR_UNSUPPORTED (radial kernels, a derivative that the kernel has not, instructions that do
// not run here), WEFT_ERR_LIMIT (memory_bytes below 1 MiB), WEFT_ERR_FORMAT (a transform without an
// inverse), WEFT_ERR_MEMORY and what weft_volume_prefilter returns.
WEFT_API enum weft_result weft_points_create(const struct weft_points_params *params,
                                             weft_points **out);
WEFT_API void weft_points_destroy(weft_points **points); // accepts &NULL, leaves NULL behind
// Tells what it is; valid until it is destroyed.
WEFT_API const struct weft_points_info *weft_points_get_info(const weft_points *points);

// Which points, and where results go. Borrowed until the call returns.
struct weft_points_run_params {
    size_t count;
    const double (*position)[3]; // required; in the space above
    float *out;                  // required: output o of point i is out[o * stride + i]
    size_t stride;               // default count; no less
    bool measure; // prefiltered kernels: read the samples around, too, for the report's values
    const struct weft_progress *progress; // may be NULL
};
#define WEFT_POINTS_RUN_DEFAULTS
#define weft_points_run_params(...)                                                                \
    (&(struct weft_points_run_params){WEFT_POINTS_RUN_DEFAULTS __VA_ARGS__})

// What a run took and found.
struct weft_points_report {
    double sort_seconds, read_seconds, pass_seconds;
    uint64_t bricks_read; // of the voxels that taps read, in this run: those that were not kept
    uint64_t peak_bytes;  // of voxels, and what points are sorted by
    // Of all points: those that have a position that is NaN or infinite, or beyond index range,
    // whose outputs are NaN; those none of whose taps lies in the box of active voxels, whose
    // outputs are of the background, or of the edge of a volume that is clamped to it.
    uint64_t bad_positions, outside;
    uint64_t not_finite; // outputs that are not finite, of all points that have a position
    // Points computed in double: those that reach a voxel that is not finite, or so large that sums
    // may overflow.
    uint64_t exact_points;
    // For weft_bound_compute: the range of the finite values that were read around the points, and
    // of the samples. Of prefiltered kernels samples and `beyond` are known where `measure` asks
    // for them, and 0 else: then they are of all bricks around, and may be larger than need be.
    struct weft_bound_values values;
};

// Samples. Positions are used as they are given, in double, transformed to index space in double
// and rounded as slices round theirs (passes/fused/fused.h), so that a point on a slice's pixel has
// that pixel's value within both bounds. The same bytes for any number of threads, any order of
// points and any others beside them. Where voxels are not finite, or too large for sums, the rules
// are those of slices, too. Bricks are kept from run to run as memory_bytes allows. report may be
// NULL. Returns WEFT_ERR_ARGUMENT (pointers, stride), WEFT_ERR_CANCELLED, WEFT_ERR_MEMORY and what
// weft_volume_find and weft_volume_read return; out may then be written in part.
WEFT_API enum weft_result weft_points_run(weft_points *points,
                                          const struct weft_points_run_params *params,
                                          struct weft_points_report *report);

// ---- curves -------------------------------------------------------------------------------------

// A line from point to point, and what is seen of it. Positions of a straightened slice: pixel
// (x, y) of width x height lies (x + 0.5) / width of the line's length along it, moved by ((y +
// 0.5) / height - 0.5) * across along a direction. At each point that is square to the mean of the
// two segments' directions there, of the one at an end, and turns as little as it can from point to
// point (rotation minimising frames by double reflection: Wang, Juettler, Zheng and Liu, ACM TOG
// 2008, table I); along a segment it goes from one end's to the other's. Corners are not smoothed.
// A closed line, whose last point is its first one, ends with the direction that it came to, not
// with that it began with.
struct weft_polyline {
    size_t count; // >= 2 points, neighbours apart
    const double (*point)[3];
    double across; // > 0, in the points' unit
    double up[3];  // the direction at the first point, as far as it is square to the line (default
                   // all 0: the axis that is farthest from the first segment)
};
// Returns the polyline's length; NAN for one that is none: fewer than 2 points, points that are not
// finite or too far away for their length to be, neighbours that are the same.
WEFT_API double weft_polyline_length(const struct weft_polyline *line);
// Writes position[y * width + x]. Returns WEFT_ERR_ARGUMENT (a line that is none, across, up along
// the first segment, sides below 1 or above WEFT_SLICE_MAX_SIZE, more than WEFT_SLICE_MAX_PIXELS)
// or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_polyline_positions(const struct weft_log *log,
                                                  const struct weft_polyline *line, int width,
                                                  int height, double (*position)[3]);

WEFT_END_DECLS
#endif
