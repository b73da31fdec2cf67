// SPDX-License-Identifier: BSD-3-Clause
#include "tools/effect/needs.h"

#include <inttypes.h>
#include <math.h>

#include "tools/common/log.h"
#include "tools/effect/samples.h"

static double find_middle(const struct effect_params *params)
{
    return 0.5 * (params->time[0] + params->time[1]);
}

static double measure_motion(const struct effect_params *params, const struct scene *scene)
{
    return scene_longest_motion(scene, params->size, params->time[0], params->time[1]);
}

// The wider of the circles of the nearest and the farthest of what is in sight.
static double measure_circle(const struct effect_params *params, const struct scene *scene,
                             const struct effect_plan *plan)
{
    const double time = find_middle(params);
    double depth[2], widest = 0.0;
    struct weft_camera camera;
    scene_camera_at(scene, time, &camera);
    scene_depths(scene, params->size, time, &depth[0], &depth[1]);
    for (int i = 0; i < 2; i++)
        widest = fmax(widest, weft_camera_circle(&camera, params->size, plan->aperture, plan->focus,
                                                 depth[i]));
    return widest;
}

// As many to a pixel's area, however many pixels the filter is wide.
static int64_t count_samples(const struct effect_params *params)
{
    const double width = effect_filter_width(params);
    return width <= 1.0 ? EFFECT_FRAMES_ANTIALIAS
                        : (int64_t)ceil(EFFECT_FRAMES_ANTIALIAS * fmin(width * width, 1e9));
}

// Of one effect in one scene.
static struct effect_need find_need(const struct effect_params *params, const struct scene *scene,
                                    const struct effect_plan *plan, unsigned effect)
{
    struct effect_need need = {0};
    switch (effect) {
    case EFFECT_MOTION_BLUR:
        need.figure = measure_motion(params, scene);
        need.frames = weft_frames_for_motion(need.figure);
        break;
    case EFFECT_DOF:
        need.figure = measure_circle(params, scene, plan);
        need.frames = weft_frames_for_circle(need.figure);
        break;
    case EFFECT_SOFT_SHADOW:
        need.figure = scene_widest_penumbra(scene, params->size, find_middle(params));
        need.frames = weft_frames_for_penumbra(need.figure, 0.0);
        break;
    case EFFECT_ANTIALIAS:
        need.frames = count_samples(params);
        break;
    case EFFECT_RADIOSITY:
        need.frames = EFFECT_FRAMES_RADIOSITY;
        break;
    default:
        break;
    }
    if (need.frames < 0) // too large a figure, or NAN
        need.frames = INT64_C(1) << 53;
    return need;
}

enum weft_result effect_needs_find(const struct effect_params *params, const double *share,
                                   struct effect_plan *plan)
{
    plan->needed = 1;
    for (int i = 0; i < EFFECT_COUNT; i++) {
        const unsigned effect = params->effects & 1u << i;
        for (int s = 0; s < params->scene_count && effect; s++) {
            if (share[s] == 0.0)
                continue;
            const struct effect_need need = find_need(params, params->scene[s], plan, effect);
            if (isnan(need.figure))
                return WEFT_ERR_MEMORY; // scene_widest_penumbra
            if (need.frames > plan->need[i].frames)
                plan->need[i] = need;
        }
        if (plan->need[i].frames > plan->needed)
            plan->needed = plan->need[i].frames;
    }
    return WEFT_OK;
}

int effect_needs_fit(const struct effect_params *params, int64_t needed)
{
    const int64_t most = needed < EFFECT_MOST_AUTO ? needed : EFFECT_MOST_AUTO;
    const int *counts = params->jitter ? params->jitter->counts : NULL;
    int count = counts ? counts[0] : (int)most;
    for (int i = 0; counts && counts[i] && count < most; i++)
        count = counts[i];
    if (count < needed)
        log_warn(params->log, "%" PRId64 " frames are needed, and %d are drawn: %s", needed, count,
                 counts ? "this set of samples has no more points" : "more have to be asked for");
    return count;
}
