// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/import.h - what of assimp weft-read-mesh uses, which takes C++ (not
// installed): in C it cannot be told which of its decoders may run.
#ifndef WEFT_TILES_READERS_MESH_IMPORT_H
#define WEFT_TILES_READERS_MESH_IMPORT_H

#include "tiles/readers/mesh/clean.h"

WEFT_BEGIN_DECLS

struct aiScene;

// Decodes a clean file, by the decoder of its kind and no other.
// The scene lives as long as the process. On failure NULL, and the file's message says why. Returns
// WEFT_ERR_FORMAT, or WEFT_ERR_LIMIT where memory was short.
enum weft_result weft_mesh_import(struct weft_mesh_clean *clean, const struct aiScene **out);

WEFT_END_DECLS
#endif
