// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/codes/write.h - PNG and TIFF files from images (not installed).
#ifndef WEFT_TILES_IMAGE_CODES_WRITE_H
#define WEFT_TILES_IMAGE_CODES_WRITE_H

#include "tiles/image/image.h"
#include "tiles/output/output_file.h"

WEFT_BEGIN_DECLS

// Writes checked parts (see weft_image_save_parts) as params->kind into an open output with up to
// `threads` threads, and adds to the report. Returns WEFT_ERR_UNSUPPORTED (channels that the kind
// has no place for), _LIMIT, _CANCELLED, _MEMORY, _READER (weft-write-tiff is missing), _WRITE.
enum weft_result weft_codes_write(const struct weft_image *parts, size_t count, int threads,
                                  const struct weft_image_save_params *params,
                                  struct weft_output_file *file,
                                  struct weft_image_save_report *report);

// Compares the values that a file of params->kind has, as its reader hands them over, with an
// image's. Returns WEFT_ERR_WRITE with the first difference in words in `what`, or WEFT_ERR_MEMORY.
enum weft_result weft_codes_compare(const struct weft_image *image, enum weft_image_file_kind kind,
                                    const struct weft_log *log, const void *values, char what[200]);

WEFT_END_DECLS
#endif
