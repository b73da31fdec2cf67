// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/clean.h - a file is checked, and written anew for assimp with what weft takes
// of it and nothing else: assimp drops in silence what it does not understand, and has memory
// faults where files contradict themselves (not installed).
#ifndef WEFT_TILES_READERS_MESH_CLEAN_H
#define WEFT_TILES_READERS_MESH_CLEAN_H

#include "tiles/mesh/mesh_wire.h"
#include "tiles/readers/mesh/files.h"
#include "tiles/readers/mesh/text.h"

WEFT_BEGIN_DECLS

// Names in what assimp is given that no file has: of that itself, of the other file that it names,
// and of what has no name.
#define WEFT_MESH_MAIN "\1main"
#define WEFT_MESH_OTHER "\1other"
#define WEFT_MESH_NAMELESS "\1"

// What of a file is left out, counted.
struct weft_mesh_left {
    uint64_t lines, points, curves, textures, animations, skins, morphs, cameras, lights;
};

struct weft_mesh_clean {
    struct weft_mesh_files *files;
    enum weft_mesh_kind kind;
    struct weft_mesh_text main, other; // what assimp is given; GLB becomes glTF
    struct weft_mesh_text names; // OBJ: of the groups that it numbers, WEFT_MESH_NAME bytes each
    uint64_t faces;              // that are in it; 0: not counted
    struct weft_mesh_left left;
    enum weft_result result; // why not
    char message[400];
};

// Each fills in what follows `kind`; the caller has filled in the rest. On failure the message says
// why. Returns WEFT_ERR_FORMAT, WEFT_ERR_UNSUPPORTED or WEFT_ERR_LIMIT.
enum weft_result weft_mesh_clean_obj(struct weft_mesh_clean *clean);
enum weft_result weft_mesh_clean_ply(struct weft_mesh_clean *clean);
enum weft_result weft_mesh_clean_gltf(struct weft_mesh_clean *clean);
// Says that there are no triangles, but what else.
enum weft_result weft_mesh_clean_no_faces(struct weft_mesh_clean *clean);
void weft_mesh_say_left(const struct weft_mesh_left *left, char text[WEFT_MESH_DROPPED]);

// A name, cut where a character of UTF-8 begins.
void weft_mesh_copy_name(char out[WEFT_MESH_NAME], const char *text, size_t length);

void weft_mesh_clean_clear(struct weft_mesh_clean *clean);

// Sets both; returns the result.
enum weft_result weft_mesh_clean_fail(struct weft_mesh_clean *clean, enum weft_result result,
                                      const char *format, ...)
    __attribute__((format(printf, 3, 4)));

WEFT_END_DECLS
#endif
