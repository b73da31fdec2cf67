// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/resident.h - a volume that stays: laid out once, and read by any number of slices.
// What slices read is kept in blocks. A block is the voxels that the taps of one cell reach: the
// 8x8x8 positions where a kernel's first tap may lie, and the apron of a kernel around them, so
// that planes of any orientation, and kernels of as many taps or fewer, find all they need in one
// block. Blocks lie in places of equal size, in a texture buffer or in memory, as many as a budget
// of bytes holds; where there is no place for a new one the block that was least recently read
// gives way. What a slice needs and is not there is added; nothing is laid out twice while it
// stays. Beneath the blocks, bricks once read from a file are kept likewise, within a budget of
// their own. What is made for running slices stays, too: targets, tables of pixels, kernel tiles.
//
// Slices planned with a resident volume (struct weft_slice_params) need not fit into it at once:
// they are run in tiles. Those whose voxels are summed along an axis before, or which are done one
// axis after the other, have a few planes of voxels made for them from bricks, as without it.
//
// Pixels are the same bytes with a resident volume as without it in the same layout and format, but
// in two cases, in which they differ by rounding and are within the plan's bound either way. Which
// cells are constant, or smooth, goes by whole blocks here: a cell that is constant as far as its
// pixels reach, and not beyond, is convolved. And in the aligned layout rows of kernels narrower
// than the apron begin elsewhere in a texel.
#ifndef WEFT_PASSES_FUSED_RESIDENT_H
#define WEFT_PASSES_FUSED_RESIDENT_H

#include "../../filter/kernels/kernel.h"
#include "../../tiles/volume/layout.h"
#include "../../tiles/volume/volume.h"
#include "../gl/context.h"

WEFT_BEGIN_DECLS

// Thread-safety: one thread at a time, for a resident volume, its volume and context, and all
// slices that read it, together.
typedef struct weft_resident weft_resident;

// What stays, and how much of it.
struct weft_resident_params {
    weft_volume *volume;   // required; borrowed for the resident volume's life
    weft_context *context; // whose slices read it, borrowed likewise (default NULL: in memory, for
                           // the CPU engine)
    // The kernel that blocks are laid out for (default, info NULL: catmull-rom). Slices of other
    // kernels of at most as many taps read them, too. With a prefiltered kernel blocks hold its
    // coefficients, and slices of that kernel alone read them.
    struct weft_kernel kernel;
    enum weft_layout layout; // default auto: interleaved, or plain for kernels of fewer than three
                             // taps and in memory, where there is no other
    enum weft_source_format source; // how voxels are stored (default float)
    double low, high; // of a source that is not float: the range it holds, finite and low < high
    uint64_t memory_bytes; // of blocks (default 1 GiB); no more than the whole volume takes, and
                           // than the context holds, is asked for
    uint64_t brick_bytes;  // of bricks that are kept, of a volume that is not in memory already; of
                           // prefiltered kernels, of voxels and of coefficients each (default
                           // 256 MiB)
    const struct weft_log *log; // borrowed for the resident volume's life; may be NULL
};
#define WEFT_RESIDENT_DEFAULTS
#define weft_resident_params(...)                                                                  \
    (&(struct weft_resident_params){WEFT_RESIDENT_DEFAULTS __VA_ARGS__})

// What a resident volume is, and what it did so far. Valid until it is destroyed; counts grow.
struct weft_resident_info {
    struct weft_kernel kernel; // the parameters with their defaults filled in
    enum weft_layout layout;
    enum weft_source_format source;
    double low, high;
    uint64_t block_bytes; // of one block
    uint64_t capacity;    // blocks that there are places for
    uint64_t blocks;      // that are there now
    uint64_t laid_out;    // blocks, whenever one was
    uint64_t reused;      // blocks that were there when a slice, or tile, asked for them
    uint64_t evicted;     // blocks that gave way
    uint64_t bricks_read; // from the volume
    uint64_t brick_bytes; // kept now, of bricks
    double read_seconds, layout_seconds, upload_seconds; // of blocks, so far
};

// Makes places for blocks, and lays nothing out. Returns WEFT_ERR_ARGUMENT (no volume, kernel,
// range), WEFT_ERR_UNSUPPORTED (radial kernels; a layout that memory has not), WEFT_ERR_LIMIT (a
// budget, or context, that holds no block: the log has both numbers), WEFT_ERR_MEMORY, WEFT_ERR_GL
// and what weft_volume_prefilter returns.
WEFT_API enum weft_result weft_resident_create(const struct weft_resident_params *params,
                                               weft_resident **out);
// Frees it, after all plans and compiled slices that were made with it. Accepts &NULL, leaves NULL
// behind.
WEFT_API void weft_resident_destroy(weft_resident **resident);
// Tells what it is and did.
WEFT_API const struct weft_resident_info *weft_resident_get_info(const weft_resident *resident);

WEFT_END_DECLS
#endif
