// SPDX-License-Identifier: BSD-3-Clause
// tiles/output/output.h - files that appear whole or not at all, also when the process is ended by
// a signal. Outputs have no name in their folder before they are complete; where the file system
// cannot do that they have a temporary one, ".NAME.XXXXXX". weft installs no signal handlers: a
// program that wants to leave neither such files nor reader programs behind when a signal ends it
// calls weft_unfinished_discard() in a handler of its own.
#ifndef WEFT_TILES_OUTPUT_OUTPUT_H
#define WEFT_TILES_OUTPUT_OUTPUT_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// Writes `size` bytes of data as a file, which appears when it is complete. A new file gets 0666 &
// ~umask, one that replaces another that one's permissions. A symbolic link stays, and what it
// leads to is replaced. Devices, pipes and /dev/stdout are written to where they stand; no_clobber
// does not apply to them. Thread-safe. Returns WEFT_ERR_WRITE (also when no_clobber is set and the
// file exists), WEFT_ERR_MEMORY, or WEFT_ERR_ARGUMENT (no path, or no data of a size).
WEFT_API enum weft_result weft_file_save(const struct weft_log *log, const char *path,
                                         bool no_clobber, const void *data, size_t size);

// Bytes that lie in memory, borrowed.
struct weft_bytes {
    const void *data; // NULL where size is 0
    size_t size;
};
// Writes `count` parts likewise, one behind the other in one file. Returns as weft_file_save.
WEFT_API enum weft_result weft_file_save_parts(const struct weft_log *log, const char *path,
                                               bool no_clobber, const struct weft_bytes *parts,
                                               size_t count);

// Removes the temporary files that weft has open in this process, and kills the reader programs
// that it has started. Async-signal-safe, and of use only right before the process ends: whatever
// is under way fails. Of more than 64 files or readers at once some are left to themselves; readers
// end when the process does.
WEFT_API void weft_unfinished_discard(void);

WEFT_END_DECLS
#endif
