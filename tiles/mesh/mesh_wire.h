// SPDX-License-Identifier: BSD-3-Clause
// tiles/mesh/mesh_wire.h - meshes in messages from weft-read-mesh (not installed).
#ifndef WEFT_TILES_MESH_MESH_WIRE_H
#define WEFT_TILES_MESH_MESH_WIRE_H

#include "tiles/mesh/mesh.h"
#include "tiles/process/wire.h"

WEFT_BEGIN_DECLS

// What a file is, by its ending; the `part` of a request for a MESH.
enum weft_mesh_kind { WEFT_MESH_OBJ, WEFT_MESH_PLY, WEFT_MESH_GLTF, WEFT_MESH_GLB };
static const char *const weft_mesh_endings[] = {".obj", ".ply", ".gltf", ".glb", NULL};

// What a MESH's payload starts with. The arrays follow, one after the other and without gaps, in
// the order of the counts: struct weft_mesh_vertex, uint32_t, struct weft_mesh_part, struct
// weft_mesh_material.
struct weft_wire_mesh {
    uint64_t vertex_count, index_count, part_count, material_count;
    char dropped[WEFT_MESH_DROPPED]; // as in struct weft_mesh
    char warning[256];               // what a caller should know all the same; "": nothing
};

// What a surface without a colour reflects in OBJ and PLY files.
#define WEFT_MESH_REFLECTANCE 0.7f

// Beyond it nothing in a mesh lies: what is computed from such numbers stays finite in double.
#define WEFT_MESH_LARGEST 1e30f

WEFT_END_DECLS
#endif
