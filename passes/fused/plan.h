// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/plan.h - what a plan holds, for those who run and verify it (not installed).
#ifndef WEFT_PASSES_FUSED_PLAN_H
#define WEFT_PASSES_FUSED_PLAN_H

#include "passes/fused/work.h"
#include "passes/positions/axes.h"
#include "passes/positions/footprint_impl.h"
#include "passes/fused/fused.h"
#include "passes/fused/lines/lines.h"
#include "passes/separable/work.h"
#include "tiles/kernel/polynomial_tiles.h"
#include "tiles/volume/block_layout.h"

// Pixels that a shader is chosen for together: squares of this size on the fixed grid of the
// output.
enum { WEFT_SLICE_SQUARE = 32 };

// Targets of four outputs each, on GL, of plans that derive.
enum { WEFT_FUSED_TARGETS = (WEFT_DERIVATIVES + 3) / 4 };
static inline int weft_fused_target_count(int outputs)
{
    return (outputs + 3) / 4;
}

// What a cell of a tile is made of. Its reach is that of all the slice's pixels in it, not of the
// tile's alone: whether one value or cheaper pieces do for it is so the same in every tile, and a
// pixel does not depend on how the slice is cut.
struct weft_slice_content {
    size_t number; // among the plan's cells
    bool constant; // every voxel in reach is `value`
    float value;
};

// Resident data of one rectangle. Source buffer: `head_texels` of room, so that no block's entry is
// negative, then a block for each cell that is not constant, in the cells' order. Tiles that read
// resident blocks have no content, and bricks only once they are asked for.
struct weft_slice_tile_plan {
    const struct weft_slice_cells *cells; // the footprint's
    struct weft_slice_content *content;   // by number
    struct weft_cell_map bricks;          // to read; keys in units of 8 voxels
    struct weft_block_layout layout;
    size_t head_texels, source_texels;
    bool background; // of tiles that read resident blocks: all cells are of its value
};

// What a cell's samples have to stay within for a cheaper piece. With n axes to convolve along:
// half their range times gain^n for one value; for linear interpolation, the sum over the axes
// i = 1..n of `curvature` gain^(n - i) times the largest second difference along axis i.
struct weft_slice_smooth {
    double error;     // 0: no cheaper pieces
    double gain;      // largest sum of |weight|
    double curvature; // 0: not by linear interpolation
};

struct weft_slice_plan {
    struct weft_slice_plan_info info;
    weft_footprint *footprint;      // held
    struct weft_resident *resident; // or NULL
    // All of the slice's pixels in the cells of the part, and more: the whole slice's cells, or
    // those of a window around the part; the footprint's. NULL: separable.
    const struct weft_slice_cells *cells;
    struct weft_slice_axes axes;
    struct weft_slice_smooth smooth;
    struct weft_source_range range; // of stored samples
    float largest_fit;              // see passes/fused/exact.h
    bool clamp_to_samples;
    // The kernel by order of derivative along an axis, and its weights, the footprint's; NULL where
    // no output has that order, but for the first.
    struct weft_kernel_facts *kernels[WEFT_LINE_ORDERS];
    const struct weft_slice_weights *weights[WEFT_LINE_ORDERS];
    struct weft_slice_tile *tiles; // info.tile_count
    struct weft_slice_tile_plan *tile_plans;
    size_t tile_capacity;
    uint64_t separable_bytes; // what the passes of one axis after the other may take
    char *text;
    const struct weft_log *log;
};

// The bounds' part, from its axes, range, tiles and kernels, and what the volume's numbers lose as
// floats; smooth_error as in the params. Returns what weft_kernel_facts_weights does.
enum weft_result weft_slice_bound_set(struct weft_slice_plan *plan, double smooth_error);

// Of one axis, the sum over its taps of what each weight of the kernel itself is off by, as shaders
// compute them from the tiles at the grid's positions.
double weft_slice_weight_bound(const struct weft_slice_plan *plan);

// What positions rounded to fixed point add to a result's error, in units of the largest |value
// read|.
double weft_slice_position_bound(const struct weft_slice_plan *plan);

// The voxels that the taps of one of the plan's cells reach, inclusive, and that the plan needs:
// fewer along a summed axis.
void weft_slice_cell_box(const struct weft_slice_plan *plan, size_t number, int32_t min[3],
                         int32_t max[3]);

// Whether it has outputs other than the value alone.
static inline bool weft_slice_derives(const struct weft_slice_plan *plan)
{
    const int *along = plan->info.output[0].derivative.along;
    return plan->info.output_count > 1 || along[0] + along[1] + along[2] > 0;
}

// Whether it is planned for all pixels of the slice.
static inline bool weft_slice_is_whole(const struct weft_slice_plan *plan)
{
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    return plan->info.part.width == g->width && plan->info.part.height == g->height;
}

// Where a run's pixels go: output o of pixel (x, y) of the part to at[o * plane + y * stride + x].
struct weft_slice_pixels {
    float *at;
    int64_t stride, plane;
    const struct weft_texture *texture; // on GL: as well, or where `at` is NULL (NULL: none)
};

// Where a run puts a pixel of the slice, which is one of the part.
static inline float *weft_slice_pixel(const struct weft_slice_plan *plan, float *pixels,
                                      int64_t stride, int x, int y)
{
    return pixels + (y - plan->info.part.y) * stride + (x - plan->info.part.x);
}

// The pixels of a tile that are the part's.
static inline struct weft_rectangle weft_slice_tile_part(const struct weft_slice_plan *plan,
                                                         const struct weft_slice_tile *tile)
{
    const struct weft_rectangle at = {tile->x, tile->y, tile->width, tile->height};
    return weft_rectangle_common(&at, &plan->info.part);
}

// Whether its voxels are those of resident blocks.
static inline bool weft_slice_reads_blocks(const struct weft_slice_plan *plan)
{
    return plan->resident && !plan->axes.summed && !plan->axes.separable;
}

// The bricks in reach of a tile, found now where it reads resident blocks. Returns WEFT_ERR_MEMORY
// and what weft_volume_find returns.
enum weft_result weft_slice_tile_bricks(const struct weft_slice_plan *plan, int tile,
                                        const struct weft_cell_map **out);

// Bricks read from the volume so far, for the plan's footprint or for all slices of what is
// resident.
uint64_t weft_slice_bricks_read(const struct weft_slice_plan *plan);

// What of a plan does not depend on where the voxels lie: kernel, grid, axes, savings and bounds,
// without tiles. Returns as weft_slice_plan_create.
enum weft_result weft_slice_request_create(weft_volume *volume,
                                           const struct weft_slice_params *params,
                                           struct weft_slice_plan **out);

// The work of a request that is laid out like this, where cells are those of a plan that has tiles.
struct weft_fused_work weft_slice_fused_work(const struct weft_slice_plan *request,
                                             const struct weft_slice_plan *placed,
                                             enum weft_layout layout);

// The same on the CPU engine.
struct weft_fused_cpu_work weft_slice_fused_cpu_work(const struct weft_slice_plan *request,
                                                     const struct weft_slice_plan *placed);

// The work of a separable request: of the whole slice, however it is cut.
struct weft_separable_work weft_slice_separable_work(const struct weft_slice_plan *request);

// The voxels that weft_slice_multipass_run lays out, those of the cells that it reaches; of large
// slices an estimate, by blocks spread over them. INFINITY where memory is not enough to find out.
double weft_slice_multipass_samples(weft_footprint *footprint);

// Fills text and info.text. Returns WEFT_ERR_MEMORY.
enum weft_result weft_slice_text_print(struct weft_slice_plan *plan,
                                       const struct weft_volume_info *volume);

#endif
