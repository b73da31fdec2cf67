// SPDX-License-Identifier: BSD-3-Clause
// `moving`: a bar that crosses the picture, a cross that turns, a ball on an arc, a post that
// rests.
#include <math.h>

#include "tools/scene/build.h"

static int add_colour(struct scene_build *build, const char *name, float r, float g, float b,
                      bool unlit)
{
    struct scene_material material = {.reflectance = {r, g, b}, .unlit = unlit};
    scene_set_name(material.name, name);
    return scene_build_material(build, &material);
}

// Its edges are upright and parallel to the picture: on the screen they move evenly.
static void add_bar(struct scene_build *build)
{
    scene_build_object(build, "bar", add_colour(build, "white", 0.9f, 0.9f, 0.9f, true));
    scene_build_box(build, (double[]){-0.3, 0.35, -0.05}, (double[]){0.3, 1.5, 0.05});
    struct scene_key *keys = scene_build_path(build, 2);
    if (!keys)
        return;
    keys[0].position[0] = -0.24;
    keys[1].position[0] = 0.24;
}

// A turn of 18 degrees, of which the second half of the time has two thirds.
static void add_cross(struct scene_build *build)
{
    scene_build_object(build, "cross", add_colour(build, "orange", 0.85f, 0.40f, 0.06f, false));
    scene_build_box(build, (double[]){-0.75, -0.08, -0.06}, (double[]){0.75, 0.08, 0.06});
    scene_build_box(build, (double[]){-0.08, 0.08, -0.06}, (double[]){0.08, 0.75, 0.06});
    scene_build_box(build, (double[]){-0.08, -0.75, -0.06}, (double[]){0.08, -0.08, 0.06});
    struct scene_key *keys = scene_build_path(build, 3);
    if (!keys)
        return;
    for (int i = 0; i < 3; i++) {
        keys[i].position[0] = 0.95;
        keys[i].position[1] = -0.75;
        scene_rotation((double[]){0.0, 0.0, 1.0}, i < 2 ? 24.0 + 6.0 * i : 42.0, keys[i].rotation);
    }
}

// Over a tenth of a circle, as 8 straight ways.
static void add_ball(struct scene_build *build)
{
    enum { WAYS = 8 };
    scene_build_object(build, "ball", add_colour(build, "blue", 0.12f, 0.30f, 0.75f, false));
    scene_build_ball(build, (double[]){0.0, 0.0, 0.0}, 0.22, 16);
    struct scene_key *keys = scene_build_path(build, WAYS + 1);
    for (int i = 0; i <= WAYS && keys; i++) {
        const double angle = M_PI * (0.6 - 0.2 * (double)i / WAYS);
        keys[i].position[0] = -0.95 + 0.75 * cos(angle);
        keys[i].position[1] = -1.1 + 0.75 * sin(angle);
    }
}

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    (void)arguments, (void)seed, (void)size;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "moving");
    add_bar(&build);
    add_cross(&build);
    add_ball(&build);
    scene_build_object(&build, "post", add_colour(&build, "green", 0.15f, 0.50f, 0.18f, false));
    scene_build_box(&build, (double[]){-0.06, -1.5, -0.4}, (double[]){0.06, 0.2, -0.28});
    scene_build_object(&build, "wall", add_colour(&build, "grey", 0.28f, 0.28f, 0.30f, false));
    const double wall[4][3] = {
        {-6.0, -6.0, -1.5}, {6.0, -6.0, -1.5}, {6.0, 6.0, -1.5}, {-6.0, 6.0, -1.5}};
    scene_build_polygon(&build, 4, wall, NULL, NULL);
    scene_build_lamp(&build, &(struct scene_light){.shape = SCENE_LIGHT_DISC,
                                                   .falloff = SCENE_FALLOFF_COSINE,
                                                   .middle = {-2.0, 3.0, 5.0},
                                                   .u = {0.5, 0.0, 0.2},
                                                   .v = {-0.096, -0.464, 0.24},
                                                   .radiance = {0.9, 0.9, 0.85}});
    for (int i = 0; i < 3; i++)
        out->ambient[i] = 0.2;
    out->camera = (struct weft_camera){.fovy_degrees = 40.0,
                                       .near_distance = 1.0,
                                       .far_distance = 12.0,
                                       .eye = {0.0, 0.0, 5.0},
                                       .up = {0.0, 1.0, 0.0}};
    out->background[3] = 1.0;
    return scene_build_end(&build, log);
}

const struct scene_info scene_moving = {
    .name = "moving",
    .description = "a bar that crosses the picture, a cross that turns, a ball on an arc",
    .make = make,
};
