// SPDX-License-Identifier: BSD-3-Clause
// tiles/kernel/kernel_tiles_impl.h - inside a tile set (not installed).
#ifndef WEFT_TILES_KERNEL_KERNEL_TILES_IMPL_H
#define WEFT_TILES_KERNEL_KERNEL_TILES_IMPL_H

#include "filter/check.h"
#include "filter/kernels/kernel_nd.h"
#include "tiles/kernel/kernel_tiles.h"

// The tile as it lies in memory: what mirrored tiles share.
struct weft_stored_tile {
    void *data;
    double scale;
    double minimum, maximum; // of the stored values, in units of one / scale
    int users;
};

// What axes with the same weights share.
struct weft_tiles_axis {
    struct weft_kernel kernel;
    // [sample][tap], for weft_kernel_combine: exact weights; for radial kernels in 2D and 3D
    // offsets.
    double *weights;
    bool even, odd; // h(-x) = h(x), or else h(-x) = -h(x); radial weights are even
};

struct weft_kernel_tiles {
    struct weft_kernel_tiles_info info;
    struct weft_kernel_tiles_params params;
    bool separate;                  // signs in tiles of their own
    int kept;                       // taps stored along an axis
    struct weft_tiles_axis axes[3]; // of the kernel and its derivatives: weft_tiles_axis_of
    struct weft_stored_tile *stored;
    // Stored number of every kept tap's parts (positive or whole, negative); -1: there is none.
    int *stored_of;
    struct weft_kernel_tile *tiles;
};

static inline const struct weft_tiles_axis *weft_tiles_axis_of(const weft_kernel_tiles *set, int a)
{
    return &set->axes[set->info.derivative.along[a]];
}

// The tap whose stored tiles are those of `tap` too; returns the sign that reflection gives them.
static inline int weft_tiles_kept_tap(const weft_kernel_tiles *set, const int tap[3], int kept[3])
{
    int sign = 1;
    for (int a = 0; a < set->info.dims; a++) {
        const bool mirrored = tap[a] >= set->kept;
        kept[a] = mirrored ? set->info.width - 1 - tap[a] : tap[a];
        sign = mirrored && weft_tiles_axis_of(set, a)->odd ? -sign : sign;
    }
    return sign;
}

// Tap (x, y, z) among `count` along every axis of the set.
static inline int weft_tiles_tap_index(const weft_kernel_tiles *set, const int tap[3], int count)
{
    int index = 0;
    for (int a = set->info.dims - 1; a >= 0; a--)
        index = index * count + tap[a];
    return index;
}

static inline size_t weft_tiles_sample_index(const weft_kernel_tiles *set, const int position[3])
{
    size_t index = 0;
    for (int a = set->info.dims - 1; a >= 0; a--)
        index = index * (size_t)set->info.samples + (size_t)position[a];
    return index;
}

// Steps through [0, count)^dims, x fastest; false after the last.
static inline bool weft_tiles_next(int dims, int count, int at[3])
{
    for (int a = 0; a < dims; a++) {
        if (++at[a] < count)
            return true;
        at[a] = 0;
    }
    return false;
}

static inline bool weft_tiles_integer_format(const weft_kernel_tiles *set)
{
    return set->info.format == WEFT_TILE_UNORM || set->info.format == WEFT_TILE_SNORM;
}

static inline double weft_tiles_load(const weft_kernel_tiles *set, const void *data, size_t i)
{
    switch (set->info.format) {
    case WEFT_TILE_UNORM:
        return ((const uint16_t *)data)[i];
    case WEFT_TILE_SNORM:
        return ((const int16_t *)data)[i];
    case WEFT_TILE_HALF:
    case WEFT_TILE_FLOAT:
        break;
    }
    return (double)((const float *)data)[i];
}

static inline void weft_tiles_store(const weft_kernel_tiles *set, void *data, size_t i, double q)
{
    switch (set->info.format) {
    case WEFT_TILE_UNORM:
        ((uint16_t *)data)[i] = (uint16_t)q;
        return;
    case WEFT_TILE_SNORM:
        ((int16_t *)data)[i] = (int16_t)q;
        return;
    case WEFT_TILE_HALF:
    case WEFT_TILE_FLOAT:
        break;
    }
    ((float *)data)[i] = (float)q;
}

// Sets range of the stored tile from its data, and the tile's view of it.
void weft_tiles_measure(const weft_kernel_tiles *set, struct weft_stored_tile *stored);
void weft_tiles_refresh(const weft_kernel_tiles *set, struct weft_kernel_tile *tile);

// Fills the weights of axis->kernel. Also finds out whether they are even or odd, within rounding,
// and makes them exactly so.
void weft_tiles_sample(const weft_kernel_tiles *set, struct weft_tiles_axis *axis);

// The exact weights of all taps at a sample position; returns how many.
int weft_tiles_weights(const weft_kernel_tiles *set, const int position[3], double *weights);

// Quantises all sample positions into the stored tiles. Returns WEFT_ERR_MEMORY.
enum weft_result weft_tiles_quantise(weft_kernel_tiles *set);

#endif
