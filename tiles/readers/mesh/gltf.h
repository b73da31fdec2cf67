// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/gltf.h - buffers and accessors of glTF files (not installed).
#ifndef WEFT_TILES_READERS_MESH_GLTF_H
#define WEFT_TILES_READERS_MESH_GLTF_H

#include <jansson.h>

#include "tiles/readers/mesh/clean.h"

WEFT_BEGIN_DECLS

// A file on its way. {0} with clean and root filled in is ready.
struct weft_gltf {
    struct weft_mesh_clean *clean;
    json_t *root;                   // as it is in the file
    struct weft_mesh_bytes body;    // of GLB: its second chunk
    struct weft_mesh_bytes *buffer; // of each of the file's, once it was used
    bool *opened, *owned;           // its bytes are there; they are allocated, not mapped
    size_t buffer_count;
};

// Members of objects, which may be NULL. A value of another type is a failure.
// An index: `otherwise` where there is none, which may be -1.
bool weft_gltf_index(struct weft_gltf *g, const json_t *object, const char *key, size_t count,
                     int64_t otherwise, int64_t *out);
// Up to `count` finite numbers, all of them if there are any; *found tells.
bool weft_gltf_numbers(struct weft_gltf *g, const json_t *object, const char *key, size_t count,
                       double *out, bool *found);
// An array; NULL where there is none.
bool weft_gltf_array(struct weft_gltf *g, const json_t *object, const char *key,
                     const json_t **out);

// The values of an accessor, as floats, or as indices below `limit` where that is not 0, appended
// to the clean file's other bytes from a multiple of 4. Sparse ones are filled in, integers that
// stand for fractions are divided. `components` are the numbers that each element may have, as bits
// (1 << 3: three). On failure the message says why.
struct weft_gltf_values {
    uint64_t offset, count;
    int components;
};
bool weft_gltf_take(struct weft_gltf *g, int64_t accessor, unsigned components, uint64_t limit,
                    struct weft_gltf_values *out);

void weft_gltf_clear(struct weft_gltf *g);

WEFT_END_DECLS
#endif
