// SPDX-License-Identifier: BSD-3-Clause
// passes/hardware/plan.h - what a plan of hardware filtering holds (not installed).
#ifndef WEFT_PASSES_HARDWARE_PLAN_H
#define WEFT_PASSES_HARDWARE_PLAN_H

#include "passes/fused/plan.h"
#include "passes/hardware/hardware.h"
#include "passes/hardware/pairs.h"

// Where blocks of voxels lie in the texture: in rows of blocks[0], planes of blocks[1] rows and
// blocks[2] planes. A block has the voxels that the taps of a cell reach, along each axis 7 more
// than taps, and then one texel of zeros: whatever a sampler reads beside the two texels that it
// was sent between is a number.
struct weft_hardware_atlas {
    int side;    // texels from block to block
    int size[3]; // of the texture; powers of two, so that a texel's coordinate is exact
    int blocks[3];
};

// A rectangle of the output with what it needs in the texture at once.
struct weft_hardware_tile {
    struct weft_rectangle at;
    const struct weft_slice_cells *cells; // the footprint's
    struct weft_cell_map bricks;          // to read
};

struct weft_hardware_plan {
    struct weft_hardware_plan_info info;
    const struct weft_slice_plan *slice;
    struct weft_hardware_pairs pairs;
    struct weft_hardware_atlas atlas;
    struct weft_hardware_tile *tiles; // info.tile_count
    size_t tile_capacity;
    uint64_t memory_bytes; // at most
    char *text;
    const struct weft_log *log;
};

// The smallest atlas that holds `count` blocks, in a texture of at most max_size along a side;
// false: there is none.
bool weft_hardware_atlas_fit(size_t count, int side, int max_size, struct weft_hardware_atlas *out);

// How many it holds.
size_t weft_hardware_atlas_blocks(const struct weft_hardware_atlas *atlas);
// Of the texture.
uint64_t weft_hardware_atlas_bytes(const struct weft_hardware_atlas *atlas,
                                   enum weft_source_format format);

// Texels along a side of a block, with the one behind it, for a kernel.
int weft_hardware_side(const struct weft_kernel *kernel);

// The bound's terms.
struct weft_bound_terms weft_hardware_bound(const struct weft_slice_plan *slice,
                                            const struct weft_hardware_pairs *pairs,
                                            const struct weft_sampler *sampler);

// What is known of a slice that was requested: pairs, bound, and the work where voxels lie as in a
// plan that was placed. Returns as weft_hardware_plan_create, without WEFT_ERR_LIMIT.
struct weft_hardware_figures {
    struct weft_hardware_pairs pairs;
    struct weft_bound_terms bound;
    struct weft_hardware_work work;
};
enum weft_result weft_hardware_figures_find(const struct weft_log *log,
                                            const struct weft_slice_plan *request,
                                            const struct weft_slice_plan *placed,
                                            const struct weft_sampler *sampler,
                                            struct weft_hardware_figures *out);

// Fills text and info.text. Returns WEFT_ERR_MEMORY.
enum weft_result weft_hardware_text_print(struct weft_hardware_plan *plan);

#endif
