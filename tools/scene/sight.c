// SPDX-License-Identifier: BSD-3-Clause
// Where the camera is at a time.
#include "tools/scene/build.h"

void scene_camera_at(const struct scene *scene, double time, struct weft_camera *out)
{
    *out = scene->camera;
    if (scene->camera_path.count == 0)
        return;
    const struct scene_key key = scene_path_key(&scene->camera_path, time);
    double sight[3];
    for (int i = 0; i < 3; i++) {
        sight[i] = scene->camera.target[i] - scene->camera.eye[i];
        out->eye[i] += key.position[i];
    }
    scene_rotate(key.rotation, sight, sight);
    scene_rotate(key.rotation, scene->camera.up, out->up);
    for (int i = 0; i < 3; i++)
        out->target[i] = out->eye[i] + sight[i];
}
