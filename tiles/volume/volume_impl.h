// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume_impl.h - a volume, and what its back ends share (not installed).
#ifndef WEFT_TILES_VOLUME_VOLUME_IMPL_H
#define WEFT_TILES_VOLUME_VOLUME_IMPL_H

#include "filter/check.h"
#include "tiles/volume/brick_store.h"

WEFT_BEGIN_DECLS

// What a volume's bricks come from: memory, a file, or another volume's voxels. The calls'
// arguments have been checked.
struct weft_volume_backend {
    size_t data_bytes; // of weft_volume.data, all zero at first
    enum weft_result (*find)(weft_volume *volume, const struct weft_region *region,
                             struct weft_brick_list *out);
    enum weft_result (*read)(weft_volume *volume, size_t count, const int32_t (*brick_origin)[3],
                             float *values);
    void (*clear)(void *data); // releases what data holds, which may be all zero
};

struct weft_volume {
    struct weft_volume_info info;
    const struct weft_log *log;
    const struct weft_volume_backend *backend;
    void *data; // the back end's own
};

// An empty volume, with nothing of its info set. Returns WEFT_ERR_MEMORY.
enum weft_result weft_volume_make(const struct weft_log *log,
                                  const struct weft_volume_backend *backend, weft_volume **out);

// Sorted as in weft_brick_list; the store borrows the values.
struct weft_volume_memory {
    size_t brick_count, tile_count;
    int32_t (*brick_origin)[3];
    float *values;
    struct weft_volume_tile *tiles;
    weft_brick_store *store;
};
// NULL for volumes that are not in memory.
const struct weft_volume_memory *weft_volume_in_memory(const weft_volume *volume);

// Sorts by z, y, x.
int weft_compare_origins(const int32_t a[3], const int32_t b[3]);

// Finite, and its columns span space.
bool weft_transform_valid(const double m[3][4]);

// Whether a brick meets a region; one at the face of a clamp-to-edge volume stands for everything
// beyond that face.
bool weft_volume_brick_meets(const struct weft_volume_info *info, const struct weft_region *region,
                             const int32_t origin[3]);

WEFT_END_DECLS
#endif
