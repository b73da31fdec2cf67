// SPDX-License-Identifier: BSD-3-Clause
// `cornell`: the Cornell box. Measurements: Cornell University Program of Computer Graphics,
// "Cornell Box Data" (1998), in millimetres. The data has spectra and no RGB: reflectances and the
// lamp's radiance are those of Tungsten's scene (Bitterli, "Rendering resources", 2016).
//
// The lamp lies in the plane of the ceiling, in a hole cut for it: the published corners of both
// stay. Blocks have no bottoms; surfaces have two sides.
#include <math.h>
#include <stdio.h>

#include "tools/scene/build.h"

static const float WHITE[3] = {0.725f, 0.71f, 0.68f}, RED[3] = {0.63f, 0.065f, 0.05f},
                   GREEN[3] = {0.14f, 0.45f, 0.091f};

// In the published order, whose fronts are inside the box.
static const double FLOOR[4][3] = {
    {552.8, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 559.2}, {549.6, 0.0, 559.2}};
static const double CEILING[4][3] = {
    {556.0, 548.8, 0.0}, {556.0, 548.8, 559.2}, {0.0, 548.8, 559.2}, {0.0, 548.8, 0.0}};
static const double BACK[4][3] = {
    {549.6, 0.0, 559.2}, {0.0, 0.0, 559.2}, {0.0, 548.8, 559.2}, {556.0, 548.8, 559.2}};
static const double RIGHT[4][3] = {
    {0.0, 0.0, 559.2}, {0.0, 0.0, 0.0}, {0.0, 548.8, 0.0}, {0.0, 548.8, 559.2}};
static const double LEFT[4][3] = {
    {552.8, 0.0, 0.0}, {549.6, 0.0, 559.2}, {556.0, 548.8, 559.2}, {556.0, 548.8, 0.0}};
static const double LIGHT[4][3] = {
    {343.0, 548.8, 227.0}, {343.0, 548.8, 332.0}, {213.0, 548.8, 332.0}, {213.0, 548.8, 227.0}};
// (x, z) of the blocks' tops.
static const double SHORT_BLOCK[4][2] = {
    {130.0, 65.0}, {82.0, 225.0}, {240.0, 272.0}, {290.0, 114.0}};
static const double TALL_BLOCK[4][2] = {
    {423.0, 247.0}, {265.0, 296.0}, {314.0, 456.0}, {472.0, 406.0}};

static int add_wall(struct scene_build *build, const char *name, const float reflectance[3])
{
    struct scene_material material = {0};
    scene_set_name(material.name, name);
    for (int i = 0; i < 3; i++)
        material.reflectance[i] = reflectance[i];
    return scene_build_material(build, &material);
}

// Around the lamp, corner by corner: both quads turn the same way.
static void add_ceiling(struct scene_build *build)
{
    for (int i = 0; i < 4; i++) {
        double quad[4][3];
        const double *corner[4] = {CEILING[i], CEILING[(i + 1) % 4], LIGHT[(i + 1) % 4], LIGHT[i]};
        for (int k = 0; k < 12; k++)
            quad[k / 3][k % 3] = corner[k / 3][k % 3];
        scene_build_polygon(build, 4, quad, NULL, NULL);
    }
}

static void add_block(struct scene_build *build, const char *name, int material,
                      const double top[4][2], double height)
{
    scene_build_object(build, name, material);
    double quad[4][3];
    for (int i = 0; i < 4; i++) {
        quad[i][0] = top[i][0];
        quad[i][1] = height;
        quad[i][2] = top[i][1];
    }
    scene_build_polygon(build, 4, quad, NULL, NULL);
    for (int i = 0; i < 4; i++) {
        const double *a = top[i], *b = top[(i + 1) % 4];
        const double side[4][3] = {
            {a[0], height, a[1]}, {a[0], 0.0, a[1]}, {b[0], 0.0, b[1]}, {b[0], height, b[1]}};
        scene_build_polygon(build, 4, side, NULL, NULL);
    }
}

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    (void)arguments, (void)seed, (void)size;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "cornell");
    const int white = add_wall(&build, "white", WHITE);
    scene_build_object(&build, "white walls", white);
    scene_build_polygon(&build, 4, FLOOR, NULL, NULL);
    scene_build_polygon(&build, 4, BACK, NULL, NULL);
    add_ceiling(&build);
    scene_build_object(&build, "right wall", add_wall(&build, "green", GREEN));
    scene_build_polygon(&build, 4, RIGHT, NULL, NULL);
    scene_build_object(&build, "left wall", add_wall(&build, "red", RED));
    scene_build_polygon(&build, 4, LEFT, NULL, NULL);
    add_block(&build, "short block", white, SHORT_BLOCK, 165.0);
    add_block(&build, "tall block", white, TALL_BLOCK, 330.0);
    scene_build_lamp(&build, &(struct scene_light){.shape = SCENE_LIGHT_SQUARE,
                                                   .falloff = SCENE_FALLOFF_RADIANCE,
                                                   .middle = {278.0, 548.8, 279.5},
                                                   .u = {130.0, 0.0, 0.0},
                                                   .v = {0.0, 0.0, 105.0},
                                                   .radiance = {17.0, 12.0, 4.0},
                                                   .seen = true});
    out->camera = (struct weft_camera){.fovy_degrees = 2.0 * atan(0.0125 / 0.035) * 180.0 /
                                                       M_PI, // film 0.025, focal length 0.035
                                       .near_distance = 400.0,
                                       .far_distance = 1600.0,
                                       .eye = {278.0, 273.0, -800.0},
                                       .target = {278.0, 273.0, 0.0},
                                       .up = {0.0, 1.0, 0.0}};
    out->background[3] = 1.0;
    snprintf(out->source, sizeof out->source,
             "Cornell Box Data (Cornell University, 1998), lamp in a hole of the ceiling; RGB "
             "reflectances and radiance of Tungsten's scene (Bitterli, 2016)");
    return scene_build_end(&build, log);
}

const struct scene_info scene_cornell = {
    .name = "cornell",
    .description = "the Cornell box by its published measurements, in Tungsten's RGB",
    .make = make,
};
