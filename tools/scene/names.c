// SPDX-License-Identifier: BSD-3-Clause
// Scenes by name: the list, and what is made from a user's text.
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "tools/common/log.h"
#include "tools/scene/build.h"

const struct scene_info *const scene_list[] = {
    &scene_cube,  &scene_cornell, &scene_furnace,  &scene_polygons,
    &scene_plane, &scene_moving,  &scene_penumbra, NULL};

const char *const *scene_find_default(const char *effect)
{
    static const struct {
        const char *effect, *scene[3];
    } list[] = {
        {"fade", {"cube", "plane"}}, {"motion-blur", {"moving"}},   {"antialias", {"polygons"}},
        {"dof", {"plane"}},          {"soft-shadow", {"penumbra"}}, {"radiosity", {"cornell"}},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        if (strcmp(effect, list[i].effect) == 0)
            return list[i].scene;
    return NULL;
}

static bool is_file(const char *name)
{
    static const char *const endings[] = {".obj", ".ply", ".gltf", ".glb"};
    const char *ending = strrchr(name, '.');
    for (size_t i = 0; ending && i < sizeof endings / sizeof *endings; i++)
        if (strcasecmp(ending, endings[i]) == 0)
            return true;
    return false;
}

enum { MAX_NAMES = 32 };

static enum weft_result complain_name(const struct scene_params *params)
{
    const char *names[MAX_NAMES + 1] = {NULL}, *meant;
    char list[400] = "";
    for (int i = 0; i < MAX_NAMES && scene_list[i]; i++) {
        const size_t length = strlen(list);
        names[i] = scene_list[i]->name;
        snprintf(list + length, sizeof list - length, "%s%s%s", i ? ", " : "", names[i],
                 scene_list[i]->arguments ? scene_list[i]->arguments : "");
    }
    meant = weft_closest_find(params->name, strcspn(params->name, ":"), names);
    log_error(params->log,
              "no scene '%.200s'%s%s%s there are %s, and files that end in .obj, .ply, .gltf or .glb",
              params->name, meant ? "; did you mean " : ";", meant ? meant : "", meant ? "?" : "",
              list);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result make_built_in(const struct scene_params *params,
                                      const struct scene_info *info, const char *arguments,
                                      struct scene *out)
{
    if (arguments && !info->arguments) {
        log_error(params->log, "%.200s: the scene %s has no arguments", params->name, info->name);
        return WEFT_ERR_ARGUMENT;
    }
    return info->make(params->log, arguments, params->seed, params->size, out);
}

enum weft_result scene_make(const struct scene_params *params, struct scene *out)
{
    *out = (struct scene){0};
    for (int axis = 0; axis < 2; axis++)
        if (params->size[axis] < 1 || params->size[axis] > 65536) {
            log_error(params->log, "a picture of %dx%d pixels: each is 1 to 65536", params->size[0],
                      params->size[1]);
            return WEFT_ERR_ARGUMENT;
        }
    if (is_file(params->name))
        return scene_load(params, out);
    const size_t length = strcspn(params->name, ":");
    const char *arguments = params->name[length] ? params->name + length + 1 : NULL;
    for (int i = 0; scene_list[i]; i++)
        if (strlen(scene_list[i]->name) == length &&
            strncmp(scene_list[i]->name, params->name, length) == 0)
            return make_built_in(params, scene_list[i], arguments, out);
    return complain_name(params);
}
