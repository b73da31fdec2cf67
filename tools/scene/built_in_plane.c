// SPDX-License-Identifier: BSD-3-Clause
// `plane`: a chequered ground that runs to the horizon, and things at several depths on it.
#include <stdio.h>

#include "tools/scene/build.h"

static const double FAR_AWAY = 2000.0;

static int add_colour(struct scene_build *build, const char *name, float r, float g, float b)
{
    struct scene_material material = {.reflectance = {r, g, b}};
    scene_set_name(material.name, name);
    return scene_build_material(build, &material);
}

// Squares of 1; uv are the ground's own coordinates.
static void add_ground(struct scene_build *build)
{
    const struct scene_material chequered = {.name = "chequers",
                                             .reflectance = {0.8f, 0.78f, 0.72f},
                                             .pattern = SCENE_CHECKER,
                                             .frequency = 1.0f};
    scene_build_object(build, "ground", scene_build_material(build, &chequered));
    const double w = FAR_AWAY;
    const double corner[4][3] = {{-w, 0.0, 10.0}, {w, 0.0, 10.0}, {w, 0.0, -w}, {-w, 0.0, -w}};
    const double uv[4][2] = {{-w, -10.0}, {w, -10.0}, {w, w}, {-w, w}};
    scene_build_polygon(build, 4, corner, uv, NULL);
}

// Pairs of a ball and a post, the further the further apart.
static void add_things(struct scene_build *build)
{
    static const struct {
        double x, z;
        float colour[3];
    } ball[] = {
        {-0.75, 1.2, {0.75f, 0.10f, 0.08f}},  {0.35, -1.0, {0.85f, 0.55f, 0.08f}},
        {-1.9, -5.0, {0.15f, 0.50f, 0.15f}},  {2.6, -12.0, {0.10f, 0.25f, 0.70f}},
        {-6.0, -26.0, {0.55f, 0.12f, 0.55f}},
    };
    for (size_t i = 0; i < sizeof ball / sizeof *ball; i++) {
        char name[SCENE_NAME];
        const float *c = ball[i].colour;
        snprintf(name, sizeof name, "ball %zu", i + 1);
        scene_build_object(build, name, add_colour(build, name, c[0], c[1], c[2]));
        scene_build_ball(build, (double[]){ball[i].x, 0.5, ball[i].z}, 0.5, 24);
    }
    const int grey = add_colour(build, "grey", 0.6f, 0.6f, 0.62f);
    for (int i = 0; i < 6; i++) {
        char name[SCENE_NAME];
        snprintf(name, sizeof name, "post %d", i + 1);
        scene_build_object(build, name, grey);
        const double x = i % 2 ? 1.5 + 0.5 * i : -1.3 - 0.6 * i, z = 0.3 - 1.0 * i * i;
        scene_build_box(build, (double[]){x - 0.09, 0.0, z - 0.09},
                        (double[]){x + 0.09, 2.0, z + 0.09});
    }
}

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    (void)arguments, (void)seed, (void)size;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "plane");
    add_ground(&build);
    add_things(&build);
    scene_build_lamp(&build, &(struct scene_light){.shape = SCENE_LIGHT_SQUARE,
                                                   .falloff = SCENE_FALLOFF_COSINE,
                                                   .middle = {6.0, 12.0, 6.0},
                                                   .u = {2.0, 0.0, -2.0},
                                                   .v = {1.8, -2.25, 1.8},
                                                   .radiance = {0.85, 0.80, 0.70}});
    for (int i = 0; i < 3; i++)
        out->ambient[i] = (double[]){0.22, 0.25, 0.32}[i];
    out->camera = (struct weft_camera){.fovy_degrees = 40.0,
                                       .near_distance = 0.5,
                                       .far_distance = 3000.0,
                                       .eye = {0.0, 1.6, 5.0},
                                       .target = {0.0, 0.75, 0.0},
                                       .up = {0.0, 1.0, 0.0}};
    const double sky[4] = {0.35, 0.50, 0.75, 1.0};
    for (int i = 0; i < 4; i++)
        out->background[i] = sky[i];
    return scene_build_end(&build, log);
}

const struct scene_info scene_plane = {
    .name = "plane",
    .description = "a chequered plane to the horizon, balls and posts at depths from 4 to 31",
    .make = make,
};
