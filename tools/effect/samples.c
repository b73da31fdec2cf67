// SPDX-License-Identifier: BSD-3-Clause
#include "tools/effect/samples.h"

#include <math.h>
#include <stdlib.h>

#include "tools/common/random.h"
#include "tools/render/lamps.h"

// ---- orders -------------------------------------------------------------------------------------

// Fisher and Yates' shuffle. The remainder prefers small numbers by 2^-43 at most.
static void permute(uint64_t seed, enum effect_dimension dimension, int count, int *out)
{
    uint64_t state = seed;
    state = random_next(&state) + (uint64_t)dimension;
    for (int i = 0; i < count; i++)
        out[i] = i;
    for (int i = count - 1; i > 0; i--) {
        const int j = (int)(random_next(&state) % ((uint64_t)i + 1)), at = out[i];
        out[i] = out[j];
        out[j] = at;
    }
}

// Numbers whose bits are mirrored, those that are not below count left out: their ranks.
static void spread(int count, int *out)
{
    int bits = 0, rank = 0;
    while (1 << bits < count)
        bits++;
    for (int r = 0; r < 1 << bits; r++) {
        int k = 0;
        for (int b = 0; b < bits; b++)
            k |= (r >> b & 1) << (bits - 1 - b);
        if (k < count)
            out[k] = rank++;
    }
}

void effect_order_make(enum effect_order order, uint64_t seed, enum effect_dimension dimension,
                       int count, int *out)
{
    if (order == EFFECT_ORDER_PERMUTED)
        permute(seed, dimension, count, out);
    else if (order == EFFECT_ORDER_SPREAD)
        spread(count, out);
    else
        for (int i = 0; i < count; i++)
            out[i] = i;
}

// ---- one dimension after another ----------------------------------------------------------------

// What is at work: the frames so far, and room for a dimension's set.
struct work {
    const struct effect_sampling *sampling;
    struct effect_frame *frames;
    struct effect_plan *plan;
    int *order;
    double *weights, *times;
    bool is_first; // no dimension has been joined yet
};

static bool has(const struct work *work, enum effect_bit effect)
{
    return work->sampling->params->effects & effect;
}

// The order of a dimension whose set has `natural` as its own.
static void order_frames(struct work *work, enum effect_dimension dimension,
                         enum effect_order natural)
{
    const enum effect_order order = work->is_first ? natural : EFFECT_ORDER_PERMUTED;
    effect_order_make(order, work->sampling->params->seed, dimension, work->sampling->count,
                      work->order);
    if (work->is_first)
        work->plan->extends = order != EFFECT_ORDER_PERMUTED;
    work->is_first = false;
}

// The set that stands for none: of one point the middle, a table, or Sobol's.
static const struct weft_jitter_info *choose_jitter(int count)
{
    if (count == 1)
        return weft_jitter_find("grid");
    for (size_t i = 0; weft_jitter_list[i]; i++) {
        const struct weft_jitter_info *info = weft_jitter_list[i];
        // The tables are the sets that come in one size.
        if (info->counts && info->counts[0] == count && !info->counts[1])
            return info;
    }
    return weft_jitter_find("sobol");
}

// Makes a dimension's set, and orders frames.
static enum weft_result make_set(struct work *work, enum effect_dimension dimension,
                                 enum weft_jitter_shape shape, double size, struct weft_jitter *set)
{
    const struct effect_params *params = work->sampling->params;
    const int count = work->sampling->count;
    const enum weft_result res = weft_jitter_create(
        weft_jitter_params(.info = params->jitter ? params->jitter : choose_jitter(count),
                           .count = count, .seed = params->seed + (uint64_t)dimension,
                           .shape = shape, .size = size,
                           .centre = params->centre || !params->jitter, .log = params->log),
        set);
    if (res == WEFT_OK)
        order_frames(work, dimension,
                     set->info->extends ? EFFECT_ORDER_KEPT : EFFECT_ORDER_PERMUTED);
    return res;
}

// Tells a set, in units of `size`.
static enum weft_result tell_set(const struct work *work, enum effect_place place,
                                 enum weft_jitter_shape shape, double size,
                                 const struct weft_jitter *set)
{
    const struct effect_params *params = work->sampling->params;
    struct effect_set *out = &work->plan->set[place];
    if (!work->sampling->tell || out->info)
        return WEFT_OK;
    *out = (struct effect_set){
        .info = set->info,
        .count = set->count,
        .shape = shape,
        .size = size,
        .mean = {set->mean[0], set->mean[1]},
        .shift = {set->shift[0], set->shift[1]},
        .discrepancy = NAN,
    };
    if (set->count > EFFECT_MAX_DISCREPANCY)
        return WEFT_OK;
    struct weft_discrepancy discrepancy;
    const enum weft_result res = weft_discrepancy_compute(
        weft_discrepancy_params(.points = (const double(*)[2])set->points, .count = set->count,
                                .shape = shape, .size = size, .log = params->log),
        &discrepancy);
    out->discrepancy = discrepancy.value;
    return res;
}

// The filter's weights at the samples. Samples of a box weigh alike, those too that centring has
// carried past its rim.
static enum weft_result weigh_pixel(const struct work *work, const struct weft_jitter *set)
{
    const struct effect_params *params = work->sampling->params;
    const struct weft_kernel_info *info = params->filter.info;
    if (!info || info == weft_kernel_find("nearest"))
        return weft_weights_even(params->log, set->count, work->weights, NULL);
    return weft_weights_kernel(
        weft_weights_kernel_params(.points = (const double(*)[2])set->points, .count = set->count,
                                   .kernel = params->filter, .width = params->filter_width,
                                   .log = params->log),
        work->weights, NULL);
}

double effect_filter_width(const struct effect_params *params)
{
    if (params->filter_width != 0.0)
        return params->filter_width;
    return params->filter.info ? 2.0 * params->filter.support : 1.0;
}

static enum weft_result join_pixel(struct work *work)
{
    const double width = effect_filter_width(work->sampling->params);
    struct weft_jitter set;
    enum weft_result res = make_set(work, EFFECT_BY_PIXEL, WEFT_JITTER_SQUARE, width, &set);
    if (res != WEFT_OK)
        return res;
    res = weigh_pixel(work, &set);
    if (res != WEFT_OK)
        goto fail;
    for (int k = 0; k < set.count; k++) {
        struct effect_frame *frame = &work->frames[k];
        weft_camera_move_to(set.points[work->order[k]], frame->show.camera.move);
        frame->weight *= work->weights[work->order[k]];
    }
    for (int axis = 0; axis < 2; axis++) {
        set.mean[axis] = 0.0;
        for (int k = 0; k < set.count; k++)
            set.mean[axis] += work->weights[k] * set.points[k][axis];
    }
    res = tell_set(work, EFFECT_PIXEL, WEFT_JITTER_SQUARE, width, &set);
fail:
    weft_jitter_clear(&set);
    return res;
}

// A pinhole has one place.
static enum weft_result join_lens(struct work *work)
{
    const double aperture = work->plan->aperture;
    if (aperture == 0.0)
        return WEFT_OK;
    struct weft_jitter set;
    enum weft_result res = make_set(work, EFFECT_BY_LENS, WEFT_JITTER_DISC, aperture, &set);
    if (res != WEFT_OK)
        return res;
    for (int k = 0; k < set.count; k++) {
        struct weft_camera_frame *camera = &work->frames[k].show.camera;
        for (int axis = 0; axis < 2; axis++)
            camera->lens[axis] = set.points[work->order[k]][axis];
        camera->focus = work->plan->focus;
    }
    res = tell_set(work, EFFECT_LENS, WEFT_JITTER_DISC, aperture, &set);
    weft_jitter_clear(&set);
    return res;
}

static enum weft_result join_lamp(struct work *work, const struct scene_light *light, int index)
{
    const enum weft_jitter_shape shape =
        light->shape == SCENE_LIGHT_DISC ? WEFT_JITTER_DISC : WEFT_JITTER_SQUARE;
    struct weft_jitter set;
    enum weft_result res = make_set(work, EFFECT_BY_LAMP + index, shape, 1.0, &set);
    if (res != WEFT_OK)
        return res;
    for (int k = 0; k < set.count; k++)
        scene_lamp_at(light, set.points[work->order[k]], &work->frames[k].show.light[index]);
    res = tell_set(work, EFFECT_LAMP, shape, 1.0, &set);
    weft_jitter_clear(&set);
    return res;
}

static enum weft_result join_lamps(struct work *work)
{
    const struct scene *scene = work->sampling->params->scene[work->sampling->scene];
    enum weft_result res = WEFT_OK;
    for (int k = 0; k < work->sampling->count; k++)
        scene_lamps_in_middle(scene, &work->frames[k].show);
    for (int i = 0; i < scene->light_count && res == WEFT_OK; i++)
        if (has(work, EFFECT_SOFT_SHADOW) && scene->lights[i].shape != SCENE_LIGHT_POINT)
            res = join_lamp(work, &scene->lights[i], i);
    return res;
}

static enum weft_result join_time(struct work *work)
{
    const struct effect_params *params = work->sampling->params;
    const double *time = params->time;
    const enum weft_result res = weft_shutter_weights(
        params->log, &params->shutter, work->sampling->count, work->times, work->weights, NULL);
    if (res != WEFT_OK)
        return res;
    order_frames(work, EFFECT_BY_TIME, EFFECT_ORDER_SPREAD);
    for (int k = 0; k < work->sampling->count; k++) {
        const int at = work->order[k];
        work->frames[k].show.time = time[0] + (time[1] - time[0]) * work->times[at];
        work->frames[k].weight *= work->weights[at];
    }
    return WEFT_OK;
}

// Lights come in an order whose first ones share bounces as all do.
static void join_lights(struct work *work)
{
    order_frames(work, EFFECT_BY_LIGHTS, EFFECT_ORDER_KEPT);
    for (int k = 0; k < work->sampling->count; k++) {
        struct scene_frame *show = &work->frames[k].show;
        show->light[0] = work->sampling->lights[work->order[k]];
        show->light_count = 1;
        show->without_ambient = true;
    }
}

static enum weft_result join(struct work *work)
{
    enum weft_result res = WEFT_OK;
    if (has(work, EFFECT_ANTIALIAS))
        res = join_pixel(work);
    if (res == WEFT_OK && has(work, EFFECT_DOF))
        res = join_lens(work);
    if (res == WEFT_OK && has(work, EFFECT_RADIOSITY))
        join_lights(work);
    else if (res == WEFT_OK)
        res = join_lamps(work);
    if (res == WEFT_OK && has(work, EFFECT_MOTION_BLUR))
        res = join_time(work);
    return res;
}

// Weights of several dimensions, multiplied, add up to something else than 1.
static enum weft_result normalise(struct work *work)
{
    const int count = work->sampling->count;
    for (int k = 0; k < count; k++)
        work->weights[k] = work->frames[k].weight;
    const enum weft_result res =
        weft_weights_normalise(work->sampling->params->log, count, work->weights, NULL);
    for (int k = 0; k < count && res == WEFT_OK; k++)
        work->frames[k].weight = work->weights[k];
    return res;
}

enum weft_result effect_sample(const struct effect_sampling *sampling, struct effect_frame *frames,
                               struct effect_plan *plan)
{
    const struct effect_params *params = sampling->params;
    const size_t count = (size_t)sampling->count;
    struct work work = {
        .sampling = sampling,
        .frames = frames,
        .plan = plan,
        .order = calloc(count, sizeof *work.order),
        .weights = calloc(count, sizeof *work.weights),
        .times = calloc(count, sizeof *work.times),
        .is_first = true,
    };
    enum weft_result res = WEFT_ERR_MEMORY;
    if (!work.order || !work.weights || !work.times)
        goto fail;
    for (size_t k = 0; k < count; k++) {
        frames[k] = (struct effect_frame){.scene = sampling->scene, .weight = 1.0};
        frames[k].show.time = 0.5 * (params->time[0] + params->time[1]);
        frames[k].show.camera.size[0] = params->size[0];
        frames[k].show.camera.size[1] = params->size[1];
    }
    res = join(&work);
    if (res == WEFT_OK)
        res = normalise(&work);
fail:
    free(work.order);
    free(work.weights);
    free(work.times);
    return res;
}
