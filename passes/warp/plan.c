// SPDX-License-Identifier: BSD-3-Clause
// What a warp is going to do.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "filter/kernels/kernel_nd.h"
#include "filter/kernels/prefilter.h"
#include "passes/warp/warp_impl.h"
#include "tiles/volume/volume.h"

const char *const weft_warp_method_names[] = {"aligned", "affine", "projective", "positions", NULL};

// ---- the request --------------------------------------------------------------------------------

static bool is_size(int width, int height)
{
    return width >= 1 && height >= 1 && width <= WEFT_RESAMPLE_MAX_SIZE &&
           height <= WEFT_RESAMPLE_MAX_SIZE && (int64_t)width * height <= WEFT_RESAMPLE_MAX_PIXELS;
}

static enum weft_result check_sizes(const struct weft_warp_plan *plan)
{
    const struct weft_warp_info *info = &plan->info;
    if (is_size(info->size[0], info->size[1]) && is_size(info->width, info->height))
        return WEFT_OK;
    weft_error(plan->log,
               "warping %d x %d samples to %d x %d pixels: sides must be 1 to %d, and %lld in all",
               info->size[0], info->size[1], info->width, info->height, WEFT_RESAMPLE_MAX_SIZE,
               (long long)WEFT_RESAMPLE_MAX_PIXELS);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check(const struct weft_warp_plan *plan)
{
    const struct weft_warp_info *info = &plan->info;
    const struct weft_warp_map *map = &plan->map;
    enum weft_result res = check_sizes(plan);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require_enum(plan->log, map->kind, WEFT_WARP_POSITIONS);
    weft_require_enum(plan->log, info->boundary, WEFT_BOUNDARY_BORDER);
    weft_require_enum(plan->log, info->engine, WEFT_ENGINE_CPU);
    weft_require_enum(plan->log, info->sums, WEFT_SUMS_DOUBLE);
    weft_require(plan->log,
                 map->kind != WEFT_WARP_POSITIONS || (map->position[0] && map->position[1]));
    weft_require(plan->log, map->stride >= info->width);
    res = WEFT_OK;
    if (info->engine == WEFT_ENGINE_GL && info->sums == WEFT_SUMS_DOUBLE) {
        weft_error(plan->log, "a warp on OpenGL does not sum in double");
        res = WEFT_ERR_UNSUPPORTED;
    }
fail:
    return res;
}

// ---- kernels ------------------------------------------------------------------------------------

static enum weft_result set_overlap(struct weft_warp_plan *plan)
{
    struct weft_prefilter prefilter;
    if (plan->info.boundary != WEFT_BOUNDARY_CLAMP) {
        weft_error(
            plan->log, "a warp with %s, which is prefiltered, and boundary %s: it must be %s",
            plan->info.kernel.info->name, weft_name(weft_boundary_names, plan->info.boundary),
            weft_boundary_names[WEFT_BOUNDARY_CLAMP]);
        return WEFT_ERR_UNSUPPORTED;
    }
    const enum weft_result res = weft_prefilter_compute(plan->log, &plan->info.kernel, &prefilter);
    if (res == WEFT_OK)
        plan->info.overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    return res;
}

static enum weft_result set_kernel(struct weft_warp_plan *plan)
{
    struct weft_kernel *kernel = &plan->info.kernel;
    if (!kernel->info)
        weft_kernel_parse(plan->log, "catmull-rom", kernel);
    enum weft_result res = weft_kernel_check(plan->log, kernel);
    if (res != WEFT_OK)
        return res;
    if (weft_kernel_is_radial(kernel, 2)) {
        weft_error(plan->log,
                   "a warp with %s, which is radial: it must be a product along the axes",
                   kernel->info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (kernel->prefiltered)
        res = set_overlap(plan);
    plan->plain = *kernel;
    plan->plain.prefiltered = false;
    for (int a = 0; a < 2; a++)
        plan->values[a] = plan->info.size[a] + 2 * plan->info.overlap;
    return res;
}

static enum weft_result find_weights(struct weft_warp_plan *plan)
{
    struct weft_kernel_facts *facts = weft_kernel_facts_find(&plan->facts, &plan->info.kernel);
    if (!facts) {
        weft_error(plan->log, "out of memory for a kernel");
        return WEFT_ERR_MEMORY;
    }
    return weft_kernel_facts_weights(plan->log, facts, 0, false, plan->info.sums, &plan->weights);
}

// ---- scales -------------------------------------------------------------------------------------

// Nearest moves samples, and is not stretched.
static bool may_stretch(const struct weft_warp_plan *plan)
{
    return !plan->info.unstretched && !plan->info.kernel.info->moves;
}

static enum weft_result set_taps(struct weft_warp_plan *plan)
{
    struct weft_warp_info *info = &plan->info;
    for (int a = 0; a < 2; a++) {
        if (!may_stretch(plan) || info->scale[a] <= WEFT_WARP_SCALE_NONE)
            info->scale[a] = 1.0;
        plan->stretches = plan->stretches || info->scale[a] > 1.0;
    }
    for (int a = 0; a < 2; a++) {
        const double taps = ceil(2.0 * info->kernel.support * info->scale[a]) + 1.0;
        info->taps[a] = info->kernel.width;
        if (info->scale[a] == 1.0)
            continue;
        if (!(taps <= WEFT_WARP_MAX_TAPS)) {
            weft_error(plan->log,
                       "a warp whose pixels lie %g samples apart along %c, and see %g of them with "
                       "%s: at most %d are possible",
                       info->scale[a], "xy"[a], taps, info -> kernel.info->name,
                       WEFT_WARP_MAX_TAPS);
            return WEFT_ERR_LIMIT;
        }
        info->taps[a] = (int)taps;
    }
    if (!plan->stretches || !info->kernel.prefiltered)
        return WEFT_OK;
    weft_error(plan->log,
               "a warp whose pixels lie up to %g x %g samples apart with %s, which is prefiltered: "
               "it cannot be stretched, but to where pixels lie on a grid of their own",
               info->scale[0], info->scale[1], info->kernel.info->name);
    return WEFT_ERR_UNSUPPORTED;
}

// ---- words --------------------------------------------------------------------------------------

static int tell_map(const struct weft_warp_plan *plan, char *text, size_t size)
{
    const double *m = plan->info.inverse;
    if (plan->info.method == WEFT_WARP_PLANES)
        return snprintf(text, size, "positions of every pixel");
    if (plan->info.method == WEFT_WARP_PROJECTIVE)
        return snprintf(text, size,
                        "x = (%.9g u + %.9g v + %.9g) / w, y = (%.9g u + %.9g v + %.9g) / w, w = "
                        "%.9g u + %.9g v + %.9g",
                        m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
    return snprintf(text, size, "x = %.9g u + %.9g v + %.9g, y = %.9g u + %.9g v + %.9g", m[0],
                    m[1], m[2], m[3], m[4], m[5]);
}

void weft_warp_set_text(struct weft_warp_plan *plan)
{
    const struct weft_warp_info *info = &plan->info;
    char name[256], map[320], scale[128] = "not stretched";
    weft_kernel_format(&info->kernel, name, sizeof name);
    tell_map(plan, map, sizeof map);
    if (plan->stretches)
        snprintf(scale, sizeof scale, "stretched by up to %.6g along x and %.6g along y",
                 info->scale[0], info->scale[1]);
    snprintf(
        plan->words, sizeof plan->words,
        "warp, %s: %s (sample of pixel u, v)\n"
        "%s, %s: %d x %d taps%s%s, boundary %s, on the %s engine in %s precision; the error is "
        "at most %.3g of the largest sample\n",
        weft_name(weft_warp_method_names, info->method), map, name, scale, info->taps[0],
        info->taps[1], plan->stretches && !plan->separable ? " at most" : "",
        plan->separable ? ", one axis after the other" : "",
        weft_name(weft_boundary_names, info->boundary), weft_name(weft_engine_names, info->engine),
        info->sums == WEFT_SUMS_DOUBLE ? "double" : "single", info->bound.relative);
    plan->info.text = plan->words;
}

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result weigh_directly(struct weft_warp_plan *plan)
{
    const enum weft_result res = find_weights(plan);
    return res == WEFT_OK ? weft_warp_set_bound(plan) : res;
}

static enum weft_result fill(struct weft_warp_plan *plan)
{
    enum weft_result res = check(plan);
    if (res == WEFT_OK)
        res = set_kernel(plan);
    if (res == WEFT_OK)
        res = plan->map.kind == WEFT_WARP_POSITIONS ? weft_warp_set_positions(plan)
                                                    : weft_warp_set_matrix(plan);
    if (res == WEFT_OK)
        res = set_taps(plan);
    if (res != WEFT_OK)
        return res;
    plan->info.moves = !plan->stretches && weft_resample_moves(&plan->info.kernel);
    res = plan->info.method == WEFT_WARP_ALIGNED ? weft_warp_aligned_plan(plan)
                                                 : weigh_directly(plan);
    if (res != WEFT_OK)
        return res;
    weft_warp_set_text(plan);
    return WEFT_OK;
}

enum weft_result weft_warp_plan_create(const struct weft_warp_params *params, weft_warp_plan **out)
{
    *out = NULL;
    weft_warp_plan *plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(params->log, "out of memory for a plan of a warp");
        return WEFT_ERR_MEMORY;
    }
    const bool given = params->width || params->height;
    *plan = (weft_warp_plan){.map = params->map,
                             .memory_bytes =
                                 params->memory_bytes ? params->memory_bytes : UINT64_C(1) << 30,
                             .log = params->log,
                             .info = {.kernel = params->kernel,
                                      .size = {params->size[0], params->size[1]},
                                      .width = given ? params->width : params->size[0],
                                      .height = given ? params->height : params->size[1],
                                      .boundary = params->boundary,
                                      .unstretched = params->unstretched,
                                      .clamp = params->clamp,
                                      .engine = params->engine,
                                      .sums = params->sums}};
    if (plan->map.stride == 0)
        plan->map.stride = plan->info.width;
    const enum weft_result res = fill(plan);
    if (res == WEFT_OK)
        *out = plan;
    else
        weft_warp_plan_destroy(&plan);
    return res;
}

void weft_warp_plan_destroy(weft_warp_plan **plan)
{
    if (!plan || !*plan)
        return;
    weft_kernel_facts_destroy(&(*plan)->facts);
    weft_separable_plan_destroy(&(*plan)->separable);
    free(*plan);
    *plan = NULL;
}

const struct weft_warp_info *weft_warp_plan_get_info(const weft_warp_plan *plan)
{
    return &plan->info;
}
