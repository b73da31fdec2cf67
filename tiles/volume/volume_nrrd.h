// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume_nrrd.h - volumes as NRRD files: a dense box of samples behind a header that
// every reader of the format knows (http://teem.sourceforge.net/nrrd/format.html).
#ifndef WEFT_TILES_VOLUME_VOLUME_NRRD_H
#define WEFT_TILES_VOLUME_VOLUME_NRRD_H

#include "volume.h"

WEFT_BEGIN_DECLS

// What is written, and where. Volumes are borrowed until the call returns, and read on its thread.
struct weft_nrrd_save_params {
    const char *path;           // required
    bool no_clobber;            // an existing file is an error (default: it is replaced)
    int components;             // 1 (default: 0 is taken for it), or 3 of a grid of vectors
    weft_volume *volume[3];     // required, as many as components; alike in all but their values
    weft_volume *rest[3];       // what floats lack of each (weft_volume_open_params.rest), so that
                                // integers of 32 bits are written whole (default NULL: nothing)
    enum weft_sample_type type; // of the samples; start from weft_nrrd_save_params(...)
    const struct weft_log *log; // may be NULL
};
// float
#define WEFT_NRRD_SAVE_DEFAULTS .type = WEFT_SAMPLE_FLOAT,
#define weft_nrrd_save_params(...)                                                                 \
    (&(struct weft_nrrd_save_params){WEFT_NRRD_SAVE_DEFAULTS __VA_ARGS__})

// Bytes of samples that one file may have: a sparse grid's box can be of any size.
#define WEFT_NRRD_MOST_BYTES (UINT64_C(1) << 40)

// Writes the voxels in the box of active ones, those between them too, in encoding raw, the lowest
// byte of a sample first. Space directions and the origin, which is the box's first voxel's
// position, are the volume's, to the last bit; the name of space, its units, the measurement frame
// and metadata that are nobody else's stand in the header. Components are the fastest axis. Of
// integers values are rounded to the nearest, ties to even, and those out of range are clamped,
// NAN becoming 0; a warning counts them. Takes up to 64 MiB. Returns WEFT_ERR_ARGUMENT (no path, no
// volume, an empty one, different boxes), WEFT_ERR_LIMIT (bytes), WEFT_ERR_WRITE, _MEMORY and what
// weft_volume_read returns.
WEFT_API enum weft_result weft_volume_save_nrrd(const struct weft_nrrd_save_params *params);

WEFT_END_DECLS
#endif
