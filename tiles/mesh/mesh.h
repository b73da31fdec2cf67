// SPDX-License-Identifier: BSD-3-Clause
// tiles/mesh/mesh.h - triangle meshes of files: OBJ, PLY and glTF 2.0, read by a process of its own
// (weft-read-mesh), as such files may crash what decodes them.
//
// Positions are those of the file, with its nodes' transforms applied, in its own unit and axes.
// Polygons of more than three corners, up to 4,096, are cut into triangles; points and lines are
// left out. Skins and morph targets are left as they lie in the file. Files are read as assimp
// reads them; what it would misread in silence is refused: strips of triangles in PLY, positions,
// normals and texture coordinates of glTF that are no floats, sparse and interleaved at once.
#ifndef WEFT_TILES_MESH_MESH_H
#define WEFT_TILES_MESH_MESH_H

#include "../../filter/base.h"
#include "../process/limits.h"

WEFT_BEGIN_DECLS

// Limits of all meshes.
enum {
    WEFT_MESH_NAME = 64,     // bytes of a name, with its NUL; longer ones are cut
    WEFT_MESH_DROPPED = 160, // likewise, of the line that says what was left out
    WEFT_MESH_MAX_TRIANGLES = 1 << 26,
    WEFT_MESH_MAX_PARTS = 1 << 16,
};

// A corner. All numbers are finite.
struct weft_mesh_vertex {
    float position[3];
    float normal[3]; // of length 1; where the file has none, that of the triangles of its node,
                     // object or group around (smooth, weighted by angle; OBJ's smoothing groups do
                     // not count)
    float uv[2];     // texture coordinates, v up; 0 where there are none
    float colour[3]; // linear, 0 to 1; 1 where there is none; OBJ's and PLY's are decoded from sRGB
};

// What a surface is made of, as far as weft draws it.
struct weft_mesh_material {
    char name[WEFT_MESH_NAME]; // UTF-8 without control characters
    float reflectance[3]; // diffuse (OBJ: Kd, glTF: baseColorFactor), linear, 0 to 1; 0.7 where an
                          // OBJ or PLY file has no material, 0.6 where its library lacks it or its
                          // Kd, 1 where a glTF file has none
    float emission[3];    // linear, >= 0 (OBJ: Ke, glTF: emissiveFactor, without its strength)
};

// Triangles of one material, under one name (a node's, an object's or a group's).
struct weft_mesh_part {
    char name[WEFT_MESH_NAME]; // UTF-8 without control characters; "part 3" where there is none
    uint32_t first_index, index_count; // three a triangle, > 0
    uint32_t material;                 // its place in the list
};

// A mesh. All zero: none.
struct weft_mesh {
    struct weft_mesh_vertex *vertices;
    size_t vertex_count; // > 0
    uint32_t *indices;   // all below vertex_count
    size_t index_count;  // > 0, three a triangle, counterclockwise seen from outside
    struct weft_mesh_part *parts;
    size_t part_count; // > 0
    struct weft_mesh_material *materials;
    size_t material_count;           // > 0
    float low[3], high[3];           // the box of the positions that triangles use
    char dropped[WEFT_MESH_DROPPED]; // what the file has that was left out, one line; "": nothing
    void *memory;                    // of all of it; freed by weft_mesh_clear
};

// What is read, and with which limits.
struct weft_mesh_params {
    const char *path;           // ends in .obj, .ply, .gltf or .glb, in any case (required)
    struct weft_limits limits;  // of the reader
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define WEFT_MESH_DEFAULTS
#define weft_mesh_params(...) (&(struct weft_mesh_params){WEFT_MESH_DEFAULTS __VA_ARGS__})

// Reads a mesh. Materials (.mtl) and buffers (.bin) in other files are read where they lie in the
// folder of the file or below it: a missing one of materials is a warning, of buffers an error; a
// name that leads out of the folder, be it by a symbolic link, is an error. `mtllib` names one
// file. On failure *out is all zero. Returns WEFT_ERR_ARGUMENT (no path, an ending), WEFT_ERR_OPEN,
// WEFT_ERR_FORMAT (damaged; no triangles; an index beyond the vertices; a number that is not finite
// or beyond +-1e30: the log says which), WEFT_ERR_UNSUPPORTED, WEFT_ERR_LIMIT, WEFT_ERR_READER or
// WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_mesh_load(const struct weft_mesh_params *params,
                                         struct weft_mesh *out);
WEFT_API void weft_mesh_clear(struct weft_mesh *mesh); // accepts NULL, leaves zeros behind

WEFT_END_DECLS
#endif
