// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_impl.h - what the halves of tiles/image share (not installed).
#ifndef WEFT_TILES_IMAGE_IMAGE_IMPL_H
#define WEFT_TILES_IMAGE_IMAGE_IMPL_H

#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

// weft_image_load of a file that is open; params->path is for messages.
enum weft_result weft_image_read(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *out);

// Reads parts back from an open file and compares all that was to be written.
// Returns WEFT_ERR_WRITE after a log line that names the first difference, or why it cannot be
// read.
enum weft_result weft_image_verify(const struct weft_image *parts, size_t count, int fd,
                                   const struct weft_image_save_params *params,
                                   struct weft_image_save_report *report);

WEFT_END_DECLS
#endif
