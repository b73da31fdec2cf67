// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/codes/encode.h - planes as the interleaved values of PNG and TIFF files (not
// installed).
#ifndef WEFT_TILES_IMAGE_CODES_ENCODE_H
#define WEFT_TILES_IMAGE_CODES_ENCODE_H

#include "filter/half.h"
#include "tiles/image/codes/decode.h"

WEFT_BEGIN_DECLS

// What a row lost.
struct weft_codes_losses {
    uint64_t clamped; // values without a nearest code
    struct weft_half_losses halves;
};

// Rows of an image, made into values. Read-only once it is created: any number of threads at once.
typedef struct weft_codes weft_codes;

// What the rows are.
struct weft_codes_shape {
    enum weft_pixel_type type;
    size_t channels, colours; // colours: 1 is grey, 3 are red, green and blue
    bool alpha, associated;   // alpha follows the colours; they are multiplied by it
    size_t value_bytes, row_bytes;
};

// Borrows the image. Refuses what the kind, PNG or TIFF, has no place for. Returns
// WEFT_ERR_UNSUPPORTED, WEFT_ERR_MEMORY after a line in the log.
enum weft_result weft_codes_create(const struct weft_image *image, enum weft_image_file_kind kind,
                                   const struct weft_log *log, weft_codes **out);
void weft_codes_destroy(weft_codes **codes);
const struct weft_codes_shape *weft_codes_shape(const weft_codes *codes);

// Writes row y, row_bytes of it, in the machine's order of bytes, and adds to the losses. scratch
// has width floats.
void weft_codes_row(const weft_codes *codes, int32_t y, void *out, float *scratch,
                    struct weft_codes_losses *losses);

WEFT_END_DECLS
#endif
