// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume_impl.h - what volume.c and volume_file.c share (not installed).
#ifndef WEFT_TILES_VOLUME_VOLUME_IMPL_H
#define WEFT_TILES_VOLUME_VOLUME_IMPL_H

#include "tiles/volume/brick_store.h"
#include "tiles/readers/client.h"

WEFT_BEGIN_DECLS

struct weft_volume {
    struct weft_volume_info info;
    const struct weft_log *log;

    // In memory, sorted as in weft_brick_list; the store borrows the values.
    size_t brick_count, tile_count;
    int32_t (*brick_origin)[3];
    float *values;
    struct weft_volume_tile *tiles;
    weft_brick_store *store;

    // In a file.
    weft_reader *reader;
    uint64_t output_bytes; // limit of one answer

    // Computed from another volume (volume_prefilter.c).
    struct weft_volume_coefficients *coefficients;
};

// Sorts by z, y, x.
int weft_compare_origins(const int32_t a[3], const int32_t b[3]);

// Finite, and its columns span space.
bool weft_transform_valid(const double m[3][4]);

enum weft_result weft_volume_file_find(weft_volume *volume, const struct weft_region *region,
                                       struct weft_brick_list *out);
enum weft_result weft_volume_file_read(weft_volume *volume, size_t count,
                                       const int32_t (*brick_origin)[3], float *values);

enum weft_result weft_volume_prefilter_find(weft_volume *volume, const struct weft_region *region,
                                            struct weft_brick_list *out);
enum weft_result weft_volume_prefilter_read(weft_volume *volume, size_t count,
                                            const int32_t (*brick_origin)[3], float *values);

// Whether a brick meets a region; one at the face of a clamp-to-edge volume stands for everything
// beyond that face.
bool weft_volume_brick_meets(const struct weft_volume_info *info, const struct weft_region *region,
                             const int32_t origin[3]);

WEFT_END_DECLS
#endif
