// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/block_layout.h - cells of a volume laid out for convolution (not installed).
// A cell is 8x8x8 positions where a kernel's first tap may lie; its block is the voxels that those
// taps reach, so that one look-up per pixel finds all of them. Interleaving four samples into RGBA
// is the dot4 algorithm's pre-offset source (Hadwiger, Hauser, Moeller 2003, section 6).
#ifndef WEFT_TILES_VOLUME_BLOCK_LAYOUT_H
#define WEFT_TILES_VOLUME_BLOCK_LAYOUT_H

#include "filter/check.h"
#include "tiles/volume/brick_store.h"
#include "tiles/volume/layout.h"

// One shape for all blocks of a tile, so that a shader needs one row and one slice pitch. Its axes
// are those of the block: a row of it may run along any axis of the volume.
struct weft_block_layout {
    enum weft_layout kind; // not AUTO
    enum weft_source_format format;
    int taps[3]; // of the kernel along each axis; 1 along the last where that is summed up
    int span[3]; // voxels that a block covers along each axis
    int row_texels;
    size_t block_texels; // row_texels * span[1] * span[2]
    size_t texel_bytes;  // 4 or 1 samples
};

// starts[a]: how many first-tap positions of any one cell are used along axis a, 1 to 8.
void weft_block_layout_init(struct weft_block_layout *layout, enum weft_layout kind,
                            enum weft_source_format format, const int taps[3], const int starts[3]);

// Texel fetches for one row of taps: what the shader does, and what the planner reports.
int weft_layout_row_fetches(enum weft_layout kind, int width);

// Texels from a block's start to the one that the first tap at `start` (0 to 7 past the first one
// covered) begins in.
size_t weft_block_layout_offset(const struct weft_block_layout *layout, const int start[3]);

// The range that a format other than float holds; what is outside is clamped to it.
struct weft_source_range {
    double low, high;
};

// Whether a source of this format can hold a range of voxels: floats hold any.
bool weft_source_format_holds(enum weft_source_format format,
                              const struct weft_source_range *range);

// Lays out voxels [z][y][x] of layout->span into block_texels texels. Samples past the span are 0.
// range: not used by floats.
void weft_block_layout_write(const struct weft_block_layout *layout,
                             const struct weft_source_range *range, const float *voxels,
                             void *texels);

// A shader's sum r of stored samples by weights that add up to S is r * scale + S * offset.
void weft_source_range_mapping(enum weft_source_format format,
                               const struct weft_source_range *range, double *scale,
                               double *offset);

// Copies the box of voxels at `min` of `size` (each at most `pitch`) to out[z][y][x], whose rows
// and slices are pitch[0] and pitch[0] * pitch[1] apart.
void weft_brick_store_copy_box(const weft_brick_store *store, const int32_t min[3],
                               const int size[3], const int pitch[3], struct weft_brick_memo *memo,
                               float *out);

// The same of the brick at `origin` with `before` voxels before it and `after` behind it along each
// axis, 8 at most, tightly packed; faster.
void weft_brick_store_copy_block(const weft_brick_store *store, const int32_t origin[3], int before,
                                 int after, float *out);

// What the bricks that meet a box of voxels hold: true if one constant everywhere.
bool weft_brick_store_box_constant(const weft_brick_store *store, const int32_t min[3],
                                   const int32_t max[3], float *constant);

#endif
