// SPDX-License-Identifier: BSD-3-Clause
// passes/slice/slab.h - cuts of some thickness: of what lies on a line through each pixel, square
// to the plane in world space, the mean, the largest, the smallest or the integral. A slab is
// sampled: it is a row of parallel cuts at equal distances, each the middle of an equal share of
// the thickness, which is centred on the plane. Cuts are made by the engine that the plane is
// planned for, one after the other, and combined in double. Where the cuts are no farther apart
// than half a voxel, as by default, what the midpoint rule leaves of the integral is of the order
// of the second derivative along the line / 96, in voxels; max and min are those of the samples.
#ifndef WEFT_PASSES_SLICE_SLAB_H
#define WEFT_PASSES_SLICE_SLAB_H

#include "../../filter/quantity.h"
#include "slice.h"

WEFT_BEGIN_DECLS

// What is made of the samples of a pixel. A sample that is NaN makes all of them NaN.
enum weft_combine {
    WEFT_COMBINE_MEAN,
    WEFT_COMBINE_MAX,
    WEFT_COMBINE_MIN,
    WEFT_COMBINE_SUM, // the integral over world length: the mean times the thickness
    WEFT_COMBINE_COUNT
};
// NULL-ended, in the order of the enum: "mean", "max", "min", "sum".
WEFT_API extern const char *const weft_combine_names[];

// Most cuts of a slab.
enum { WEFT_SLAB_MAX_CUTS = 1 << 16 };

// What is cut, and how thick. Borrowed until the call returns.
struct weft_slab_params {
    weft_volume *volume; // required
    // The plane in the middle, and how it is cut; no part, and no footprint. With quantities,
    // derivatives are left out: they are the list's.
    struct weft_slice_params slice;
    double thickness; // in world space, whatever the geometry's space is; > 0 (required)
    enum weft_combine combine;
    int cuts; // default 0: no two are farther apart than half a voxel along the line
    // What is combined: channels of these, computed for each cut in world space. Default NULL: the
    // slice's derivatives, in index space, or its value.
    const struct weft_quantities *quantities;
};
#define WEFT_SLAB_DEFAULTS
#define weft_slab_params(...) (&(struct weft_slab_params){WEFT_SLAB_DEFAULTS __VA_ARGS__})

// Where a slab's cuts lie. A plain value.
struct weft_slab_info {
    int cuts;
    double normal[3]; // square to the plane in world space, of length 1
    double spacing;   // from cut to cut, in world units
    double voxels;    // the same in voxels: the length in index space
    double first[3];  // from the plane's origin to that of the first cut, in the geometry's space
    double step[3];   // from cut to cut likewise
    int output_count; // planes that a run writes
};

// Says where the cuts lie. Returns WEFT_ERR_ARGUMENT (no volume; a thickness or edges of the plane
// that are not finite, 0 or parallel; cuts under 0; enums) or WEFT_ERR_LIMIT (more than
// WEFT_SLAB_MAX_CUTS: thickness, spacing and their number are in the log); *out is then all zero.
WEFT_API enum weft_result weft_slab_place(const struct weft_slab_params *params,
                                          struct weft_slab_info *out);

// Makes all cuts and combines them. Output o of pixel (x, y) is as in weft_slice_run_params, with
// outputs or channels in the place of the plan's outputs; the sums take width * height * 8 bytes
// for each, and a cut's planes 4 bytes. Every sample is within the bound that the plane's own plan
// states for its output: so are mean, max and min of the exact samples, and the sum within the
// thickness times it; beside half a unit of the last place. The same bytes every time. `where` is
// borrowed; passes and hardware plans are of one plane and not for slabs. report, which may be
// NULL, adds up those of the cuts. Returns as weft_slab_place, weft_slice_plan_create and
// weft_slice_run.
WEFT_API enum weft_result weft_slab_run(const struct weft_slab_params *params,
                                        const struct weft_slice_compile_params *where,
                                        const struct weft_slice_run_params *run,
                                        struct weft_slice_report *report);

WEFT_END_DECLS
#endif
