// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/dense/nrrd.h - NRRD files, by Teem (not installed).
#ifndef WEFT_TILES_READERS_DENSE_NRRD_H
#define WEFT_TILES_READERS_DENSE_NRRD_H

#include "tiles/readers/dense/dense.h"

WEFT_BEGIN_DECLS

// Samples in encoding raw in one file are read where they lie; all others are decoded whole.
enum weft_result weft_nrrd_read_header(struct weft_server *server, struct weft_dense *dense);

WEFT_END_DECLS
#endif
