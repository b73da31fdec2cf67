// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/exr/write.h - EXR files, written through OpenEXRCore (not installed).
#ifndef WEFT_TILES_IMAGE_EXR_WRITE_H
#define WEFT_TILES_IMAGE_EXR_WRITE_H

#include "tiles/image/image.h"
#include "tiles/output/output_file.h"

WEFT_BEGIN_DECLS

// Writes checked parts (see weft_image_save_parts) into an open output with up to `threads`
// threads, and adds to the report. Returns WEFT_ERR_LIMIT, _CANCELLED, _MEMORY, _WRITE or, of
// blocks that are packed, _ARGUMENT after a log line, and what params->packed does.
enum weft_result weft_image_write(const struct weft_image *parts, size_t count, int threads,
                                  const struct weft_image_save_params *params,
                                  struct weft_output_file *file,
                                  struct weft_image_save_report *report);

// Packs the lines of a checked image likewise, into out, which is {0} before.
enum weft_result weft_image_pack_lines(const struct weft_image *image, int threads,
                                       const struct weft_log *log, struct weft_image_packed *out);

WEFT_END_DECLS
#endif
