// SPDX-License-Identifier: BSD-3-Clause
// `penumbra`: a floor, a board over it and a square lamp over both, whose visible share is what
// the picture shows: under the board's straight edges it is linear, side * ho / (hl - ho) wide.
#include "tools/scene/build.h"

static int add_colour(struct scene_build *build, const char *name, float r, float g, float b)
{
    struct scene_material material = {.reflectance = {r, g, b}};
    scene_set_name(material.name, name);
    return scene_build_material(build, &material);
}

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    (void)arguments, (void)seed, (void)size;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "penumbra");
    scene_build_object(&build, "floor", add_colour(&build, "grey", 0.6f, 0.6f, 0.6f));
    const double ground[4][3] = {
        {-40.0, 0.0, 20.0}, {40.0, 0.0, 20.0}, {40.0, 0.0, -60.0}, {-40.0, 0.0, -60.0}};
    scene_build_polygon(&build, 4, ground, NULL, NULL);
    scene_build_object(&build, "board", add_colour(&build, "red", 0.7f, 0.15f, 0.1f));
    const double board[4][3] = {
        {-1.0, 1.0, 0.75}, {1.0, 1.0, 0.75}, {1.0, 1.0, -0.75}, {-1.0, 1.0, -0.75}};
    scene_build_polygon(&build, 4, board, NULL, NULL);
    scene_build_object(&build, "post", add_colour(&build, "blue", 0.15f, 0.3f, 0.7f));
    scene_build_box(&build, (double[]){1.9, 0.0, -1.1}, (double[]){2.1, 1.6, -0.9});
    scene_build_lamp(&build, &(struct scene_light){.shape = SCENE_LIGHT_SQUARE,
                                                   .falloff = SCENE_FALLOFF_NONE,
                                                   .middle = {0.0, 4.0, 0.0},
                                                   .u = {1.0, 0.0, 0.0},
                                                   .v = {0.0, 0.0, 1.0},
                                                   .radiance = {1.0, 1.0, 1.0}});
    for (int i = 0; i < 3; i++)
        out->ambient[i] = 0.05;
    out->camera = (struct weft_camera){.fovy_degrees = 40.0,
                                       .near_distance = 1.0,
                                       .far_distance = 120.0,
                                       .eye = {1.0, 3.8, 5.4},
                                       .target = {0.3, 0.55, 0.0},
                                       .up = {0.0, 1.0, 0.0}};
    out->background[3] = 1.0;
    return scene_build_end(&build, log);
}

const struct scene_info scene_penumbra = {
    .name = "penumbra",
    .description = "a board and a post under a square lamp, of which the visible share is shown",
    .make = make,
};
