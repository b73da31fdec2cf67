// SPDX-License-Identifier: BSD-3-Clause
// A slice's plan in words.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "passes/fused/plan.h"

const char *const weft_lookup_names[] = {"polynomial", "linear", "nearest", NULL};
const char *const weft_saving_names[] = {"constant", "axis", "separable", "smooth", NULL};

static void print_plane(FILE *out, const struct weft_slice_plan *plan, int i)
{
    const struct weft_slice_tile *t = &plan->tiles[i];
    const struct weft_slice_plan_info *info = &plan->info;
    int32_t min[3], max[3];
    const int *order = plan->axes.order, last = info->kernel.width - 1;
    const struct weft_rectangle at = {t->x, t->y, t->width, t->height};
    weft_slice_axes_box(&plan->axes, &info->kernel, &plan->footprint->grid, &at, min, max);
    fprintf(out,
            "tile %02d: pixels (%d,%d) %dx%d, read %" PRIu64 " bricks, a plane of %dx%d samples, "
            "%.1f MB\n",
            i, t->x, t->y, t->width, t->height, t->bricks_read, max[order[0]] - min[order[0]] + 1,
            max[order[1]] - min[order[1]] + 1, 1e-6 * (double)t->memory_bytes);
    fprintf(out,
            "pass %02d: taps (0,0,0)-(%d,%d,%d), %d of them summed along %c before, one axis after "
            "the other -> r32f\n",
            i, last, last, last, info->summed_taps, "xyz"[info->summed_axis]);
}

static void print_tile(FILE *out, const struct weft_slice_plan *plan, int i)
{
    const struct weft_slice_tile *t = &plan->tiles[i];
    const struct weft_slice_tile_plan *p = &plan->tile_plans[i];
    const struct weft_slice_plan_info *info = &plan->info;
    fprintf(out,
            "tile %02d: pixels (%d,%d) %dx%d, read %" PRIu64 " bricks, %" PRIu64 " cells: %" PRIu64
            " constant, %" PRIu64 " in blocks of %dx%dx%d voxels, %.1f MB\n",
            i, t->x, t->y, t->width, t->height, t->bricks_read, t->cells,
            t->cells - t->cells_laid_out, t->cells_laid_out, p->layout.span[0], p->layout.span[1],
            p->layout.span[2], 1e-6 * (double)t->memory_bytes);
    int w = info->kernel.width;
    fprintf(out, "pass %02d: taps (0,0,0)-(%d,%d,%d)", i, w - 1, w - 1, w - 1);
    if (plan->axes.summed)
        fprintf(out, ", %d of them summed along %c before", info->summed_taps,
                "xyz"[info->summed_axis]);
    fprintf(out, ", %d %s%s fetches a pixel, fused -> r32f\n", info->fetches_per_pixel,
            p->layout.kind == WEFT_LAYOUT_PLAIN ? "r" : "rgba",
            weft_source_format_name(info->source));
}

static void print_savings(FILE *out, unsigned savings)
{
    fprintf(out, "savings:");
    for (int i = 0; weft_saving_names[i]; i++)
        if (savings & 1u << i)
            fprintf(out, " %s", weft_saving_names[i]);
    fprintf(out, savings ? "\n" : " none\n");
}

// Of plans that derive, every output; what can be saved along axes is not.
static void print_outputs(FILE *out, const struct weft_slice_plan_info *info, bool derives)
{
    for (int o = 0; derives && o < info->output_count; o++) {
        const struct weft_slice_output *output = &info->output[o];
        char name[8] = "", *at = name;
        for (int a = 0; a < 3; a++)
            for (int i = 0; i < output->derivative.along[a]; i++)
                *at++ = "xyz"[a];
        fprintf(out, "output %02d: %s%s, error bound %.2g x |voxel| + %.2g\n", o,
                at == name ? "value" : "derivative along ", name, output->error_bound,
                output->error_absolute);
    }
    if (derives)
        fprintf(out, "all outputs are summed from the same voxels in one pass, along every axis\n");
}

enum weft_result weft_slice_text_print(struct weft_slice_plan *plan,
                                       const struct weft_volume_info *volume)
{
    char kernel[64];
    size_t size;
    FILE *out = open_memstream(&plan->text, &size);
    if (!out)
        goto fail;
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    weft_kernel_format(&plan->info.kernel, kernel, sizeof kernel);
    fprintf(out, "slice %dx%d of grid %s (%s, %" PRIu64 " bricks), kernel %s, %d taps\n", g->width,
            g->height, volume->name, volume->type, volume->bricks, kernel,
            plan->info.kernel.width * plan->info.kernel.width * plan->info.kernel.width);
    if (!weft_slice_is_whole(plan))
        fprintf(out, "part: pixels (%d,%d) %dx%d\n", plan->info.part.x, plan->info.part.y,
                plan->info.part.width, plan->info.part.height);
    fprintf(out,
            "index space: origin (%.9g, %.9g, %.9g), u (%.9g, %.9g, %.9g), v (%.9g, %.9g, %.9g)\n",
            g->origin[0], g->origin[1], g->origin[2], g->u[0], g->u[1], g->u[2], g->v[0], g->v[1],
            g->v[2]);
    fprintf(out,
            "layout %s, kernel tiles of degree %d in %d segments, error bound %.2g x |voxel| + "
            "%.2g\n",
            weft_layout_name(plan->info.layout), plan->weights[0]->tiles.degree,
            plan->weights[0]->tiles.segments, plan->info.output[0].error_bound,
            plan->info.output[0].error_absolute);
    print_outputs(out, &plan->info, weft_slice_derives(plan));
    if (plan->info.engine == WEFT_ENGINE_CPU)
        fprintf(out, "engine cpu, sums %s\n", weft_sums_names[plan->info.sums]);
    print_savings(out, plan->info.savings);
    if (plan->footprint->coefficients)
        fprintf(out,
                "prefilter: a coefficient depends on voxels up to %d away along each axis; farther "
                "ones add %.2g x |voxel| to the bound\n",
                plan->info.prefilter_overlap, plan->info.output[0].error_beyond);
    for (int i = 0; i < plan->info.tile_count; i++)
        (plan->axes.separable ? print_plane : print_tile)(out, plan, i);
    if (fclose(out) != 0)
        goto fail;
    plan->info.text = plan->text;
    return WEFT_OK;
fail:
    weft_error(plan->log, "not enough memory for the text of the plan");
    return WEFT_ERR_MEMORY;
}
