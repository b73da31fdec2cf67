// SPDX-License-Identifier: BSD-3-Clause
#include "tools/scene/rays.h"

#include <math.h>
#include <stdlib.h>

#include "tools/scene/vector.h"

// ---- triangles at a time ------------------------------------------------------------------------

static void move_point(const double m[16], const float from[3], double to[3])
{
    for (int row = 0; row < 3; row++)
        to[row] = m[row] * from[0] + m[4 + row] * from[1] + m[8 + row] * from[2] + m[12 + row];
}

// false: it has no area.
static bool make_triangle(const struct scene *scene, const struct scene_object *object,
                          const double matrix[16], uint32_t first, struct scene_triangle *out)
{
    for (int k = 0; k < 3; k++) {
        out->vertex[k] = scene->indices[first + (uint32_t)k];
        move_point(matrix, scene->vertices[out->vertex[k]].position, out->corner[k]);
    }
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = out->corner[1][i] - out->corner[0][i];
        v[i] = out->corner[2][i] - out->corner[0][i];
    }
    scene_cross(u, v, out->normal);
    const double length = scene_normalise(out->normal);
    out->area = length / 2.0;
    out->material = object->material;
    return length > 0.0 && isfinite(length);
}

static double find_largest_coordinate(const struct scene_triangles *triangles)
{
    double largest = 0.0;
    for (size_t t = 0; t < triangles->count; t++)
        for (int k = 0; k < 9; k++)
            largest = fmax(largest, fabs(triangles->list[t].corner[k / 3][k % 3]));
    return largest;
}

// Around the triangles from `first` on, and wider than that by more than what rounding does to a
// ray's way through it, so that no triangle is missed for its run's sake.
static void make_bounds(const struct scene_triangles *triangles, size_t first, double wider,
                        struct scene_bounds *out)
{
    const double *start = triangles->list[first].corner[0];
    for (int axis = 0; axis < 3; axis++) {
        double low = start[axis], high = low;
        for (size_t t = first; t < first + SCENE_RUN && t < triangles->count; t++)
            for (int k = 0; k < 3; k++) {
                low = fmin(low, triangles->list[t].corner[k][axis]);
                high = fmax(high, triangles->list[t].corner[k][axis]);
            }
        out->low[axis] = low - wider;
        out->high[axis] = high + wider;
    }
}

enum weft_result scene_triangles_make(const struct scene *scene, double time,
                                      struct scene_triangles *out)
{
    const size_t most = scene->index_count / 3;
    *out = (struct scene_triangles){.scene = scene};
    out->list = calloc(most + 1, sizeof *out->list);
    out->run = calloc(most / SCENE_RUN + 1, sizeof *out->run);
    if (!out->list || !out->run) {
        scene_triangles_clear(out);
        return WEFT_ERR_MEMORY;
    }
    for (int o = 0; o < scene->object_count; o++) {
        const struct scene_object *object = &scene->objects[o];
        double matrix[16];
        scene_path_at(&object->path, time, matrix);
        for (uint32_t i = 0; i + 2 < object->index_count; i += 3)
            if (make_triangle(scene, object, matrix, object->first_index + i,
                              &out->list[out->count]))
                out->count++;
    }
    const double wider = 1e-9 * find_largest_coordinate(out);
    for (size_t first = 0; first < out->count; first += SCENE_RUN)
        make_bounds(out, first, wider, &out->run[first / SCENE_RUN]);
    return WEFT_OK;
}

void scene_triangles_clear(struct scene_triangles *triangles)
{
    if (!triangles)
        return;
    free(triangles->list);
    free(triangles->run);
    *triangles = (struct scene_triangles){0};
}

// ---- rays ---------------------------------------------------------------------------------------

// A ray as Woop's test wants it: axes in an order in which the last is the one along which the
// direction is longest, and the shear that takes the direction onto it.
struct sheared_ray {
    const double *origin, *direction;
    int axis[3];
    double shear[3];
};

static struct sheared_ray shear_ray(const double origin[3], const double direction[3])
{
    struct sheared_ray ray = {.origin = origin, .direction = direction};
    int z = fabs(direction[0]) > fabs(direction[1]) ? 0 : 1;
    z = fabs(direction[z]) > fabs(direction[2]) ? z : 2;
    ray.axis[2] = z;
    ray.axis[0] = (z + 1) % 3;
    ray.axis[1] = (z + 2) % 3;
    ray.shear[0] = direction[ray.axis[0]] / direction[z];
    ray.shear[1] = direction[ray.axis[1]] / direction[z];
    ray.shear[2] = 1.0 / direction[z];
    return ray;
}

// Weights are those of the corners, not yet divided by their sum, which has a sign. The distance is
// scaled likewise. false: the ray's line misses the triangle.
static bool meet(const struct sheared_ray *ray, const struct scene_triangle *triangle,
                 double weight[3], double *sum, double *distance)
{
    double x[3], y[3], z[3];
    for (int k = 0; k < 3; k++) {
        const double *corner = triangle->corner[k];
        z[k] = corner[ray->axis[2]] - ray->origin[ray->axis[2]];
        x[k] = corner[ray->axis[0]] - ray->origin[ray->axis[0]] - ray->shear[0] * z[k];
        y[k] = corner[ray->axis[1]] - ray->origin[ray->axis[1]] - ray->shear[1] * z[k];
    }
    // Two triangles at an edge compute the same two products for it, in one order or the other.
    weight[0] = x[2] * y[1] - y[2] * x[1];
    weight[1] = x[0] * y[2] - y[0] * x[2];
    weight[2] = x[1] * y[0] - y[1] * x[0];
    if ((weight[0] < 0.0 || weight[1] < 0.0 || weight[2] < 0.0) &&
        (weight[0] > 0.0 || weight[1] > 0.0 || weight[2] > 0.0))
        return false;
    *sum = weight[0] + weight[1] + weight[2];
    *distance = ray->shear[2] * (weight[0] * z[0] + weight[1] * z[1] + weight[2] * z[2]);
    return *sum != 0.0;
}

// Whether the ray is in the bounds somewhere between its start and `most`. `inverse`: 1 /
// direction.
static bool meets_bounds(const double origin[3], const double inverse[3],
                         const struct scene_bounds *bounds, double most)
{
    double from = 0.0, to = most;
    for (int axis = 0; axis < 3; axis++) {
        if (isinf(inverse[axis])) {
            if (origin[axis] < bounds->low[axis] || origin[axis] > bounds->high[axis])
                return false;
            continue;
        }
        const double a = (bounds->low[axis] - origin[axis]) * inverse[axis],
                     b = (bounds->high[axis] - origin[axis]) * inverse[axis];
        const double enters = a < b ? a : b, leaves = a < b ? b : a;
        from = enters > from ? enters : from;
        to = leaves < to ? leaves : to;
    }
    return from <= to;
}

// The nearest of a run, before `most`.
static bool hit_run(const struct scene_triangles *triangles, const struct sheared_ray *ray,
                    size_t first, size_t from, double most, struct scene_hit *out)
{
    bool found = false;
    for (size_t t = first; t < first + SCENE_RUN && t < triangles->count; t++) {
        const struct scene_triangle *triangle = &triangles->list[t];
        double weight[3], sum, scaled;
        if (t == from || !meet(ray, triangle, weight, &sum, &scaled))
            continue;
        const double distance = scaled / sum;
        if (!(distance > 0.0 && distance < most))
            continue;
        const bool back = scene_dot(ray->direction, triangle->normal) > 0.0;
        if (back && triangles->scene->materials[triangle->material].single_sided)
            continue;
        most = distance;
        found = true;
        *out = (struct scene_hit){
            t, distance, {weight[0] / sum, weight[1] / sum, weight[2] / sum}, back};
    }
    return found;
}

bool scene_triangles_hit(const struct scene_triangles *triangles, const double origin[3],
                         const double direction[3], size_t from, double most, struct scene_hit *out)
{
    const struct sheared_ray ray = shear_ray(origin, direction);
    const double inverse[3] = {1.0 / direction[0], 1.0 / direction[1], 1.0 / direction[2]};
    struct scene_hit hit = {.distance = most};
    bool found = false;
    for (size_t first = 0; first < triangles->count; first += SCENE_RUN)
        if (meets_bounds(origin, inverse, &triangles->run[first / SCENE_RUN], hit.distance))
            found |= hit_run(triangles, &ray, first, from, hit.distance, &hit);
    if (found && out)
        *out = hit;
    return found;
}

// ---- what is there ------------------------------------------------------------------------------

void scene_triangle_point(const struct scene_triangle *triangle, const double weight[3],
                          double point[3])
{
    double within[3], sum = 0.0;
    for (int k = 0; k < 3; k++) {
        within[k] = fmax(weight[k], 1e-9);
        sum += within[k];
    }
    for (int i = 0; i < 3; i++) {
        point[i] = 0.0;
        for (int k = 0; k < 3; k++)
            point[i] += within[k] / sum * triangle->corner[k][i];
    }
}

// What a pattern leaves of the reflectance.
static double find_pattern(const struct scene_material *material, const double uv[2])
{
    if (material->pattern != SCENE_CHECKER)
        return 1.0;
    const double sum = floor(uv[0] * material->frequency) + floor(uv[1] * material->frequency);
    return fmod(sum, 2.0) == 0.0 ? 1.0 : 0.25;
}

void scene_triangle_reflectance(const struct scene_triangles *triangles, size_t at,
                                const double weight[3], double reflectance[3])
{
    const struct scene_triangle *triangle = &triangles->list[at];
    const struct scene_material *material = &triangles->scene->materials[triangle->material];
    double uv[2] = {0.0, 0.0}, colour[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        const struct weft_mesh_vertex *vertex = &triangles->scene->vertices[triangle->vertex[k]];
        for (int i = 0; i < 2; i++)
            uv[i] += weight[k] * vertex->uv[i];
        for (int i = 0; i < 3; i++)
            colour[i] += weight[k] * vertex->colour[i];
    }
    const double kept = material->unlit ? 0.0 : find_pattern(material, uv);
    for (int i = 0; i < 3; i++)
        reflectance[i] = fmin(fmax(kept * material->reflectance[i] * colour[i], 0.0), 1.0);
}
