// SPDX-License-Identifier: BSD-3-Clause
// passes/lattice/lattice.h - the call for volumes on another lattice: scaled, moved, turned, or on
// the lattice of another volume; values, and what derivatives make (filter/quantity.h). Sparse in,
// sparse out, in bounded memory, on the CPU.
//
// A request is made in two steps: a plan (what is done, which it tells; reads no voxel) and a run
// (streams bricks and tiles to a sink, which may be a file's: tiles/volume/volume_writer.h).
//
// Where. Voxel r of the result lies at to_source r in the source's index space. Positions are
// rounded to multiples of 2^-32 voxels. Nothing is shifted: voxels are points at integer
// coordinates in both, so that a scale by 2 puts every second voxel onto one of the source, a
// source that is moved gives the same voxels, moved, and moving by whole and half voxels commutes
// with doubling, byte for byte.
//
// Minification. Where the result's voxels lie more than one voxel of the source apart along an axis
// of it (the length of that row of to_source), the kernel is stretched along this axis
// (filter/kernels/stretch.h), unless it is told not to be.
//
// How. Along axes of the source, in any order and direction, one axis after another; else directly,
// all taps at once. All sums are in double and rounded to float once. Taps whose weight is exactly
// 0 do not count. Where all that a voxel's kernel meets is of one value, and the kernel's weights
// add up to one, the voxel has that value exactly.
//
// What comes out. Of a value: only bricks whose kernels meet a brick of the source, or a tile that
// is not of the background's value, are computed; everywhere else the background holds, exactly.
// Where all that the kernels meet is of one value, tiles come out, as large as they can be (4096,
// 128 or 8 voxels); so do bricks all voxels of which have one value, and none where that is the
// background. A voxel is active that differs from the background by more than `prune`; the others
// are the background, exactly. Level sets stay level sets: values are distances in the world's
// unit, whatever the lattice, within +-|background|, to which sums beyond are clamped; active are
// those with |value| < |background| - prune, and the others are +-|background| by their sign. The
// band has as many voxels as its width in the world's unit gives on the new lattice. Derivatives
// are of a fog volume with a background of 0. A clamp-to-edge volume gives the voxels whose
// positions lie in its box, half a voxel around it included, all of them active.
#ifndef WEFT_PASSES_LATTICE_LATTICE_H
#define WEFT_PASSES_LATTICE_LATTICE_H

#include "../../filter/analysis/bound.h"
#include "../../filter/quantity.h"
#include "../../tiles/volume/volume_writer.h"
#include "../cpu/cpu.h"
#include "../verify/verify.h"

WEFT_BEGIN_DECLS

// Voxels that a result may have in its bricks, and taps of one voxel, at most.
#define WEFT_LATTICE_MAX_VOXELS (INT64_C(1) << 36)
#define WEFT_LATTICE_MAX_TAPS (INT64_C(1) << 24)

// ---- plan ---------------------------------------------------------------------------------------

struct weft_lattice_params {
    weft_volume *volume;       // required; must outlive the plan
    struct weft_kernel kernel; // default (info NULL): catmull-rom; not radial
    double to_source[3][4];    // default (all 0): identity
    // Of the result; derivatives are in this world space, too. Default (all 0): the source's after
    // to_source, so that all stays where it is. Another one moves the volume.
    double index_to_world[3][4];
    bool index_space; // derivatives per voxel of the source, not in world space
    bool boxed;       // only voxels in this box are made; beyond it the background holds
    int32_t box_min[3], box_max[3]; // inclusive
    // What is made (default NULL: the value). Borrowed until the call returns.
    const struct weft_quantities *quantities;
    bool no_stretch;       // minification may alias
    double prune;          // >= 0, in the values' unit, of each grid's (default 0)
    uint64_t memory_bytes; // of voxels of both lattices (default 1 GiB); where lies what of the
                           // source, some 40 bytes a brick, comes on top
    const struct weft_log *log; // borrowed for the plan's life; may be NULL
};
#define WEFT_LATTICE_DEFAULTS
#define weft_lattice_params(...) (&(struct weft_lattice_params){WEFT_LATTICE_DEFAULTS __VA_ARGS__})

typedef struct weft_lattice_plan weft_lattice_plan; // Thread-safety: one thread at a time, as its
                                                    // volume.

// A grid that comes out: a value, a vector of three, or one of several components.
struct weft_lattice_grid {
    enum weft_quantity quantity;
    int channel;    // the first of its channels in the list of quantities
    int components; // 1, or 3 for gradients and normals
    // What a writer is to know of it. Name and class are the source's for values; else the name is
    // "NAME.CHANNEL", for vectors "NAME.QUANTITY". Owned by the plan; metadata is the volume's.
    struct weft_volume_grid grid;
};
enum { WEFT_LATTICE_GRIDS = WEFT_QUANTITY_CHANNELS };

struct weft_lattice_info {
    struct weft_kernel kernel;
    double to_source[3][4], index_to_world[3][4];
    bool separable;    // one axis after another
    int axis[3];       // of those: the source's axis that each of the result's runs along
    double stretch[3]; // of the kernel along each of the source's axes; 1: it is not
    int64_t width[3];  // taps along each of the source's axes
    bool clamps;       // values of a level set, to +-|background|
    int grid_count;
    struct weft_lattice_grid grid[WEFT_LATTICE_GRIDS];
    int derivative_count;
    struct weft_derivative derivative[WEFT_DERIVATIVES];
    struct weft_bound_terms bound[WEFT_DERIVATIVES]; // of each, in the source's index space
    uint64_t bricks_in, tiles_in;                    // of the source, those in reach
    double voxels; // about so many in bricks of the result: an upper estimate
    // Around all that may be active; empty: nothing is.
    bool empty;
    int32_t box_min[3], box_max[3];
    double band_voxels; // of a level set: half the band's width, in voxels of the result along its
                        // longest axis; 0 else
    const char *text;   // the plan in words, lines ended
};

// Plans. Returns WEFT_ERR_ARGUMENT (transforms that are singular or not finite, kernel, prune, an
// empty box, quantities whose derivatives the kernel has not), WEFT_ERR_UNSUPPORTED (radial
// kernels; a prefiltered kernel that would be stretched; a kernel whose weights do not add up to
// one, and a background or tile that is not 0), WEFT_ERR_LIMIT (voxels, taps, index range, memory:
// the log has both numbers), WEFT_ERR_MEMORY and what weft_volume_find returns; *out is then NULL.
WEFT_API enum weft_result weft_lattice_plan_create(const struct weft_lattice_params *params,
                                                   weft_lattice_plan **out);
WEFT_API void weft_lattice_plan_destroy(weft_lattice_plan **plan); // accepts &NULL
WEFT_API const struct weft_lattice_info *weft_lattice_plan_get_info(const weft_lattice_plan *plan);

// Computes to_source: of a volume, moved by `moved` in world space (NULL: it is not), onto the
// lattice `result`, both index_to_world. Returns WEFT_ERR_ARGUMENT where one is singular or not
// finite: the log says which.
WEFT_API enum weft_result weft_lattice_map_compute(const struct weft_log *log,
                                                   const double (*source)[4],
                                                   const double (*moved)[4],
                                                   const double (*result)[4],
                                                   double (*to_source)[4]);

// ---- run ----------------------------------------------------------------------------------------

// How voxels are verified while they are made: a share of them, by a hash of their place and the
// seed, is computed anew from the source's voxels (of prefiltered kernels, its coefficients) by
// weft_stretch_weights and sums over all taps, as filter/analysis/reference.h makes them.
struct weft_lattice_verify {
    double share; // of the voxels in bricks that come out, 0 (default: none) to 1
    uint64_t seed;
};

struct weft_lattice_run_params {
    weft_volume_sink sink; // required; called by the calling thread
    void *priv;            // handed to sink as it is
    struct weft_cpu cpu;   // default: as fast as it can
    struct weft_lattice_verify verify;
    const struct weft_progress *progress; // may be NULL
};
#define WEFT_LATTICE_RUN_DEFAULTS
#define weft_lattice_run_params(...)                                                               \
    (&(struct weft_lattice_run_params){WEFT_LATTICE_RUN_DEFAULTS __VA_ARGS__})

struct weft_lattice_report {
    double read_seconds, pass_seconds, sink_seconds, verify_seconds, seconds; // the last: of all
    uint64_t bricks_read;     // of the source; more than there are where memory did not keep them
    uint64_t bricks_computed; // of the result
    uint64_t bricks_out[WEFT_LATTICE_GRIDS], tiles_out[WEFT_LATTICE_GRIDS]; // of each grid
    uint64_t active_voxels[WEFT_LATTICE_GRIDS];                             // in bricks and tiles
    uint64_t not_finite; // voxels that are NaN or infinite, in bricks of all grids
    uint64_t clamped;    // voxels of a level set that were beyond +-|background|
    uint64_t peak_bytes; // of what memory_bytes limits
    struct weft_cpu cpu;
    // Of the share that was verified; at_channel is the grid's channel. Maxima are relative to each
    // voxel's own bound in `verify.share`, at most 1 where all is well.
    struct weft_verify_report verify;
    int32_t verify_at[3]; // where the largest error is
};

// Makes all bricks and hands them to the sink in lots, layers of 8 voxels along z in order, and
// within a layer by y, then x; tiles come with the layer that they begin in. All grids' lots of a
// part come one after another. The same bytes for any number of threads and any memory. report may
// be NULL. Returns WEFT_ERR_ARGUMENT (sink, cpu, share), WEFT_ERR_UNSUPPORTED (instructions that do
// not run here), WEFT_ERR_LIMIT (memory_bytes do not hold what one part needs), WEFT_ERR_MEMORY,
// WEFT_ERR_CANCELLED, what weft_volume_read returns, and what the sink does.
WEFT_API enum weft_result weft_lattice_run(weft_lattice_plan *plan,
                                           const struct weft_lattice_run_params *params,
                                           struct weft_lattice_report *report);

WEFT_END_DECLS
#endif
