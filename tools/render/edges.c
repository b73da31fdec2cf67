// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/edges.h"

#include <stdlib.h>

#include "tools/scene/vector.h"

// ---- surfaces -----------------------------------------------------------------------------------

// The first triangle of the set that one is in; the way there is made shorter (Tarjan, "Efficiency
// of a good but not linear set union algorithm", 1975).
static uint32_t find_first(uint32_t *set, uint32_t triangle)
{
    while (set[triangle] != triangle) {
        set[triangle] = set[set[triangle]];
        triangle = set[triangle];
    }
    return triangle;
}

static void unite(uint32_t *set, uint32_t a, uint32_t b)
{
    a = find_first(set, a);
    b = find_first(set, b);
    set[a > b ? a : b] = a > b ? b : a;
}

// Turns sets into numbers from 1 on.
static void number(struct scene_edges *edges, uint32_t count)
{
    uint32_t *set = edges->surface;
    for (uint32_t i = 0; i < count; i++)
        set[i] = find_first(set, i);
    for (uint32_t i = 0; i < count; i++)
        set[i] = set[i] == i ? ++edges->surface_count : set[set[i]];
}

// ---- edges --------------------------------------------------------------------------------------

// A side of a triangle.
struct side {
    uint32_t low, high; // its vertices
    uint32_t triangle;
    bool falls; // from the higher vertex to the lower one
};

static int compare(const void *a, const void *b)
{
    const struct side *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    if (x->high != y->high)
        return x->high < y->high ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

// Lists the sides of an object's triangles, equal ones in a row; returns how many there are.
static size_t list_sides(const struct scene *scene, const struct scene_object *object,
                         struct side *out)
{
    size_t count = 0;
    for (uint32_t i = 0; i < object->index_count - object->index_count % 3; i++) {
        const uint32_t at = object->first_index + i, next = i % 3 < 2 ? at + 1 : at - 2;
        const uint32_t a = scene->indices[at], b = scene->indices[next];
        if (a == b)
            continue;
        out[count++] = (struct side){
            .low = a < b ? a : b, .high = a < b ? b : a, .triangle = at / 3, .falls = a > b};
    }
    qsort(out, count, sizeof *out, compare);
    return count;
}

static bool has_normal(const struct scene *scene, uint32_t vertex)
{
    const float *n = scene->vertices[vertex].normal;
    return n[0] != 0.0f || n[1] != 0.0f || n[2] != 0.0f;
}

static void add_edges(const struct scene *scene, const struct side *side, size_t count,
                      size_t *lines, size_t *folds, struct scene_edges *out)
{
    for (size_t i = 0, next; i < count; i = next) {
        const struct side *s = &side[i];
        for (next = i + 1; next < count; next++)
            if (side[next].low != s->low || side[next].high != s->high)
                break;
        const bool smooth = has_normal(scene, s->low) && has_normal(scene, s->high);
        for (size_t k = i + 1; k < next && smooth; k++)
            unite(out->surface, s->triangle, side[k].triangle);
        const struct scene_line line = {{s->low, s->high}};
        // Of more than two triangles, or two whose fronts are on different sides, anything can be
        // seen.
        if (smooth && next - i == 2 && s[0].falls != s[1].falls)
            out->fold[(*folds)++] = (struct scene_fold){line, {s[0].triangle, s[1].triangle}};
        else
            out->line[(*lines)++] = line;
    }
}

enum weft_result scene_edges_find(const struct scene *scene, struct scene_edges *out)
{
    const size_t sides = scene->index_count + 1, objects = (size_t)scene->object_count;
    const uint32_t triangles = (uint32_t)(scene->index_count / 3);
    size_t lines = 0, folds = 0;
    *out = (struct scene_edges){.surface_count = 0};
    struct side *side = calloc(sides, sizeof *side);
    out->surface = calloc(triangles + 1, sizeof *out->surface);
    out->line = calloc(sides, sizeof *out->line);
    out->fold = calloc(sides / 2 + 1, sizeof *out->fold);
    out->line_first = calloc(objects + 1, sizeof *out->line_first);
    out->fold_first = calloc(objects + 1, sizeof *out->fold_first);
    const bool full =
        !side || !out->surface || !out->line || !out->fold || !out->line_first || !out->fold_first;
    for (uint32_t i = 0; i < triangles && !full; i++)
        out->surface[i] = i;
    for (size_t i = 0; i < objects && !full; i++) {
        const size_t count = list_sides(scene, &scene->objects[i], side);
        add_edges(scene, side, count, &lines, &folds, out);
        out->line_first[i + 1] = lines;
        out->fold_first[i + 1] = folds;
    }
    free(side);
    if (full) {
        scene_edges_clear(out);
        return WEFT_ERR_MEMORY;
    }
    number(out, triangles);
    return WEFT_OK;
}

void scene_edges_clear(struct scene_edges *edges)
{
    if (!edges)
        return;
    free(edges->surface);
    free(edges->line);
    free(edges->fold);
    free(edges->line_first);
    free(edges->fold_first);
    *edges = (struct scene_edges){.surface_count = 0};
}

// ---- silhouettes --------------------------------------------------------------------------------

static bool is_front(const struct scene *scene, size_t first, const double eye[3])
{
    double side[2][3], way[3], normal[3];
    const float *p[3];
    for (size_t i = 0; i < 3; i++)
        p[i] = scene->vertices[scene->indices[first + i]].position;
    for (int k = 0; k < 3; k++) {
        side[0][k] = (double)p[1][k] - p[0][k];
        side[1][k] = (double)p[2][k] - p[0][k];
        way[k] = eye[k] - p[0][k];
    }
    scene_cross(side[0], side[1], normal);
    return scene_dot(normal, way) > 0.0;
}

size_t scene_edges_silhouette(const struct scene *scene, const struct scene_edges *edges,
                              int object, const double eye[3], bool *front, struct scene_line *out)
{
    const size_t begin = edges->fold_first[object], end = edges->fold_first[object + 1];
    const uint32_t first = scene->objects[object].first_index;
    size_t count = 0;
    if (begin == end)
        return 0;
    for (uint32_t i = 0; i < scene->objects[object].index_count / 3; i++)
        front[i] = is_front(scene, first + 3 * (size_t)i, eye);
    for (size_t i = begin; i < end; i++) {
        const uint32_t *t = edges->fold[i].triangle;
        if (front[t[0] - first / 3] != front[t[1] - first / 3])
            out[count++] = edges->fold[i].line;
    }
    return count;
}
