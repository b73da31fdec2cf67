// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume_writer.h - VDB files written bit by bit: one or several grids of floats or of
// vectors of three, brick by brick as they are made. weft-write-vdb holds what was added as
// OpenVDB's trees until the file is finished, within its own limits; here no more than a lot is
// held.
#ifndef WEFT_TILES_VOLUME_VOLUME_WRITER_H
#define WEFT_TILES_VOLUME_VOLUME_WRITER_H

#include "volume.h"

WEFT_BEGIN_DECLS

// Grids of a file, at most.
enum { WEFT_VOLUME_WRITER_GRIDS = 64 };

// A grid to be written. Active voxels are those that differ from the background; in level sets
// those with |value| < |background|; of boxed grids those in the box, all others getting the
// background. Vectors differ where a component does.
struct weft_volume_grid {
    const char *name;       // default "density"
    const char *grid_class; // default "fog volume"; level sets get their inside filled (signed
                            // flood fill)
    int components;         // 1 (default): floats; 3: vectors, whose background is 0
    // Of vectors, how they follow when space is moved: "invariant" (default), "covariant",
    // "covariant normalize", "contravariant relative", "contravariant absolute".
    const char *vector_type;
    double index_to_world[3][4]; // default (all zero): identity
    float background;            // where nothing is added (default 0)
    bool boxed;
    int32_t box_min[3], box_max[3]; // inclusive
    // Written as text, but for what OpenVDB writes by itself: the grid's name, class, creator and
    // type, and what it counts of a file. Default: none.
    size_t metadata_count;
    const struct weft_metadata *metadata;
};

// Bricks and tiles of a grid. Nothing is added twice.
struct weft_volume_lot {
    int grid; // its place in the writer's list
    size_t brick_count;
    const int32_t (*brick_origin)[3]; // multiples of 8 within +-WEFT_INDEX_LIMIT
    const float *values;              // brick after brick, each as many blocks of 512 as components
    size_t tile_count;                // of grids of one component
    const struct weft_volume_tile *tiles;
};

// What takes lots, as they are made. Lots are the caller's again when it returns; another result
// than WEFT_OK ends the work, which returns it.
typedef enum weft_result (*weft_volume_sink)(void *priv, const struct weft_volume_lot *lot);

struct weft_volume_writer_params {
    const char *path;                    // required
    bool no_clobber;                     // an existing file is an error (default: it is replaced)
    int grid_count;                      // 1 to WEFT_VOLUME_WRITER_GRIDS
    const struct weft_volume_grid *grid; // required; borrowed until the call returns
    struct weft_limits limits;           // of the writer process
    const struct weft_log *log;          // may be NULL; borrowed for the writer's life
};
#define WEFT_VOLUME_WRITER_DEFAULTS
#define weft_volume_writer_params(...)                                                             \
    (&(struct weft_volume_writer_params){WEFT_VOLUME_WRITER_DEFAULTS __VA_ARGS__})

// A file that is being written. Thread-safety: one thread at a time.
typedef struct weft_volume_writer weft_volume_writer;

// Creates a temporary file in the folder of the path, and starts weft-write-vdb for it. On failure
// *out is NULL. Returns WEFT_ERR_ARGUMENT (path, counts, names that are twice there, components, a
// transform that is singular or not finite), WEFT_ERR_WRITE, _MEMORY, _READER, _LIMIT.
WEFT_API enum weft_result weft_volume_writer_create(const struct weft_volume_writer_params *params,
                                                    weft_volume_writer **out);

// Hands bricks and tiles over, while the process may still be busy with those before: what goes
// wrong with a lot may be told with the next. After a failure all that follows fails. Returns
// WEFT_ERR_ARGUMENT (grid, origins, tiles, pointers), WEFT_ERR_WRITE, _MEMORY, _READER, _LIMIT.
WEFT_API enum weft_result weft_volume_writer_add(weft_volume_writer *writer,
                                                 const struct weft_volume_lot *lot);

// Writes the file and puts it in its place; leaves NULL behind, whatever comes of it. *bytes (may
// be NULL) is the file's size. Returns as above.
WEFT_API enum weft_result weft_volume_writer_finish(weft_volume_writer **writer, uint64_t *bytes);

// Ends without a file. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_volume_writer_discard(weft_volume_writer **writer);

WEFT_END_DECLS
#endif
