// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/effect/boxes.h - small scenes of quads, built by hand for tests of light.
// Include after cmocka.h.
#ifndef WEFT_TESTS_TOOLS_EFFECT_BOXES_H
#define WEFT_TESTS_TOOLS_EFFECT_BOXES_H

#include <stdlib.h>
#include <string.h>

#include "tools/scene/scene.h"

enum { BOX_QUADS = 16 };

// A scene with room for so many quads, each an object of a material of its own. Cleared by
// scene_clear.
static inline struct scene *box_create(struct scene *scene)
{
    *scene = (struct scene){.name = "box", .camera = {WEFT_CAMERA_DEFAULTS}};
    scene->vertices = calloc(4 * BOX_QUADS, sizeof *scene->vertices);
    scene->indices = calloc(6 * BOX_QUADS, sizeof *scene->indices);
    scene->objects = calloc(BOX_QUADS, sizeof *scene->objects);
    scene->materials = calloc(BOX_QUADS, sizeof *scene->materials);
    assert_non_null(scene->vertices);
    assert_non_null(scene->indices);
    assert_non_null(scene->objects);
    assert_non_null(scene->materials);
    return scene;
}

// Adds a quad, counterclockwise seen from its front, of one grey reflectance and emission.
static inline void box_add(struct scene *scene, const double corner[4][3], double reflectance,
                           double emission, bool single_sided)
{
    const int o = scene->object_count++;
    scene->material_count++;
    assert_true(o < BOX_QUADS);
    struct scene_material *material = &scene->materials[o];
    material->single_sided = single_sided;
    for (int i = 0; i < 3; i++) {
        material->reflectance[i] = (float)reflectance;
        material->emission[i] = (float)emission;
    }
    static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    for (int k = 0; k < 6; k++)
        scene->indices[scene->index_count + (size_t)k] =
            (uint32_t)scene->vertex_count + order[k];
    scene->objects[o] = (struct scene_object){
        .first_index = (uint32_t)scene->index_count, .index_count = 6, .material = o};
    for (int k = 0; k < 4; k++) {
        struct weft_mesh_vertex *vertex = &scene->vertices[scene->vertex_count++];
        for (int i = 0; i < 3; i++) {
            vertex->position[i] = (float)corner[k][i];
            vertex->colour[i] = 1.0f;
        }
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, l = (i + 2) % 3;
            vertex->normal[i] =
                (float)((corner[1][j] - corner[0][j]) * (corner[2][l] - corner[0][l]) -
                        (corner[1][l] - corner[0][l]) * (corner[2][j] - corner[0][j]));
        }
        const float length = sqrtf(vertex->normal[0] * vertex->normal[0] +
                                   vertex->normal[1] * vertex->normal[1] +
                                   vertex->normal[2] * vertex->normal[2]);
        for (int i = 0; i < 3; i++)
            vertex->normal[i] /= length;
    }
    scene->index_count += 6;
}

// A closed box from `low` to `high`, its fronts inside, of one reflectance, that emits everywhere.
static inline void box_add_room(struct scene *scene, const double low[3], const double high[3],
                                double reflectance, double emission)
{
    for (int axis = 0; axis < 3; axis++)
        for (int end = 0; end < 2; end++) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            double corner[4][3];
            for (int k = 0; k < 4; k++) {
                // Around the axis, the other way at its upper end.
                const int at = end ? 3 - k : k;
                corner[k][axis] = end ? high[axis] : low[axis];
                corner[k][u] = at == 1 || at == 2 ? high[u] : low[u];
                corner[k][v] = at >= 2 ? high[v] : low[v];
            }
            box_add(scene, corner, reflectance, emission, true);
        }
}

#endif
