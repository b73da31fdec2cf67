// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/import.h - what of assimp weft-read-mesh uses, which takes C++ (not
// installed): in C it cannot be told which of its decoders may run.
#ifndef WEFT_TILES_READERS_MESH_IMPORT_H
#define WEFT_TILES_READERS_MESH_IMPORT_H

#include "tiles/readers/mesh/source.h"

WEFT_BEGIN_DECLS

struct aiScene;

// Decodes a file by the decoder of its kind and no other, which opens other files by
// weft_mesh_files_open alone. What assimp warns of is a failure where it leaves something out.
// The scene lives as long as the process. On failure NULL, and the source's message says why.
// Returns WEFT_ERR_FORMAT, or WEFT_ERR_LIMIT where memory was short.
enum weft_result weft_mesh_import(struct weft_mesh_source *source, const struct aiScene **out);

WEFT_END_DECLS
#endif
