// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/geometry.h - planar cuts through volumes: where they lie and how large they are.
// Pixel (x, y) of a W x H cut samples origin + (x + 0.5) u / W + (y + 0.5) v / H; row 0 comes
// first. All functions here are pure: they may be called from any thread.
#ifndef WEFT_PASSES_POSITIONS_GEOMETRY_H
#define WEFT_PASSES_POSITIONS_GEOMETRY_H

#include "../../tiles/volume/volume.h"

WEFT_BEGIN_DECLS

// What coordinates mean: the world's units, by the volume's index_to_world, or voxels.
enum weft_space { WEFT_SPACE_WORLD, WEFT_SPACE_INDEX };
// NULL-ended, in the order of the enum: "world", "index".
WEFT_API extern const char *const weft_space_names[];

// The largest cut: pixels along a side, and in all (8 GiB of floats).
enum { WEFT_SLICE_MAX_SIZE = 1 << 20 };
#define WEFT_SLICE_MAX_PIXELS (INT64_C(1) << 31)

// A cut: a corner and two edges, in a space that is said beside it, and pixels along each edge.
// Cuts that are planned have edges that are finite and not parallel, and sides of 1 pixel or more.
struct weft_slice_geometry {
    double origin[3];  // the corner where pixel (0, 0) lies
    double u[3], v[3]; // the edges along rows and down columns
    int width, height; // pixels
};

// Chooses what is 0 of geometry->width and height: 1024 along the longer edge (by its length in
// world space) if both are, and pixels that are square in world space.
// Returns WEFT_ERR_ARGUMENT (a negative size, edges without a length) or WEFT_ERR_FORMAT (edges
// that only the volume's transform leaves without a length).
WEFT_API enum weft_result weft_slice_size_compute(const struct weft_log *log,
                                                  const weft_volume *volume, enum weft_space space,
                                                  struct weft_slice_geometry *geometry);

// The box of the active voxels' cells, half a voxel around their centres, in the given space. In
// world space it is along the world's axes: where the volume's are turned or sheared against them
// it is the smallest one that holds all cells. Of a volume without active voxels it is the cell of
// voxel (0, 0, 0).
WEFT_API void weft_slice_active_box(const struct weft_volume_info *info, enum weft_space space,
                                    double low[3], double high[3]);

// Makes the axis-aligned cut through a box, in the given space, at `coordinate` along `axis` (0, 1,
// 2; NAN: the middle of the box): u and v run along the other two axes in order (x y, x z, y z).
// width and height of 0 are chosen as weft_slice_size_compute does; the volume tells how long edges
// of index space are. For several volumes that are to be shown alike.
// Returns WEFT_ERR_ARGUMENT (axis, size, infinite coordinate) or WEFT_ERR_FORMAT (a box that has no
// area there, or is not finite).
WEFT_API enum weft_result weft_slice_box_geometry(const struct weft_log *log,
                                                  const weft_volume *volume, enum weft_space space,
                                                  const double low[3], const double high[3],
                                                  int axis, double coordinate, int width,
                                                  int height, struct weft_slice_geometry *out);

// Makes the axis-aligned cut through the active box of a volume at `coordinate` along `axis` (0, 1,
// 2) in the given space (NAN: the middle of the box). It covers the active box with half a voxel
// around it; u and v run along the other two axes in order (x y, x z, y z). In world space the axes
// are the world's, and the box is the world box of the active voxels. width and height of 0 are
// chosen as weft_slice_size_compute does.
// Returns WEFT_ERR_ARGUMENT (axis, size, coordinate not finite) or WEFT_ERR_FORMAT (a transform
// that leaves no box).
WEFT_API enum weft_result weft_slice_axis_geometry(const struct weft_log *log,
                                                   const weft_volume *volume, enum weft_space space,
                                                   int axis, double coordinate, int width,
                                                   int height, struct weft_slice_geometry *out);

// Turns a cut within its plane so that `up`, a direction in the given space, points from the bottom
// of the picture to its top, as far as the plane lets it; row 0 is on top. Where up runs along an
// edge that edge becomes the columns, and the other one keeps its direction: the pixels are those
// that were there, in another order, and width and height go with their edges. Elsewhere, with
// `whole`, the picture is turned to any angle, and grows to the rectangle in world space that holds
// the given one: what is nearest to running rightwards keeps its direction, and width and height
// become 0, to be chosen. Without `whole` the edge nearest to up is taken.
// Returns WEFT_ERR_ARGUMENT (a direction without a length, or square to the plane) or
// WEFT_ERR_FORMAT (a transform that leaves the plane no area); *geometry is then as it was.
WEFT_API enum weft_result weft_slice_turn(const struct weft_log *log, const weft_volume *volume,
                                          enum weft_space space, const double up[3], bool whole,
                                          struct weft_slice_geometry *geometry);

// Mirrors a cut: columns run from right to left then, rows from the bottom up, or both.
WEFT_API void weft_slice_mirror(bool columns, bool rows, struct weft_slice_geometry *geometry);

WEFT_END_DECLS
#endif
