// SPDX-License-Identifier: BSD-3-Clause
// tiles/output/output_file.h - outputs appear whole or not at all (not installed).
// A file without a name in the target's folder (O_TMPFILE), fsync, then a link, or where the name
// is taken a link to a temporary name and a rename. On file systems that have no such files, one
// with a temporary name and a rename (one that refuses to replace, for no-clobber). Devices, pipes
// and /dev/stdout have no folder to rename in: for them the output is gathered in memory and copied
// over at the end.
#ifndef WEFT_TILES_OUTPUT_OUTPUT_FILE_H
#define WEFT_TILES_OUTPUT_OUTPUT_FILE_H

#include "filter/check.h"
#include "tiles/output/output.h"

WEFT_BEGIN_DECLS

struct weft_output_file {
    char *path;      // the target, symbolic links followed; NULL after commit or discard
    char *temporary; // "<folder>/.<name>.XXXXXX"; NULL: no such file is there
    int fd;          // open for reading and writing
    int stream;      // the open device or pipe, else -1
    bool no_clobber;
    const struct weft_log *log;
};

// A new file gets 0666 & ~umask, one that replaces another that one's permissions. A symbolic link
// stays, and what it points to is replaced. no_clobber does not apply to devices and pipes.
// Returns WEFT_ERR_WRITE (also when no_clobber is set and the target exists), WEFT_ERR_MEMORY, or
// WEFT_ERR_ARGUMENT (no path).
enum weft_result weft_output_file_create(const struct weft_log *log, const char *path,
                                         bool no_clobber, struct weft_output_file *out);

// Writes all of data at an offset in bytes, or logs why not and returns WEFT_ERR_WRITE.
enum weft_result weft_output_file_write(struct weft_output_file *file, uint64_t offset,
                                        const void *data, size_t size);

// Likewise, in any thread: returns false without a log line, and errno tells why.
bool weft_output_file_put(struct weft_output_file *file, uint64_t offset, const void *data,
                          size_t size);

// Logs what errno tells. Returns WEFT_ERR_MEMORY (ENOMEM) or WEFT_ERR_WRITE.
enum weft_result weft_output_file_fail(const struct weft_output_file *file);

// Puts the file in place and releases everything. On failure the temporary file is gone too.
// Returns WEFT_ERR_WRITE.
enum weft_result weft_output_file_commit(struct weft_output_file *file);

// Removes the temporary file and releases everything; harmless after commit or on {0}.
void weft_output_file_discard(struct weft_output_file *file);

WEFT_END_DECLS
#endif
