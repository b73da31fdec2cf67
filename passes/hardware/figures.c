// SPDX-License-Identifier: BSD-3-Clause
// What a slice by hardware filtering comes to, before it is cut into tiles.
#include <math.h>

#include "passes/hardware/plan.h"

int weft_hardware_side(const struct weft_kernel *kernel)
{
    return WEFT_BRICK_SIZE + kernel->width;
}

static enum weft_result check(const struct weft_log *log, const struct weft_slice_plan *slice)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, slice->info.engine == WEFT_ENGINE_GL);
    weft_require(log, !slice->axes.summed && !slice->axes.separable);
    weft_require(log, !slice->clamp_to_samples);
    res = WEFT_OK;
fail:
    return res;
}

// A block for each cell, constant ones and those of two tiles included.
static double count_texels(const struct weft_slice_plan *placed)
{
    double cells = 0.0;
    for (int i = 0; i < placed->info.tile_count; i++)
        cells += (double)placed->info.tiles[i].cells;
    return cells * pow(weft_hardware_side(&placed->info.kernel), 3);
}

enum weft_result weft_hardware_figures_find(const struct weft_log *log,
                                            const struct weft_slice_plan *request,
                                            const struct weft_slice_plan *placed,
                                            const struct weft_sampler *sampler,
                                            struct weft_hardware_figures *out)
{
    const struct weft_slice_plan_info *info = &request->info;
    *out = (struct weft_hardware_figures){.work.source = info->source};
    const enum weft_result res = check(log, request);
    if (res != WEFT_OK)
        return res;
    if (weft_slice_derives(request)) {
        weft_error(log, "the sampler makes values: plan the slice without derivatives");
        return WEFT_ERR_UNSUPPORTED;
    }
    weft_hardware_pairs_find(&request->weights[0]->tiles, &out->pairs);
    if (out->pairs.pairs == 0) {
        weft_error(log, "kernel %s: no two neighbouring taps that the sampler could take at once",
                   info->kernel.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    out->bound = weft_hardware_bound(request, &out->pairs, sampler);
    out->work = (struct weft_hardware_work){
        .source = info->source,
        .texels = count_texels(placed),
        .fetches = pow(out->pairs.fetches, 3),
        .weights = 3.0 * info->weight_vectors,
        .weights_fetched = info->samples > 1,
    };
    return WEFT_OK;
}
