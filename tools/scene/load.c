// SPDX-License-Identifier: BSD-3-Clause
// The scene of a mesh file: its triangles, a camera that sees all of them, and a lamp above.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"
#include "tools/scene/build.h"

static void copy_material(const struct weft_mesh_material *from, struct scene_material *to)
{
    *to = (struct scene_material){0};
    scene_set_name(to->name, from->name);
    memcpy(to->reflectance, from->reflectance, sizeof to->reflectance);
    memcpy(to->emission, from->emission, sizeof to->emission);
}

static void copy_part(const struct weft_mesh_part *from, struct scene_object *to)
{
    *to = (struct scene_object){.first_index = from->first_index,
                                .index_count = from->index_count,
                                .material = (int)from->material};
    scene_set_name(to->name, from->name);
}

// false: there was no memory.
static bool copy_mesh(const struct weft_mesh *mesh, struct scene *out)
{
    out->vertices = calloc(mesh->vertex_count, sizeof *out->vertices);
    out->indices = calloc(mesh->index_count, sizeof *out->indices);
    out->objects = calloc(mesh->part_count, sizeof *out->objects);
    out->materials = calloc(mesh->material_count, sizeof *out->materials);
    if (!out->vertices || !out->indices || !out->objects || !out->materials)
        return false;
    memcpy(out->vertices, mesh->vertices, mesh->vertex_count * sizeof *out->vertices);
    memcpy(out->indices, mesh->indices, mesh->index_count * sizeof *out->indices);
    for (size_t i = 0; i < mesh->part_count; i++)
        copy_part(&mesh->parts[i], &out->objects[i]);
    for (size_t i = 0; i < mesh->material_count; i++)
        copy_material(&mesh->materials[i], &out->materials[i]);
    out->vertex_count = mesh->vertex_count;
    out->index_count = mesh->index_count;
    out->object_count = (int)mesh->part_count;
    out->material_count = (int)mesh->material_count;
    return true;
}

// How far a camera that looks at `middle` from a direction has to stand, so that every vertex is
// within 9/10 of the picture; and how far the nearest one comes towards it.
static double find_distance(const struct scene *s, const double middle[3], const double towards[3],
                            const double tangent[2], double *nearest)
{
    double right[3], up[3], distance = -INFINITY;
    scene_cross((double[]){0.0, 1.0, 0.0}, towards, right);
    scene_normalise(right);
    scene_cross(towards, right, up);
    *nearest = -INFINITY;
    for (size_t i = 0; i < s->index_count; i++) {
        const float *f = s->vertices[s->indices[i]].position;
        const double at[3] = {f[0] - middle[0], f[1] - middle[1], f[2] - middle[2]};
        const double depth = scene_dot(at, towards);
        const double across = fabs(scene_dot(at, right)) / (0.9 * tangent[0]),
                     high = fabs(scene_dot(at, up)) / (0.9 * tangent[1]);
        distance = fmax(distance, depth + fmax(across, high));
        *nearest = fmax(*nearest, depth);
    }
    return distance;
}

// From the front, the right and a little above, y being up. Before the nearest vertex and behind
// the ball around the box there is room for what keyframes move.
static void place_camera(struct scene *s, const int size[2], const double middle[3], double radius)
{
    const double fovy = 40.0, up = tan(fovy * M_PI / 360.0);
    double towards[3] = {0.40, 0.35, 1.0}, nearest;
    scene_normalise(towards);
    double distance =
        find_distance(s, middle, towards, (double[]){up * size[0] / size[1], up}, &nearest);
    distance = fmax(distance, nearest + 0.1 * radius);
    s->camera = (struct weft_camera){.fovy_degrees = fovy,
                                     .near_distance = 0.25 * (distance - nearest),
                                     .far_distance = distance + 4.0 * radius,
                                     .up = {0.0, 1.0, 0.0}};
    for (int i = 0; i < 3; i++) {
        s->camera.target[i] = middle[i];
        s->camera.eye[i] = middle[i] + distance * towards[i];
    }
}

// A square above and to the left of the camera, half as wide as the ball, that faces its middle.
static void place_lamp(struct scene *s, const double middle[3], double radius)
{
    double away[3] = {-0.5, 1.0, 0.6};
    scene_normalise(away);
    struct scene_light lamp = {
        .shape = SCENE_LIGHT_SQUARE, .falloff = SCENE_FALLOFF_COSINE, .radiance = {0.9, 0.9, 0.9}};
    double u[3], v[3];
    scene_cross(away, (double[]){0.0, 0.0, 1.0}, u);
    scene_normalise(u);
    scene_cross(u, away, v); // u x v = -away
    for (int i = 0; i < 3; i++) {
        lamp.middle[i] = middle[i] + 3.0 * radius * away[i];
        lamp.u[i] = radius * u[i];
        lamp.v[i] = radius * v[i];
    }
    s->lights[s->light_count++] = lamp;
    for (int i = 0; i < 3; i++)
        s->ambient[i] = 0.25;
}

static void place(struct scene *s, const int size[2])
{
    double middle[3], radius = 0.0;
    for (int i = 0; i < 3; i++) {
        middle[i] = 0.5 * (s->low[i] + s->high[i]);
        radius = hypot(radius, 0.5 * (s->high[i] - s->low[i]));
    }
    const double away = hypot(hypot(middle[0], middle[1]), middle[2]);
    if (!(radius > 1e-6 * away)) // as good as all in one point
        radius = away > 0.0 ? 1e-6 * away : 1.0;
    place_camera(s, size, middle, radius);
    place_lamp(s, middle, radius);
    for (int i = 0; i < 4; i++)
        s->background[i] = i < 3 ? 0.05 : 1.0;
}

enum weft_result scene_load(const struct scene_params *params, struct scene *out)
{
    struct weft_mesh mesh;
    enum weft_result res = weft_mesh_load(
        weft_mesh_params(.path = params->name, .limits = params->limits, .log = params->log),
        &mesh);
    if (res != WEFT_OK)
        return res;
    if (copy_mesh(&mesh, out)) {
        const char *slash = strrchr(params->name, '/');
        scene_set_name(out->name, slash ? slash + 1 : params->name);
        scene_find_box(out);
        place(out, params->size);
    } else {
        log_error(params->log, "%.200s: out of memory for a scene of %zu triangles", params->name,
                  mesh.index_count / 3);
        scene_clear(out);
        res = WEFT_ERR_MEMORY;
    }
    weft_mesh_clear(&mesh);
    return res;
}
