// SPDX-License-Identifier: BSD-3-Clause
#include "tools/effect/plan.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/effect/lights/lights.h"
#include "tools/effect/needs.h"
#include "tools/effect/samples.h"

const char *const effect_place_names[] = {"pixel", "lens", "lamp", NULL};

// ---- checks -------------------------------------------------------------------------------------

static bool complain(const struct effect_params *params, const char *what, double value,
                     const char *range)
{
    log_error(params->log, "%s is %g: %s", what, value, range);
    return false;
}

static bool check_scenes(const struct effect_params *params)
{
    const bool fades = params->effects & EFFECT_FADE;
    if (params->scene_count < (fades ? 2 : 1) ||
        params->scene_count > (fades ? EFFECT_MAX_SCENES : 1))
        return complain(params, "the number of scenes", params->scene_count,
                        fades ? "a fade has 2 to 16" : "only a fade has several");
    for (int i = 0; i < params->scene_count; i++) {
        if (!params->scene[i]) {
            log_error(params->log, "scene %d is missing", i + 1);
            return false;
        }
        if (fades && !isfinite(params->fade[i]))
            return complain(params, "the weight of a scene", params->fade[i], "it must be finite");
    }
    return true;
}

static bool check_lamps(const struct effect_params *params)
{
    if (!(params->effects & EFFECT_SOFT_SHADOW))
        return true;
    for (int s = 0; s < params->scene_count; s++)
        for (int i = 0; i < params->scene[s]->light_count; i++)
            if (params->scene[s]->lights[i].shape != SCENE_LIGHT_POINT)
                return true;
    log_error(params->log, "soft-shadow: scene %s has no square or round lamp",
              params->scene[0]->name);
    return false;
}

static bool check(const struct effect_params *params)
{
    const unsigned effects = params->effects;
    if (effects == 0 || effects >= 1u << EFFECT_COUNT) {
        log_error(params->log, "no effects %#x", effects);
        return false;
    }
    if ((effects & EFFECT_SOFT_SHADOW) && (effects & EFFECT_RADIOSITY)) {
        log_error(params->log, "radiosity has soft shadows: leave soft-shadow out");
        return false;
    }
    if (params->size[0] < 1 || params->size[1] < 1)
        return complain(params, "a side of the picture", fmin(params->size[0], params->size[1]),
                        "it must be above 0");
    if (!(params->time[0] >= 0.0 && params->time[0] <= params->time[1] && params->time[1] <= 1.0)) {
        log_error(params->log, "the shutter is open from %g to %g: it must be within 0 to 1",
                  params->time[0], params->time[1]);
        return false;
    }
    if (params->frames < 0)
        return complain(params, "the number of frames", (double)params->frames,
                        "it must be above 0");
    if (params->clamp < 0.0 || isinf(params->clamp))
        return complain(params, "the clamp", params->clamp, "it must be finite, and 0 or more");
    return check_scenes(params) && check_lamps(params);
}

// ---- the lens -----------------------------------------------------------------------------------

static double find_target(const struct weft_camera *camera)
{
    const double *from = camera->eye, *to = camera->target;
    return hypot(hypot(to[0] - from[0], to[1] - from[1]), to[2] - from[2]);
}

// Writes what the lens is, and checks it against the cameras of all scenes.
static bool find_lens(const struct effect_params *params, struct effect_plan *plan)
{
    const double middle = 0.5 * (params->time[0] + params->time[1]);
    if (!(params->effects & EFFECT_DOF))
        return true;
    for (int s = 0; s < params->scene_count; s++) {
        struct weft_camera camera;
        scene_camera_at(params->scene[s], middle, &camera);
        if (s == 0)
            plan->focus = isnan(params->focus) ? find_target(&camera) : params->focus;
        if (!(plan->focus > camera.near_distance) || isinf(plan->focus)) {
            log_error(params->log,
                      "the plane in focus is at %g: it must lie beyond the near plane, at %g",
                      plan->focus, camera.near_distance);
            return false;
        }
    }
    plan->aperture = isnan(params->aperture) ? plan->focus / 20.0 : params->aperture;
    if (!(plan->aperture >= 0.0) || isinf(plan->aperture))
        return complain(params, "the aperture", plan->aperture, "it must be finite, and 0 or more");
    return true;
}

// ---- scenes -------------------------------------------------------------------------------------

// The scenes' shares of the picture; those of a fade are its weights.
static enum weft_result share_out(const struct effect_params *params,
                                  double share[EFFECT_MAX_SCENES])
{
    bool all_zero = true;
    for (int s = 0; s < params->scene_count; s++) {
        share[s] = params->effects & EFFECT_FADE ? params->fade[s] : 0.0;
        all_zero = all_zero && share[s] == 0.0;
    }
    if (all_zero)
        return weft_weights_even(params->log, params->scene_count, share, NULL);
    return weft_weights_normalise(params->log, params->scene_count, share, NULL);
}

// Makes room for so many frames more.
static enum weft_result grow(const struct effect_params *params, struct effect_plan *plan,
                             int64_t more)
{
    if (more > EFFECT_MAX_FRAMES - plan->count) {
        log_error(params->log, "%" PRId64 " frames or more: a plan has %d at most",
                  plan->count + more, EFFECT_MAX_FRAMES);
        return WEFT_ERR_LIMIT;
    }
    struct effect_frame *frames =
        realloc(plan->frames, (size_t)(plan->count + more) * sizeof *frames);
    if (!frames)
        return WEFT_ERR_MEMORY;
    plan->frames = frames;
    return WEFT_OK;
}

// Lights are made once, at the middle of the time.
static void warn_of_motion(const struct effect_params *params, const struct scene *scene)
{
    if (!(params->effects & EFFECT_MOTION_BLUR))
        return;
    for (int i = 0; i < scene->object_count; i++)
        if (scene->objects[i].path.count > 1) {
            log_warn(params->log,
                     "scene %s moves, and its virtual lights do not: they stay where they are at "
                     "the middle of the time",
                     scene->name);
            return;
        }
}

static enum weft_result make_lights(const struct effect_params *params, int scene, int64_t count,
                                    struct effect_virtual_lights *out)
{
    *out = (struct effect_virtual_lights){0};
    if (!(params->effects & EFFECT_RADIOSITY))
        return WEFT_OK;
    warn_of_motion(params, params->scene[scene]);
    return effect_lights_make(
        effect_lights_params(.scene = params->scene[scene], .count = count, .paths = params->paths,
                             .seed = params->seed, .clamp = params->clamp,
                             .time = 0.5 * (params->time[0] + params->time[1]), .log = params->log),
        out);
}

// Appends a scene's frames, which add up to `share`.
static enum weft_result plan_scene(const struct effect_params *params, int scene, int64_t count,
                                   double share, struct effect_plan *plan)
{
    struct effect_virtual_lights lights;
    enum weft_result res = make_lights(params, scene, count, &lights);
    if (res != WEFT_OK)
        goto fail;
    if (lights.light)
        count = lights.count;
    res = grow(params, plan, count);
    if (res != WEFT_OK)
        goto fail;
    if (plan->count == 0) {
        plan->mean_reflectance = lights.mean_reflectance;
        plan->clamp = lights.most;
    }
    plan->paths += lights.paths;
    struct effect_frame *frames = plan->frames + plan->count;
    res = effect_sample(&(struct effect_sampling){.params = params,
                                                  .scene = scene,
                                                  .count = (int)count,
                                                  .lights = lights.light,
                                                  .tell = plan->count == 0},
                        frames, plan);
    if (res != WEFT_OK)
        goto fail;
    for (int64_t k = 0; k < count; k++)
        frames[k].weight *= share;
    plan->count += count;
fail:
    effect_lights_clear(&lights);
    return res;
}

// Puts the frames of a fade's scenes in turn, so that the first ones are of all scenes alike.
static enum weft_result interleave(struct effect_plan *plan)
{
    int64_t first[EFFECT_MAX_SCENES] = {0}, end[EFFECT_MAX_SCENES] = {0}, at[EFFECT_MAX_SCENES];
    struct effect_frame *out = malloc((size_t)plan->count * sizeof *out);
    if (!out)
        return WEFT_ERR_MEMORY;
    for (int64_t k = plan->count - 1; k >= 0; k--) {
        const int s = plan->frames[k].scene;
        end[s] = end[s] ? end[s] : k + 1;
        first[s] = at[s] = k;
    }
    for (int64_t k = 0; k < plan->count; k++) {
        int next = -1;
        double least = INFINITY;
        for (int s = 0; s < plan->scene_count; s++) {
            const double done = ((double)(at[s] - first[s]) + 0.5) / (double)(end[s] - first[s]);
            if (end[s] > 0 && at[s] < end[s] && done < least) {
                least = done;
                next = s;
            }
        }
        out[k] = plan->frames[at[next]++];
    }
    free(plan->frames);
    plan->frames = out;
    return WEFT_OK;
}

// ---- all of it ----------------------------------------------------------------------------------

static enum weft_result tell_weights(const struct weft_log *log, struct effect_plan *plan)
{
    double *weights = malloc((size_t)plan->count * sizeof *weights);
    if (!weights)
        return WEFT_ERR_MEMORY;
    effect_plan_get_weights(plan, weights);
    const enum weft_result res =
        weft_weights_normalise(log, (int)plan->count, weights, &plan->weights);
    free(weights);
    return res;
}

enum weft_result effect_plan_make(const struct effect_params *params, struct effect_plan *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    double share[EFFECT_MAX_SCENES];
    *out = (struct effect_plan){0};
    if (!check(params) || !find_lens(params, out))
        goto fail;
    out->effects = params->effects;
    out->size[0] = params->size[0];
    out->size[1] = params->size[1];
    out->scene_count = params->scene_count;
    res = share_out(params, share);
    if (res != WEFT_OK)
        goto fail;
    res = effect_needs_find(params, share, out);
    if (res != WEFT_OK)
        goto fail;
    const int64_t count = params->frames ? params->frames : effect_needs_fit(params, out->needed);
    for (int s = 0; s < params->scene_count && res == WEFT_OK; s++)
        if (share[s] != 0.0)
            res = plan_scene(params, s, count, share[s], out);
    if (res == WEFT_OK && params->scene_count > 1)
        res = interleave(out);
    if (res == WEFT_OK)
        res = tell_weights(params->log, out);
fail:
    if (res != WEFT_OK)
        effect_plan_clear(out);
    return res;
}

void effect_plan_clear(struct effect_plan *plan)
{
    if (!plan)
        return;
    free(plan->frames);
    *plan = (struct effect_plan){0};
}

void effect_plan_get_weights(const struct effect_plan *plan, double *weights)
{
    for (int64_t k = 0; k < plan->count; k++)
        weights[k] = plan->frames[k].weight;
}
