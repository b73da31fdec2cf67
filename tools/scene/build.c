// SPDX-License-Identifier: BSD-3-Clause
// Scenes that grow: vertices, triangles, objects, materials, lamps.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"
#include "tools/scene/build.h"

void scene_set_name(char out[SCENE_NAME], const char *name)
{
    snprintf(out, SCENE_NAME, "%s", name);
    weft_text_clean(out, false);
}

// ---- room ---------------------------------------------------------------------------------------

// Room for one more; NULL where there is none. What is there stays in either case.
static void *make_room(struct scene_build *build, void *list, size_t count, size_t *room,
                       size_t bytes)
{
    if (build->full || count < *room)
        return build->full ? NULL : list;
    const size_t more = *room ? 2 * *room : 16;
    void *grown = realloc(list, more * bytes);
    if (grown)
        *room = more;
    build->full = !grown;
    return grown;
}

static void add_vertex(struct scene_build *build, const struct weft_mesh_vertex *vertex)
{
    struct scene *s = build->scene;
    struct weft_mesh_vertex *list =
        make_room(build, s->vertices, s->vertex_count, &build->vertex_room, sizeof *list);
    if (list) {
        s->vertices = list;
        list[s->vertex_count++] = *vertex;
    }
}

static void add_index(struct scene_build *build, size_t vertex)
{
    struct scene *s = build->scene;
    uint32_t *list = make_room(build, s->indices, s->index_count, &build->index_room, sizeof *list);
    if (list) {
        s->indices = list;
        list[s->index_count++] = (uint32_t)vertex;
        s->objects[s->object_count - 1].index_count++;
    }
}

int scene_build_material(struct scene_build *build, const struct scene_material *material)
{
    struct scene *s = build->scene;
    size_t room = (size_t)build->material_room;
    struct scene_material *list =
        make_room(build, s->materials, (size_t)s->material_count, &room, sizeof *list);
    if (!list)
        return 0;
    s->materials = list;
    build->material_room = (int)room;
    list[s->material_count] = *material;
    return s->material_count++;
}

void scene_build_object(struct scene_build *build, const char *name, int material)
{
    struct scene *s = build->scene;
    size_t room = (size_t)build->object_room;
    struct scene_object *list =
        make_room(build, s->objects, (size_t)s->object_count, &room, sizeof *list);
    if (!list)
        return;
    s->objects = list;
    build->object_room = (int)room;
    struct scene_object *object = &list[s->object_count++];
    *object = (struct scene_object){.first_index = (uint32_t)s->index_count, .material = material};
    scene_set_name(object->name, name);
}

struct scene_key *scene_build_path(struct scene_build *build, int count)
{
    struct scene_key *keys = build->full ? NULL : calloc((size_t)count, sizeof *keys);
    build->full = !keys;
    if (!keys)
        return NULL;
    build->scene->objects[build->scene->object_count - 1].path =
        (struct scene_path){.keys = keys, .count = count};
    for (int i = 0; i < count; i++) {
        keys[i].rotation[3] = keys[i].scale = 1.0;
        keys[i].time = count > 1 ? (double)i / (count - 1) : 0.0;
    }
    return keys;
}

// ---- shapes -------------------------------------------------------------------------------------

// Newell's normal (Sutherland, Sproull and Schumacker 1974): of a flat polygon, twice its area
// long.
static void find_normal(int count, const double corner[][3], double normal[3])
{
    for (int axis = 0; axis < 3; axis++) {
        const int y = (axis + 1) % 3, z = (axis + 2) % 3;
        normal[axis] = 0.0;
        for (int i = 0; i < count; i++) {
            const double *a = corner[i], *b = corner[(i + 1) % count];
            normal[axis] += (a[y] - b[y]) * (a[z] + b[z]);
        }
    }
    scene_normalise(normal);
}

void scene_build_polygon(struct scene_build *build, int count, const double corner[][3],
                         const double uv[][2], const float colour[3])
{
    const size_t first = build->scene->vertex_count;
    double normal[3];
    find_normal(count, corner, normal);
    for (int i = 0; i < count; i++) {
        struct weft_mesh_vertex vertex = {.colour = {1.0f, 1.0f, 1.0f}};
        for (int axis = 0; axis < 3; axis++) {
            vertex.position[axis] = (float)corner[i][axis];
            vertex.normal[axis] = (float)normal[axis];
            if (colour)
                vertex.colour[axis] = colour[axis];
        }
        for (int axis = 0; axis < 2 && uv; axis++)
            vertex.uv[axis] = (float)uv[i][axis];
        add_vertex(build, &vertex);
    }
    for (int i = 1; i + 1 < count; i++) {
        add_index(build, first);
        add_index(build, first + (size_t)i);
        add_index(build, first + (size_t)i + 1);
    }
}

void scene_build_box(struct scene_build *build, const double low[3], const double high[3])
{
    static const double uv[4][2] = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
    for (int face = 0; face < 6; face++) {
        const int axis = face / 2, side = face % 2;
        double corner[4][3];
        for (int i = 0; i < 4; i++) {
            // The other two axes in their order go counterclockwise seen from the high side.
            const int turn = side ? i : 3 - i;
            const bool far[2] = {turn == 1 || turn == 2, turn >= 2};
            corner[i][axis] = side ? high[axis] : low[axis];
            for (int other = 0; other < 2; other++) {
                const int a = (axis + 1 + other) % 3;
                corner[i][a] = far[other] ? high[a] : low[a];
            }
        }
        scene_build_polygon(build, 4, corner, uv, NULL);
    }
}

static void add_ball_vertex(struct scene_build *build, const double middle[3], double radius,
                            double around, double up)
{
    const double theta = M_PI * (up - 0.5), phi = 2.0 * M_PI * around;
    const double normal[3] = {cos(theta) * cos(phi), sin(theta), -cos(theta) * sin(phi)};
    struct weft_mesh_vertex vertex = {.uv = {(float)around, (float)up},
                                      .colour = {1.0f, 1.0f, 1.0f}};
    for (int axis = 0; axis < 3; axis++) {
        vertex.normal[axis] = (float)normal[axis];
        vertex.position[axis] = (float)(middle[axis] + radius * normal[axis]);
    }
    add_vertex(build, &vertex);
}

void scene_build_ball(struct scene_build *build, const double middle[3], double radius, int rings)
{
    const size_t first = build->scene->vertex_count;
    const int around = 2 * rings;
    for (int j = 0; j <= rings; j++)
        for (int i = 0; i <= around; i++)
            add_ball_vertex(build, middle, radius, (double)i / around, (double)j / rings);
    for (int j = 0; j < rings; j++)
        for (int i = 0; i < around; i++) {
            const size_t low = first + (size_t)(j * (around + 1) + i),
                         high = low + (size_t)around + 1;
            const size_t corner[6] = {low, low + 1, high + 1, low, high + 1, high};
            // At the poles one of both triangles has no area.
            for (int k = j ? 0 : 3; k < (j + 1 < rings ? 6 : 3); k++)
                add_index(build, corner[k]);
        }
}

// ---- lamps --------------------------------------------------------------------------------------

enum { DISC_CORNERS = 16 };

// Of a disc the corners of a polygon that has its area.
static int find_lamp_corners(const struct scene_light *light, double corner[DISC_CORNERS][3])
{
    static const double square[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
    const bool disc = light->shape == SCENE_LIGHT_DISC;
    const int count = disc ? DISC_CORNERS : 4;
    const double step = 2.0 * M_PI / DISC_CORNERS;
    const double reach = sqrt(M_PI / (2.0 * DISC_CORNERS * sin(step)));
    for (int i = 0; i < count; i++) {
        const double u = disc ? reach * cos(i * step) : square[i][0];
        const double v = disc ? reach * sin(i * step) : square[i][1];
        for (int axis = 0; axis < 3; axis++)
            corner[i][axis] = light->middle[axis] + u * light->u[axis] + v * light->v[axis];
    }
    return count;
}

void scene_build_lamp(struct scene_build *build, const struct scene_light *light)
{
    struct scene *s = build->scene;
    struct scene_light *lamp = &s->lights[s->light_count++];
    *lamp = *light;
    // In the plane of vertices, which are floats.
    for (int i = 0; i < 3; i++)
        lamp->middle[i] = (float)lamp->middle[i];
    if (!light->seen)
        return;
    struct scene_material material = {.name = "light", .single_sided = true};
    for (int i = 0; i < 3; i++)
        material.emission[i] = (float)light->radiance[i];
    scene_build_object(build, "light", scene_build_material(build, &material));
    double corner[DISC_CORNERS][3];
    const int count = find_lamp_corners(lamp, corner);
    scene_build_polygon(build, count, corner, NULL, NULL);
}

enum weft_result scene_build_end(struct scene_build *build, const struct weft_log *log)
{
    if (!build->full) {
        scene_find_box(build->scene);
        return WEFT_OK;
    }
    log_error(log, "out of memory for the triangles of %s", build->scene->name);
    scene_clear(build->scene);
    return WEFT_ERR_MEMORY;
}
