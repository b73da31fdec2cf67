// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/render/traced.h - what a pixel shows, by rays in double: the surface, the light on
// it, and whether it is hidden. Include after pictures.h.
#ifndef WEFT_TESTS_TOOLS_RENDER_TRACED_H
#define WEFT_TESTS_TOOLS_RENDER_TRACED_H

#include "tools/scene/rays.h"

// A point that is seen.
struct traced_point {
    size_t triangle;      // SIZE_MAX: the background
    struct scene_hit hit; // of the ray that sees it
    double position[3];
    double normal[3]; // of the triangle, to the viewer
    double smooth[3]; // that of its corners, likewise
    double reach;     // how far a point lies from there that the picture has 1/128 of a pixel aside
};

// Rays through pixels of a camera that has not moved, from the lower left.
struct traced_camera {
    double eye[3], right[3], up[3], forward[3]; // right and up: from the middle to the edges
    int size[2];
    double time;
};

static inline void find_camera(const struct weft_camera *camera, const int size[2], double time,
                               struct traced_camera *out)
{
    const double tangent = tan(camera->fovy_degrees * M_PI / 360.0);
    const double aspect = camera->aspect > 0.0 ? camera->aspect : (double)size[0] / size[1];
    for (int i = 0; i < 3; i++) {
        out->eye[i] = camera->eye[i];
        out->forward[i] = camera->target[i] - camera->eye[i];
    }
    scene_normalise(out->forward);
    scene_cross(out->forward, camera->up, out->right);
    scene_normalise(out->right);
    scene_cross(out->right, out->forward, out->up);
    for (int i = 0; i < 3; i++) {
        out->right[i] *= tangent * aspect;
        out->up[i] *= tangent;
    }
    out->time = time;
    out->size[0] = size[0];
    out->size[1] = size[1];
}

// The normal of a corner at a time, of length 1 but for rounding.
static inline void find_corner_normal(const struct scene *scene, uint32_t vertex, double time,
                                      double out[3])
{
    const float *n = scene->vertices[vertex].normal;
    const struct scene_object *object = scene->objects;
    uint32_t i = object->first_index;
    while (scene->indices[i] != vertex)
        if (++i == object->first_index + object->index_count)
            i = (++object)->first_index;
    const struct scene_key key = scene_path_key(&object->path, time);
    scene_rotate(key.rotation, (double[]){n[0], n[1], n[2]}, out);
}

static inline void trace_pixel(const struct scene_triangles *triangles,
                               const struct traced_camera *camera, double x, double y,
                               struct traced_point *out)
{
    double way[3];
    struct scene_hit hit;
    for (int i = 0; i < 3; i++)
        way[i] = camera->forward[i] + (2.0 * x / camera->size[0] - 1.0) * camera->right[i] +
                 (2.0 * y / camera->size[1] - 1.0) * camera->up[i];
    *out = (struct traced_point){.triangle = SIZE_MAX};
    if (!scene_triangles_hit(triangles, camera->eye, way, SIZE_MAX, INFINITY, &hit))
        return;
    const struct scene_triangle *triangle = &triangles->list[hit.triangle];
    const double sign = hit.back ? -1.0 : 1.0;
    out->triangle = hit.triangle;
    out->hit = hit;
    for (int i = 0; i < 3; i++) {
        out->position[i] = camera->eye[i] + hit.distance * way[i];
        out->normal[i] = sign * triangle->normal[i];
    }
    for (int k = 0; k < 3; k++) {
        double normal[3];
        find_corner_normal(triangles->scene, triangle->vertex[k], camera->time, normal);
        for (int i = 0; i < 3; i++)
            out->smooth[i] += sign * hit.weight[k] * normal[i];
    }
    scene_normalise(out->smooth);
    const double pixel = 2.0 * hypot(hypot(camera->up[0], camera->up[1]), camera->up[2]) *
                         hit.distance / camera->size[1];
    const double length = sqrt(scene_dot(way, way));
    out->reach = pixel / 128.0 * length / fabs(scene_dot(way, out->normal));
}

// Whether every point that is up to 1/64 of a pixel aside belongs to the same triangle.
static inline bool is_inside(const struct scene_triangles *triangles,
                             const struct traced_camera *camera, double x, double y,
                             size_t triangle)
{
    for (int i = 0; i < 4; i++) {
        struct traced_point aside;
        trace_pixel(triangles, camera, x + (i & 1 ? 1.0 : -1.0) / 64.0,
                    y + (i & 2 ? 1.0 : -1.0) / 64.0, &aside);
        if (aside.triangle != triangle)
            return false;
    }
    return true;
}

// Whether something lies between a point of a triangle and a light.
static inline bool is_hidden(const struct scene_triangles *triangles, const double point[3],
                             size_t triangle, const double light[3])
{
    double way[3];
    for (int i = 0; i < 3; i++)
        way[i] = light[i] - point[i];
    return scene_triangles_hit(triangles, point, way, triangle, 1.0, NULL);
}

enum traced_light { TRACED_HIDDEN, TRACED_LIT, TRACED_BETWEEN };

// How all points of the triangle's plane see the light that lie within `aside` of the point, as
// seen from the light, at distance 1.
static inline enum traced_light trace_light(const struct scene_triangles *triangles,
                                            const struct traced_point *point, const double light[3],
                                            double aside)
{
    double way[3], right[3], up[3];
    for (int i = 0; i < 3; i++)
        way[i] = point->position[i] - light[i];
    const double distance = scene_normalise(way), above = -scene_dot(way, point->normal) * distance;
    const double other[3] = {fabs(way[0]) < 0.5, fabs(way[0]) >= 0.5, 0.0};
    scene_cross(way, other, right);
    scene_normalise(right);
    scene_cross(way, right, up);
    const bool hidden = is_hidden(triangles, point->position, point->triangle, light);
    for (int ring = 1; ring <= 3; ring++)
        for (int i = 0; i < 16; i++) {
            double turned[3], moved[3];
            for (int k = 0; k < 3; k++)
                turned[k] =
                    way[k] + aside * ring / 3.0 *
                                 (cos(i * M_PI / 8.0) * right[k] + sin(i * M_PI / 8.0) * up[k]);
            const double fall = -scene_dot(turned, point->normal);
            // Beyond the horizon, or nearly.
            if (fall * distance < 0.25 * above)
                return TRACED_BETWEEN;
            for (int k = 0; k < 3; k++)
                moved[k] = light[k] + above / fall * turned[k];
            if (is_hidden(triangles, moved, point->triangle, light) != hidden)
                return TRACED_BETWEEN;
        }
    return hidden ? TRACED_HIDDEN : TRACED_LIT;
}

// cos cos / distance^2 with the light's normal, or without where it has none; 0 behind surfaces.
static inline double find_form(const struct scene_point_light *light,
                               const struct traced_point *point)
{
    double way[3];
    for (int i = 0; i < 3; i++)
        way[i] = light->position[i] - point->position[i];
    const double distance = scene_normalise(way);
    const bool faces = scene_dot(way, point->normal) > 0.0;
    const double here = faces ? fmax(scene_dot(way, point->smooth), 0.0) : 0.0;
    const bool flat = scene_dot(light->normal, light->normal) > 0.0;
    const double there = flat ? fmax(-scene_dot(way, light->normal), 0.0) : 1.0;
    return here * there / (distance * distance);
}

#endif
