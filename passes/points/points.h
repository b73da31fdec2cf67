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
    uint64_t memory_bytes;      // of voxels, and what points are sorted by (default 1 GiB)
    const struct weft_log *log; // borrowed for the result's life; may be NULL
};
#define WEFT_POINTS_DEFAULTS
#define weft_points_params(...) (&(struct weft_points_params){WEFT_POINTS_DEFAULTS __VA_ARGS__})

// A volume ready to be sampled. Thread-safety: one thread at a time, for it and its volume.
typedef struct weft_points weft_points;

struct weft_points_info {
    struct weft_kernel kernel;
    enum weft_space space;
    int output_count; // derivatives, or 1
    struct weft_derivative output[WEFT_DERIVATIVES];
    struct weft_bound_terms bound[WEFT_DERIVATIVES]; // of each output
    int prefilter_overlap;                           // as in struct weft_footprint_info
    struct weft_cpu cpu;
};

// Makes weights; reads nothing. Returns WEFT_ERR_ARGUMENT (kernel, derivatives, enums),
// WEFT_ERR_UNSUPPORTED (radial kernels, a derivative that the kernel has not, instructions that do
// not run here), WEFT_ERR_MEMORY and what weft_volume_prefilter returns.
WEFT_API enum weft_result weft_points_create(const struct weft_points_params *params,
                                             weft_points **out);
WEFT_API void weft_points_destroy(weft_points **points); // accepts &NULL, leaves NULL behind
WEFT_API const struct weft_points_info *weft_points_get_info(const weft_points *points);

// Which points, and where results go. Borrowed until the call returns.
struct weft_points_run_params {
    size_t count;
    const double (*position)[3];          // required; in the space above
    float *out;                           // required: output o of point i is out[o * stride + i]
    size_t stride;                        // default count
    const struct weft_progress *progress; // may be NULL
};
#define WEFT_POINTS_RUN_DEFAULTS
#define weft_points_run_params(...)                                                                \
    (&(struct weft_points_run_params){WEFT_POINTS_RUN_DEFAULTS __VA_ARGS__})

struct weft_points_report {
    double sort_seconds, read_seconds, pass_seconds;
    uint64_t bricks_read, peak_bytes;
    // Of all points: those that have a position that is NaN or infinite, or beyond index range,
    // whose outputs are NaN; those none of whose taps lies in the box of active voxels, whose
    // outputs are of the background; outputs that are not finite though the position is.
    uint64_t bad_positions, outside, not_finite;
    // Of the voxels in reach, for weft_bound_compute: values read, and the samples themselves.
    struct weft_bound_values values;
};

// Samples. Positions are used as they are given, in double, transformed to index space in double
// and rounded as slices round theirs (passes/fused/fused.h), so that a point on a slice's pixel has
// that pixel's value within both bounds. The same bytes for any number of threads and any order of
// points. report may be NULL. Returns WEFT_ERR_ARGUMENT (pointers, stride), WEFT_ERR_CANCELLED,
// WEFT_ERR_MEMORY and what weft_volume_find and weft_volume_read return; out may then be written in
// part.
WEFT_API enum weft_result weft_points_run(weft_points *points,
                                          const struct weft_points_run_params *params,
                                          struct weft_points_report *report);

// ---- curves -------------------------------------------------------------------------------------

// Positions of a straightened slice: pixel (x, y) of width x height lies on a polyline at (x + 0.5)
// / width of its length, moved by ((y + 0.5) / height - 0.5) * across along a direction that is
// square to the line there and turns as little as it can from point to point (rotation minimising:
// Wang, Juettler, Zheng, Liu 2008), from `up` at the first point on. Corners are not smoothed: the
// direction changes along a segment from one end's to the other's.
struct weft_polyline {
    size_t count; // >= 2 points, neighbours apart
    const double (*point)[3];
    double across; // > 0, in the points' unit
    double up[3];  // default (all 0): the axis that is farthest from the first segment
};
// Returns the polyline's length; NAN for one that is none.
WEFT_API double weft_polyline_length(const struct weft_polyline *line);
// Writes position[y * width + x]. Returns WEFT_ERR_ARGUMENT (count, points that are not finite or
// not apart, across, up along the first segment, sizes) or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_polyline_positions(const struct weft_log *log,
                                                  const struct weft_polyline *line, int width,
                                                  int height, double (*position)[3]);

WEFT_END_DECLS
#endif
