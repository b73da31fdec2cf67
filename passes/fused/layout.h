// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/layout.h - a tile's own voxels as the slice shader reads them: laid out for it, and
// no farther than its pixels reach (not installed).
#ifndef WEFT_PASSES_FUSED_LAYOUT_H
#define WEFT_PASSES_FUSED_LAYOUT_H

#include "passes/fused/blocks.h"

// Scratch, sized for the largest tile.
struct weft_slice_layout {
    const struct weft_slice_plan *plan;
    float *box, *block; // voxels of one cell in reach, and as they are laid out
};

// Returns WEFT_ERR_MEMORY.
enum weft_result weft_slice_layout_create(const struct weft_slice_plan *plan,
                                          struct weft_slice_layout *out);
void weft_slice_layout_destroy(struct weft_slice_layout *layout); // {0} is fine

// Writes the tile's source texels, and where they are to `blocks`.
void weft_slice_layout_write(const struct weft_slice_layout *layout,
                             const struct weft_slice_tile_plan *tile, const weft_brick_store *store,
                             char *source, struct weft_slice_blocks *blocks);

#endif
