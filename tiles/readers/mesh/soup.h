// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/soup.h - what assimp decoded becomes a mesh (not installed).
#ifndef WEFT_TILES_READERS_MESH_SOUP_H
#define WEFT_TILES_READERS_MESH_SOUP_H

#include "tiles/readers/mesh/source.h"

WEFT_BEGIN_DECLS

struct aiScene;

// A mesh in the making: corners that are not joined yet, in the order of the file.
struct weft_mesh_soup {
    struct weft_mesh_vertex *vertices;
    uint32_t *objects; // of each vertex: normals are smooth within one
    size_t vertex_count;
    uint32_t *indices;
    size_t index_count;
    struct weft_mesh_part *parts;
    size_t part_count;
    struct weft_mesh_material *materials;
    size_t material_count;
    char dropped[WEFT_MESH_DROPPED];
};

// Applies transforms and takes materials. Normals that the file lacks are 0. Returns
// WEFT_ERR_FORMAT or WEFT_ERR_LIMIT, with the source's message.
enum weft_result weft_mesh_soup_make(const struct aiScene *scene, struct weft_mesh_source *source,
                                     struct weft_mesh_soup *out);

// Fills in the normals that are 0. Returns false where memory is short.
bool weft_mesh_soup_smooth(struct weft_mesh_soup *soup);

// Vertices of the same bits become one; those that no triangle uses go. Returns false where memory
// is short.
bool weft_mesh_soup_join(struct weft_mesh_soup *soup);

void weft_mesh_soup_clear(struct weft_mesh_soup *soup);

WEFT_END_DECLS
#endif
