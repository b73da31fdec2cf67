// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/codes/png.h - PNG files, written by libpng from rows that several threads make (not
// installed).
#ifndef WEFT_TILES_IMAGE_CODES_PNG_H
#define WEFT_TILES_IMAGE_CODES_PNG_H

#include "tiles/image/image.h"
#include "tiles/output/output_file.h"

WEFT_BEGIN_DECLS

struct weft_png_writer {
    int32_t width, height;
    int samples; // of a pixel: 1 and 2 are grey, 3 and 4 red, green and blue; even: with alpha
    int bits;    // of a sample: 8 or 16, in the machine's order of bytes
    int threads; // >= 1
    // What the file says of its codes, and attributes that PNG has a place for; may be NULL.
    const struct weft_image *says;
    // Makes row y; thread < threads. In any thread, several rows at once.
    void (*fill_row)(const void *priv, int thread, int32_t y, uint8_t *out);
    const void *priv;
    const struct weft_progress *progress; // may be NULL
};

// Writes into an open output. Returns WEFT_ERR_CANCELLED, _MEMORY or _WRITE, after a line in the
// output's log.
enum weft_result weft_png_write(const struct weft_png_writer *writer,
                                struct weft_output_file *file);

WEFT_END_DECLS
#endif
