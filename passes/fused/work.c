// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/plan.h"

// Of all tiles, their cells laid out like this.
static double count_texels(const struct weft_slice_plan *placed, enum weft_layout layout,
                           enum weft_source_format source)
{
    double texels = 0.0;
    for (int i = 0; i < placed->info.tile_count; i++) {
        const struct weft_block_layout *there = &placed->tile_plans[i].layout;
        struct weft_block_layout block;
        int starts[3];
        for (int a = 0; a < 3; a++)
            starts[a] = there->span[a] - there->taps[a] + 1;
        weft_block_layout_init(&block, layout, source, there->taps, starts);
        texels += (double)placed->tiles[i].cells_laid_out * (double)block.block_texels;
    }
    return texels;
}

struct weft_fused_cpu_work weft_slice_fused_cpu_work(const struct weft_slice_plan *request,
                                                     const struct weft_slice_plan *placed)
{
    const int width = request->info.kernel.width;
    return (struct weft_fused_cpu_work){
        .samples = count_texels(placed, WEFT_LAYOUT_PLAIN, WEFT_SOURCE_FLOAT),
        .rows = (double)request->axes.taps[2] * width,
        .width = width,
    };
}

struct weft_fused_work weft_slice_fused_work(const struct weft_slice_plan *request,
                                             const struct weft_slice_plan *placed,
                                             enum weft_layout layout)
{
    const struct weft_slice_plan_info *info = &request->info;
    const int width = info->kernel.width;
    return (struct weft_fused_work){
        .layout = layout,
        .source = info->source,
        .texels = count_texels(placed, layout, info->source),
        .fetches = (double)request->axes.taps[2] * width * weft_layout_row_fetches(layout, width),
        .weights = (request->axes.summed ? 2.0 : 3.0) * info->weight_vectors,
        .weights_fetched = info->samples > 1,
    };
}
