// SPDX-License-Identifier: BSD-3-Clause
// `cube`: the RGB colour cube, each corner in the colour of its place.
#include "tools/scene/build.h"

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    (void)arguments, (void)seed, (void)size;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "cube");
    const struct scene_material colours = {
        .name = "colours", .reflectance = {1.0f, 1.0f, 1.0f}, .unlit = true};
    scene_build_object(&build, "cube", scene_build_material(&build, &colours));
    scene_build_box(&build, (double[]){0.0, 0.0, 0.0}, (double[]){1.0, 1.0, 1.0});
    for (size_t i = 0; i < out->vertex_count; i++)
        for (int axis = 0; axis < 3; axis++)
            out->vertices[i].colour[axis] = out->vertices[i].position[axis];
    out->camera = (struct weft_camera){.fovy_degrees = 40.0,
                                       .near_distance = 1.0,
                                       .far_distance = 6.0,
                                       .eye = {1.85, 1.75, 2.6},
                                       .target = {0.5, 0.45, 0.5},
                                       .up = {0.0, 1.0, 0.0}};
    out->background[3] = 1.0;
    return scene_build_end(&build, log);
}

const struct scene_info scene_cube = {
    .name = "cube",
    .description = "the RGB colour cube: corners in the colours of their places, no lights",
    .make = make,
};
