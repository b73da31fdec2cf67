// SPDX-License-Identifier: BSD-3-Clause
// The scenes of `weft effect`: made, and changed as the options say.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"
#include "tools/scene/vector.h"

static double length_of(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

// ---- the camera ---------------------------------------------------------------------------------

// Distances from a point to the nearest and the farthest point of the scene's box.
static void find_distances(const struct scene *scene, const double from[3], double out[2])
{
    double nearest[3], farthest[3];
    for (int i = 0; i < 3; i++) {
        const double below = scene->low[i] - from[i], above = from[i] - scene->high[i];
        nearest[i] = fmax(0.0, fmax(below, above));
        farthest[i] = fmax(fabs(below), fabs(above));
    }
    out[0] = length_of(nearest);
    out[1] = length_of(farthest);
}

// Planes that nothing is cut off by. The depth of what is seen is at least its distance times the
// cosine of the angle to the picture's corner, which half of it is below for all that are usual.
static void place_planes(struct scene *scene)
{
    double distance[2];
    find_distances(scene, scene->camera.eye, distance);
    const double farthest = distance[1] > 0.0 ? distance[1] : 1.0;
    const bool moves = scene->camera_path.count > 0;
    scene->camera.far_distance = (moves ? 2.0 : 1.01) * farthest;
    scene->camera.near_distance = fmax(1e-3 * farthest, moves ? 0.0 : 0.5 * distance[0]);
}

static enum weft_result set_camera(const struct effect_job *job, struct scene *scene)
{
    const struct option_value *o = job->option;
    struct weft_camera *camera = &scene->camera;
    if (o[ASK_EYE].given)
        memcpy(camera->eye, o[ASK_EYE].number, sizeof camera->eye);
    if (o[ASK_TARGET].given)
        memcpy(camera->target, o[ASK_TARGET].number, sizeof camera->target);
    if (o[ASK_UP].given)
        memcpy(camera->up, o[ASK_UP].number, sizeof camera->up);
    if (o[ASK_FOV].given)
        camera->fovy_degrees = o[ASK_FOV].number[0];
    if (o[ASK_EYE].given || o[ASK_TARGET].given)
        place_planes(scene);
    // What is in focus may lie before all that there is.
    if (o[ASK_FOCUS].given)
        camera->near_distance = fmin(camera->near_distance, 0.5 * o[ASK_FOCUS].number[0]);
    struct weft_camera_matrices ignored;
    const struct weft_camera_frame frame = {.size = {job->params.size[0], job->params.size[1]}};
    return weft_camera_compute(report_log(), camera, &frame, &ignored);
}

// ---- the lamp -----------------------------------------------------------------------------------

static enum weft_result fail_lamp(const char *option, const struct scene *scene, const char *why)
{
    report_error("%s: scene %s has no lamp that %s", option, scene->name, why);
    return WEFT_ERR_ARGUMENT;
}

// Moves the first lamp, and turns it to the middle of the scene.
static enum weft_result move_lamp(const struct effect_job *job, struct scene *scene)
{
    const struct option_value *o = &job->option[ASK_LIGHT];
    struct scene_light *lamp = &scene->lights[0];
    double towards[3], side[3] = {0.0, 0.0, 0.0}, up[3];
    if (!o->given)
        return WEFT_OK;
    if (scene->light_count == 0 || lamp->seen)
        return fail_lamp("--light", scene, "can be moved");
    for (int i = 0; i < 3; i++) {
        lamp->middle[i] = o->number[i];
        towards[i] = 0.5 * (scene->low[i] + scene->high[i]) - lamp->middle[i];
    }
    if (lamp->shape == SCENE_LIGHT_POINT)
        return WEFT_OK;
    if (scene_normalise(towards) == 0.0)
        return fail_lamp("--light", scene, "shines from the middle of it");
    // Along the axis that is most across.
    int across = 0;
    for (int i = 1; i < 3; i++)
        across = fabs(towards[i]) < fabs(towards[across]) ? i : across;
    side[across] = 1.0;
    scene_cross(towards, side, up);
    scene_normalise(up);
    scene_cross(up, towards, side); // side x up = towards
    const double size[2] = {length_of(lamp->u), length_of(lamp->v)};
    for (int i = 0; i < 3; i++) {
        lamp->u[i] = size[0] * side[i];
        lamp->v[i] = size[1] * up[i];
    }
    return WEFT_OK;
}

// Scales lamps that have an area. Their power stays.
static enum weft_result size_lamps(const struct effect_job *job, struct scene *scene)
{
    const struct option_value *o = &job->option[ASK_LIGHT_SIZE];
    int sized = 0;
    for (int i = 0; i < scene->light_count && o->given; i++) {
        struct scene_light *lamp = &scene->lights[i];
        const double longer = fmax(length_of(lamp->u), length_of(lamp->v));
        if (lamp->shape == SCENE_LIGHT_POINT || lamp->seen || !(longer > 0.0))
            continue;
        const double scale = o->number[0] / longer;
        for (int axis = 0; axis < 3; axis++) {
            lamp->u[axis] *= scale;
            lamp->v[axis] *= scale;
            if (lamp->falloff == SCENE_FALLOFF_RADIANCE)
                lamp->radiance[axis] /= scale * scale;
        }
        sized++;
    }
    return o->given && sized == 0
               ? fail_lamp("--light-size", scene, "has an area that can be changed")
               : WEFT_OK;
}

// ---- all ----------------------------------------------------------------------------------------

static bool moves(const struct scene *scene)
{
    bool any = scene->camera_path.count > 1;
    for (int i = 0; i < scene->object_count; i++)
        any = any || scene->objects[i].path.count > 1;
    return any;
}

static enum weft_result check_scene(const struct effect_job *job, const struct scene *scene)
{
    const bool shadows = scene->light_count > 0 || (job->params.effects & EFFECT_RADIOSITY);
    if (job->option[ASK_SHADOW_SIZE].given && !shadows)
        return fail_lamp("--shadow-size", scene, "throws shadows");
    if ((job->params.effects & EFFECT_MOTION_BLUR) && !moves(scene))
        report_warning("motion-blur: nothing moves in scene %s; --keyframes FILE makes it",
                       scene->name);
    return WEFT_OK;
}

static enum weft_result make_scene(struct effect_job *job, struct effect_scene *out)
{
    const struct option_value *keys = &job->option[ASK_KEYFRAMES];
    const int *size = job->params.size;
    report_stage("reading", out->name);
    enum weft_result res = scene_make(scene_params(.name = out->name, .seed = job->params.seed,
                                                   .size = {size[0], size[1]}, .log = report_log()),
                                      &out->scene);
    if (res == WEFT_OK && keys->given)
        res = scene_read_keys(report_log(), keys->text, &out->scene);
    if (res == WEFT_OK)
        res = set_camera(job, &out->scene);
    if (res == WEFT_OK)
        res = move_lamp(job, &out->scene);
    if (res == WEFT_OK)
        res = size_lamps(job, &out->scene);
    return res == WEFT_OK ? check_scene(job, &out->scene) : res;
}

// What a frame may show at least: lamps and surfaces that shine, and what faces lamps that are so
// far away that all of it gets their light alike.
static double find_brightest(const struct scene *scene)
{
    double lit[3], most = 1.0;
    memcpy(lit, scene->ambient, sizeof lit);
    for (int i = 0; i < scene->light_count; i++)
        for (int c = 0; c < 3; c++)
            lit[c] += scene->lights[i].falloff == SCENE_FALLOFF_RADIANCE
                          ? 0.0
                          : scene->lights[i].radiance[c];
    for (int c = 0; c < 3; c++) {
        most = fmax(most, fmax(lit[c], scene->background[c]));
        for (int m = 0; m < scene->material_count; m++)
            most = fmax(most, (double)scene->materials[m].emission[c] + lit[c]);
    }
    return most;
}

enum weft_result effect_job_make_scenes(struct effect_job *job)
{
    const double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < job->scene_count && res == WEFT_OK; i++) {
        res = make_scene(job, &job->scene[i]);
        job->params.scene[i] = &job->scene[i].scene;
        job->brightest = fmax(job->brightest, find_brightest(&job->scene[i].scene));
    }
    job->params.scene_count = job->scene_count;
    report_erase_progress();
    job->seconds.scene = report_now_seconds() - start;
    return res;
}
