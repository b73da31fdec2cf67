// SPDX-License-Identifier: BSD-3-Clause
// tiles/output_file.h - outputs appear whole or not at all (not installed).
// A temporary file in the target's folder, fsync, then rename (or link, for no-clobber).
#ifndef WEFT_TILES_OUTPUT_FILE_H
#define WEFT_TILES_OUTPUT_FILE_H

#include "filter/check.h"

WEFT_BEGIN_DECLS

struct weft_output_file {
    char *path;      // the target
    char *temporary; // "<folder>/.<name>.XXXXXX"
    int fd;          // open for reading and writing, 0666 & ~umask
    bool no_clobber;
    const struct weft_log *log;
};

// Returns WEFT_ERR_WRITE (also when no_clobber is set and the target exists) or WEFT_ERR_MEMORY.
enum weft_result weft_output_file_create(const struct weft_log *log, const char *path,
                                         bool no_clobber, struct weft_output_file *out);

// Puts the file in place and releases everything. On failure the temporary file is gone too.
enum weft_result weft_output_file_commit(struct weft_output_file *file);

// Removes the temporary file and releases everything; harmless after commit or on {0}.
void weft_output_file_discard(struct weft_output_file *file);

WEFT_END_DECLS
#endif
