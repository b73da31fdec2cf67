// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/kernel_nd.h"
#include "filter/kernels/stretch.h"
#include "passes/separable/separable_impl.h"

// ---- the request --------------------------------------------------------------------------------

static bool in_range(int size)
{
    return size >= 1 && size <= WEFT_SEPARABLE_MAX_SIZE;
}

static enum weft_result check_positions(const struct weft_log *log, char axis, const double *at,
                                        int count)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(at[i])) {
            weft_error(log, "separable filtering: position %g of pixel %d along %c", at[i], i,
                       axis);
            return WEFT_ERR_ARGUMENT;
        }
    }
    return WEFT_OK;
}

static enum weft_result check_kernel(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK || !weft_kernel_is_radial(kernel, 2))
        return res;
    weft_error(log, "separable filtering: kernel %s is radial, not separable", kernel->info->name);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result check_engine(const struct weft_separable_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require_enum(p->log, p->engine, WEFT_ENGINE_CPU);
    weft_require_enum(p->log, p->sums, WEFT_SUMS_DOUBLE);
    weft_require_enum(p->log, p->boundary, WEFT_BOUNDARY_BORDER);
    if (p->sums == WEFT_SUMS_FLOAT || p->engine == WEFT_ENGINE_CPU)
        return WEFT_OK;
    weft_error(p->log, "OpenGL sums in single precision: sums in double need the CPU engine");
    return WEFT_ERR_UNSUPPORTED;
fail:
    return res;
}

static double stretch_of(const struct weft_separable_params *p, int axis)
{
    return p->stretch[axis] == 0.0 ? 1.0 : p->stretch[axis];
}

// Each pixel has a weight for every tap.
static enum weft_result check_stretch(const struct weft_separable_params *p,
                                      const struct weft_kernel *kernel)
{
    const int positions[2] = {p->width, p->height};
    for (int a = 0; a < 2; a++) {
        const double stretch = stretch_of(p, a);
        if (!(stretch >= 1.0 && stretch <= WEFT_STRETCH_MAX)) {
            weft_error(p->log, "separable filtering: a kernel stretched by %g: 1 to %.0f", stretch,
                       WEFT_STRETCH_MAX);
            return WEFT_ERR_ARGUMENT;
        }
        if (stretch == 1.0)
            continue;
        if (kernel->prefiltered) {
            weft_error(p->log, "separable filtering: %s is prefiltered and cannot be stretched",
                       kernel->info->name);
            return WEFT_ERR_UNSUPPORTED;
        }
        const double weights = (double)weft_stretch_width(kernel, stretch) * positions[a];
        if (weights > WEFT_SEPARABLE_MAX_WEIGHTS) {
            weft_error(p->log,
                       "separable filtering: %.4g weights along an axis, of %d pixels and a kernel "
                       "stretched by %g: the limit is %d",
                       weights, positions[a], stretch, WEFT_SEPARABLE_MAX_WEIGHTS);
            return WEFT_ERR_LIMIT;
        }
    }
    return WEFT_OK;
}

static enum weft_result check(const struct weft_separable_params *p,
                              const struct weft_kernel *kernel)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->x && p->y);
    weft_require_enum(p->log, p->order, WEFT_AXIS_ORDER_Y_FIRST);
    if (!in_range(p->size[0]) || !in_range(p->size[1]) || !in_range(p->width) ||
        !in_range(p->height)) {
        weft_error(
            p->log,
            "separable filtering of %d x %d samples to %d x %d pixels: sides must be 1 to %d",
            p->size[0], p->size[1], p->width, p->height, WEFT_SEPARABLE_MAX_SIZE);
        goto fail;
    }
    res = check_engine(p);
    if (res == WEFT_OK)
        res = check_kernel(p->log, kernel);
    if (res == WEFT_OK)
        res = check_stretch(p, kernel);
    if (res == WEFT_OK)
        res = check_positions(p->log, 'x', p->x, p->width);
    if (res == WEFT_OK)
        res = check_positions(p->log, 'y', p->y, p->height);
fail:
    return res;
}

// ---- the request of a run -----------------------------------------------------------------------

static bool is_within(const struct weft_rectangle *a, const struct weft_rectangle *b)
{
    return a->x >= b->x && a->y >= b->y && a->x + a->width <= b->x + b->width &&
           a->y + a->height <= b->y + b->height;
}

// The part's and, without a survey, that of all pixels.
static enum weft_result check_reach(const weft_separable_plan *plan,
                                    const struct weft_separable_run_params *p)
{
    const struct weft_rectangle reach =
        weft_separable_reach(plan, p->survey ? &p->part : &(struct weft_rectangle){0});
    if (is_within(&reach, &p->window))
        return WEFT_OK;
    weft_error(
        p->log,
        "separable filtering: samples from (%d, %d) on, %d x %d, where %s reach %d x %d from "
        "(%d, %d) on",
        p->window.x, p->window.y, p->window.width, p->window.height,
        p->survey ? "the part's pixels" : "all pixels, which are surveyed,", reach.width,
        reach.height, reach.x, reach.y);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_separable_check_samples(const weft_separable_plan *plan,
                                              struct weft_separable_run_params *params)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->samples || params->wide);
    weft_require(params->log, !params->wide || plan->info.sums == WEFT_SUMS_DOUBLE);
    weft_require(params->log, isfinite(params->border));
    return weft_rectangle_within(params->log, &params->window, plan->info.size[0],
                                 plan->info.size[1], &params->window);
fail:
    return res;
}

enum weft_result weft_separable_check_run(const weft_separable_plan *plan,
                                          const struct weft_separable_run_params *params,
                                          struct weft_separable_run_params *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = *params;
    weft_require(params->log, params->pixels || params->texture);
    weft_require(params->log, !params->texture || plan->info.engine == WEFT_ENGINE_GL);
    res = weft_separable_check_samples(plan, out);
    if (res == WEFT_OK)
        res = weft_rectangle_within(params->log, &params->part, plan->info.width, plan->info.height,
                                    &out->part);
    if (res == WEFT_OK)
        res = check_reach(plan, out);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    out->stride = params->stride ? params->stride : out->part.width;
    if (out->stride < out->part.width) {
        weft_error(params->log,
                   "separable filtering: a stride of %lld floats is less than the %d pixels",
                   (long long)params->stride, out->part.width);
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

// ---- an axis ------------------------------------------------------------------------------------

// Beyond the edges all taps are alike, or the same as a period away.
static int32_t move_tap(const struct weft_separable_axis *axis, int64_t tap)
{
    const int64_t size = axis->size, width = axis->width;
    const bool border = axis->boundary == WEFT_BOUNDARY_BORDER;
    const int64_t low = border ? -width : 1 - width, high = border ? size : size - 1;
    const int64_t period = axis->boundary == WEFT_BOUNDARY_MIRROR ? 2 * (size - 1) : size;
    if (tap >= low && tap <= high)
        return (int32_t)tap;
    if (axis->boundary == WEFT_BOUNDARY_CLAMP || border)
        return (int32_t)(tap < low ? low : high);
    const int64_t rest = period ? tap % period : 0;
    return (int32_t)(rest < 0 ? rest + period : rest);
}

// The sample that a position is: all of its weights are 0 but for one of 1. -1: none.
static int32_t whole_sample(const struct weft_separable_axis *axis, double at, int64_t first,
                            const double *weights)
{
    int64_t sample = -1;
    if (axis->stretch > 1.0 || (axis->width > 1 && at != rint(at)))
        return -1;
    for (int j = 0; j < axis->width; j++) {
        if (weights[j] == 1.0)
            sample = weft_boundary_index(axis->boundary, first + j, axis->size);
        else if (weights[j] != 0.0)
            return -1;
    }
    return (int32_t)sample;
}

void weft_separable_weights(const struct weft_kernel *kernel,
                            const struct weft_separable_axis *axis, int position, double *weights)
{
    weft_stretch_weights(kernel, axis->stretch, axis->at[position], weights);
}

static void fill_axis(const struct weft_kernel *kernel, struct weft_separable_axis *axis,
                      double *weights)
{
    int32_t high = INT32_MIN;
    axis->growth = 1.0;
    axis->low = INT32_MAX;
    for (int i = 0; i < axis->positions; i++) {
        double sum = 0.0;
        const int64_t first = weft_stretch_weights(kernel, axis->stretch, axis->at[i], weights);
        for (int j = 0; j < axis->width; j++)
            sum += fabs(weights[j]);
        axis->growth = fmax(axis->growth, sum);
        axis->first[i] = move_tap(axis, first);
        axis->whole[i] = whole_sample(axis, axis->at[i], first, weights);
        axis->low = axis->first[i] < axis->low ? axis->first[i] : axis->low;
        high = axis->first[i] > high ? axis->first[i] : high;
    }
    axis->span = high - axis->low + axis->width;
}

static enum weft_result create_axis(const weft_separable_plan *plan, const double *at,
                                    struct weft_separable_axis *axis)
{
    const size_t count = (size_t)axis->positions;
    struct weft_separable_taps taps;
    axis->width = (int)weft_stretch_width(&plan->info.kernel, axis->stretch);
    axis->at = malloc(count * sizeof *axis->at);
    axis->first = malloc(count * sizeof *axis->first);
    axis->whole = malloc(count * sizeof *axis->whole);
    double *weights = malloc((size_t)axis->width * sizeof *weights);
    if (!axis->at || !axis->first || !axis->whole || !weights) {
        weft_error(plan->log, "not enough memory for %d pixels", axis->positions);
        free(weights);
        return WEFT_ERR_MEMORY;
    }
    memcpy(axis->at, at, count * sizeof *axis->at);
    fill_axis(&plan->info.kernel, axis, weights);
    free(weights);
    const enum weft_result res = weft_separable_taps_create(plan->log, axis, &taps);
    if (res != WEFT_OK)
        return res;
    weft_separable_taps_number(axis, 0, axis->positions, &taps);
    axis->all_taps = taps.count;
    weft_separable_taps_destroy(&taps);
    weft_separable_axis_reach(axis, 0, axis->positions, axis->reach);
    return WEFT_OK;
}

// ---- the order of the axes ----------------------------------------------------------------------

// For all pixels. On GL by texels of four columns: along x, each of the four has its own weights
// and taps. On the CPU by vectors: along x weights are read for each pixel, and rows interleaved.
static double count_fetches(const weft_separable_plan *plan, int first_axis)
{
    const struct weft_separable_axis *x = &plan->axis[0], *y = &plan->axis[1];
    const bool gl = plan->info.engine == WEFT_ENGINE_GL;
    const double lanes = gl ? WEFT_SEPARABLE_LANES : 1.0;
    const double along_y = gl ? 1.0 + ceil(y->width / lanes) + y->width : y->width;
    const double along_x = gl ? lanes * (1.0 + ceil(x->width / lanes) + x->width) : 2.0 * x->width;
    const double columns = ceil(x->positions / lanes), taps = ceil(x->all_taps / lanes);
    return first_axis == 0 ? columns * y->all_taps * along_x + columns * y->positions * along_y
                           : taps * y->positions * along_y + columns * y->positions * along_x;
}

static void choose_order(weft_separable_plan *plan, enum weft_axis_order asked)
{
    const double fetches[2] = {count_fetches(plan, 0), count_fetches(plan, 1)};
    const int first =
        asked == WEFT_AXIS_ORDER_AUTO ? fetches[1] < fetches[0] : asked == WEFT_AXIS_ORDER_Y_FIRST;
    plan->info.first_axis = first;
    plan->info.fetches_per_pixel = fetches[first] / plan->info.width / plan->info.height;
}

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result fill(const struct weft_separable_params *p, weft_separable_plan *plan)
{
    const int positions[2] = {p->width, p->height};
    for (int a = 0; a < 2; a++)
        plan->axis[a] = (struct weft_separable_axis){.positions = positions[a],
                                                     .size = p->size[a],
                                                     .stretch = plan->info.stretch[a],
                                                     .boundary = p->boundary};
    enum weft_result res = create_axis(plan, p->x, &plan->axis[0]);
    if (res == WEFT_OK)
        res = create_axis(plan, p->y, &plan->axis[1]);
    if (res != WEFT_OK)
        return res;
    for (int a = 0; a < 2; a++) {
        plan->info.taps[a] = plan->axis[a].width;
        plan->info.gain[a] = plan->axis[a].growth;
    }
    choose_order(plan, p->order);
    return WEFT_OK;
}

enum weft_result weft_separable_plan_create(const struct weft_separable_params *params,
                                            weft_separable_plan **out)
{
    struct weft_kernel kernel = params->kernel;
    *out = NULL;
    if (!kernel.info)
        weft_kernel_parse(params->log, "catmull-rom", &kernel);
    enum weft_result res = check(params, &kernel);
    if (res != WEFT_OK)
        return res;
    weft_separable_plan *plan = calloc(1, sizeof *plan);
    if (!plan) {
        weft_error(params->log, "not enough memory for a plan of separable filtering");
        return WEFT_ERR_MEMORY;
    }
    *plan = (weft_separable_plan){
        .info = {.kernel = kernel,
                 .size = {params->size[0], params->size[1]},
                 .width = params->width,
                 .height = params->height,
                 .stretch = {stretch_of(params, 0), stretch_of(params, 1)},
                 .boundary = params->boundary,
                 .engine = params->engine,
                 .sums = params->sums},
        .memory_bytes = params->memory_bytes ? params->memory_bytes : UINT64_C(1) << 30,
        .log = params->log,
    };
    res = fill(params, plan);
    if (res == WEFT_OK)
        *out = plan;
    else
        weft_separable_plan_destroy(&plan);
    return res;
}

void weft_separable_plan_destroy(weft_separable_plan **plan)
{
    if (!plan || !*plan)
        return;
    for (int a = 0; a < 2; a++) {
        free((*plan)->axis[a].at);
        free((*plan)->axis[a].first);
        free((*plan)->axis[a].whole);
    }
    free(*plan);
    *plan = NULL;
}

const struct weft_separable_info *weft_separable_plan_get_info(const weft_separable_plan *plan)
{
    return &plan->info;
}
