// SPDX-License-Identifier: BSD-3-Clause
// How wide penumbrae get in a picture: rays from the camera, and to the lamps from there.
#include <math.h>

#include "tools/scene/build.h"
#include "tools/scene/rays.h"

// Points along a side, and the pairs of points and triangles that are looked at unasked.
enum { MOST_POINTS = 48, LEAST_POINTS = 12 };
static const double PAIRS = 7e7;

// Cosines below are of what lies in the plane of a lamp, but for rounding.
static const double LEAST_COSINE = 1e-6;

// A ray from the camera, what it hits, and where that is.
struct sight {
    double from[3], along[3]; // along[] is 1 long in the direction of sight: distances are depths
    struct scene_hit hit;
    double surface[3];
};

// Whether light along a ray, which comes from a lamp of such a normal, falls on the side of the
// surface that is seen.
static bool faces(const struct scene_triangles *triangles, const struct sight *sight,
                  const double normal[3], const double along[3])
{
    const double *n = triangles->list[sight->hit.triangle].normal;
    const double least = LEAST_COSINE * sqrt(scene_dot(along, along));
    const double falls = sight->hit.back ? scene_dot(n, along) : -scene_dot(n, along);
    return falls > least && scene_dot(normal, along) > least;
}

// The widest penumbra of a lamp at a surface, in the scene's unit: see the header.
static double find_width(const struct scene_triangles *triangles, const struct scene_light *lamp,
                         const struct sight *sight)
{
    // A little inwards of the corners, where what the lamp is set into may begin.
    static const double place[5][2] = {
        {0.0, 0.0}, {-0.49, -0.49}, {0.49, -0.49}, {0.49, 0.49}, {-0.49, 0.49}};
    const double inwards = lamp->shape == SCENE_LIGHT_DISC ? M_SQRT1_2 : 1.0;
    const double extent = sqrt(fmax(scene_dot(lamp->u, lamp->u), scene_dot(lamp->v, lamp->v)));
    double normal[3], widest = 0.0;
    scene_cross(lamp->u, lamp->v, normal);
    scene_normalise(normal);
    for (int k = 0; k < 5; k++) {
        double from[3], along[3];
        struct scene_hit hit;
        for (int i = 0; i < 3; i++) {
            from[i] =
                lamp->middle[i] + inwards * (place[k][0] * lamp->u[i] + place[k][1] * lamp->v[i]);
            along[i] = sight->surface[i] - from[i];
        }
        // What is between is seen from the lamp, whose own surface has its back there.
        if (faces(triangles, sight, normal, along) &&
            scene_triangles_hit(triangles, from, along, sight->hit.triangle, 1.0 - 1e-9, &hit))
            widest = fmax(widest, extent * (1.0 - hit.distance) / hit.distance);
    }
    return widest;
}

// The ray through a place of the picture, from -1 to 1 each.
static struct sight look(const struct weft_camera *camera, const struct weft_camera_matrices *m,
                         double x, double y)
{
    struct sight sight = {0};
    for (int i = 0; i < 3; i++) {
        sight.along[i] = m->view[4 * i] * x / m->projection[0] +
                         m->view[4 * i + 1] * y / m->projection[5] - m->view[4 * i + 2];
        // Rays start on the near plane.
        sight.from[i] = camera->eye[i] + camera->near_distance * sight.along[i];
    }
    return sight;
}

// In the scene's unit at a depth of 1.
static double find_widest(const struct scene_triangles *triangles, const struct weft_camera *camera,
                          struct sight *sight)
{
    double widest = 0.0;
    if (!scene_triangles_hit(triangles, sight->from, sight->along, SIZE_MAX,
                             camera->far_distance - camera->near_distance, &sight->hit))
        return widest;
    for (int i = 0; i < 3; i++)
        sight->surface[i] = sight->from[i] + sight->hit.distance * sight->along[i];
    const struct scene *scene = triangles->scene;
    for (int i = 0; i < scene->light_count; i++)
        if (scene->lights[i].shape != SCENE_LIGHT_POINT)
            widest = fmax(widest, find_width(triangles, &scene->lights[i], sight));
    return widest / (camera->near_distance + sight->hit.distance);
}

static int count_points(const struct scene_triangles *triangles)
{
    const double points = floor(sqrt(PAIRS / ((double)triangles->count + 1.0)));
    return (int)fmin(fmax(points, LEAST_POINTS), MOST_POINTS);
}

double scene_widest_penumbra(const struct scene *scene, const int size[2], double time)
{
    struct weft_camera camera;
    struct weft_camera_matrices matrices;
    struct scene_triangles triangles;
    scene_camera_at(scene, time, &camera);
    if (weft_camera_compute(NULL, &camera, weft_camera_frame(.size = {size[0], size[1]}),
                            &matrices) != WEFT_OK)
        return 0.0;
    if (scene_triangles_make(scene, time, &triangles) != WEFT_OK)
        return NAN;
    const int points = count_points(&triangles);
    double widest = 0.0;
    for (int i = 0; i < points * points; i++) {
        struct sight sight = look(&camera, &matrices, (2.0 * (i % points) + 1.0) / points - 1.0,
                                  (2.0 * (i / points) + 1.0) / points - 1.0);
        widest = fmax(widest, find_widest(&triangles, &camera, &sight));
    }
    scene_triangles_clear(&triangles);
    // Pixels across what is as wide as it is deep.
    return widest * 0.5 * fmax(size[0] * matrices.projection[0], size[1] * matrices.projection[5]);
}
