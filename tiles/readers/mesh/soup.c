// SPDX-License-Identifier: BSD-3-Clause
// Corners of triangles that are the same: normals around them, and one vertex for all.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include <xxhash.h>

#include "tiles/readers/mesh/soup.h"

// ---- keys that are the same ---------------------------------------------------------------------

// The place of the first one that has the same bytes, for each of `count` keys of `size` bytes. No
// file can be made to meet the hash's seed.
static bool find_first(const void *keys, size_t size, size_t count, uint32_t *first)
{
    size_t slots = 16;
    uint64_t seed = 0;
    while (slots < 2 * count)
        slots *= 2;
    uint32_t *table = calloc(slots, sizeof *table); // places + 1
    if (!table)
        return false;
    if (getrandom(&seed, sizeof seed, GRND_NONBLOCK) < 0)
        seed = 0;
    for (size_t i = 0; i < count; i++) {
        const char *key = (const char *)keys + i * size;
        size_t at = XXH3_64bits_withSeed(key, size, seed) & (slots - 1);
        while (table[at] && memcmp((const char *)keys + (table[at] - 1) * size, key, size))
            at = (at + 1) & (slots - 1);
        if (!table[at])
            table[at] = (uint32_t)i + 1;
        first[i] = table[at] - 1;
    }
    free(table);
    return true;
}

// ---- normals ------------------------------------------------------------------------------------

struct key {
    uint32_t object;
    float position[3];
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

// The triangle's unit normal; false where it has no area.
static bool face_normal(const struct weft_mesh_soup *soup, const uint32_t corner[3],
                        double edge[3][3], double out[3])
{
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++)
            edge[i][c] = (double)soup->vertices[corner[(i + 1) % 3]].position[c] -
                         (double)soup->vertices[corner[i]].position[c];
    cross(edge[0], edge[1], out);
    const double length = sqrt(dot(out, out));
    for (int c = 0; c < 3; c++)
        out[c] /= length;
    return length > 0.0;
}

// G. Thürmer and C. A. Wüthrich, "Computing vertex normals from polygonal facets" (1998): each
// triangle counts with its angle at the corner.
static void add_angles(const struct weft_mesh_soup *soup, const uint32_t *first, double (*sum)[3])
{
    for (size_t t = 0; t < soup->index_count; t += 3) {
        const uint32_t *corner = soup->indices + t;
        double edge[3][3], normal[3], turn[3];
        if (!face_normal(soup, corner, edge, normal))
            continue;
        for (int i = 0; i < 3; i++) {
            const double *in = edge[(i + 2) % 3], *out = edge[i];
            cross(in, out, turn);
            const double angle = atan2(sqrt(dot(turn, turn)), -dot(in, out));
            for (int c = 0; c < 3; c++)
                sum[first[corner[i]]][c] += angle * normal[c];
        }
    }
}

static bool is_missing(const struct weft_mesh_vertex *v)
{
    return v->normal[0] == 0.0f && v->normal[1] == 0.0f && v->normal[2] == 0.0f;
}

static void set_normal(struct weft_mesh_vertex *v, const double n[3])
{
    const double length = sqrt(dot(n, n));
    for (int c = 0; c < 3; c++)
        v->normal[c] = (float)(n[c] / length) + 0.0f;
}

// Where triangles around cancel out, one of them; where they have no area, any direction.
static void set_rest(struct weft_mesh_soup *soup)
{
    static const double up[3] = {0.0, 0.0, 1.0};
    for (size_t i = 0; i < soup->index_count; i++) {
        double edge[3][3], normal[3];
        struct weft_mesh_vertex *v = &soup->vertices[soup->indices[i]];
        if (is_missing(v) && face_normal(soup, soup->indices + i / 3 * 3, edge, normal))
            set_normal(v, normal);
    }
    for (size_t i = 0; i < soup->vertex_count; i++)
        if (is_missing(&soup->vertices[i]))
            set_normal(&soup->vertices[i], up);
}

static bool any_missing(const struct weft_mesh_soup *soup)
{
    for (size_t i = 0; i < soup->vertex_count; i++)
        if (is_missing(&soup->vertices[i]))
            return true;
    return false;
}

bool weft_mesh_soup_smooth(struct weft_mesh_soup *soup)
{
    const size_t count = soup->vertex_count;
    if (!any_missing(soup))
        return true;
    struct key *keys = calloc(count, sizeof *keys);
    uint32_t *first = calloc(count, sizeof *first);
    double(*sum)[3] = calloc(count, sizeof *sum);
    bool good = keys && first && sum;
    for (size_t i = 0; good && i < count; i++) {
        keys[i].object = soup->objects[i];
        memcpy(keys[i].position, soup->vertices[i].position, sizeof keys[i].position);
    }
    good = good && find_first(keys, sizeof *keys, count, first);
    if (good) {
        // Sums that are rounding errors of opposite normals have no direction.
        const double least = 1e-9;
        add_angles(soup, first, sum);
        for (size_t i = 0; i < count; i++)
            if (is_missing(&soup->vertices[i]) && dot(sum[first[i]], sum[first[i]]) > least * least)
                set_normal(&soup->vertices[i], sum[first[i]]);
        set_rest(soup);
    }
    free(keys);
    free(first);
    free(sum);
    return good;
}

// ---- vertices -----------------------------------------------------------------------------------

bool weft_mesh_soup_join(struct weft_mesh_soup *soup)
{
    const size_t count = soup->vertex_count;
    uint32_t *first = calloc(count, sizeof *first), *place = calloc(count, sizeof *place);
    struct weft_mesh_vertex *joined = calloc(count, sizeof *joined);
    if (!first || !place || !joined ||
        !find_first(soup->vertices, sizeof *soup->vertices, count, first)) {
        free(first);
        free(place);
        free(joined);
        return false;
    }
    // In the order in which triangles use them, which suits the caches of what draws them.
    soup->vertex_count = 0;
    for (size_t i = 0; i < soup->index_count; i++) {
        const uint32_t from = first[soup->indices[i]];
        if (!place[from]) {
            joined[soup->vertex_count] = soup->vertices[from];
            place[from] = (uint32_t)++soup->vertex_count;
        }
        soup->indices[i] = place[from] - 1;
    }
    free(soup->vertices);
    free(first);
    free(place);
    soup->vertices = joined;
    return true;
}
