// SPDX-License-Identifier: BSD-3-Clause
// passes/positions/footprint.h - what a cut through a volume reaches: made once per request, shared
// by every plan for it, by its runs and by its verification.
// A voxel is in reach of a cut where a tap of some pixel lies on it, whatever the tap's weight is.
// Reach so depends on positions and on the kernel's width and on nothing else: not on how a plan
// cuts the cut into tiles, nor on where bricks begin, nor on which method is asked for. That is why
// the range of these voxels is the one range: a plan that maps it to [0, 1] gives the same pixels
// however it was come by, and no voxel that counts is outside. Whole bricks would make it depend on
// where the volume begins, and the background on pixels that are not there.
//
// Voxels of bricks are read once and kept as long as there is room; so are the statistics. With a
// prefiltered kernel voxels are coefficients (weft_volume_prefilter).
//
// Thread-safety: one thread at a time, for a footprint, its plans and its volume together.
#ifndef WEFT_PASSES_POSITIONS_FOOTPRINT_H
#define WEFT_PASSES_POSITIONS_FOOTPRINT_H

#include "../../filter/kernels/kernel.h"
#include "../../filter/rectangle.h"
#include "../../filter/statistics.h"
#include "geometry.h"

WEFT_BEGIN_DECLS

typedef struct weft_footprint weft_footprint;

struct weft_footprint_params {
    weft_volume *volume;                 // required; borrowed for the footprint's life
    struct weft_kernel kernel;           // default (info NULL): catmull-rom; not radial
    enum weft_space space;               // of the geometry (default world)
    struct weft_slice_geometry geometry; // required
    uint64_t memory_bytes;               // of voxels that are kept, together with what whoever
                                         // needs them has beside (default 1 GiB)
    const struct weft_log *log;          // borrowed for the footprint's life; may be NULL
};
#define WEFT_FOOTPRINT_DEFAULTS
#define weft_footprint_params(...)                                                                 \
    (&(struct weft_footprint_params){WEFT_FOOTPRINT_DEFAULTS __VA_ARGS__})

// Valid until the footprint is gone; the counts grow while it is used.
struct weft_footprint_info {
    struct weft_kernel kernel;
    enum weft_space space;
    struct weft_slice_geometry geometry;       // as asked for
    struct weft_slice_geometry index_geometry; // the same in index space
    // Prefiltered kernels: voxels on either side of the taps that count as in reach too, since
    // their coefficients depend on them; 0 for others.
    int prefilter_overlap;
    // So far, from the volume: for prefiltered kernels those that coefficients depend on. Each
    // counts once as long as memory_bytes holds them all.
    uint64_t bricks_read;
    uint64_t kept_bytes; // of voxels, and coefficients, now
    double read_seconds; // so far
};

// Finds which bricks and tiles lie near the cut; no voxel is read. The one who creates a footprint
// holds it, and every plan made on it does too: it is gone when the last of them gives it up.
// Returns WEFT_ERR_ARGUMENT (kernel, sizes, edges), WEFT_ERR_UNSUPPORTED (radial kernels),
// WEFT_ERR_FORMAT (a transform that leaves no cut), WEFT_ERR_LIMIT (index range), WEFT_ERR_MEMORY
// and what weft_volume_find and weft_volume_prefilter return.
WEFT_API enum weft_result weft_footprint_create(const struct weft_footprint_params *params,
                                                weft_footprint **out);
// Gives up the caller's hold. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_footprint_destroy(weft_footprint **footprint);
WEFT_API const struct weft_footprint_info *weft_footprint_get_info(const weft_footprint *footprint);

// What the voxels in reach are, as far as plans depend on it: constant tiles and the background
// where some tap may lie on them, and no voxel besides.
struct weft_slice_statistics {
    double low, high;    // of the finite voxels, or coefficients; 0 where there are none
    uint64_t voxels;     // in reach, each of them once
    uint64_t not_finite; // of those
    // Of the finite voxels themselves, those included that coefficients depend on.
    double voxel_low, voxel_high;
    // Prefiltered kernels: the largest |voxel| farther away, for error_beyond. Voxels count the
    // less the farther they are, as inverse filters fall, and not at all where these are below
    // 2^-80: neither do they in the exact result then. 0 for others.
    double beyond;
    // Largest |n-th difference| along an axis, n = 1 to 4, of neighbouring voxels in a brick:
    // derivatives of the signal, as far as it is sampled well. Of whole bricks: boxes in reach may
    // be too thin for differences.
    double difference[WEFT_STATISTICS_DIFFERENCES];
};

// The statistics: computed at the first call, which reads all bricks in reach, for prefiltered
// kernels the voxels around, too (43 on either side for cubics, up to 96), and remembered.
// progress may be NULL. Returns WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED and what weft_volume_read
// returns.
WEFT_API enum weft_result weft_footprint_statistics(weft_footprint *footprint,
                                                    const struct weft_progress *progress,
                                                    struct weft_slice_statistics *out);

// ---- measured in parts --------------------------------------------------------------------------

// What a part of the slice's pixels reaches (all 0: all of them), which the footprint does not
// remember. Only bricks in its reach are read. Returns as weft_footprint_statistics, and
// WEFT_ERR_ARGUMENT (a part that is not within the slice) or WEFT_ERR_UNSUPPORTED (prefiltered
// kernels, where what counts around is measured for all pixels together).
WEFT_API enum weft_result weft_footprint_part_statistics(weft_footprint *footprint,
                                                         const struct weft_rectangle *part,
                                                         const struct weft_progress *progress,
                                                         struct weft_slice_statistics *out);
// Joins what two parts reach: parts that cover the slice give the whole slice's statistics, bit for
// bit, but that voxels in reach of several parts are counted in each of them. {0}, with no voxels,
// is nothing. Pure.
WEFT_API struct weft_slice_statistics
weft_slice_statistics_join(const struct weft_slice_statistics *a,
                           const struct weft_slice_statistics *b);
// The statistics of the whole slice, as they were measured elsewhere: nothing is read for them any
// more. Of prefiltered kernels the range alone is taken.
WEFT_API void weft_footprint_set_statistics(weft_footprint *footprint,
                                            const struct weft_slice_statistics *statistics);

WEFT_END_DECLS
#endif
