// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/brick_reader.h - the bricks of a volume near a region: where they are, and their
// voxels, kept once they were read (not installed).
#ifndef WEFT_TILES_VOLUME_BRICK_READER_H
#define WEFT_TILES_VOLUME_BRICK_READER_H

#include "tiles/volume/brick_store.h"
#include "tiles/volume/cell_map.h"

// {0} is closed.
struct weft_brick_reader {
    weft_volume *volume; // borrowed; NULL: closed
    const struct weft_log *log;
    bool borrowed;  // places and store are those of a volume in memory
    bool has_tiles; // near the region, or anywhere where they are borrowed
    struct weft_brick_list topology;
    weft_brick_store *places; // of the topology, without voxels
    weft_brick_store *store;  // of what was read; NULL: nothing
    float **lots;             // of voxels, that were read together
    size_t lot_count, lot_capacity;
    uint64_t kept_bytes;  // of voxels
    uint64_t bricks_read; // so far
    double read_seconds;  // so far
};

// The part of a clamped volume's box that a region reaches once clamped, without slabs.
void weft_region_clamp(const struct weft_volume_info *volume, struct weft_region *region);

// A store over a list's tiles, and its bricks without voxels: for where they are.
enum weft_result weft_brick_places_create(const struct weft_log *log,
                                          const struct weft_volume_info *info,
                                          const struct weft_brick_list *topology,
                                          weft_brick_store **out);

// Finds what is near a region, which is clamped where the volume is; reads no voxel. Returns
// WEFT_ERR_MEMORY and what weft_volume_find returns.
enum weft_result weft_brick_reader_open(const struct weft_log *log, weft_volume *volume,
                                        const struct weft_region *region,
                                        struct weft_brick_reader *out);
// Opens a volume that is in memory: nothing is looked for, and voxels are those in memory, all of
// which are kept and none read. Returns false, and does nothing, where it is not.
bool weft_brick_reader_borrow(const struct weft_log *log, weft_volume *volume,
                              struct weft_brick_reader *out);
void weft_brick_reader_close(struct weft_brick_reader *reader);

// Notes the bricks that hold a box of voxels, inclusive, which is clamped where the volume is, and
// have voxels of their own; by their origins in units of 8 voxels. false: out of memory.
bool weft_brick_reader_note(const struct weft_brick_reader *reader, const int32_t min[3],
                            const int32_t max[3], struct weft_cell_map *bricks);

// How many of these are not kept.
size_t weft_brick_reader_missing(const struct weft_brick_reader *reader,
                                 const struct weft_cell_map *bricks);
// Reads those. `store` then answers for these bricks and the tiles, clamped where the volume is,
// until what is kept is dropped: on failure, too. Returns WEFT_ERR_MEMORY and what weft_volume_read
// returns.
enum weft_result weft_brick_reader_load(struct weft_brick_reader *reader,
                                        const struct weft_cell_map *bricks);
void weft_brick_reader_drop(struct weft_brick_reader *reader);

#endif
