// SPDX-License-Identifier: BSD-3-Clause
#include "passes/choose/choose.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/choose/cost_impl.h"
#include "passes/choose/method_impl.h"

const char *const weft_candidate_state_names[] = {"chosen", "dearer", "exceeds", "refused", NULL};

struct chooser {
    const struct weft_choose_params *params;
    const struct weft_cost_model *model;
    weft_volume *volume;
    struct weft_choice *choice;
    weft_slice_plan *base; // fused, interleaved floats: what lies where
    struct weft_log quiet; // for candidates that are only looked at
    char failure[256];     // the last error among them
    double slope;          // largest sum of |h'|
};

static struct weft_method_params way_params(const struct chooser *c,
                                            const struct weft_method *method)
{
    return (struct weft_method_params){
        .method = *method, .slice = c->params->slice, .statistics = c->choice->statistics};
}

// What keeps a candidate out is no error of the choice.
static void write_quietly(void *priv, enum weft_log_level level, const char *message)
{
    struct chooser *c = priv;
    if (level == WEFT_LOG_ERROR)
        snprintf(c->failure, sizeof c->failure, "%s", message);
    weft_log_write(c->params->slice.log, WEFT_LOG_DEBUG, "%s", message);
}

// true: the candidate does not apply. What else went wrong is told.
static bool is_refusal(const struct chooser *c, enum weft_result res)
{
    if (res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT)
        return true;
    if (res != WEFT_OK && c->failure[0])
        weft_error(c->params->slice.log, "%s", c->failure);
    return false;
}

static double pixel_count(const struct chooser *c)
{
    return (double)c->params->slice.geometry.width * c->params->slice.geometry.height;
}

static double range_width(const struct chooser *c)
{
    return c->choice->statistics.high - c->choice->statistics.low;
}

// Of the voxels, whatever is read in their place.
static double voxel_width(const struct chooser *c)
{
    return c->choice->statistics.voxel_high - c->choice->statistics.voxel_low;
}

// ---- fused and separable ------------------------------------------------------------------------

// Texels of all tiles if they were laid out another way.
static double texels_of(const struct weft_slice_plan *base, const struct weft_method *method)
{
    double texels = 0.0;
    for (int i = 0; i < base->info.tile_count; i++) {
        const struct weft_block_layout *b = &base->tile_plans[i].layout;
        struct weft_block_layout layout;
        int starts[3];
        for (int a = 0; a < 3; a++)
            starts[a] = b->span[a] - b->taps[a] + 1;
        weft_block_layout_init(&layout, method->layout, method->source, b->taps, starts);
        texels += (double)base->tiles[i].cells_laid_out * (double)layout.block_texels;
    }
    return texels;
}

static void predict_fused(const struct chooser *c, const struct weft_slice_plan_info *request,
                          struct weft_candidate *candidate)
{
    const struct weft_method *method = &candidate->method;
    const struct weft_slice_plan *base = c->base;
    const int width = base->info.kernel.width;
    const struct weft_cost_work work = {
        .engine = WEFT_ENGINE_FUSED,
        .pixels = pixel_count(c),
        .voxels = 512.0 * (double)base->info.bricks_read,
        .layout = method->layout,
        .source = method->source,
        .texels = texels_of(base, method),
        .fetches =
            (double)base->axes.taps[2] * width * weft_layout_row_fetches(method->layout, width),
        .weights = (base->axes.summed ? 2.0 : 3.0) * request->weight_vectors,
        .weights_fetched = request->samples > 1,
    };
    const int samples = method->layout == WEFT_LAYOUT_PLAIN ? 1 : 4;
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes = (uint64_t)(work.texels * samples * weft_source_format_bytes(method->source) +
                                  4.0 * work.voxels + 8.0 * work.pixels);
}

static void predict_separable(const struct chooser *c, struct weft_slice_plan *request,
                              struct weft_candidate *candidate)
{
    const struct weft_rectangle whole = {.width = c->params->slice.geometry.width,
                                         .height = c->params->slice.geometry.height};
    const int *order = request->axes.order;
    int32_t min[3], max[3];
    weft_slice_axes_box(&request->axes, &request->info.kernel, &request->footprint->grid, &whole,
                        min, max);
    const double columns = max[order[0]] - min[order[0]] + 1;
    const double rows = max[order[1]] - min[order[1]] + 1;
    const double between = fmin(whole.width * rows, whole.height * columns);
    const struct weft_cost_work work = {
        .engine = WEFT_ENGINE_SEPARABLE,
        .pixels = pixel_count(c),
        .voxels = 512.0 * (double)c->base->info.bricks_read,
        .summed = columns * rows * request->axes.kept,
        .taps = request->info.kernel.width * (pixel_count(c) + between),
    };
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes =
        (uint64_t)(4.0 * (work.voxels + 2.0 * columns * rows + between + 2.0 * work.pixels));
}

// Bounds need no cells, only the kernel and the axes.
static enum weft_result consider_slice(const struct chooser *c, struct weft_candidate *candidate)
{
    struct weft_method_params params = way_params(c, &candidate->method);
    params.slice.log = &c->quiet;
    const struct weft_slice_params slice = weft_method_slice_params(&params);
    const bool separable = candidate->method.engine == WEFT_ENGINE_SEPARABLE;
    weft_slice_plan *request = NULL;
    candidate->state = WEFT_CANDIDATE_REFUSED;
    if (weft_method_check(&params) != WEFT_OK)
        return WEFT_OK;
    enum weft_result res = weft_slice_request_create(c->volume, &slice, &request);
    if (res != WEFT_OK)
        return is_refusal(c, res) ? WEFT_OK : res;
    if (!separable || request->axes.separable) {
        candidate->state = WEFT_CANDIDATE_DEARER;
        candidate->bound = weft_method_slice_bound(&request->info, &c->choice->statistics);
        if (separable)
            predict_separable(c, request, candidate);
        else
            predict_fused(c, &request->info, candidate);
    }
    weft_slice_plan_destroy(&request);
    return WEFT_OK;
}

// ---- passes -------------------------------------------------------------------------------------

// The least that a plan can cost and be off by: a fetch of source and tile for each group of taps,
// tiles looked up at the nearest of M samples, and the target's codes.
static void estimate_passes(const struct chooser *c, struct weft_candidate *candidate)
{
    const struct weft_method *method = &candidate->method;
    const struct weft_kernel *kernel = &c->base->info.kernel;
    const bool dot4 = method->technique == WEFT_TECHNIQUE_DOT4;
    const int bits = weft_target_bits(method->profile.target);
    const double row = dot4 ? (kernel->width + 3) / 4 : kernel->width;
    const double groups = kernel->width * kernel->width * row;
    struct weft_cost_work work = {
        .engine = WEFT_ENGINE_MULTIPASS,
        .pixels = pixel_count(c),
        .voxels = 512.0 * (double)c->base->info.bricks_read,
        .target = method->profile.target,
        .dot4 = dot4,
        .passes = ceil(groups / method->profile.taps_per_pass),
        .fetches = 2.0 * groups,
        .tile_bytes = groups * pow(method->samples, 3) * (dot4 ? 4 : 1) *
                      (bits == 8 && method->bits <= 8 ? 1
                       : bits                         ? 2
                                                      : 4),
    };
    work.samples = weft_cost_box_samples(&c->base->info);
    if (method->technique == WEFT_TECHNIQUE_SPLIT_PRECISION)
        work.passes = 2.0 * work.passes;
    candidate->estimated = true;
    candidate->state = WEFT_CANDIDATE_DEARER;
    candidate->seconds = weft_cost_of(c->model, &work);
    candidate->bytes = (uint64_t)(work.tile_bytes + 4.0 * work.voxels + 8.0 * work.pixels);
    // Half of what a slope over half a sample makes, along one axis (of prefiltered kernels, whose
    // cardinal splines are no flatter, for half the voxels' range); half a code.
    const double reach = kernel->prefiltered ? 0.5 * voxel_width(c) : range_width(c);
    candidate->bound =
        0.25 * c->slope / method->samples * reach +
        (bits ? 0.5 / weft_target_one(method->profile.target) * range_width(c) : 0.0);
}

static enum weft_result plan_passes(const struct chooser *c, struct weft_candidate *candidate)
{
    struct weft_method_params params = way_params(c, &candidate->method);
    weft_method_plan *plan = NULL;
    params.slice.log = &c->quiet;
    enum weft_result res = weft_method_plan_create(c->volume, &params, &plan);
    candidate->estimated = false;
    if (is_refusal(c, res)) {
        candidate->state = WEFT_CANDIDATE_REFUSED;
        candidate->bound = NAN;
        return WEFT_OK;
    }
    if (res != WEFT_OK)
        return res;
    const struct weft_method_plan_info *info = weft_method_plan_get_info(plan);
    candidate->bound = info->bound;
    candidate->bytes = info->bytes;
    candidate->seconds = weft_cost_predict(c->model, plan);
    weft_method_plan_destroy(&plan);
    return WEFT_OK;
}

// ---- candidates ---------------------------------------------------------------------------------

static bool is_wanted(const struct weft_choose_params *p, const struct weft_method *method)
{
    if (p->profile)
        return method->engine == WEFT_ENGINE_MULTIPASS;
    return method->engine != WEFT_ENGINE_FUSED || p->slice.layout == WEFT_LAYOUT_AUTO ||
           p->slice.layout == method->layout;
}

// With a profile, the passes of the list stand for those on it.
static bool adapt(const struct weft_choose_params *p, struct weft_method *method)
{
    if (!p->profile)
        return true;
    if (method->profile.target != p->profile->target)
        return false;
    method->profile = *p->profile;
    return method->technique != WEFT_TECHNIQUE_DOT4 || p->profile->dot_width >= 3;
}

static enum weft_result list_candidates(struct chooser *c)
{
    struct weft_choice *choice = c->choice;
    struct weft_method *methods = NULL;
    size_t count = 0;
    enum weft_result res = weft_method_list(c->params->slice.log, &methods, &count);
    choice->candidates = res == WEFT_OK ? calloc(count, sizeof *choice->candidates) : NULL;
    if (res == WEFT_OK && !choice->candidates) {
        weft_error(c->params->slice.log, "not enough memory for %zu candidates", count);
        res = WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; res == WEFT_OK && i < count; i++) {
        struct weft_candidate candidate = {.method = methods[i], .bound = NAN};
        if (!is_wanted(c->params, &methods[i]) || !adapt(c->params, &candidate.method))
            continue;
        const struct weft_method_params params = way_params(c, &candidate.method);
        if (candidate.method.engine != WEFT_ENGINE_MULTIPASS)
            res = consider_slice(c, &candidate);
        else if (weft_method_check(&params) == WEFT_OK && !c->params->slice.clamp_to_samples)
            estimate_passes(c, &candidate);
        else
            candidate.state = WEFT_CANDIDATE_REFUSED;
        weft_method_format(&candidate.method, candidate.name, sizeof candidate.name);
        choice->candidates[choice->count++] = candidate;
    }
    free(methods);
    return res;
}

// ---- the choice ---------------------------------------------------------------------------------

static bool is_open(const struct weft_candidate *candidate)
{
    return candidate->state == WEFT_CANDIDATE_DEARER;
}

// The cheapest that still may meet the budget; NULL: none.
static struct weft_candidate *cheapest(const struct weft_choice *choice)
{
    struct weft_candidate *best = NULL;
    for (size_t i = 0; i < choice->count; i++)
        if (is_open(&choice->candidates[i]) &&
            (!best || choice->candidates[i].seconds < best->seconds))
            best = &choice->candidates[i];
    return best;
}

// Bounding a cell's second differences takes the time of so many pixels, give or take.
static bool smooth_may_pay(const struct chooser *c)
{
    enum { PIXELS_PER_CELL = 1500 };
    double cells = 0.0;
    for (int i = 0; i < c->base->info.tile_count; i++)
        cells += (double)c->base->tiles[i].cells_laid_out;
    return pixel_count(c) >= PIXELS_PER_CELL * cells;
}

// Plans the way, giving what its own bound leaves to smooth pieces. One that cannot be planned,
// within the memory say, is refused.
static enum weft_result choose(const struct chooser *c, struct weft_candidate *candidate)
{
    struct weft_method_params params = way_params(c, &candidate->method);
    if (candidate->method.engine == WEFT_ENGINE_FUSED && smooth_may_pay(c))
        params.slice.smooth_error = fmax(0.0, 0.999 * (c->params->max_error - candidate->bound));
    enum weft_result res = weft_method_plan_create(c->volume, &params, &c->choice->plan);
    if (res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT) {
        candidate->state = WEFT_CANDIDATE_REFUSED;
        candidate->bound = NAN;
        return WEFT_OK;
    }
    if (res == WEFT_OK)
        candidate->state = WEFT_CANDIDATE_CHOSEN;
    return res;
}

// Passes are planned only when nothing cheaper does.
static enum weft_result find_cheapest(struct chooser *c)
{
    enum weft_result res = WEFT_OK;
    struct weft_candidate *candidate;
    while (res == WEFT_OK && !c->choice->plan && (candidate = cheapest(c->choice))) {
        if (!(candidate->bound <= c->params->max_error))
            candidate->state = WEFT_CANDIDATE_EXCEEDS;
        else
            res = candidate->estimated ? plan_passes(c, candidate) : choose(c, candidate);
    }
    return res;
}

static int compare(const void *a, const void *b)
{
    const struct weft_candidate *x = a, *y = b;
    const int refused = (x->state == WEFT_CANDIDATE_REFUSED) - (y->state == WEFT_CANDIDATE_REFUSED);
    return refused ? refused : (x->seconds > y->seconds) - (x->seconds < y->seconds);
}

static void sort_candidates(struct chooser *c)
{
    struct weft_choice *choice = c->choice;
    qsort(choice->candidates, choice->count, sizeof *choice->candidates, compare);
    for (size_t i = 0; i < choice->count; i++) {
        struct weft_candidate *candidate = &choice->candidates[i];
        const int best = choice->best;
        if (candidate->state == WEFT_CANDIDATE_CHOSEN)
            choice->chosen = (int)i;
        if (is_open(candidate) && !(candidate->bound <= c->params->max_error))
            candidate->state = WEFT_CANDIDATE_EXCEEDS;
        if (candidate->state != WEFT_CANDIDATE_REFUSED && !candidate->estimated &&
            (best < 0 || candidate->bound < choice->candidates[best].bound))
            choice->best = (int)i;
    }
}

// Where no estimate was worth a plan, one tells what the best would be.
static enum weft_result plan_best(struct chooser *c)
{
    struct weft_candidate *least = NULL;
    for (size_t i = 0; i < c->choice->count; i++) {
        struct weft_candidate *candidate = &c->choice->candidates[i];
        if (candidate->state == WEFT_CANDIDATE_REFUSED)
            continue;
        if (!candidate->estimated)
            return WEFT_OK;
        if (!least || candidate->bound < least->bound)
            least = candidate;
    }
    return least ? plan_passes(c, least) : WEFT_OK;
}

static enum weft_result prepare(struct chooser *c)
{
    const struct weft_method usual = {.layout = WEFT_LAYOUT_INTERLEAVED};
    const struct weft_method_params params = way_params(c, &usual);
    struct weft_slice_params slice = weft_method_slice_params(&params);
    slice.layout = WEFT_LAYOUT_AUTO; // whatever fits
    enum weft_result res = weft_slice_plan_create(c->volume, &slice, &c->base);
    if (res != WEFT_OK)
        return res;
    c->slope = weft_slice_largest_slope(&c->base->info.kernel);
    if (!c->params->statistics)
        return weft_footprint_statistics(c->base->footprint, c->params->slice.progress,
                                         &c->choice->statistics);
    c->choice->statistics = *c->params->statistics;
    return WEFT_OK;
}

enum weft_result weft_choose(weft_volume *volume, const struct weft_choose_params *params,
                             struct weft_choice *out)
{
    *out = (struct weft_choice){.chosen = -1, .best = -1};
    struct chooser c = {.params = params,
                        .model = params->model ? params->model : &weft_cost_default,
                        .volume = volume,
                        .choice = out,
                        .quiet = {write_quietly, &c}};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (!(params->max_error >= 0.0)) {
        weft_error(params->slice.log, "an error budget must be 0 or more: %g", params->max_error);
        goto fail;
    }
    res = prepare(&c);
    if (res == WEFT_OK)
        res = list_candidates(&c);
    if (res == WEFT_OK)
        res = find_cheapest(&c);
    if (res == WEFT_OK)
        res = plan_best(&c);
    if (res != WEFT_OK)
        goto fail;
    sort_candidates(&c);
fail:
    weft_slice_plan_destroy(&c.base);
    if (res != WEFT_OK)
        weft_choice_clear(out);
    return res;
}

void weft_choice_clear(struct weft_choice *choice)
{
    if (!choice)
        return;
    free(choice->candidates);
    weft_method_plan_destroy(&choice->plan);
    *choice = (struct weft_choice){.chosen = -1, .best = -1};
}
