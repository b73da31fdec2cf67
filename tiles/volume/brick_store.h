// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/brick_store.h - bricks and constant tiles, found by their coordinates (not
// installed). An open-addressing hash for bricks and 8-voxel tiles, and one each for tiles of 128
// and 4096. Where nothing was added the background holds; with a clamp box, the nearest voxel of
// the box does. Voxel values are borrowed: they must outlive the store. Thread-safety: adding is
// for one thread; any number of threads may look up afterwards.
#ifndef WEFT_TILES_VOLUME_BRICK_STORE_H
#define WEFT_TILES_VOLUME_BRICK_STORE_H

#include "filter/check.h"
#include "tiles/volume/volume.h"

WEFT_BEGIN_DECLS

typedef struct weft_brick_store weft_brick_store;

// capacity: bricks and tiles expected (0 is fine; tables grow). Returns WEFT_ERR_MEMORY.
enum weft_result weft_brick_store_create(const struct weft_log *log, size_t capacity,
                                         float background, weft_brick_store **out);
void weft_brick_store_destroy(weft_brick_store **store); // accepts &NULL, leaves NULL behind

// origin: multiples of 8 within +-WEFT_INDEX_LIMIT. values: 512 floats, [z][y][x], borrowed.
// Returns WEFT_ERR_ARGUMENT (origin; this brick is there already) or WEFT_ERR_MEMORY.
enum weft_result weft_brick_store_add_brick(weft_brick_store *store, const int32_t origin[3],
                                            const float *values);

// size 8, 128 or 4096, origin a multiple of it. Returns as above.
enum weft_result weft_brick_store_add_tile(weft_brick_store *store,
                                           const struct weft_volume_tile *tile);

// A whole list as weft_volume_find and weft_volume_read give it; values: brick_count * 512.
enum weft_result weft_brick_store_add_list(weft_brick_store *store,
                                           const struct weft_brick_list *list, const float *values);

// WEFT_ERR_ARGUMENT if a brick or tile lies inside a larger tile; the log says which.
enum weft_result weft_brick_store_check_disjoint(const weft_brick_store *store);

// From now on coordinates are clamped to this box (inclusive) before any look-up. Bricks that are
// partly outside must hold the clamped values there.
void weft_brick_store_clamp(weft_brick_store *store, const int32_t min[3], const int32_t max[3]);

enum weft_brick_kind {
    WEFT_BRICK_VALUES,   // *values points to 512 floats
    WEFT_BRICK_CONSTANT, // *constant holds in the whole brick (tile or background)
    WEFT_BRICK_EDGE,     // outside the clamp box: weft_brick_store_copy forms it
};

// The brick at an origin (any multiples of 8). The other out-parameter is left NULL or NAN.
enum weft_brick_kind weft_brick_store_find(const weft_brick_store *store, const int32_t origin[3],
                                           const float **values, float *constant);

// The 512 voxels of the brick at an origin, whatever its kind.
void weft_brick_store_copy(const weft_brick_store *store, const int32_t origin[3], float *out);

// Remembers the last brick, for many look-ups close together. One per thread; start with
// { .store = store }.
struct weft_brick_cursor {
    const weft_brick_store *store;
    bool valid;
    int32_t origin[3];
    const float *values; // NULL: constant
    float constant;
};
float weft_brick_cursor_voxel(struct weft_brick_cursor *cursor, int32_t i, int32_t j, int32_t k);

// Remembers bricks that were found, for many boxes close together. One per thread, for as long as
// nothing is added to the store; starts as {0}.
enum { WEFT_BRICK_MEMO = 256 };
struct weft_found_brick {
    bool valid;
    int32_t origin[3];
    enum weft_brick_kind kind;
    const float *values;
    float constant;
};
struct weft_brick_memo {
    struct weft_found_brick brick[WEFT_BRICK_MEMO]; // by their coordinates
};

WEFT_END_DECLS
#endif
