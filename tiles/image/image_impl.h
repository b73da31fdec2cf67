// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_impl.h - what the halves of tiles/image share (not installed).
#ifndef WEFT_TILES_IMAGE_IMAGE_IMPL_H
#define WEFT_TILES_IMAGE_IMAGE_IMPL_H

#include "tiles/image/image_wire.h"
#include "tiles/process/client.h"

WEFT_BEGIN_DECLS

// Finds what an open file is by its first bytes. Returns WEFT_ERR_OPEN (it cannot be read) or
// _FORMAT after a line in the log.
enum weft_result weft_image_find_kind(const struct weft_log *log, const char *path, int fd,
                                      enum weft_image_file_kind *out);
// The program that reads headers and values of files of a kind (but DWA's values).
const char *weft_image_program(enum weft_image_file_kind kind);

// Makes an image without planes of what the reader of a kind says of part `part`: struct
// weft_wire_image and what follows it, exactly `size` bytes. Ownership: clear it with
// weft_image_clear, on failure, too. Returns WEFT_ERR_READER where that contradicts itself, or
// WEFT_ERR_MEMORY; the log hears nothing.
enum weft_result weft_image_take_info(const void *info, size_t size, enum weft_image_file_kind kind,
                                      int part, struct weft_image *out);

// What a frame of PNG or TIFF says of its codes, for an image whose info was taken. Returns
// WEFT_ERR_READER where that contradicts itself.
enum weft_result weft_image_take_codes(const struct weft_wire_frame *frame,
                                       struct weft_image *image);

// weft_image_load of a file that is open; params->path is for messages.
enum weft_result weft_image_read(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *out);

// The values of a part of an open PNG or TIFF file as it stores them: interleaved, in the order of
// the image's channels and of their one type. Ownership: release the payload, clear the image.
struct weft_image_values {
    const void *values; // in the payload
    struct weft_payload payload;
};
enum weft_result weft_image_read_values(const struct weft_image_load_params *params, int fd,
                                        enum weft_image_file_kind kind,
                                        struct weft_image_values *values, struct weft_image *image);

// Reads parts back from an open file and compares all that was to be written.
// Returns WEFT_ERR_WRITE after a log line that names the first difference, or why it cannot be
// read.
enum weft_result weft_image_verify(const struct weft_image *parts, size_t count, int fd,
                                   const struct weft_image_save_params *params,
                                   struct weft_image_save_report *report);

WEFT_END_DECLS
#endif
