// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/polygon.h - polygons are cut into triangles (not installed). assimp 5.2.5 cuts
// an L of six corners into triangles that lie outside of it.
#ifndef WEFT_TILES_READERS_MESH_POLYGON_H
#define WEFT_TILES_READERS_MESH_POLYGON_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

enum { WEFT_MESH_CORNERS = 4096 }; // of a polygon, at most: time grows with the square or more

// Cuts off ears (G. H. Meisters, "Polygons have ears", 1975) of a polygon of `count` corners in
// space, 3 or more, seen along its mean normal: count - 2 triangles, as places of corners, which
// are turned as it is. One that crosses itself is cut somehow.
void weft_mesh_cut(const float (*corners)[3], int count, int (*triangles)[3]);

WEFT_END_DECLS
#endif
