// SPDX-License-Identifier: BSD-3-Clause
// What the camera has in sight: where it is, how fast that moves, how far away it is.
#include <math.h>
#include <string.h>

#include "tools/scene/build.h"

void scene_camera_at(const struct scene *scene, double time, struct weft_camera *out)
{
    *out = scene->camera;
    if (scene->camera_path.count == 0)
        return;
    const struct scene_key key = scene_path_key(&scene->camera_path, time);
    double sight[3];
    for (int i = 0; i < 3; i++) {
        sight[i] = scene->camera.target[i] - scene->camera.eye[i];
        out->eye[i] += key.position[i];
    }
    scene_rotate(key.rotation, sight, sight);
    scene_rotate(key.rotation, scene->camera.up, out->up);
    for (int i = 0; i < 3; i++)
        out->target[i] = out->eye[i] + sight[i];
}

// ---- clip coordinates ---------------------------------------------------------------------------

// From an object's modelled points to clip coordinates at a time. false: the camera sees nothing.
static bool find_matrix(const struct scene *scene, const struct scene_object *object,
                        const int size[2], double time, double out[16])
{
    struct weft_camera camera;
    struct weft_camera_matrices matrices;
    scene_camera_at(scene, time, &camera);
    if (weft_camera_compute(NULL, &camera, weft_camera_frame(.size = {size[0], size[1]}),
                            &matrices) != WEFT_OK)
        return false;
    double model[16];
    scene_path_at(&object->path, time, model);
    scene_multiply(matrices.clip, model, out);
    return true;
}

// A point of an object, where it is modelled, and its clip coordinates. w is its depth.
struct point {
    double at[3], clip[4];
};

static void project(const double m[16], const double v[3], double clip[4])
{
    for (int i = 0; i < 4; i++)
        clip[i] = m[i] * v[0] + m[4 + i] * v[1] + m[8 + i] * v[2] + m[12 + i];
}

// ---- polygons in sight --------------------------------------------------------------------------

enum { PLANES = 6, CORNERS = 3 + PLANES };

// How far inside of a plane of the frustum a point is, which is `wide` times as wide and high: the
// near plane first, then the far one, and those of the picture's edges.
static double inside(const double clip[4], int plane, double wide)
{
    const double sign = plane % 2 ? -1.0 : 1.0;
    if (plane < 2)
        return clip[3] + sign * clip[2];
    return wide * clip[3] + sign * clip[plane / 2 - 1];
}

static struct point between(const struct point *a, const struct point *b, double share)
{
    struct point out;
    for (int i = 0; i < 3; i++)
        out.at[i] = a->at[i] + share * (b->at[i] - a->at[i]);
    for (int i = 0; i < 4; i++)
        out.clip[i] = a->clip[i] + share * (b->clip[i] - a->clip[i]);
    return out;
}

// Sutherland and Hodgman, "Reentrant polygon clipping", 1974: one plane.
static int clip_plane(const struct point *in, int count, int plane, double wide, struct point *out)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const struct point *a = &in[i], *b = &in[(i + 1) % count];
        const double from = inside(a->clip, plane, wide), to = inside(b->clip, plane, wide);
        if (from >= 0.0)
            out[kept++] = *a;
        if ((from < 0.0) != (to < 0.0))
            out[kept++] = between(a, b, from / (from - to));
    }
    return kept;
}

// The part of a triangle that is in sight; returns how many corners it has, 0 or 3 to CORNERS.
static int clip_triangle(const struct scene *scene, uint32_t first, const double matrix[16],
                         double wide, struct point out[CORNERS])
{
    int count = 3;
    for (int i = 0; i < 3; i++) {
        const float *f = scene->vertices[scene->indices[first + (uint32_t)i]].position;
        for (int axis = 0; axis < 3; axis++)
            out[i].at[axis] = f[axis];
        project(matrix, out[i].at, out[i].clip);
    }
    for (int plane = 0; plane < PLANES && count; plane++) {
        bool cut = false;
        for (int i = 0; i < count; i++)
            cut |= !(inside(out[i].clip, plane, wide) >= 0.0);
        if (!cut)
            continue;
        struct point whole[CORNERS];
        memcpy(whole, out, (size_t)count * sizeof *whole);
        count = clip_plane(whole, count, plane, wide, out);
    }
    return count;
}

// ---- motion -------------------------------------------------------------------------------------

enum { PARTS = 64, STEPS = 8 };

// A part of the time: an object's matrices at the start and after each step.
struct part {
    double matrix[STEPS + 1][16];
    int steps;
};

static bool has_key(const struct scene_path *path, double from, double to)
{
    for (int i = 0; i < path->count; i++)
        if (path->keys[i].time > from && path->keys[i].time < to)
            return true;
    return false;
}

// Without a key motion is as good as straight.
static bool find_part(const struct scene *scene, const struct scene_object *object,
                      const int size[2], const double time[2], struct part *out)
{
    const bool bent =
        has_key(&object->path, time[0], time[1]) || has_key(&scene->camera_path, time[0], time[1]);
    out->steps = bent ? STEPS : 1;
    for (int i = 0; i <= out->steps; i++) {
        const double at = time[0] + (time[1] - time[0]) * i / out->steps;
        if (!find_matrix(scene, object, size, at, out->matrix[i]))
            return false;
    }
    return true;
}

// The way of a point on the screen, until it comes before the near plane.
static double follow(const struct part *part, const struct point *point, const int size[2])
{
    double way = 0.0, last[2] = {0.0, 0.0};
    for (int step = 0; step <= part->steps; step++) {
        double clip[4], now[2];
        project(part->matrix[step], point->at, clip);
        if (!(clip[3] > 0.0) || (step > 0 && inside(clip, 0, 1.0) < 0.0))
            break;
        for (int axis = 0; axis < 2; axis++)
            now[axis] = 0.5 * size[axis] * clip[axis] / clip[3];
        way += step ? hypot(now[0] - last[0], now[1] - last[1]) : 0.0;
        memcpy(last, now, sizeof last);
    }
    return way;
}

static double find_longest_way(const struct scene *scene, const struct scene_object *object,
                               const int size[2], const double time[2])
{
    struct part part;
    double longest = 0.0;
    if (!find_part(scene, object, size, time, &part))
        return longest;
    for (uint32_t i = 0; i + 2 < object->index_count; i += 3) {
        struct point corner[CORNERS];
        const int count =
            clip_triangle(scene, object->first_index + i, part.matrix[0], 1.25, corner);
        for (int k = 0; k < count; k++)
            longest = fmax(longest, follow(&part, &corner[k], size));
    }
    return longest;
}

double scene_longest_motion(const struct scene *scene, const int size[2], double from, double to)
{
    double longest = 0.0;
    if (!(from < to))
        return longest;
    for (int i = 0; i < scene->object_count; i++) {
        const struct scene_object *object = &scene->objects[i];
        if (object->path.count < 2 && scene->camera_path.count < 2)
            continue;
        for (int k = 0; k < PARTS; k++) {
            const double time[2] = {from + (to - from) * k / PARTS,
                                    from + (to - from) * (k + 1) / PARTS};
            longest = fmax(longest, PARTS * find_longest_way(scene, object, size, time));
        }
    }
    return longest;
}

// ---- depth --------------------------------------------------------------------------------------

void scene_depths(const struct scene *scene, const int size[2], double time, double *nearest,
                  double *farthest)
{
    *nearest = *farthest = NAN;
    for (int i = 0; i < scene->object_count; i++) {
        const struct scene_object *object = &scene->objects[i];
        double matrix[16];
        if (!find_matrix(scene, object, size, time, matrix))
            return;
        for (uint32_t k = 0; k + 2 < object->index_count; k += 3) {
            struct point corner[CORNERS];
            const int count = clip_triangle(scene, object->first_index + k, matrix, 1.0, corner);
            for (int c = 0; c < count; c++) {
                *nearest = fmin(*nearest, corner[c].clip[3]); // a number, where one is NAN
                *farthest = fmax(*farthest, corner[c].clip[3]);
            }
        }
    }
}
