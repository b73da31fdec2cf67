// SPDX-License-Identifier: BSD-3-Clause
// Surfaces, lines and silhouettes of small scenes against what they are by hand and by definition.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "tests/support/common.h"
#include "tests/tools/render/pictures.h"
#include "tools/render/edges.h"
#include "tools/scene/scene.h"

static void make_named(const char *name, struct scene *out)
{
    assert_int_equal(
        scene_make(scene_params(.name = name, .size = {64, 64}, .log = &log_to_stderr), out),
        WEFT_OK);
}

// ---- counts by hand -----------------------------------------------------------------------------

static void test_counts(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint32_t surfaces;
        size_t lines, folds;
    } list[] = {
        // Sides of squares, and their diagonals.
        {"cube", 6, 24, 6},
        // Floor, back, four parts of the ceiling, two walls, two blocks of five sides, the lamp.
        {"cornell", 19, 76, 19},
        {"furnace", 6, 24, 6},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        struct scene scene;
        struct scene_edges edges;
        make_named(list[i].name, &scene);
        assert_int_equal(scene_edges_find(&scene, &edges), WEFT_OK);
        assert_int_equal(edges.surface_count, list[i].surfaces);
        assert_int_equal(edges.line_first[scene.object_count], list[i].lines);
        assert_int_equal(edges.fold_first[scene.object_count], list[i].folds);
        for (size_t t = 0; t < scene.index_count / 3; t++)
            assert_int_equal(edges.surface[t], t / 2 + 1);
        scene_edges_clear(&edges);
        scene_clear(&scene);
    }
}

// ---- by definition ------------------------------------------------------------------------------

static bool has_side(const struct scene *scene, size_t triangle, uint32_t a, uint32_t b)
{
    const uint32_t *v = &scene->indices[3 * triangle];
    for (int i = 0; i < 3; i++)
        if ((v[i] == a && v[(i + 1) % 3] == b) || (v[i] == b && v[(i + 1) % 3] == a))
            return true;
    return false;
}

static int count_neighbours(const struct scene *scene, uint32_t a, uint32_t b, size_t found[2])
{
    int count = 0;
    for (size_t t = 0; t < scene->index_count / 3; t++)
        if (has_side(scene, t, a, b)) {
            if (count < 2)
                found[count] = t;
            count++;
        }
    return count;
}

// Of which all sides are lines or folds, once each; neighbours over a fold are one surface, and
// surfaces are no larger than that. Vertices have normals, no side more than two triangles.
static void check_definition(const char *name)
{
    struct scene scene;
    struct scene_edges edges;
    size_t sides = 0;
    make_named(name, &scene);
    assert_int_equal(scene_edges_find(&scene, &edges), WEFT_OK);
    for (int o = 0; o < scene.object_count; o++) {
        size_t found[2];
        for (size_t i = edges.line_first[o]; i < edges.line_first[o + 1]; i++)
            assert_int_equal(
                count_neighbours(&scene, edges.line[i].vertex[0], edges.line[i].vertex[1], found),
                1);
        for (size_t i = edges.fold_first[o]; i < edges.fold_first[o + 1]; i++) {
            const struct scene_fold *f = &edges.fold[i];
            assert_int_equal(count_neighbours(&scene, f->line.vertex[0], f->line.vertex[1], found),
                             2);
            assert_int_equal(found[0], f->triangle[0]);
            assert_int_equal(found[1], f->triangle[1]);
            assert_int_equal(edges.surface[found[0]], edges.surface[found[1]]);
        }
        sides += edges.line_first[o + 1] - edges.line_first[o] +
                 2 * (edges.fold_first[o + 1] - edges.fold_first[o]);
    }
    assert_int_equal(sides, scene.index_count);
    // Surfaces by spreading over folds until nothing changes.
    const size_t count = scene.index_count / 3;
    uint32_t *surface = calloc(count, sizeof *surface), number = 0;
    assert_non_null(surface);
    for (size_t first = 0; first < count; first++) {
        if (surface[first])
            continue;
        surface[first] = ++number;
        for (bool changed = true; changed;) {
            changed = false;
            for (size_t i = 0; i < edges.fold_first[scene.object_count]; i++) {
                uint32_t *a = &surface[edges.fold[i].triangle[0]];
                uint32_t *b = &surface[edges.fold[i].triangle[1]];
                if ((*a == number) == (*b == number))
                    continue;
                *a = *b = number;
                changed = true;
            }
        }
    }
    assert_int_equal(edges.surface_count, number);
    for (size_t t = 0; t < count; t++)
        assert_int_equal(edges.surface[t], surface[t]);
    free(surface);
    scene_edges_clear(&edges);
    scene_clear(&scene);
}

static void test_definition(void **state)
{
    (void)state;
    static const char *const names[] = {"cube", "cornell", "polygons:60", "moving", "penumbra"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        check_definition(names[i]);
}

// ---- silhouettes --------------------------------------------------------------------------------

// Six times the volume of the tetrahedron of a triangle and the eye, in long double: above 0 where
// its front is seen.
static long double find_volume(const struct scene *scene, size_t triangle, const double eye[3])
{
    long double way[3][3];
    for (size_t i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            way[i][k] =
                scene->vertices[scene->indices[3 * triangle + i]].position[k] - (long double)eye[k];
    return -(way[0][0] * (way[1][1] * way[2][2] - way[1][2] * way[2][1]) -
             way[0][1] * (way[1][0] * way[2][2] - way[1][2] * way[2][0]) +
             way[0][2] * (way[1][0] * way[2][1] - way[1][1] * way[2][0]));
}

// A ball from many sides: what is listed is what has a front and a back, and with the open rim of
// the fronts each vertex has as many lines in as out.
static void test_silhouettes(void **state)
{
    (void)state;
    struct test_scene made;
    struct scene_edges edges;
    begin_scene(&made);
    scene_build_object(&made.build, "",
                       scene_build_material(&made.build, &(struct scene_material){.unlit = true}));
    scene_build_ball(&made.build, (double[]){0.0, 0.0, 0.0}, 1.0, 14);
    const struct scene *scene = &made.scene;
    const size_t count = scene->index_count / 3;
    assert_int_equal(scene_edges_find(scene, &edges), WEFT_OK);
    assert_int_equal(edges.surface_count, 1);
    bool *front = calloc(count, sizeof *front);
    struct scene_line *line = calloc(edges.fold_first[1], sizeof *line);
    int *ends = calloc(scene->vertex_count, sizeof *ends);
    assert_true(front && line && ends);
    size_t most = 0;
    for (int turn = 0; turn < 50; turn++) {
        const double eye[3] = {2.0 * cos(turn) + 0.3, 1.7 * sin(1.3 * turn), 2.0 * sin(turn)};
        const size_t lines = scene_edges_silhouette(scene, &edges, 0, eye, front, line);
        size_t wanted = 0;
        for (size_t t = 0; t < count; t++)
            assert_int_equal(front[t], find_volume(scene, t, eye) > 0.0L);
        for (size_t i = 0; i < edges.fold_first[1]; i++) {
            const uint32_t *t = edges.fold[i].triangle;
            if (front[t[0]] != front[t[1]]) {
                assert_true(wanted < lines);
                assert_memory_equal(&line[wanted++], &edges.fold[i].line, sizeof *line);
            }
        }
        assert_int_equal(wanted, lines);
        for (size_t v = 0; v < scene->vertex_count; v++)
            ends[v] = 0;
        for (size_t i = 0; i < lines; i++)
            for (int k = 0; k < 2; k++)
                ends[line[i].vertex[k]]++;
        for (size_t i = 0; i < edges.line_first[1]; i++) {
            size_t found[2];
            const uint32_t *v = edges.line[i].vertex;
            count_neighbours(scene, v[0], v[1], found);
            for (int k = 0; k < 2 && front[found[0]]; k++)
                ends[v[k]]++;
        }
        for (size_t v = 0; v < scene->vertex_count; v++)
            assert_int_equal(ends[v] % 2, 0);
        most = lines > most ? lines : most;
    }
    assert_in_range(most, 28, 200);
    free(front);
    free(line);
    free(ends);
    scene_edges_clear(&edges);
    end_scene(&made);
}

// ---- what is not plain --------------------------------------------------------------------------

// A fan of three on one side, two whose fronts are on different sides, two whose vertices have no
// normals, a triangle without area.
static void test_odd(void **state)
{
    (void)state;
    static uint32_t indices[] = {0,  1,  2,  1,  0, 3,  0, 1, 4, // three on 0-1
                                 5,  6,  7,  5,  6, 8,           // both from 5 to 6
                                 9,  10, 11, 10, 9, 12,          // no normals at 9 and 10
                                 13, 13, 14};
    struct weft_mesh_vertex vertices[15] = {{.normal = {0.0f}}};
    struct scene_object object = {.index_count = sizeof indices / sizeof *indices};
    const struct scene scene = {.vertices = vertices,
                                .vertex_count = 15,
                                .indices = indices,
                                .index_count = object.index_count,
                                .objects = &object,
                                .object_count = 1};
    struct scene_edges edges;
    for (int i = 0; i < 15; i++) {
        vertices[i].position[0] = (float)i;
        vertices[i].position[1] = (float)(i * i);
        vertices[i].normal[2] = i == 9 || i == 10 ? 0.0f : 1.0f;
    }
    static const uint32_t wanted[] = {1, 1, 1, 2, 2, 3, 4, 5};
    assert_int_equal(scene_edges_find(&scene, &edges), WEFT_OK);
    assert_int_equal(edges.surface_count, 5);
    assert_memory_equal(edges.surface, wanted, sizeof wanted);
    // 1 + 6, 1 + 4, 1 + 4, and the side of the last one, which it has twice.
    assert_int_equal(edges.line_first[1] + edges.fold_first[1], 18);
    assert_int_equal(edges.fold_first[1], 1);
    scene_edges_clear(&edges);
    scene_edges_clear(NULL);

    const struct scene none = {.objects = &object};
    assert_int_equal(scene_edges_find(&none, &edges), WEFT_OK);
    assert_int_equal(edges.surface_count, 0);
    scene_edges_clear(&edges);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_definition),
        cmocka_unit_test(test_silhouettes),
        cmocka_unit_test(test_odd),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
