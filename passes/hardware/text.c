// SPDX-License-Identifier: BSD-3-Clause
// A plan of hardware filtering in words.
#include <stdio.h>

#include "passes/hardware/plan.h"

static void print_taps(FILE *out, const struct weft_hardware_pairs *pairs)
{
    for (int i = 0; i < pairs->fetches; i++)
        fprintf(out, pairs->paired[i] ? "%s%d+%d" : "%s%d", i ? " " : "", pairs->tap[i],
                pairs->tap[i] + 1);
}

static void print_tile(FILE *out, const struct weft_hardware_plan *plan, int i)
{
    const struct weft_hardware_tile *t = &plan->tiles[i];
    const int last = plan->slice->info.kernel.width - 1;
    fprintf(out,
            "tile %02d: pixels (%d,%d) %dx%d, read %zu bricks, %zu cells in blocks of %d voxels "
            "along a side\n",
            i, t->at.x, t->at.y, t->at.width, t->at.height, t->bricks.count, t->cells->map.count,
            plan->atlas.side - 1);
    fprintf(out, "pass %02d: taps (0,0,0)-(%d,%d,%d), %d filtered %s fetches a pixel -> r32f\n", i,
            last, last, last, plan->info.fetches_per_pixel,
            weft_source_format_name(plan->slice->info.source));
}

enum weft_result weft_hardware_text_print(struct weft_hardware_plan *plan)
{
    const struct weft_hardware_plan_info *info = &plan->info;
    size_t size;
    FILE *out = open_memstream(&plan->text, &size);
    if (!out)
        goto fail;
    fprintf(out, "hardware filtering: taps ");
    print_taps(out, &plan->pairs);
    fprintf(out,
            " along each axis, a sampler whose fractions are off by %.2g, a texture of "
            "%dx%dx%d texels, %.1f MB\n",
            info->sampler.fraction, info->texture_size[0], info->texture_size[1],
            info->texture_size[2],
            1e-6 * (double)weft_hardware_atlas_bytes(&plan->atlas, plan->slice->info.source));
    fprintf(out, "error bound %.2g x range + %.2g x |voxel| + %.2g\n", info->bound.e3,
            info->bound.relative + info->bound.sample_rounding,
            info->bound.absolute + info->bound.absolute_rounding);
    for (int i = 0; i < info->tile_count; i++)
        print_tile(out, plan, i);
    if (fclose(out) != 0)
        goto fail;
    plan->info.text = plan->text;
    return WEFT_OK;
fail:
    weft_error(plan->log, "not enough memory for the text of the plan");
    return WEFT_ERR_MEMORY;
}
