// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/casters.h"

#include <math.h>

#include "tools/scene/vector.h"

static double find_tolerance(const struct scene *scene)
{
    double square = 0.0;
    for (int i = 0; i < 3; i++)
        square += (scene->high[i] - scene->low[i]) * (scene->high[i] - scene->low[i]);
    return 0x1p-20 * sqrt(square);
}

static const float *find_corner(const struct scene *scene, size_t index)
{
    return scene->vertices[scene->indices[index]].position;
}

static double find_distance(const double plane[4], const float p[3])
{
    return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] - plane[3];
}

// ---- the planes of an object --------------------------------------------------------------------

// false: the triangle has no area.
static bool find_triangle_plane(const struct scene *scene, size_t first, double out[4])
{
    double side[2][3];
    const float *corner[3];
    for (size_t i = 0; i < 3; i++)
        corner[i] = find_corner(scene, first + i);
    for (int i = 0; i < 3; i++) {
        side[0][i] = (double)corner[1][i] - corner[0][i];
        side[1][i] = (double)corner[2][i] - corner[0][i];
    }
    scene_cross(side[0], side[1], out);
    if (!(scene_normalise(out) > 0.0))
        return false;
    out[3] = 0.0;
    out[3] = find_distance(out, corner[0]);
    return true;
}

static bool is_in(const struct scene *scene, size_t first, const double plane[4], double tolerance)
{
    for (size_t i = 0; i < 3; i++)
        if (fabs(find_distance(plane, find_corner(scene, first + i))) > tolerance)
            return false;
    return true;
}

static bool is_in_any(const struct scene *scene, size_t first, const struct scene_hull *hull,
                      double tolerance)
{
    for (int i = 0; i < hull->count; i++)
        if (is_in(scene, first, hull->plane[i], tolerance))
            return true;
    return false;
}

// false: there are too many.
static bool find_planes(const struct scene *scene, const struct scene_object *object,
                        double tolerance, struct scene_hull *out)
{
    for (uint32_t i = 0; i < object->index_count; i += 3) {
        const size_t first = object->first_index + i;
        double plane[4];
        if (is_in_any(scene, first, out, tolerance) || !find_triangle_plane(scene, first, plane))
            continue;
        if (out->count == SCENE_CASTER_PLANES)
            return false;
        for (int k = 0; k < 4; k++)
            out->plane[out->count][k] = plane[k];
        out->count++;
    }
    return true;
}

// ---- what lies on which side --------------------------------------------------------------------

// Least and greatest distance from a plane of what moves: between keys positions and scales are
// linear, and whatever the rotation, points stay within their greatest distance from the origin.
static void measure_moving(const struct scene *scene, const struct scene_object *object,
                           const double plane[4], double range[2])
{
    double radius = 0.0;
    for (uint32_t i = 0; i < object->index_count; i++) {
        const float *p = find_corner(scene, object->first_index + i);
        radius = fmax(radius, hypot(hypot(p[0], p[1]), p[2]));
    }
    for (int i = 0; i < object->path.count; i++) {
        const struct scene_key *key = &object->path.keys[i];
        const double middle = scene_dot(plane, key->position) - plane[3];
        range[0] = fmin(range[0], middle - key->scale * radius);
        range[1] = fmax(range[1], middle + key->scale * radius);
    }
}

// false: it is on both sides.
static bool measure_resting(const struct scene *scene, const struct scene_object *object,
                            const double plane[4], double tolerance, double range[2])
{
    for (uint32_t i = 0; i < object->index_count; i++) {
        const double d = find_distance(plane, find_corner(scene, object->first_index + i));
        range[0] = fmin(range[0], d);
        range[1] = fmax(range[1], d);
        if (range[0] < -tolerance && range[1] > tolerance)
            return false;
    }
    return true;
}

// Turns the plane's normal to where the scene is. false: it is on both sides, or *corners, how many
// may still be looked at, has run out.
static bool turn_to_scene(const struct scene *scene, double plane[4], double tolerance,
                          int64_t *corners)
{
    double range[2] = {0.0, 0.0};
    for (int i = 0; i < scene->object_count; i++) {
        const struct scene_object *object = &scene->objects[i];
        *corners -= object->index_count;
        if (*corners < 0)
            return false;
        if (object->path.count)
            measure_moving(scene, object, plane, range);
        else if (!measure_resting(scene, object, plane, tolerance, range))
            return false;
        if (range[0] < -tolerance && range[1] > tolerance)
            return false;
    }
    const double sign = range[0] < -tolerance ? -1.0 : 1.0;
    for (int i = 0; i < 4; i++)
        plane[i] *= sign;
    return true;
}

static void find_hull(const struct scene *scene, int object, int64_t *corners,
                      struct scene_hull *out)
{
    const double tolerance = find_tolerance(scene);
    out->count = 0;
    bool is_hull = !scene->objects[object].path.count &&
                   find_planes(scene, &scene->objects[object], tolerance, out);
    for (int i = 0; i < out->count && is_hull; i++)
        is_hull = turn_to_scene(scene, out->plane[i], tolerance, corners);
    if (!is_hull)
        out->count = 0;
}

void scene_hulls_find(const struct scene *scene, struct scene_hull *out)
{
    int64_t corners = SCENE_CASTER_CORNERS;
    for (int i = 0; i < scene->object_count; i++)
        find_hull(scene, i, &corners, &out[i]);
}

bool scene_hull_casts(const struct scene *scene, const struct scene_hull *hull, const double eye[3])
{
    const double tolerance = find_tolerance(scene);
    for (int i = 0; i < hull->count; i++)
        if (scene_dot(hull->plane[i], eye) - hull->plane[i][3] <= tolerance)
            return true;
    return hull->count == 0;
}
