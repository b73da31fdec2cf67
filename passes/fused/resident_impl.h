// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/resident_impl.h - a resident volume, for plans and engines (not installed).
// An engine that reads blocks makes a tile's cells resident by weft_resident_load and then, by the
// number of a cell among the tile's (struct weft_slice_tile_plan.cells), has blocks->entries: the
// texel that the block begins with. In the plain layout, in memory, the taps of a pixel whose
// floor(position + tap_shift) is at `start` (0 to 7 along each axis) in its cell begin at
//     (const float *)blocks->texels + entry + weft_block_layout_offset(&blocks->layout, at),
//     at[a] = start[a] + blocks->lead,
// one sample apart along x, layout.row_texels along y, layout.row_texels * layout.span[1] along z.
#ifndef WEFT_PASSES_FUSED_RESIDENT_IMPL_H
#define WEFT_PASSES_FUSED_RESIDENT_IMPL_H

#include "passes/fused/blocks.h"
#include "passes/fused/objects.h"
#include "passes/fused/resident.h"
#include "tiles/volume/brick_reader.h"
#include "tiles/volume/cell_cache.h"

// What is known of a block's voxels, by its place.
struct weft_resident_block {
    struct weft_sample_range range;
    bool curved;     // `second` is known
    float second[3]; // largest second difference along each axis
};

struct weft_resident {
    struct weft_resident_info info;
    const struct weft_log *log;
    weft_context *context; // NULL: in memory
    weft_volume *volume;   // the caller's
    // Prefiltered kernels: the volume's bricks, kept, and coefficients of them; else NULL.
    weft_volume *samples, *coefficients;
    weft_volume *kept;   // bricks of what blocks hold, kept; NULL: the volume has them in memory
    weft_volume *voxels; // what blocks hold: `kept`, or the volume
    struct weft_block_layout layout;
    struct weft_source_range range;
    struct weft_cell_cache cells;       // by whose places blocks lie
    struct weft_resident_block *blocks; // by place
    struct weft_cell_cache constants;   // cells that are known to be of one value
    float *values;                      // of those, by place
    char *texels;                       // in memory, or
    struct weft_gl_buffer buffer;       // in GL
    // Where bricks are near the slice that was looked at last, or everywhere.
    struct weft_brick_reader reader;
    struct weft_slice_grid reader_grid;
    // Of one call.
    struct weft_resident_job *jobs; // blocks to lay out
    size_t job_capacity;
    float *boxes; // voxels of a block, for each thread
    int threads;
    // What a later room keeps from one slice to the next, and what frees it; or NULL.
    void *kept_by_slice;
    void (*free_kept)(void *kept);
    // For its slices.
    struct weft_fused_objects objects; // of the context
    struct weft_kernel_facts *kernels;
};

// Whether a plan's slice may read this, as far as voxels and kernels go; the log says why not.
// Returns WEFT_ERR_ARGUMENT (another volume, or a kernel that it has no blocks for).
enum weft_result weft_resident_check(const weft_resident *resident, const struct weft_log *log,
                                     const weft_volume *volume, const struct weft_kernel *kernel);

// Samples from the first along a block's axes to where the taps of a kernel of this width begin for
// the first position of the cell.
int weft_resident_lead(const weft_resident *resident, int width);

// What footprints of its slices share, and the volume with which they are made.
struct weft_footprint_shared weft_resident_shared(weft_resident *resident);
weft_volume *weft_resident_volume(const weft_resident *resident);

// Keeps something from one slice to the next, in the place of what was kept before; `release` frees
// it in the end.
void weft_resident_keep(weft_resident *resident, void *kept, void (*release)(void *kept));
// Gives what was kept with this `release` back to the caller; NULL: nothing is.
void *weft_resident_take(weft_resident *resident, void (*release)(void *kept));

// Counts of bricks, brought up to date.
void weft_resident_count(weft_resident *resident);

// Which cells a call is about.
struct weft_resident_request {
    const struct weft_slice_grid *grid;
    const struct weft_slice_cells *cells;
    bool constants; // blocks of one value are not needed
    bool curved;    // second differences are
    const struct weft_log *log;
};

// What a plan asks for of these cells.
struct weft_resident_request weft_resident_request_of(const struct weft_slice_plan *plan,
                                                      const struct weft_slice_cells *cells);

// What becomes of a request's cells.
struct weft_resident_survey {
    size_t blocks;   // needed
    size_t missing;  // of these, to lay out
    size_t bricks;   // that these take; 0 of voxels in memory, which are read where they are
    bool background; // all cells are of one value, that of the background
};

// Finds out without laying anything out. Returns WEFT_ERR_MEMORY and what weft_volume_find returns.
enum weft_result weft_resident_survey(weft_resident *resident,
                                      const struct weft_resident_request *request,
                                      struct weft_resident_survey *out);

// Makes all blocks of a tile's cells resident, and fills in `out` (weft_slice_blocks_create): what
// it says holds until the next load. The context is current. What was laid out before a failure
// stays. Returns WEFT_ERR_LIMIT (more blocks than places: both numbers are in the log),
// WEFT_ERR_CANCELLED, WEFT_ERR_MEMORY, WEFT_ERR_GL, and what weft_volume_find and weft_volume_read
// return.
enum weft_result weft_resident_load(weft_resident *resident, const struct weft_slice_plan *plan,
                                    int tile, const struct weft_progress *progress,
                                    struct weft_slice_blocks *out);

#endif
