// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_impl.h - what the halves of tiles/image share (not installed).
#ifndef WEFT_TILES_IMAGE_IMAGE_IMPL_H
#define WEFT_TILES_IMAGE_IMAGE_IMPL_H

#include "tiles/image/image.h"

WEFT_BEGIN_DECLS

// Makes an image without planes of what a reader says of part `part`: struct weft_wire_image and
// what follows it, exactly `size` bytes. Ownership: clear it with weft_image_clear, on failure,
// too. Returns WEFT_ERR_READER where that contradicts itself, or WEFT_ERR_MEMORY; the log hears
// nothing.
enum weft_result weft_image_take_info(const void *info, size_t size, int part,
                                      struct weft_image *out);

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
