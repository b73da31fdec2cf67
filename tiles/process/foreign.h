// SPDX-License-Identifier: BSD-3-Clause
// tiles/process/foreign.h - what a file is that is not what was asked for, for messages (not
// installed).
#ifndef WEFT_TILES_PROCESS_FOREIGN_H
#define WEFT_TILES_PROCESS_FOREIGN_H

#include <stddef.h>

// The kind of file that starts with these bytes, of which 8 are enough: "a PNG image", "packed by
// gzip"; NULL where it is none that is known.
const char *weft_foreign_name(const unsigned char *start, size_t size);

#endif
