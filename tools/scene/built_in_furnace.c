// SPDX-License-Identifier: BSD-3-Clause
// `furnace`: a closed box seen from within, whose walls all emit 1 and reflect rho: light is
// 1 / (1 - rho) everywhere, whatever the box's shape.
#include <stdio.h>

#include "tools/scene/arguments.h"
#include "tools/scene/build.h"

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    (void)seed, (void)size;
    struct scene_argument rho = {
        .name = "the walls' reflectance", .least = 0.0, .most = 0.99, .value = 0.5};
    const enum weft_result res = scene_read_arguments(log, "furnace", arguments, 1, &rho);
    if (res != WEFT_OK)
        return res;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "furnace");
    struct scene_material wall = {.name = "wall"};
    for (int i = 0; i < 3; i++) {
        wall.reflectance[i] = (float)rho.value;
        wall.emission[i] = 1.0f;
    }
    scene_build_object(&build, "walls", scene_build_material(&build, &wall));
    // Low and high are swapped along an axis: the fronts are inside.
    scene_build_box(&build, (double[]){-1.0, -1.0, 1.25}, (double[]){1.0, 1.0, -1.25});
    out->camera = (struct weft_camera){.fovy_degrees = 60.0,
                                       .near_distance = 0.05,
                                       .far_distance = 5.0,
                                       .eye = {0.4, 0.2, 0.9},
                                       .target = {-0.2, -0.1, -1.0},
                                       .up = {0.0, 1.0, 0.0}};
    out->background[3] = 1.0;
    snprintf(out->source, sizeof out->source,
             "analytic: walls that emit 1 and reflect %.6g show %.6g everywhere", rho.value,
             1.0 / (1.0 - rho.value));
    return scene_build_end(&build, log);
}

const struct scene_info scene_furnace = {
    .name = "furnace",
    .description = "a closed box from within; its walls emit 1 and reflect RHO (default 0.5)",
    .arguments = "[:RHO]",
    .make = make,
};
