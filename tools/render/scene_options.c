// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/scene_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/scene/vector.h"

enum { MOST_PIXELS = 16384, MOST_TEXELS = 16384 };

// ---- values -------------------------------------------------------------------------------------

static enum weft_result read_size(const struct option_value *o, int out[2])
{
    for (int axis = 0; axis < 2; axis++) {
        out[axis] = o->given ? (int)o->integer[axis] : 512;
        if (!o->given || (o->integer[axis] >= 1 && o->integer[axis] <= MOST_PIXELS))
            continue;
        report_error("--size %s: each is 1 to %d pixels", o->text, MOST_PIXELS);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result read_seed(const struct option_value *o, uint64_t *out)
{
    double seed = 0.0;
    const enum weft_result res =
        options_read_number(o, "seed", 0.0, 0x1p53, "not a whole number from 0 to 2^53", &seed);
    *out = (uint64_t)seed;
    if (res != WEFT_OK || seed == floor(seed))
        return res;
    report_error("--seed %s: not a whole number from 0 to 2^53", o->text);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_time(const struct option_value *o, double out[2])
{
    out[0] = o->given ? o->number[0] : 0.0;
    out[1] = o->given ? o->number[1] : 1.0;
    if (out[0] >= 0.0 && out[0] <= out[1] && out[1] <= 1.0)
        return WEFT_OK;
    report_error("--time %s: not a time from 0 to 1, or two as 0.25..0.75", o->text);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result read_shadow_size(const struct option_value *o, int *out)
{
    double texels = 0.0;
    const char *const what = "not a whole number of texels from 1 to 16384";
    enum weft_result res = options_read_number(o, "shadow-size", 1.0, MOST_TEXELS, what, &texels);
    if (res == WEFT_OK && texels != floor(texels)) {
        report_error("--shadow-size %s: %s", o->text, what);
        res = WEFT_ERR_ARGUMENT;
    }
    *out = (int)texels;
    return res;
}

enum weft_result scene_options_read(const struct option_value *first, struct scene_request *out)
{
    double ignored;
    *out = (struct scene_request){.option = first};
    enum weft_result res = read_size(&first[SCENE_OPTION_SIZE], out->size);
    if (res == WEFT_OK)
        res = read_seed(&first[SCENE_OPTION_SEED], &out->seed);
    if (res == WEFT_OK)
        res = read_time(&first[SCENE_OPTION_TIME], out->time);
    if (res == WEFT_OK)
        res = options_read_number(&first[SCENE_OPTION_FOV], "fov", 0.01, 179.0,
                                  "not an angle from 0.01 to 179 degrees", &ignored);
    if (res == WEFT_OK)
        res = read_shadow_size(&first[SCENE_OPTION_SHADOW_SIZE], &out->shadow_size);
    return res;
}

void scene_options_print_scenes(void)
{
    puts("scenes:");
    for (int i = 0; scene_list[i]; i++) {
        char name[80];
        snprintf(name, sizeof name, "%s%s", scene_list[i]->name,
                 scene_list[i]->arguments ? scene_list[i]->arguments : "");
        printf("  %-24s %s\n", name, scene_list[i]->description);
    }
    puts("  FILE                     triangles of a file that ends in .obj, .ply, .gltf or .glb");
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
    out[0] = scene_length(nearest);
    out[1] = scene_length(farthest);
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

static enum weft_result set_camera(const struct scene_request *request, double nearest,
                                   struct scene *scene)
{
    const struct option_value *o = request->option;
    struct weft_camera *camera = &scene->camera;
    if (o[SCENE_OPTION_EYE].given)
        memcpy(camera->eye, o[SCENE_OPTION_EYE].number, sizeof camera->eye);
    if (o[SCENE_OPTION_TARGET].given)
        memcpy(camera->target, o[SCENE_OPTION_TARGET].number, sizeof camera->target);
    if (o[SCENE_OPTION_UP].given)
        memcpy(camera->up, o[SCENE_OPTION_UP].number, sizeof camera->up);
    if (o[SCENE_OPTION_FOV].given)
        camera->fovy_degrees = o[SCENE_OPTION_FOV].number[0];
    if (o[SCENE_OPTION_EYE].given || o[SCENE_OPTION_TARGET].given)
        place_planes(scene);
    camera->near_distance = fmin(camera->near_distance, 0.5 * nearest);
    struct weft_camera_matrices ignored;
    const struct weft_camera_frame frame = {.size = {request->size[0], request->size[1]}};
    return weft_camera_compute(report_log(), camera, &frame, &ignored);
}

// ---- the lamp -----------------------------------------------------------------------------------

enum weft_result scene_options_fail_lamp(const char *option, const struct scene *scene,
                                         const char *why)
{
    report_error("%s: scene %s has no lamp that %s", option, scene->name, why);
    return WEFT_ERR_ARGUMENT;
}

// Moves the first lamp, and turns it to the middle of the scene.
static enum weft_result move_lamp(const struct scene_request *request, struct scene *scene)
{
    const struct option_value *o = &request->option[SCENE_OPTION_LIGHT];
    struct scene_light *lamp = &scene->lights[0];
    double towards[3], side[3] = {0.0, 0.0, 0.0}, up[3];
    if (!o->given)
        return WEFT_OK;
    if (scene->light_count == 0 || lamp->seen)
        return scene_options_fail_lamp("--light", scene, "can be moved");
    for (int i = 0; i < 3; i++) {
        lamp->middle[i] = o->number[i];
        towards[i] = 0.5 * (scene->low[i] + scene->high[i]) - lamp->middle[i];
    }
    if (lamp->shape == SCENE_LIGHT_POINT)
        return WEFT_OK;
    if (scene_normalise(towards) == 0.0)
        return scene_options_fail_lamp("--light", scene, "shines from the middle of it");
    // Along the axis that is most across.
    int across = 0;
    for (int i = 1; i < 3; i++)
        across = fabs(towards[i]) < fabs(towards[across]) ? i : across;
    side[across] = 1.0;
    scene_cross(towards, side, up);
    scene_normalise(up);
    scene_cross(up, towards, side); // side x up = towards
    const double size[2] = {scene_length(lamp->u), scene_length(lamp->v)};
    for (int i = 0; i < 3; i++) {
        lamp->u[i] = size[0] * side[i];
        lamp->v[i] = size[1] * up[i];
    }
    return WEFT_OK;
}

enum weft_result scene_options_check_shadows(const struct scene_request *request,
                                             const struct scene *scene)
{
    return request->shadow_size && scene->light_count == 0
               ? scene_options_fail_lamp("--shadow-size", scene, "throws shadows")
               : WEFT_OK;
}

// ---- all ----------------------------------------------------------------------------------------

enum weft_result scene_options_make(const struct scene_request *request, const char *name,
                                    double nearest, struct scene *out)
{
    const struct option_value *keys = &request->option[SCENE_OPTION_KEYFRAMES];
    report_stage("reading", name);
    enum weft_result res =
        scene_make(scene_params(.name = name, .seed = request->seed,
                                .size = {request->size[0], request->size[1]}, .log = report_log()),
                   out);
    if (res == WEFT_OK && keys->given)
        res = scene_read_keys(report_log(), keys->text, out);
    if (res == WEFT_OK)
        res = set_camera(request, nearest, out);
    return res == WEFT_OK ? move_lamp(request, out) : res;
}

// ---- reports ------------------------------------------------------------------------------------

json_t *scene_options_json(const char *name, const struct scene *s)
{
    return json_pack("{s:o,s:o,s:o,s:i,s:i,s:i,s:o,s:o,s:o,s:o,s:o}", "name", json_text(name),
                     "source", json_text(s->source), "triangles", json_count(s->index_count / 3),
                     "objects", s->object_count, "materials", s->material_count, "lights",
                     s->light_count, "low", json_numbers(s->low, 3), "high",
                     json_numbers(s->high, 3), "eye", json_numbers(s->camera.eye, 3), "target",
                     json_numbers(s->camera.target, 3), "fov", json_number(s->camera.fovy_degrees));
}

json_t *scene_options_shadow_json(const struct scene_shadow_info *shadow)
{
    return json_pack("{s:i,s:i,s:o,s:o}", "faces", shadow->faces, "size", shadow->size, "bias",
                     json_number(shadow->bias), "bytes", run_report_bytes("held", shadow->bytes));
}
