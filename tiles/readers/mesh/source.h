// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/source.h - a file on its way through assimp, and what is looked at before:
// where assimp 5.2.5 would read a wrong mesh in silence (not installed).
#ifndef WEFT_TILES_READERS_MESH_SOURCE_H
#define WEFT_TILES_READERS_MESH_SOURCE_H

#include "tiles/mesh/mesh_wire.h"
#include "tiles/readers/mesh/files.h"

WEFT_BEGIN_DECLS

struct weft_mesh_source {
    struct weft_mesh_files *files;
    enum weft_mesh_kind kind;
    char *text;              // what assimp is given in the file's place; NULL: the file as it is
    size_t size;             // of the text
    uint64_t faces;          // polygons that it has to find; 0: not counted
    uint64_t strengths;      // of emission, which assimp does not know
    enum weft_result result; // why not
    char message[400];
};

// OBJ: indices lead to something (assimp drops all normals where one does not), vertices and faces
// have the numbers that assimp takes. Its text is without comments, the space around lines, and
// lines that go on, and ends in a line feed: assimp skips what is indented, and may lose the end.
enum weft_result weft_mesh_check_obj(struct weft_mesh_source *source);

// PLY: there is a line for each element (assimp takes the last one again and again), and there are
// no strips (of which it keeps one triangle). Its text is without comments, at which assimp ends an
// element, and its header ends so that assimp does not take data for the end of a line.
enum weft_result weft_mesh_check_ply(struct weft_mesh_source *source);

// glTF: accessors lie in their views, and are of the types that assimp reads; JSON has no key
// twice; no extension that changes geometry is required.
enum weft_result weft_mesh_check_gltf(struct weft_mesh_source *source);

// Sets both; returns the result.
enum weft_result weft_mesh_fail(struct weft_mesh_source *source, enum weft_result result,
                                const char *format, ...) __attribute__((format(printf, 3, 4)));

WEFT_END_DECLS
#endif
