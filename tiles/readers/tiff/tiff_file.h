// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/tiff/tiff_file.h - headers of TIFF files through libtiff (not installed).
#ifndef WEFT_TILES_READERS_TIFF_TIFF_FILE_H
#define WEFT_TILES_READERS_TIFF_TIFF_FILE_H

#include <string.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"
#include "tiles/readers/tiff/tiff_stream.h"
#include "tiles/readers/tiff/tiff_texts.h"

WEFT_BEGIN_DECLS

enum { WEFT_TIFF_CHANNELS = 64, WEFT_TIFF_PARTS = 1024 };

struct weft_tiff_file {
    struct weft_server *server;
    TIFF *tiff; // NULL: none is open
    struct weft_tiff_stream stream;
    uint32_t part_count;
    // Of the part that was taken: as it is stored,
    uint32_t width, height, samples, bits;
    uint32_t across, rows; // pixels of a strip or tile
    uint64_t row_bytes, block_bytes;
    bool tiled, planar, min_is_white, palette;
    uint16_t orientation, photometric, compression;
    uint16_t *map[3]; // of a palette; libtiff's
    // and as it is handed over.
    uint32_t shown_width, shown_height;
    enum weft_pixel_type type;
    uint32_t channels, colours;
    bool alpha, associated;
    bool expands;                       // samples are not values as they are
    bool moves;                         // channels change places
    uint32_t place[WEFT_TIFF_CHANNELS]; // of each sample, in a pixel
    size_t value_bytes, pixel_bytes;
};

// Opens the server's input, unless it is open, and counts its parts.
enum weft_result weft_tiff_open(struct weft_tiff_file *file);
void weft_tiff_close(struct weft_tiff_file *file); // accepts one that is not open
// Reads and checks a part's header.
enum weft_result weft_tiff_take_part(struct weft_tiff_file *file, uint32_t part);
// An answer with room for so many bytes of values, and in *values where they go; NULL where there
// is no room.
enum weft_result weft_tiff_begin_frame(struct weft_tiff_file *file, size_t bytes, char **values);
// Tells the caller what libtiff said, or that something is damaged.
enum weft_result weft_tiff_fail(struct weft_tiff_file *file, const char *what);

WEFT_END_DECLS
#endif
