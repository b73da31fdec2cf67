// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume_cache.h - a volume whose bricks are kept once they were read (not installed).
#ifndef WEFT_TILES_VOLUME_VOLUME_CACHE_H
#define WEFT_TILES_VOLUME_VOLUME_CACHE_H

#include "tiles/volume/volume.h"

WEFT_BEGIN_DECLS

// What was read from the volume, and is kept of it now.
struct weft_volume_cache_info {
    uint64_t bricks_read; // so far
    uint64_t kept_bytes;  // of voxels
};

// Makes a volume that is what `volume` is, voxel by voxel. It borrows `volume` and keeps no brick
// until it is limited to more. Returns WEFT_ERR_MEMORY.
enum weft_result weft_volume_cache(weft_volume *volume, const struct weft_log *log,
                                   weft_volume **out);

// Limits the bytes of kept voxels from now on. Where there is no room for a brick that is read, or
// for those that are kept, the bricks least recently asked for are dropped, one by one.
void weft_volume_cache_limit(weft_volume *cache, uint64_t memory_bytes);

// Valid until the cache is destroyed; the counts change as it reads.
const struct weft_volume_cache_info *weft_volume_cache_get_info(const weft_volume *cache);

WEFT_END_DECLS
#endif
