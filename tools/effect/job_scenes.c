// SPDX-License-Identifier: BSD-3-Clause
// The scenes of `weft effect`: made, and changed as the options say.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/effect/job.h"
#include "tools/scene/vector.h"

// Scales lamps that have an area. Their power stays.
static enum weft_result size_lamps(const struct effect_job *job, struct scene *scene)
{
    const struct option_value *o = &job->option[ASK_LIGHT_SIZE];
    int sized = 0;
    for (int i = 0; i < scene->light_count && o->given; i++) {
        struct scene_light *lamp = &scene->lights[i];
        const double longer = fmax(scene_length(lamp->u), scene_length(lamp->v));
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
               ? scene_options_fail_lamp("--light-size", scene, "has an area that can be changed")
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
    if ((job->params.effects & EFFECT_MOTION_BLUR) && !moves(scene))
        report_warning("motion-blur: nothing moves in scene %s; --keyframes FILE makes it",
                       scene->name);
    return job->params.effects & EFFECT_RADIOSITY // of which all lights throw shadows
               ? WEFT_OK
               : scene_options_check_shadows(&job->request, scene);
}

static enum weft_result make_scene(struct effect_job *job, struct effect_scene *out)
{
    const struct option_value *focus = &job->option[ASK_FOCUS];
    // What is in focus may lie before all that there is.
    enum weft_result res = scene_options_make(
        &job->request, out->name, focus->given ? focus->number[0] : INFINITY, &out->scene);
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
