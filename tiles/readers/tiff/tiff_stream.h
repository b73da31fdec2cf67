// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/tiff/tiff_stream.h - a file as libtiff reads or writes it: by its descriptor, not
// mapped, and with libtiff's first message kept (not installed).
#ifndef WEFT_TILES_READERS_TIFF_TIFF_STREAM_H
#define WEFT_TILES_READERS_TIFF_TIFF_STREAM_H

#include <stdbool.h>
#include <stdint.h>

#include <tiffio.h>

// Set `fd` and, to read, `end`, the file's bytes; the rest starts as 0.
struct weft_tiff_stream {
    int fd;            // borrowed
    uint64_t at, end;  // where the next byte is read or written; the file's bytes
    bool writes;       // set by opening
    char message[256]; // what libtiff, or writing, said first
};

// Opens it with a mode of TIFFOpen; of what is read libtiff allocates at most 1 GiB at once. NULL:
// the message says why, or is empty. The stream outlives the result.
TIFF *weft_tiff_stream_open(struct weft_tiff_stream *stream, const char *path, const char *mode);

#endif
