// SPDX-License-Identifier: BSD-3-Clause
// tools/render/edges.h - which triangles are one smooth surface, and along which of their edges a
// picture can have an edge; inside of tools/render. Pure, without OpenGL.
//
// Triangles of an object that share an edge by the same two vertices share their normals there: no
// edge is to be seen between them, unless one shows its front and the other its back. Vertices
// without a normal share none. All other edges can be seen from anywhere.
#ifndef WEFT_TOOLS_RENDER_EDGES_H
#define WEFT_TOOLS_RENDER_EDGES_H

#include "tools/scene/scene.h"

// Two vertices of the scene.
struct scene_line {
    uint32_t vertex[2];
};

// An edge between two triangles.
struct scene_fold {
    struct scene_line line;
    uint32_t triangle[2]; // of the scene
};

// All zero: none. Everything is owned.
struct scene_edges {
    uint32_t *surface; // of each triangle of the scene: surfaces are numbered from 1 on, in the
                       // order of their first triangles
    uint32_t surface_count;
    // Edges that are always drawn, and edges between two triangles that hang together smoothly:
    // those of object i are line[line_first[i]] up to line[line_first[i + 1]], likewise folds.
    struct scene_line *line;
    struct scene_fold *fold;
    size_t *line_first, *fold_first;
};

// On failure *out is all zero. Returns WEFT_ERR_MEMORY.
enum weft_result scene_edges_find(const struct scene *scene, struct scene_edges *out);
void scene_edges_clear(struct scene_edges *edges); // accepts NULL, leaves zeros behind

// Writes the folds of an object that have a front on one side and a back on the other, seen from an
// eye, which is given where the object is modelled. front: room for all triangles of the object;
// out: for all its folds. Returns how many there are.
size_t scene_edges_silhouette(const struct scene *scene, const struct scene_edges *edges,
                              int object, const double eye[3], bool *front, struct scene_line *out);

#endif
