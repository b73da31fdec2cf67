// SPDX-License-Identifier: BSD-3-Clause
// passes/points/points_impl.h - what a volume ready to be sampled holds, and how a run goes on (not
// installed).
// A run takes points in batches. Each point's position is rounded and its cell found; batches are
// sorted by cell, so that points that share voxels are neighbours ("runs" of a cell); as many runs
// as memory has bricks for are then added up by threads, each in parts of a fixed number of points.
// A point's outputs depend on its position and on nothing else.
#ifndef WEFT_PASSES_POINTS_POINTS_IMPL_H
#define WEFT_PASSES_POINTS_POINTS_IMPL_H

#include "passes/fused/lines/lines.h"
#include "passes/points/points.h"
#include "passes/positions/weights.h"
#include "tiles/volume/brick_reader.h"

struct weft_points {
    struct weft_points_info info;
    const struct weft_log *log;
    weft_volume *volume;
    weft_volume *coefficients; // own; NULL: the kernel is not prefiltered
    weft_volume *voxels;       // which of these two taps read
    uint64_t memory_bytes;
    // By order along an axis, as far as outputs have it.
    int orders;
    struct weft_kernel kernel[WEFT_LINE_ORDERS];
    struct weft_kernel_facts *facts;
    const struct weft_slice_weights *weights[WEFT_LINE_ORDERS];
    struct weft_line_kernel lines;
    weft_line_fn line;
    float largest_fit;               // larger voxels are added up in double
    double to_index[3][4];           // of positions
    uint32_t tap_shift;              // 0 or half a voxel, in 2^-29 voxels
    int32_t tap_offset;              // floor(position + tap_shift) - first tap
    int span;                        // voxels along a side of a cell's block: 7 + taps
    struct weft_brick_reader bricks; // opened by the first run
};

// ---- positions ----------------------------------------------------------------------------------

// Where a point lies: position + tap_shift = cell * 8 + word * 2^-29, as lines have it.
struct weft_point_place {
    uint32_t word[3];
};

// Points of a batch whose first taps share a cell.
struct weft_point_run {
    int32_t cell[3];
    uint32_t first, count; // among the sorted ones
    uint8_t low[3],
        high[3]; // of floor(position + tap_shift) within the cell, as far as is gathered
};

enum { WEFT_POINTS_BATCH = 1 << 20 };

// A batch, and what it is sorted by.
struct weft_point_batch {
    size_t capacity, count, good; // points, and those with a position
    size_t first;                 // of the call's
    int32_t (*cell)[3];
    struct weft_point_place *place;
    uint64_t *sorted; // good: keys of cells, and in the low 20 bits the number of the point
    uint64_t *spare;
    struct weft_point_run *run;
    size_t run_count;
};

// Returns WEFT_ERR_MEMORY. Bytes it takes: weft_point_batch_bytes a point.
enum weft_result weft_point_batch_create(const struct weft_log *log, size_t capacity,
                                         struct weft_point_batch *out);
void weft_point_batch_destroy(struct weft_point_batch *batch); // {0} is fine
extern const size_t weft_point_batch_bytes;

static inline size_t weft_point_number(uint64_t sorted)
{
    return (size_t)(sorted & (WEFT_POINTS_BATCH - 1));
}

// Rounds and sorts the batch's points: from batch->first on, batch->count. Points without a
// position, and those outside, are counted, and NAN is written for the former.
void weft_point_batch_sort(const weft_points *points, const struct weft_points_run_params *params,
                           struct weft_point_batch *batch, struct weft_points_report *report);

// The voxels that a run's taps reach, inclusive.
void weft_point_run_box(const weft_points *points, const struct weft_point_run *run, int32_t min[3],
                        int32_t max[3]);

// ---- sums ---------------------------------------------------------------------------------------

// What threads add up: runs `from` to `to`, exclusive, of a batch, whose bricks are there.
struct weft_point_job {
    weft_points *points;
    const struct weft_points_run_params *params;
    const struct weft_point_batch *batch;
    size_t from, to;
    struct weft_points_report *report;
};
// Returns WEFT_ERR_MEMORY.
enum weft_result weft_point_job_run(const struct weft_point_job *job);

// Sets the bounds of each output.
void weft_points_set_bounds(weft_points *points);

// What the samples are that coefficients in a box stand for, and those farther away: no less.
// Returns WEFT_ERR_MEMORY and what weft_volume_find and weft_volume_read return.
enum weft_result weft_points_measure_samples(const weft_points *points, const int32_t min[3],
                                             const int32_t max[3], struct weft_bound_values *out);

#endif
