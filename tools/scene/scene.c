// SPDX-License-Identifier: BSD-3-Clause
// What becomes of scenes: their box, and their end.
#include <math.h>
#include <stdlib.h>

#include "tools/scene/build.h"

void scene_clear(struct scene *scene)
{
    if (!scene)
        return;
    for (int i = 0; i < scene->object_count; i++)
        free(scene->objects[i].path.keys);
    free(scene->camera_path.keys);
    free(scene->objects);
    free(scene->materials);
    free(scene->indices);
    free(scene->vertices);
    *scene = (struct scene){0};
}

// ---- box ----------------------------------------------------------------------------------------

static void add_object(struct scene *scene, const struct scene_object *object, double time)
{
    double matrix[16];
    scene_path_at(&object->path, time, matrix);
    for (uint32_t i = 0; i < object->index_count; i++) {
        const float *f = scene->vertices[scene->indices[object->first_index + i]].position;
        double p[3] = {f[0], f[1], f[2]};
        scene_transform(matrix, p, p);
        for (int axis = 0; axis < 3; axis++) {
            scene->low[axis] = fmin(scene->low[axis], p[axis]);
            scene->high[axis] = fmax(scene->high[axis], p[axis]);
        }
    }
}

static void add_path(struct scene *scene, const struct scene_object *object)
{
    enum { BETWEEN = 17 };
    const struct scene_path *path = &object->path;
    add_object(scene, object, path->count ? path->keys[0].time : 0.0);
    for (int k = 1; k < path->count; k++) {
        const double from = path->keys[k - 1].time, step = path->keys[k].time - from;
        for (int i = 1; i < BETWEEN; i++)
            add_object(scene, object, from + step * i / BETWEEN);
        add_object(scene, object, path->keys[k].time);
    }
}

void scene_find_box(struct scene *scene)
{
    for (int axis = 0; axis < 3; axis++) {
        scene->low[axis] = scene->index_count ? INFINITY : 0.0;
        scene->high[axis] = -scene->low[axis];
    }
    for (int i = 0; i < scene->object_count; i++)
        add_path(scene, &scene->objects[i]);
}
