// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/exr/header.h - headers of EXR files, written by OpenEXRCore (not installed).
#ifndef WEFT_TILES_IMAGE_EXR_HEADER_H
#define WEFT_TILES_IMAGE_EXR_HEADER_H

#include <OpenEXR/openexr.h>

#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

// Adds a part of lines or tiles with the windows, channels and attributes of a checked image (see
// weft_image_save). `channels` are the image's in the order of their names. What attributes point
// to is borrowed until exr_write_header.
exr_result_t weft_image_header_add(exr_context_t exr, const struct weft_image *image,
                                   const struct weft_image_channel *const *channels);

// Pixels of an image's tiles, where it has some, and how many levels of it are written.
void weft_image_tile_size(const struct weft_image *image, int32_t out[2]);
int weft_image_levels_of(const struct weft_image *image);

WEFT_END_DECLS
#endif
