// SPDX-License-Identifier: BSD-3-Clause
// tests/support/exr_maker.h - EXR files of kinds that weft itself does not write, through OpenEXRCore.
#ifndef WEFT_TESTS_SUPPORT_EXR_MAKER_H
#define WEFT_TESTS_SUPPORT_EXR_MAKER_H

#include <openexr.h>

struct exr_recipe {
    const char *path;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_pixel_type_t type;
    exr_lineorder_t order;
    int x, y, width, height;
    int tile_width, tile_height; // for tiled files
    int parts;                   // default 1; the second has other pixels
    int sampling;                // default 1, of both axes
    const void *pixels;          // one channel "V", packed in `type`
};

// Deep files get a header and no pixels, and so do those with a sampling.
exr_result_t exr_make(const struct exr_recipe *recipe);

#endif
