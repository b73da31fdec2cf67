// SPDX-License-Identifier: BSD-3-Clause
// `polygons`: random triangles and parallelograms of one area on the picture, as tests of
// anti-aliasing have them (dead leaves). Nothing but sums, products, quotients and square roots
// makes them: they are the same bytes everywhere.
#include <math.h>

#include "tools/scene/arguments.h"
#include "tools/scene/build.h"

enum { MOST = 1000000 };

// Half the picture's height at a depth of 1; depths of the polygons' middles.
static const double TANGENT = 0.5, NEAREST = 5.0, FARTHEST = 20.0;

static double between(uint64_t *random, double low, double high)
{
    return low + (high - low) * random_unit(random);
}

static void find_point_of_disc(uint64_t *random, double out[2])
{
    do {
        out[0] = between(random, -1.0, 1.0);
        out[1] = between(random, -1.0, 1.0);
    } while (out[0] * out[0] + out[1] * out[1] > 1.0);
}

// A triangle, or the parallelogram that it is half of, about its middle, counterclockwise, of an
// area; returns how many corners it has. Thin ones are left out.
static int find_shape(uint64_t *random, double area, double corner[4][2])
{
    const int count = random_next(random) >> 63 ? 4 : 3;
    double doubled;
    do {
        for (int i = 0; i < 3; i++)
            find_point_of_disc(random, corner[i]);
        doubled = (corner[1][0] - corner[0][0]) * (corner[2][1] - corner[0][1]) -
                  (corner[1][1] - corner[0][1]) * (corner[2][0] - corner[0][0]);
    } while (doubled < 0.7);
    const double scale = sqrt(area / (count == 3 ? 0.5 * doubled : doubled));
    for (int axis = 0; axis < 2; axis++) {
        corner[3][axis] = corner[0][axis] + corner[2][axis] - corner[1][axis];
        double middle = 0.0;
        for (int i = 0; i < count; i++)
            middle += corner[i][axis] / count;
        for (int i = 0; i < count; i++)
            corner[i][axis] = scale * (corner[i][axis] - middle);
    }
    return count;
}

// Somewhere in the picture, at some depth, tilted; flat, as 1 / depth is linear on the picture.
static void add_polygon(struct scene_build *build, uint64_t *random, const int size[2], double area)
{
    double shape[4][2], corner[4][3];
    const int count = find_shape(random, area, shape);
    const double x = between(random, 0.0, size[0]), y = between(random, 0.0, size[1]);
    const double middle = 1.0 / between(random, NEAREST, FARTHEST);
    double tilt[2];
    find_point_of_disc(random, tilt);
    // Over its whole extent, some 2 sqrt(area), by a twentieth.
    const double slope = 0.05 * middle / (2.0 * sqrt(area));
    for (int i = 0; i < count; i++) {
        const double depth =
            1.0 / (middle + slope * (tilt[0] * shape[i][0] + tilt[1] * shape[i][1]));
        const double pixel = 2.0 * TANGENT / size[1] * depth;
        corner[i][0] = (x + shape[i][0] - 0.5 * size[0]) * pixel;
        corner[i][1] = (y + shape[i][1] - 0.5 * size[1]) * pixel;
        corner[i][2] = -depth;
    }
    float colour[3];
    for (int i = 0; i < 3; i++)
        colour[i] = (float)random_unit(random);
    scene_build_polygon(build, count, corner, NULL, colour);
}

static enum weft_result make(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out)
{
    struct scene_argument given[2] = {
        {.name = "the count", .least = 1.0, .most = MOST, .value = 4000.0, .whole = true},
        {.name = "the area in pixels", .least = 0.01, .most = 1e6, .value = 50.0}};
    const enum weft_result res = scene_read_arguments(log, "polygons", arguments, 2, given);
    if (res != WEFT_OK)
        return res;
    struct scene_build build = {.scene = out};
    scene_set_name(out->name, "polygons");
    const struct scene_material colours = {
        .name = "colours", .reflectance = {1.0f, 1.0f, 1.0f}, .unlit = true};
    scene_build_object(&build, "polygons", scene_build_material(&build, &colours));
    uint64_t random = seed;
    for (int i = 0; i < (int)given[0].value && !build.full; i++)
        add_polygon(&build, &random, size, given[1].value);
    out->camera = (struct weft_camera){.fovy_degrees = 2.0 * atan(TANGENT) * 180.0 / M_PI,
                                       .near_distance = 1.0,
                                       .far_distance = 50.0,
                                       .target = {0.0, 0.0, -8.0},
                                       .up = {0.0, 1.0, 0.0}};
    const double grey[4] = {0.02, 0.02, 0.03, 1.0};
    for (int i = 0; i < 4; i++)
        out->background[i] = grey[i];
    return scene_build_end(&build, log);
}

const struct scene_info scene_polygons = {
    .name = "polygons",
    .description = "N random polygons (default 4000) that cover PIXELS pixels each (default 50)",
    .arguments = "[:N[,PIXELS]]",
    .make = make,
};
