// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/exr_file.h - an EXR file's headers through OpenEXRCore, for the programs that read
// its values (not installed).
#ifndef WEFT_TILES_READERS_EXR_FILE_H
#define WEFT_TILES_READERS_EXR_FILE_H

#include <openexr.h>

#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"

WEFT_BEGIN_DECLS

// What went wrong in OpenEXRCore.
struct weft_exr_complaint {
    char message[256]; // the first that it told
    size_t refused;    // bytes of an allocation that failed, else 0
};

struct weft_exr_file {
    struct weft_server *server;
    exr_context_t exr; // NULL: none is open
    struct weft_exr_complaint complaint;
    uint64_t file_bytes;
    int part, part_count;
    exr_attr_box2i_t data, display;
    int64_t width, height;
    int64_t first_row, rows; // that are read: of a part that was just taken, all
    exr_storage_t storage;
    uint32_t tile[2]; // pixels of a tile; {0, 0}: it is in lines
    exr_tile_level_mode_t levels;
    exr_compression_t compression;
    const exr_attr_chlist_t *channels;
};

// Opens the server's input, unless it is open.
enum weft_result weft_exr_open(struct weft_exr_file *file);
void weft_exr_close(struct weft_exr_file *file); // accepts one that is not open
// Reads and checks a part's header: windows, channels, compression.
enum weft_result weft_exr_take_part(struct weft_exr_file *file, uint32_t part);

// Chooses the rows that the request asks for, and what is packed with them in blocks of `lines`.
enum weft_result weft_exr_choose_rows(struct weft_exr_file *file, int64_t lines);

bool weft_exr_is_dwa(const struct weft_exr_file *file);
// Whether the part's values are of a kind that is read: flat, not subsampled.
enum weft_result weft_exr_check_kind(const struct weft_exr_file *file);
// Bytes of its planes' rows, within the limits, in the channels' own types as struct
// weft_wire_frame has them, or in four bytes a value, tightly packed.
enum weft_result weft_exr_measure(const struct weft_exr_file *file, bool own_types, size_t *bytes);

// struct weft_wire_image and what follows it. The caller frees *out.
enum weft_result weft_exr_inform(struct weft_exr_file *file, void **out, size_t *size);
// An answer to FRAME with room for the planes, and in *planes where they go; NULL with WEFT_OK
// where none are wanted, or there is no room. own: bytes of the planes, as weft_exr_measure has
// them.
enum weft_result weft_exr_begin_frame(struct weft_exr_file *file, size_t bytes, char **planes);

// Tells the caller what OpenEXRCore said.
enum weft_result weft_exr_fail(struct weft_exr_file *file, exr_result_t code);
// Where the calling thread's complaints go; returns where they went before.
struct weft_exr_complaint *weft_exr_complain(struct weft_exr_complaint *to);
// malloc, which complains.
void *weft_exr_allocate(size_t size);

WEFT_END_DECLS
#endif
