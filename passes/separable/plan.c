// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/kernel_nd.h"
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
    if (p->boundary != WEFT_BOUNDARY_CLAMP || p->stretch[0] > 1.0 || p->stretch[1] > 1.0) {
        weft_error(p->log,
                   "separable filtering with boundary %s, stretched by %g and %g, is not "
                   "built yet",
                   weft_boundary_names[p->boundary], p->stretch[0], p->stretch[1]);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (p->sums == WEFT_SUMS_FLOAT || p->engine == WEFT_ENGINE_CPU)
        return WEFT_OK;
    weft_error(p->log, "OpenGL sums in single precision: sums in double need the CPU engine");
    return WEFT_ERR_UNSUPPORTED;
fail:
    return res;
}

static enum weft_result check(const struct weft_separable_params *p,
                              const struct weft_kernel *kernel)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->x && p->y);
    weft_require(p->log, p->first_axis >= 0 && p->first_axis <= 2);
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
    weft_require(params->log, params->pixels);
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

// ---- taps ---------------------------------------------------------------------------------------

enum weft_result weft_separable_taps_create(const struct weft_log *log, int width,
                                            const struct weft_separable_axis *axis,
                                            struct weft_separable_taps *out)
{
    // Taps from 1 - width to size + width - 2.
    const size_t taps = (size_t)axis->size + 2 * (size_t)width - 2;
    *out = (struct weft_separable_taps){
        .sample = malloc(taps * sizeof *out->sample),
        .place = malloc(taps * sizeof *out->place),
    };
    if (out->sample && out->place)
        return WEFT_OK;
    weft_error(log, "not enough memory for the taps of %d pixels and %d samples", axis->positions,
               axis->size);
    weft_separable_taps_destroy(out);
    return WEFT_ERR_MEMORY;
}

void weft_separable_taps_destroy(struct weft_separable_taps *taps)
{
    free(taps->sample);
    free(taps->place);
    *taps = (struct weft_separable_taps){0};
}

void weft_separable_taps_number(const struct weft_separable_axis *axis, int width, int from, int to,
                                struct weft_separable_taps *taps)
{
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (int i = from; i < to; i++) {
        low = axis->first[i] < low ? axis->first[i] : low;
        high = axis->first[i] > high ? axis->first[i] : high;
    }
    int32_t *place = taps->place + (width - 1); // of tap 0
    const int32_t end = high + width;
    memset(place + low, 0, (size_t)(end - low) * sizeof *place);
    for (int i = from; i < to; i++)
        place[axis->first[i]] = 1;
    taps->count = 0;
    int left = 0; // taps that a position before needs
    for (int32_t tap = low; tap < end; tap++) {
        left = place[tap] ? width : left - 1;
        place[tap] = taps->count;
        if (left > 0)
            taps->sample[taps->count++] = tap < 0 ? 0 : tap >= axis->size ? axis->size - 1 : tap;
    }
}

int weft_separable_most_taps(const struct weft_separable_axis *axis, int width, int cut,
                             struct weft_separable_taps *taps)
{
    int most = 0;
    for (int from = 0; from < axis->positions; from += cut) {
        const int left = axis->positions - from;
        weft_separable_taps_number(axis, width, from, from + (left < cut ? left : cut), taps);
        most = taps->count > most ? taps->count : most;
    }
    return most;
}

float weft_separable_single_weight(bool skips_zeros, double weight)
{
    const bool vanishes = fabs(weight) < FLT_MIN && weight != 0.0;
    return skips_zeros && vanishes ? (float)copysign(FLT_MIN, weight) : (float)weight;
}

// ---- an axis ------------------------------------------------------------------------------------

static int32_t clamp_tap(const struct weft_separable_axis *axis, int width, int64_t tap)
{
    const int64_t low = 1 - width, high = axis->size - 1;
    return (int32_t)(tap < low ? low : tap > high ? high : tap);
}

// The sample that a position is: all of its weights are 0 but for one of 1. -1: none.
static int32_t whole_sample(const struct weft_kernel *kernel, double at, int64_t first,
                            const double *weights, int size)
{
    int64_t sample = -1;
    if (kernel->width > 1 && at != rint(at))
        return -1;
    for (int j = 0; j < kernel->width; j++) {
        if (weights[j] == 1.0)
            sample = first + j < 0 ? 0 : first + j >= size ? size - 1 : first + j;
        else if (weights[j] != 0.0)
            return -1;
    }
    return (int32_t)sample;
}

static void fill_axis(const struct weft_kernel *kernel, struct weft_separable_axis *axis)
{
    axis->growth = 1.0;
    for (int i = 0; i < axis->positions; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
        const int64_t first = weft_kernel_weights(kernel, axis->at[i], weights);
        for (int j = 0; j < kernel->width; j++)
            sum += fabs(weights[j]);
        axis->growth = fmax(axis->growth, sum);
        axis->first[i] = clamp_tap(axis, kernel->width, first);
        axis->whole[i] = whole_sample(kernel, axis->at[i], first, weights, axis->size);
    }
}

static enum weft_result create_axis(const weft_separable_plan *plan, const double *at,
                                    struct weft_separable_axis *axis)
{
    const int width = plan->info.kernel.width;
    const size_t count = (size_t)axis->positions;
    struct weft_separable_taps taps;
    axis->at = malloc(count * sizeof *axis->at);
    axis->first = malloc(count * sizeof *axis->first);
    axis->whole = malloc(count * sizeof *axis->whole);
    if (!axis->at || !axis->first || !axis->whole) {
        weft_error(plan->log, "not enough memory for %d pixels", axis->positions);
        return WEFT_ERR_MEMORY;
    }
    memcpy(axis->at, at, count * sizeof *axis->at);
    fill_axis(&plan->info.kernel, axis);
    const enum weft_result res = weft_separable_taps_create(plan->log, width, axis, &taps);
    if (res != WEFT_OK)
        return res;
    weft_separable_taps_number(axis, width, 0, axis->positions, &taps);
    axis->all_taps = taps.count;
    // All taps are numbered, in order.
    axis->reach[0] = taps.sample[0];
    axis->reach[1] = taps.sample[taps.count - 1];
    weft_separable_taps_destroy(&taps);
    return WEFT_OK;
}

// ---- what a part reads --------------------------------------------------------------------------

// From the first to the last sample of positions `from` to `to`, exclusive.
void weft_separable_axis_reach(const struct weft_separable_axis *axis, int width, int from, int to,
                               int reach[2])
{
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (int i = from; i < to; i++) {
        low = axis->first[i] < low ? axis->first[i] : low;
        high = axis->first[i] > high ? axis->first[i] : high;
    }
    const int last = axis->size - 1, end = high + width - 1;
    reach[0] = low < 0 ? 0 : low;
    reach[1] = end > last ? last : end < 0 ? 0 : end;
}

struct weft_rectangle weft_separable_reach(const weft_separable_plan *plan,
                                           const struct weft_rectangle *part)
{
    struct weft_rectangle pixels;
    int x[2], y[2];
    if (weft_rectangle_within(NULL, part, plan->info.width, plan->info.height, &pixels) != WEFT_OK)
        return (struct weft_rectangle){0};
    weft_separable_axis_reach(&plan->axis[0], plan->info.kernel.width, pixels.x,
                              pixels.x + pixels.width, x);
    weft_separable_axis_reach(&plan->axis[1], plan->info.kernel.width, pixels.y,
                              pixels.y + pixels.height, y);
    return (struct weft_rectangle){x[0], y[0], x[1] - x[0] + 1, y[1] - y[0] + 1};
}

// ---- the order of the axes ----------------------------------------------------------------------

// For all pixels. On GL by texels of four columns: along x, each of the four has its own weights
// and taps. On the CPU by vectors: along x weights are read for each pixel, and rows interleaved.
static double count_fetches(const weft_separable_plan *plan, int first_axis)
{
    const struct weft_separable_axis *x = &plan->axis[0], *y = &plan->axis[1];
    const double width = plan->info.kernel.width;
    const bool gl = plan->info.engine == WEFT_ENGINE_GL;
    const double lanes = gl ? WEFT_SEPARABLE_LANES : 1.0;
    const double along_y = gl ? 1.0 + ceil(width / lanes) + width : width;
    const double along_x = gl ? lanes * along_y : 2.0 * width;
    const double columns = ceil(x->positions / lanes), taps = ceil(x->all_taps / lanes);
    return first_axis == 0 ? columns * y->all_taps * along_x + columns * y->positions * along_y
                           : taps * y->positions * along_y + columns * y->positions * along_x;
}

static void choose_order(weft_separable_plan *plan, int asked)
{
    const double fetches[2] = {count_fetches(plan, 0), count_fetches(plan, 1)};
    const int first = asked ? asked - 1 : fetches[1] < fetches[0];
    plan->info.first_axis = first;
    plan->info.fetches_per_pixel = fetches[first] / plan->info.width / plan->info.height;
}

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result fill(const struct weft_separable_params *p, weft_separable_plan *plan)
{
    plan->axis[0] = (struct weft_separable_axis){.positions = p->width, .size = p->size[0]};
    plan->axis[1] = (struct weft_separable_axis){.positions = p->height, .size = p->size[1]};
    enum weft_result res = create_axis(plan, p->x, &plan->axis[0]);
    if (res == WEFT_OK)
        res = create_axis(plan, p->y, &plan->axis[1]);
    if (res == WEFT_OK)
        choose_order(plan, p->first_axis);
    return res;
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
