// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/mesh/files.h - the files that a mesh is made of: the one that the reader was
// started with, and those that it names, which lie in its folder or below (not installed).
#ifndef WEFT_TILES_READERS_MESH_FILES_H
#define WEFT_TILES_READERS_MESH_FILES_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// Bytes of a file, mapped.
struct weft_mesh_bytes {
    const char *data; // NULL where size is 0
    size_t size;
};

struct weft_mesh_files {
    const char *path;            // of the file itself
    struct weft_mesh_bytes main; // the file itself
    int folder;                  // that it lies in; -1: not opened yet
    int opened;                  // files besides the file itself
    char refused[400];           // the first name that leads out of the folder or is no plain
                                 // file, in words
    char missing[256];           // the first file that is not there, in words
};

// Maps the file itself. On failure `refused` says why.
bool weft_mesh_files_begin(struct weft_mesh_files *files, const char *path, int fd);

// Maps a file that the mesh names, relative to its folder. Where that fails `refused` or `missing`
// says why, unless it is known already what was wrong with another one.
bool weft_mesh_files_open(struct weft_mesh_files *files, const char *name,
                          struct weft_mesh_bytes *out);
void weft_mesh_bytes_release(struct weft_mesh_bytes *bytes);

WEFT_END_DECLS
#endif
