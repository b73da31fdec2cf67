// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/lamps.h"

#include <math.h>

#include "tools/scene/vector.h"

double scene_lamp_area(const struct scene_light *light)
{
    double normal[3];
    if (light->shape == SCENE_LIGHT_POINT)
        return 0.0;
    scene_cross(light->u, light->v, normal);
    return scene_normalise(normal) * (light->shape == SCENE_LIGHT_DISC ? M_PI_4 : 1.0);
}

void scene_lamp_at(const struct scene_light *light, const double place[2],
                   struct scene_point_light *out)
{
    const bool is_point = light->shape == SCENE_LIGHT_POINT;
    const bool has_area = !is_point && light->falloff == SCENE_FALLOFF_RADIANCE;
    const double scale = has_area ? scene_lamp_area(light) : 1.0;
    *out = (struct scene_point_light){.falloff = light->falloff, .shadowed = true};
    for (int i = 0; i < 3; i++) {
        out->position[i] = light->middle[i];
        out->intensity[i] = scale * light->radiance[i];
    }
    if (is_point)
        return;
    scene_cross(light->u, light->v, out->normal);
    scene_normalise(out->normal);
    for (int i = 0; i < 3; i++)
        out->position[i] += place[0] * light->u[i] + place[1] * light->v[i];
}

void scene_lamps_in_middle(const struct scene *scene, struct scene_frame *out)
{
    const double middle[2] = {0.0, 0.0};
    for (int i = 0; i < scene->light_count; i++)
        scene_lamp_at(&scene->lights[i], middle, &out->light[i]);
    out->light_count = scene->light_count;
}
