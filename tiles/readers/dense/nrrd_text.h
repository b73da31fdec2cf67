// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/dense/nrrd_text.h - the text of NRRD headers, before Teem sees it (not installed).
// Teem would open whatever file a header names. Here names are taken out of the header, and the
// files opened by weft_dense_open_beside.
#ifndef WEFT_TILES_READERS_DENSE_NRRD_TEXT_H
#define WEFT_TILES_READERS_DENSE_NRRD_TEXT_H

#include "tiles/readers/dense/dense.h"

WEFT_BEGIN_DECLS

// {0} is empty. Release it with weft_nrrd_text_clear.
struct weft_nrrd_text {
    char *header; // all lines but those that name files, each ending in one line feed
    size_t bytes; // of the file, with the empty line that ends the header
    char **file;  // names, in order; none: the samples follow the header
    size_t file_count;
    char *room; // that the names lie in
};
void weft_nrrd_text_clear(struct weft_nrrd_text *text);

// Reads the header from the file's start. Fails for one of over 1 MiB, one that is not ended where
// it names no file, more than 65536 files, and ways to write their names that NRRD does not have.
enum weft_result weft_nrrd_text_read(struct weft_server *server, struct weft_nrrd_text *out);

WEFT_END_DECLS
#endif
