// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/dense/nifti.h - NIfTI-1 and NIfTI-2 files, by libnifti2 (not installed).
#ifndef WEFT_TILES_READERS_DENSE_NIFTI_H
#define WEFT_TILES_READERS_DENSE_NIFTI_H

#include "tiles/readers/dense/dense.h"

WEFT_BEGIN_DECLS

// One file, a header with its ".img" beside it, either of them gzipped: those that are not are read
// where their samples lie.
enum weft_result weft_nifti_read_header(struct weft_server *server, struct weft_dense *dense);

WEFT_END_DECLS
#endif
